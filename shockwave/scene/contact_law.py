"""Contact laws: the force between two granules as a function of their overlap, and the contract of further laws."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.base.arguments import Explained
from shockwave.base.errors import PluginError
from shockwave.base.numerics import FloatArray
from shockwave.base.quantity_fields import SI, Value, quantity
from shockwave.registry.registry import blame, owner_of


@frozen(eq=False)
class Pairs:
    """All contacts of a chain, as arrays of shape (contacts,) in the order of the contacts.

    Attributes
    ----------
    moduli : ndarray
        E* [Pa], ``1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2``; the term of a rigid wall is zero.
    radii : ndarray
        R* [m], ``1/R* = 1/R1 + 1/R2``; at a flat wall, the radius of the granule.
    masses : ndarray
        Reduced mass m1 m2/(m1 + m2) [kg]; at a fixed wall, the mass of the granule.
    stiffnesses : ndarray
        k of ``F = k d^p`` [N/m^p].
    exponents : ndarray
        p.
    """

    moduli: FloatArray
    radii: FloatArray
    masses: FloatArray
    stiffnesses: FloatArray
    exponents: FloatArray


@frozen(eq=False)
class PlasticPairs:
    """Further properties of contacts beyond first yield, as arrays of shape (contacts,).

    Attributes
    ----------
    contacts : ndarray of bool
        Where the contact law is elastic-plastic.
    strengths : ndarray
        Yield strength of the softer body [Pa]; infinite where the contact is elastic.
    rate_constants : ndarray
        Rate constant K of the softer body.
    lengths : ndarray
        Length over which the closing velocity gives the strain rate, R1 + R2 [m]; at a flat wall, R1.
    """

    contacts: npt.NDArray[np.bool_]
    strengths: FloatArray
    rate_constants: FloatArray
    lengths: FloatArray


class ContactLaw(Explained, ABC):
    """Base class of contact laws that plugins add: the force between two granules in contact.

    A law is an immutable attrs class (``attrs.frozen``). Its fields are the parameters of the ``contact`` block of a
    scenario; declare numbers with `shockwave.quantity`. Chains with such a law are integrated by the NumPy code,
    under these rules:

    1. ``force(overlap, closing_velocity, state, pairs)`` returns the forces [N] at all contacts at once. ``overlap``
       [m] and ``closing_velocity`` [m/s], its derivative, have the shape (contacts,); ``pairs`` holds the properties of
       the contacts. The force at a contact depends on its own values alone. All quantities are in SI units.
    2. The force is zero where the overlap is zero or negative. A negative force counts as zero: contacts never attract.
    3. The force is a continuous function of the overlap and the closing velocity, also where a contact closes. It must
       not change ``state`` or depend on earlier calls, because an integrator calls it many times in a step, and repeats
       steps.
    4. ``state`` has the shape (states, contacts), with the class attribute ``states``, and is zero at first. It
       describes the history of the contacts, such as their greatest overlap, up to the last accepted step. The force
       must also be valid for overlaps beyond this history, which occur within a step.
    5. ``update(overlap, closing_velocity, state, pairs)`` returns the state after an accepted step, from the overlaps
       and velocities at its end, as a new array. By default it returns ``state``. An update that changes the force
       at this overlap and velocity adds or removes energy.
    6. A contact creates no energy: from its closing to its opening, it never returns more work than it has received.
       The unloading curve must not lie above the loading curve, and velocity-dependent terms must only dissipate.

    A law includes its own velocity-dependent forces. It cannot be combined with ``damping`` of the same contact,
    ``precompression``, ``gravity`` or a prescribed motion. `shockwave.testing.ContactLawContract` tests these rules.
    """

    #: Number of values that describe the history of a contact.
    states: int = 0

    @abstractmethod
    def force(self, overlap: FloatArray, closing_velocity: FloatArray, state: FloatArray, pairs: Pairs) -> FloatArray:
        """Forces [N] at all contacts."""

    def update(self, overlap: FloatArray, closing_velocity: FloatArray, state: FloatArray, pairs: Pairs) -> FloatArray:
        """The state after an accepted step that ends with these overlaps and velocities."""
        return state


@frozen(eq=False)
class BoundLaw:
    """A contact law and the contacts of a chain, in units of length [m], velocity [m/s] and force [N]."""

    law: ContactLaw
    pairs: Pairs
    length: float
    velocity: float
    unit_force: float

    def initial_state(self) -> FloatArray:
        """State of contacts without a history, of shape (states, contacts)."""
        return np.zeros((self.law.states, len(self.pairs.stiffnesses)))

    def force(self, overlap: FloatArray, closing_velocity: FloatArray, state: FloatArray) -> FloatArray:
        """Forces at all contacts, zero or positive.

        Raises
        ------
        PluginError
            If the law raises, or does not return finite numbers of the shape of ``overlap``.
        """
        forces = self._result("force", overlap.shape, overlap, closing_velocity, state)
        return np.where(overlap > 0, np.maximum(forces, 0.0), 0.0) / self.unit_force

    def update(self, overlap: FloatArray, closing_velocity: FloatArray, state: FloatArray) -> FloatArray:
        """The state after an accepted step; see `force` for the error."""
        return self._result("update", state.shape, overlap, closing_velocity, state)

    def _result(self, name: str, shape: tuple[int, ...], overlap: FloatArray, *others: FloatArray) -> FloatArray:
        closing_velocity, state = others
        with blame("contacts", type(self.law)):
            method = getattr(self.law, name)
            result = method(overlap * self.length, closing_velocity * self.velocity, state, self.pairs)
            values = np.asarray(result, dtype=float)
        if values.shape == shape and np.isfinite(values).all():
            return values
        got = "numbers that are not" if values.shape == shape else f"shape {values.shape}"
        law = f"contact {owner_of('contacts', type(self.law))}"
        raise PluginError(f"{law}: {name} must return finite numbers of shape {shape} (got {got})")


@frozen(kw_only=True)
class PowerContact(Value):
    """A contact law ``F = k d^p`` with the same stiffness at all contacts, in place of Hertz's.

    Parameters
    ----------
    exponent : float
        p, from 1 to 10; 1 is a linear spring.
    stiffness : float
        k [N/m^p], above 0.

    Raises
    ------
    InvalidValueError
        If a value is out of range.

    Examples
    --------
    >>> import shockwave as sw
    >>> contact = sw.PowerContact(exponent=2, stiffness=1e7)
    >>> sw.Chain(material="delrin", diameter="9.5 mm", contact=contact).exponent
    2.0
    """

    exponent: SI[float] = quantity("", "exponent p of F = k d^p", at_least=1, at_most=10)
    stiffness: SI[float] = quantity(
        "", "stiffness k of F = k d^p, a bare number in N/m**p", at_least=1e-100, at_most=1e100
    )


@frozen(kw_only=True)
class ElasticPlastic(Value):
    """Elastic-plastic contact: Hertz's law until a contact flows plastically, and elastic unloading from there.

    The law of Burgoyne and Daraio (2014), limited to Hertz's force. A contact flows at the yield strength of its softer
    body, which the rate constant of that body raises with the strain rate; a body without a yield strength counts as
    elastic.

    Raises
    ------
    InvalidValueError
        Raised by the layout of a chain if the yield strength of the softer body divided by E* is outside 0.001 to 0.1.

    Examples
    --------
    >>> import shockwave as sw
    >>> row = sw.Chain(
    ...     material="stainless-steel-302",
    ...     diameter="9.5 mm",
    ...     granules=20,
    ...     contact=sw.ElasticPlastic(),
    ... )
    >>> row.is_plastic
    True
    """


@frozen
class Hertz:
    """Hertz's law ``F = k d^(3/2)``, with k from the materials and radii of each contact: the default of a chain.

    Examples
    --------
    >>> import shockwave as sw
    >>> hard = sw.Segment(count=5, material="alumina", contact=sw.Hertz())
    >>> row = sw.Chain(
    ...     material="stainless-steel-440c",
    ...     diameter="9.5 mm",
    ...     granules=[sw.Segment(count=20), hard],
    ...     contact=sw.ElasticPlastic(),
    ... )
    >>> row.count
    25
    """


#: Law of a contact.
AnyContact: TypeAlias = PowerContact | ElasticPlastic | ContactLaw | Hertz
