"""Elastic-plastic contacts: loading, unloading and stored energy beyond first yield.

Loading follows Burgoyne and Daraio, Phys. Rev. E 89, 032203 (2014), but never exceeds Hertz's force: with more, a
collision would release more energy than it had. Units are consistent ones: SI, or those of the engine.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple, TypeVar

import numpy as np
from attrs import frozen

from shockwave.base.numerics import FloatArray, bracketed_root
from shockwave.scene.yielding import PRESSURE

_Number = TypeVar("_Number", float, FloatArray)
# Radius of the spheres of the finite elements to which the law was fitted [m]; it only scales the lengths below.
_FITTED = 1.5875e-3
#: Overlap of full plasticity over R*: its increase with the ratio q of strength and modulus E*, less a constant.
FULL = 0.0067 / _FITTED
FULL_LESS = 3.082e-6 / _FITTED
#: Mean pressure of full plasticity over the strength: a constant less a factor of a power of q.
HARDNESS = 5.487
SOFTENING = 5.972
SOFTENING_POWER = 0.1637
#: Area of contact of full plasticity without overlap, over R*^2: a constant less a factor of q.
AREA = 3.999e-9 / _FITTED**2
AREA_LESS = 4.104e-6 / _FITTED**2
#: Strength over E* for which the law is defined; below, the hardness exceeds that of any metal.
RANGE = 1e-3, 0.1
#: Strain rate above which the strength grows [1/s].
RATE = 1e-3
# Overlap over that of first yield between which the curve leaves Hertz's law.
_CAPS = 1.2, 1e6
# Steps of Newton's method for the overlap under a force.
_TURNS = 30


@frozen
class Curve:
    """Loading curve for one ratio of strength and modulus: forces over E* R*^2, overlaps over R*.

    The force is Hertz's to the overlap ``cap``, then d (ratio + bend ln(d/first)) to ``full``, then level + slope d.
    """

    first: float
    ratio: float
    bend: float
    full: float
    level: float
    slope: float
    strength: float

    @classmethod
    def of(cls, strength: float) -> Curve:
        """The curve of a ``strength`` over E*; infinite if the contact is elastic."""
        if strength == math.inf:
            return cls(math.inf, 0.0, 0.0, math.inf, 0.0, 0.0, strength)
        yielding = 0.5 * PRESSURE * math.pi * strength
        first, full = yielding * yielding, FULL * strength - FULL_LESS
        pressure = math.pi * (HARDNESS - SOFTENING * math.pow(strength, SOFTENING_POWER)) * strength
        slope, level = 2 * pressure, pressure * (AREA - AREA_LESS * strength)
        ratio = 4 / 3 * yielding
        bend = (slope + level / full - ratio) / math.log(full / first)
        return cls(first, ratio, bend, full, level, slope, strength)

    @property
    def changes(self) -> Changes:
        """Derivatives by the strength."""
        q, power = self.strength, SOFTENING_POWER
        pressure = (1 + power) * (0.5 * self.slope / q) - power * math.pi * HARDNESS
        level = pressure * (AREA - AREA_LESS * q) - 0.5 * self.slope * AREA_LESS
        ratio, share = self.ratio / q, FULL / self.full
        bend = 2 * pressure + (level - self.level * FULL / self.full) / self.full - ratio - self.bend * (share - 2 / q)
        return Changes(ratio, bend / math.log(self.full / self.first), level, 2 * pressure)

    @cached_property
    def cap(self) -> float:
        """Overlap up to which the force is Hertz's."""
        share = self.bend / self.ratio if self.ratio else 0.0

        def excess(change: float) -> float:
            return math.sqrt(change) - 1 - share * math.log(change)

        least, most = _CAPS
        if not excess(least) < 0:
            return self.first
        return self.first * bracketed_root(excess, least, most, "the overlap at which loading leaves Hertz's law")


class Changes(NamedTuple):
    """Derivatives of a `Curve` by the strength."""

    ratio: float
    bend: float
    level: float
    slope: float


