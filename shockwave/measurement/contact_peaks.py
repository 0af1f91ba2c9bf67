"""Greatest forces at contacts, and the force at which a contact begins to yield."""

from __future__ import annotations

import math
from typing import TypeVar

from attrs import evolve, frozen

from shockwave.limit import LeavingForce
from shockwave.quadrature import FloatArray

_Number = TypeVar("_Number", float, FloatArray)
# Pressure at the centre of the contact at first yield, over the yield strength: 1.6 for a Poisson ratio of 0.3
# (Johnson, Contact Mechanics, section 6.1).
_PRESSURE = 1.6


@frozen(kw_only=True)
class ContactPeak:
    """Greatest force at a contact.

    Attributes
    ----------
    contact : int
        The contact, counted from 0.
    peak_force : float
        Greatest total contact force [N].
    time : float
        Time of this force [s].
    error_estimate : float
        Estimated error of the force, relative to its dynamic part ``peak_force - static_force``.
    static_force : float
        Force at the contact before the shock arrives [N].
    """

    contact: int
    peak_force: float
    time: float
    error_estimate: float
    static_force: float = 0.0


@frozen(kw_only=True)
class Yielding:
    """First yield of the contacts.

    Attributes
    ----------
    first_yield_force : float
        Smallest force in the chain at which a contact begins to yield [N].
    peak_ratio : float
        Largest ratio of a peak force to the force at which its contact begins to yield.
    """

    first_yield_force: float
    peak_ratio: float


def first_yield_force(radius: _Number, modulus: _Number, strength: _Number) -> _Number:
    """F_y = pi^3 R*^2 (1.6 sigma_y)^3 / (6 E*^2) [N], for the yield strength of the softer body.

    ``radius`` R* [m], ``modulus`` E* [Pa] and ``strength`` sigma_y [Pa] are numbers, or arrays of the same shape.
    """
    pressure = _PRESSURE * strength
    size = radius / modulus
    return math.pi**3 / 6 * size * size * pressure * pressure * pressure


def last_force(name: str, peak: ContactPeak | None, arrived: bool = True) -> LeavingForce:
    """The force that leaves a chain, from its last contact; ``peak`` is None if it is not known.

    Before the leading wave has ``arrived`` there is no upper end.
    """
    if peak is None:
        return LeavingForce(name=name, remedy="simulate with a longer timeout")
    error = peak.error_estimate * (peak.peak_force - peak.static_force)
    found = LeavingForce.measured(name, peak.peak_force, error)
    return found if arrived else evolve(found, high=None, remedy="simulate to a later end")
