"""Elastic-plastic contacts: loading, unloading and stored energy beyond first yield.

Loading follows Burgoyne and Daraio, Phys. Rev. E 89, 032203 (2014), but never exceeds Hertz's force: with more, a
collision would release more energy than it had. Units are consistent ones: SI, or those of the engine.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np
from attrs import frozen

from shockwave.base.numerics import FloatArray, bracketed_root
from shockwave.scene.yielding import PRESSURE

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
# Instead of zero in a denominator.
_LEAST = 1e-300


class Curve(NamedTuple):
    """Loading curves for ratios of strength and modulus: forces over E* R*^2, overlaps over R*.

    The force is Hertz's to an overlap beyond ``first``, then d (ratio + bend ln(d/first)) to ``full``, then
    level + slope d.
    """

    first: FloatArray
    ratio: FloatArray
    bend: FloatArray
    full: FloatArray
    level: FloatArray
    slope: FloatArray

    @classmethod
    def of(cls, strengths: FloatArray) -> Curve:
        """The curves of finite strengths over E*."""
        yielding = 0.5 * PRESSURE * math.pi * strengths
        first, full = yielding * yielding, FULL * strengths - FULL_LESS
        pressure = math.pi * (HARDNESS - SOFTENING * strengths**SOFTENING_POWER) * strengths
        slope, level = 2 * pressure, pressure * (AREA - AREA_LESS * strengths)
        ratio = 4 / 3 * yielding
        return cls(first, ratio, (slope + level / full - ratio) / np.log(full / first), full, level, slope)


def _cap(share: float) -> float:
    """Overlap up to which the force is Hertz's over that of first yield, from bend over ratio."""

    def excess(change: float) -> float:
        return math.sqrt(change) - 1 - share * math.log(change)

    least, most = _CAPS
    if not excess(least) < 0:
        return 1.0
    return bracketed_root(excess, least, most, "the overlap at which loading leaves Hertz's law")


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
    def softness(self) -> FloatArray:
        """Factor c of the depth F sqrt(c/(2 F + F_y)) of unloading; zero where the contact is elastic.

        The radius a of the contact has grown to a^2 = (2 F + F_y)/(2 pi 1.6 s), and the depth is 3 F/(4 E* a).
        """
        strengths = np.where(np.isfinite(self.strengths), self.strengths, 0.0)
        return np.asarray(9 / 8 * math.pi * PRESSURE * strengths * self.radii**2 / self.units)

    @cached_property
    def _curves(self) -> dict[str, FloatArray]:
        strengths, places = np.unique(self.strengths[np.isfinite(self.strengths)], return_inverse=True)
        curve = Curve.of(strengths)
        caps = curve.first * [_cap(share) for share in (curve.bend / curve.ratio).tolist()]
        curves = {name: np.zeros(len(self.strengths)) for name in (*Curve._fields, "cap")}
        for name, values in zip(curves, (*curve, caps), strict=True):
            curves[name][np.isinf(self.strengths)] = math.inf if name in ("first", "full", "cap") else 0.0
            curves[name][np.isfinite(self.strengths)] = values[places]
        return curves

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

    def depth(self, forces: FloatArray) -> FloatArray:
        """Overlap above the residual one where unloading begins from these forces."""
        yielded = forces > self.first_forces
        first = np.where(yielded, self.first_forces, 0.0)
        plastic = forces * np.sqrt(self.softness / np.maximum(2 * forces + first, _LEAST))
        return np.asarray(np.where(yielded, plastic, (forces / self.stiffnesses) ** (2 / 3)))

    def unloading_stiffness(self, forces: FloatArray) -> FloatArray:
        """K of unloading K (d - d_r)^(3/2) from these forces on."""
        yielded = forces > self.first_forces
        return np.where(yielded, forces / np.where(yielded, self.depth(forces), 1.0) ** 1.5, self.stiffnesses)

    def residual(self, overlaps: FloatArray, forces: FloatArray) -> FloatArray:
        """Residual overlap d_r after unloading from an overlap and force, zero up to first yield."""
        return np.asarray(np.where(forces > self.first_forces, overlaps - self.depth(forces), 0.0))
