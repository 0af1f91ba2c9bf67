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
from collections.abc import Iterator, Sequence
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from attrs import field, frozen

from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.numerics import product
from shockwave.prediction.model_interface import Indices, Shocks
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
# Parts that are worked on together.
_MOST_TOGETHER = 20_000


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
    return _of_one(profiles[0], areas[0]) if len(profiles) == 1 else _integrals(profiles, areas)


@kept
def _of_one(profile: ShockProfile, area: float) -> FloatArray:
    return _integrals([profile], [area])


def correction(profile: ShockProfile) -> float:
    """q to ten digits or so: pieces halve until they do not matter, unless there are so many that each is short."""
    halvings = _FINE if len(profile.breakpoints) - 1 <= _SMOOTH_PARTS else 0
    return float(_by_rule([profile], [profile.breakpoints], halvings, _FINE_NODES)[1][0])


def _integrals(profiles: Sequence[ShockProfile], areas: Sequence[float]) -> FloatArray:
    result, edges = np.full((len(profiles), 3), np.nan), [profile.breakpoints for profile in profiles]
    parts = np.array([len(each) - 1 for each in edges], dtype=int)
    records = [type(profile).__name__ == "Tabulated" and trusted(profile) for profile in profiles]
    for halvings, missed, most in _RULES:
        left = np.isnan(result[:, 0]) & (parts <= most)
        if not halvings:
            left &= records | (parts > _RULES[-1][-1])
        for where in _alike(np.flatnonzero(left), parts):
            shapes = [profiles[index] for index in where], [edges[index] for index in where], halvings
            whole, *found = _by_rule(*shapes, _NODES)
            _, *fewer = _by_rule(*shapes, _FEWER)
            good = (np.abs(whole / [areas[index] for index in where] - 1) <= missed) & (found[0] > 0)
            # the area alone may be right by chance
            off = np.abs(np.subtract(fewer, found))
            good &= (off[0] <= _AGREED * found[0]) & (off[1:] <= _NEAR * np.maximum(found[2], 1)).all(axis=0)
            result[where[good]] = np.transpose(found)[good]
    return result


def _alike(left: Indices, parts: Indices) -> Iterator[Indices]:
    """Of the indices ``left`` those of shapes with equally many parts, and not too many at once."""
    for count in np.unique(parts[left]).tolist():
        where = left[parts[left] == count]
        size = max(1, _MOST_TOGETHER // count)
        yield from (where[begin : begin + size] for begin in range(0, len(where), size))


def _by_rule(
    profiles: Sequence[ShockProfile], breakpoints: Sequence[Sequence[float]], halvings: int, count: int
) -> tuple[FloatArray, ...]:
    """Areas, q, g and kurtosis of shapes with equally many parts, shape (shapes,) each."""
    nodes, _ = gauss_legendre(halvings, count, count)
    weights, running = _running(count)
    edges = np.array(breakpoints, dtype=float)
    widths = np.diff(edges)[..., None]
    s = edges[:, :-1, None] + widths * nodes
    force = np.empty_like(s)
    for profile, parts, at, here in zip(profiles, breakpoints, s, force, strict=True):
        rising = parts.index(1.0)
        here[:rising] = guarded(profile, "rise", at[:rising])
        here[rising:] = guarded(profile, "decay", at[rising:])
    # below, the pieces of all parts share one axis
    s, force = (values.reshape(len(edges), -1, count) for values in (s, force))
    widths = (widths * np.diff(pieces(halvings))).reshape(len(edges), -1, 1)
    weights = widths * weights
    with np.errstate(all="ignore"):
        impulse, area = _integral(force, widths, weights, running)
        path, whole = _integral(impulse, widths, weights, running)
        # the time from the centroid to the end, after which the path is a straight line
        after = whole / area
        path = np.maximum(path / area[:, None, None], 0)
        held = (weights * path * np.sqrt(path)).sum(axis=(1, 2))
        off, mass = s - (edges[:, -1] - after)[:, None, None], weights * force / area[:, None, None]
        squared = off * off
        variance = (mass * squared).sum(axis=(1, 2))
        skewness = (mass * squared * off).sum(axis=(1, 2)) / variance**1.5
        tails = (mass * squared * squared).sum(axis=(1, 2)) / variance**2
        return area, np.sqrt(area) * (held - np.sqrt(after) * after**2 / 2.5), skewness, tails


def _integral(values: FloatArray, widths: FloatArray, weights: FloatArray, running: FloatArray) -> Any:
    """Running integrals at the nodes, shape (shapes, pieces, nodes), and total integrals, shape (shapes,)."""
    wholes = (weights * values).sum(axis=2)
    ends = np.cumsum(wholes, axis=1)
    return (ends - wholes)[:, :, None] + widths * product(values, running), ends[:, -1]


@cache
def _running(count: int) -> tuple[FloatArray, FloatArray]:
    """Weights, shape (count,), and matrix, shape (count, count), of a rule on a piece of width 1.

    A row of values at the nodes times the matrix gives the integrals from the start of the piece to each node.
    """
    share, weights = gauss_legendre(0, count, count)
    # integrals of the Lagrange polynomials of the nodes, from 0 to each node, by the same rule
    at = interpolation(share, np.outer(share, share).ravel()).reshape(count, count, count)
    return weights, share * (weights[:, None] * at).sum(axis=1).T