@frozen(eq=False, slots=False)
class Loading:
    """First loading of contacts without rate, as arrays of shape (contacts,).

    Attributes
    ----------
    stiffnesses : array
        k of Hertz's law.
    radii : array
        R*.
    strengths : array
        Yield strength of the softer body over E*; infinite where the contact is elastic.
    """

    stiffnesses: FloatArray
    radii: FloatArray
    strengths: FloatArray

    @cached_property
    def units(self) -> FloatArray:
        """E* R*^2."""
        return np.asarray(0.75 * self.stiffnesses * self.radii * np.sqrt(self.radii))

    @cached_property
    def _curves(self) -> dict[str, FloatArray]:
        strengths, places = np.unique(self.strengths, return_inverse=True)
        curves = [Curve.of(strength) for strength in strengths.tolist()]
        names = "first", "ratio", "bend", "full", "level", "slope", "cap"
        return {name: np.array([getattr(curve, name) for curve in curves])[places] for name in names}

    @property
    def first_overlaps(self) -> FloatArray:
        """Overlap of first yield, d_y."""
        return self._curves["first"] * self.radii

    @property
    def first_forces(self) -> FloatArray:
        """Force of first yield, F_y."""
        return np.asarray(self.stiffnesses * self.first_overlaps**1.5)

    @property
    def cap_overlaps(self) -> FloatArray:
        """Overlap up to which loading is Hertz's."""
        return self._curves["cap"] * self.radii

    @property
    def full_overlaps(self) -> FloatArray:
        """Overlap of full plasticity, d_p."""
        return self._curves["full"] * self.radii

    @cached_property
    def middle(self) -> tuple[FloatArray, FloatArray]:
        """a and b of the force d (a + b ln d) between cap and full plasticity."""
        curves, unit = self._curves, self.units / self.radii
        start = np.log(np.where(np.isfinite(curves["first"]), self.first_overlaps, 1.0))
        return unit * (curves["ratio"] - curves["bend"] * start), unit * curves["bend"]

    @cached_property
    def straight(self) -> tuple[FloatArray, FloatArray]:
        """c and e of the force c + e d of full plasticity."""
        return self.units * self._curves["level"], self.units / self.radii * self._curves["slope"]

    def force(self, overlaps: FloatArray) -> FloatArray:
        """F_load, zero where the overlap is not positive; overlaps may have leading axes."""
        d = np.maximum(overlaps, 0.0)
        (a, b), (c, e) = self.middle, self.straight
        middle = d * (a + b * np.log(np.where(d > 0, d, 1.0)))
        plastic = np.where(d > self.full_overlaps, c + e * d, middle)
        return np.asarray(np.where(d > self.cap_overlaps, plastic, self.stiffnesses * d * np.sqrt(d)))

    def overlap(self, forces: FloatArray) -> FloatArray:
        """Overlap under a force that is reached by slow first loading."""
        elastic, (a, b), (c, e) = (forces / self.stiffnesses) ** (2 / 3), self.middle, self.straight
        d = np.where(np.isfinite(self.strengths), np.maximum(elastic, self.cap_overlaps), 1.0)
        for _ in range(_TURNS):
            log = np.log(d)
            d = np.maximum(d + (forces - d * (a + b * log)) / np.where(b > 0, a + b * (1 + log), 1.0), 0.5 * d)
        straight = (forces - c) / np.where(e > 0, e, 1.0)
        yielded = np.where(straight > self.full_overlaps, straight, d)
        return np.asarray(np.where(elastic > self.cap_overlaps, yielded, elastic))

    def unloading(self, forces: FloatArray) -> FloatArray:
        """K of unloading K (d - d_r)^(3/2) from these forces on."""
        finite = np.isfinite(self.strengths)
        shared = self.units * np.where(finite, self.strengths, 1.0)
        first = np.where(finite, self.first_forces, 1.0)
        softer = unloading_stiffness(self.stiffnesses, self.units, shared, first, np.maximum(forces, first))
        return np.asarray(np.where(forces > self.first_forces, softer, self.stiffnesses))

    def residual(self, overlaps: FloatArray, forces: FloatArray) -> FloatArray:
        """Residual overlap d_r after unloading from an overlap and force, zero up to first yield."""
        left = overlaps - (forces / self.unloading(forces)) ** (2 / 3)
        return np.asarray(np.where(forces > self.first_forces, left, 0.0))


def unloading_stiffness(k: _Number, unit: _Number, strength: _Number, first: _Number, force: _Number) -> _Number:
    """K of unloading from a ``force`` of at least ``first``, that of first yield; numbers or arrays.

    The radius of the contact has grown to R_p = 4 E*/(3 F) ((2 F + F_y)/(2 pi 1.6 s))^(3/2); ``unit`` is E* R*^2 and
    ``strength`` s R*^2.
    """
    area = (2 * force + first) / (2 * math.pi * PRESSURE * strength)
    stiffness: _Number = k * np.sqrt(4 * unit / (3 * force) * area * np.sqrt(area))
    return stiffness
