r"""The law of moments for short shocks, written out: four integrals of the shape, three coefficients.

A shock much shorter than its wave hands its impulse to the first granule. What differs from a blow of no duration is
the momentum that the first contact passes on meanwhile: with s = t/t0, X(s) the path of a free granule, the double
integral of the force, over the impulse a, and s' the centroid of the force, the contact feels X^(3/2) instead of
(s - s')^(3/2). What it takes up while the force acts is

    q = sqrt(a) int_0^n X^(3/2) - max(s - s', 0)^(3/2) ds,

and a shock of the impulse S, in that of a wave of its peak force, falls short of the impulse limit by

    F = 1.168181738 F0 S^(6/5) exp(-x / (1 + x (p0 + p1 g + p2 g^2))),   x = 1.1445 q (t0/T0)^3,

where g is the skewness of the force as a density in time. The first power of x is known, with the cube of the duration;
the denominator is fitted, and has no zero. The error stays below c sqrt(h) x^(3/2), with h the kurtosis of that
density, which orders the errors of pulses with far tails. ``short_shock_law.json`` holds the coefficients,
``docs/fit_short.py`` makes them, ``docs/auto.md`` reports how they were judged.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from attrs import field, frozen

from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.numerics import product
from shockwave.prediction.model_interface import Shocks
from shockwave.prediction.shock_measures import gauss_legendre, pieces
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.guard import guarded, kept, trusted
from shockwave.quadrature import FloatArray
from shockwave.quadrature.gauss_legendre import interpolation

#: Name of the file with the coefficients, beside this one.
RESOURCE = "short_shock_law.json"

#: As of `shockwave.chain.solitary_wave`, to all digits that simulation at rtol 1e-12 gives, for seven shapes.
IMPULSE_LIMIT = 1.168181738
#: Simulated at rtol 1e-12 for sixteen shapes that last a tenth of T0: 1.14440 to 1.14455.
CORRECTION = 1.1445
# What the last digit leaves open.
_LIMIT_ERROR = 3e-9
# How the integrals of a shape are taken: halvings of its parts towards both their ends, the share of the impulse that
# may be missed, the most parts. A record is straight between its samples, and may do without halvings; so must shapes
# of very many parts.
_RULES = ((0, 1e-9, 100_000), (5, 1e-5, 16), (12, 1e-5, 64))
# Nodes on each piece.
_NODES = 4
# A rule of so many nodes must give nearly the same: q relative to itself, skewness and kurtosis to the latter.
_FEWER = 3
_AGREED = 1e-3
_NEAR = 1e-2
# For all digits of q: halvings, for shapes of so few parts, and nodes.
_FINE = 20
_SMOOTH_PARTS = 8
_FINE_NODES = 8


@frozen(eq=False)
class ShortLaw:
    """Coefficients of the law.

    Attributes
    ----------
    coefficients : numpy.ndarray, shape (3,)
        p0, p1, p2.
    error : float
        Relative error to be expected, over x^(3/2) and the root of the kurtosis.
    farthest : float
        Of x; the law was judged up to there.
    """

    coefficients: FloatArray = field(converter=np.array)
    error: float
    farthest: float

    def slope(self, x: FloatArray, skewness: FloatArray | float) -> FloatArray:
        """The denominator."""
        p0, p1, p2 = self.coefficients
        return np.asarray(1 + x * (p0 + skewness * (p1 + skewness * p2)))

    def amplification(self, strength: FloatArray, x: FloatArray, skewness: FloatArray | float) -> FloatArray:
        """F/F0 of pulses, given their integrals; arrays of one shape.

        Parameters
        ----------
        strength : numpy.ndarray
            S, impulse over that of a wave of the shock's peak force.
        x : numpy.ndarray
            1.1445 q (t0/T0)^3.
        skewness : numpy.ndarray or float
            g.
        """
        return np.asarray(IMPULSE_LIMIT * np.exp(1.2 * np.log(strength) - x / self.slope(x, skewness)))

    def bound(self, x: FloatArray, tails: FloatArray | float) -> FloatArray:
        """Relative error to be expected, infinite where the law was not judged; ``tails`` is the kurtosis."""
        error = self.error * np.sqrt(tails) * x * np.sqrt(x) + _LIMIT_ERROR
        return np.where(x <= self.farthest, error, np.inf)

    def of(self, shocks: Shocks) -> tuple[FloatArray, FloatArray, FloatArray]:
        """F/F0, bound, and d ln(F/F0) / d ln t0 of shocks; the bound is infinite where the shape is too fine."""
        areas = [areas.total for areas in shocks.areas]
        first, skewness, tails = integrals(shocks.profiles, areas)[shocks.shapes].T
        x = CORRECTION * first * shocks.rise_times**3
        strength = np.array(areas)[shocks.shapes] / MOMENTUM * shocks.rise_times
        with np.errstate(over="ignore", invalid="ignore"):
            slope = 1.2 - 3 * x / self.slope(x, skewness) ** 2
            return self.amplification(strength, x, skewness), self.bound(x, tails), slope


@cache
def short_law() -> ShortLaw:
    """The law, read once."""
    text = resources.files(__package__).joinpath(RESOURCE).read_text(encoding="utf-8")
    return ShortLaw(**json.loads(text)["law"])


# ---------------------------------------------------------------- the integrals of shapes


def integrals(profiles: Sequence[ShockProfile], areas: Sequence[float]) -> FloatArray:
    """q, g and h of shapes with these areas a1 + a2, shape (shapes, 3); NaN where one is too fine to have them."""
    found = [_of_shape(profile, area) for profile, area in zip(profiles, areas, strict=True)]
    return np.reshape(found, (-1, 3))


@kept
def _of_shape(profile: ShockProfile, area: float) -> FloatArray:
    parts = len(profile.breakpoints) - 1
    straight = type(profile).__name__ == "Tabulated" and trusted(profile)
    for halvings, missed, most in _RULES:
        if parts > most or not (halvings or straight or parts > _RULES[-1][-1]):
            continue
        whole, *found = _by_rule(profile, halvings, _NODES)
        _, *fewer = _by_rule(profile, halvings, _FEWER)
        # the area alone may be right by chance
        off = np.abs(np.subtract(fewer, found))
        agreed = off[0] <= _AGREED * found[0] and off[1:].max() <= _NEAR * max(found[2], 1)
        if agreed and found[0] > 0 and abs(whole / area - 1) <= missed:
            return np.array(found)
    return np.full(3, np.nan)


def correction(profile: ShockProfile) -> float:
    """q to ten digits or so: pieces halve until they do not matter, unless there are so many that each is short."""
    halvings = _FINE if len(profile.breakpoints) - 1 <= _SMOOTH_PARTS else 0
    return _by_rule(profile, halvings, _FINE_NODES)[1]


def _by_rule(profile: ShockProfile, halvings: int, count: int) -> tuple[float, float, float, float]:
    """Area, q, g and kurtosis of a shape."""
    nodes, _ = gauss_legendre(halvings, count, count)
    weights, running = _running(count)
    edges = np.array(profile.breakpoints, dtype=float)
    widths = np.diff(edges)[:, None]
    s = edges[:-1, None] + widths * nodes
    force = np.empty_like(s)
    rising = profile.breakpoints.index(1.0)
    force[:rising] = guarded(profile, "rise", s[:rising])
    force[rising:] = guarded(profile, "decay", s[rising:])
    # below, the pieces of all parts share one axis
    s = s.reshape(-1, count)
    force = force.reshape(-1, count)
    widths = (widths * np.diff(pieces(halvings))).reshape(-1, 1)
    weights = widths * weights
    with np.errstate(all="ignore"):
        impulse, area = _integral(force, widths, weights, running)
        path, whole = _integral(impulse, widths, weights, running)
        # the time from the centroid to the end, after which the path is a straight line
        after = whole / area
        path = np.maximum(path / area, 0)
        held = (weights * path * np.sqrt(path)).sum()
        off = s - (edges[-1] - after)
        mass = weights * force / area
        squared = off * off
        variance = (mass * squared).sum()
        skewness = (mass * squared * off).sum() / variance**1.5
        tails = (mass * squared * squared).sum() / variance**2
        q = np.sqrt(area) * (held - np.sqrt(after) * after**2 / 2.5)
    return float(area), float(q), float(skewness), float(tails)


def _integral(values: FloatArray, widths: FloatArray, weights: FloatArray, running: FloatArray) -> Any:
    """Running integrals at the nodes, shape (pieces, nodes), and the total integral."""
    wholes = (weights * values).sum(axis=1)
    ends = np.cumsum(wholes)
    return (ends - wholes)[:, None] + widths * product(values, running), ends[-1]


@cache
def _running(count: int) -> tuple[FloatArray, FloatArray]:
    """Weights, shape (count,), and matrix, shape (count, count), of a rule on a piece of width 1.

    A row of values at the nodes times the matrix gives the integrals from the start of the piece to each node.
    """
    share, weights = gauss_legendre(0, count, count)
    # integrals of the Lagrange polynomials of the nodes, from 0 to each node, by the same rule
    at = interpolation(share, np.outer(share, share).ravel()).reshape(count, count, count)
    return weights, share * (weights[:, None] * at).sum(axis=1).T
