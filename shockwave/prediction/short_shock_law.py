r"""The explicit form of the law of moments for short shocks: four integrals of the shape, three coefficients.

A shock that is much shorter than its wave transfers its impulse to the first granule. The difference from an
instantaneous impulse is the momentum that the first contact transmits during the shock. Let s = t/t0, let X(s) be the
displacement of a free granule (the double integral of the force) over the impulse a, and s' the centroid of the force.
The contact force is then proportional to X^(3/2) instead of (s - s')^(3/2), and the additional momentum is

    q = sqrt(a) int_0^n X^(3/2) - max(s - s', 0)^(3/2) ds.

The peak force of a shock with the impulse S, relative to that of a wave of its peak force, is below the impulse limit:

    F = 1.168181738 F0 S^(6/5) exp(-x / (1 + x (p0 + p1 g + p2 g^2))),   x = 1.1445 q (t0/T0)^3,

where g is the skewness of the force as a density in time. The term linear in x, with the cube of the rise time, is
known; the denominator is fitted and has no zero. The error is below c sqrt(h) x^(3/2), where the kurtosis h of that
density accounts for pulses with long tails. ``short_shock_law.json`` contains the coefficients, ``docs/fit_short.py``
computes them, and ``docs/auto.md`` describes their validation.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from attrs import field, frozen

from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.numerics import product
from shockwave.prediction.model_interface import Shocks
from shockwave.prediction.shock_impulses import alike, gauss_legendre, pieces
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.guard import guarded, kept, trusted
from shockwave.quadrature import FloatArray
from shockwave.quadrature.gauss_legendre import interpolation

#: Name of the file with the coefficients, beside this one.
RESOURCE = "short_shock_law.json"

#: Impulse limit of `shockwave.chain.solitary_wave` to more digits, simulated with rtol 1e-12 for seven shapes.
IMPULSE_LIMIT = 1.168181738
#: Coefficient of q (t0/T0)^3, simulated with rtol 1e-12 for sixteen shapes of duration T0/10: 1.14440 to 1.14455.
CORRECTION = 1.1445
# Relative uncertainty of the impulse limit.
_LIMIT_ERROR = 3e-9
# Rules for the integrals of a shape, tried in this order: halvings of its parts towards both their ends, fraction of
# the impulse that may be missed, most parts. Records are linear between samples and need no halvings; shapes with very
# many parts cannot have any.
_RULES = ((0, 1e-9, 100_000), (5, 1e-5, 16), (12, 1e-5, 64))
# Nodes on each piece.
_NODES = 4
# Nodes of the rule with which the results are compared.
_FEWER = 3
# Allowed difference of q between the two rules, over q.
_AGREED = 1e-3
# Allowed difference of skewness and kurtosis between the two rules, over the kurtosis.
_NEAR = 1e-2
# Halvings for q to ten digits.
_FINE = 20
# Most parts of a shape that gets these halvings; the parts of other shapes are short.
_SMOOTH_PARTS = 8
# Nodes on each piece for q to ten digits.
_FINE_NODES = 8
# Largest number of parts that are evaluated together, to limit the memory.
_MOST_TOGETHER = 20_000


@frozen(eq=False)
class ShortLaw:
    """Coefficients of the law.

    Attributes
    ----------
    coefficients : numpy.ndarray, shape (3,)
        Coefficients p0, p1 and p2.
    error : float
        Expected relative error over x^(3/2) and the square root of the kurtosis.
    farthest : float
        Largest x for which the law was validated.
    """

    coefficients: FloatArray = field(converter=np.array)
    error: float
    farthest: float

    def slope(self, x: FloatArray, skewness: FloatArray | float) -> FloatArray:
        """Denominator of the exponent."""
        p0, p1, p2 = self.coefficients
        return np.asarray(1 + x * (p0 + skewness * (p1 + skewness * p2)))

    def amplification(self, strength: FloatArray, x: FloatArray, skewness: FloatArray | float) -> FloatArray:
        """Amplification F/F0 of pulses from their integrals, which are arrays of the same shape.

        Parameters
        ----------
        strength : numpy.ndarray
            S, impulse over that of a wave of the shock's peak force.
        x : numpy.ndarray
            1.1445 q (t0/T0)^3.
        skewness : numpy.ndarray or float
            Skewness g.
        """
        return np.asarray(IMPULSE_LIMIT * np.exp(1.2 * np.log(strength) - x / self.slope(x, skewness)))

    def bound(self, x: FloatArray, tails: FloatArray | float) -> FloatArray:
        """Expected relative error, infinite where the law was not validated; ``tails`` is the kurtosis."""
        error = self.error * np.sqrt(tails) * x * np.sqrt(x) + _LIMIT_ERROR
        return np.where(x <= self.farthest, error, np.inf)

    def of(self, shocks: Shocks) -> tuple[FloatArray, FloatArray, FloatArray]:
        """F/F0, error bound, and d ln(F/F0) / d ln t0 of shocks, shape (shocks,) each.

        The bound is infinite where the shape is too fine for its integrals to be computed.
        """
        areas = [areas.total for areas in shocks.areas]
        first, skewness, tails = integrals(shocks.profiles, areas)[shocks.shapes].T
        x = CORRECTION * first * shocks.rise_times**3
        strength = np.array(areas)[shocks.shapes] / MOMENTUM * shocks.rise_times
        with np.errstate(over="ignore", invalid="ignore"):
            slope = 1.2 - 3 * x / self.slope(x, skewness) ** 2
            return self.amplification(strength, x, skewness), self.bound(x, tails), slope


@cache
def short_law() -> ShortLaw:
    """Law from the file of coefficients, read once."""
    text = (Path(__file__).parent / RESOURCE).read_text(encoding="utf-8")
    return ShortLaw(**json.loads(text)["law"])


# ---------------------------------------------------------------- integrals of shapes


def integrals(profiles: Sequence[ShockProfile], areas: Sequence[float]) -> FloatArray:
    """q, g and h of shapes with the areas a1 + a2, shape (shapes, 3); NaN for a shape that is too fine."""
    return _of_one(profiles[0], areas[0]) if len(profiles) == 1 else _integrals(profiles, areas)


@kept
def _of_one(profile: ShockProfile, area: float) -> FloatArray:
    return _integrals([profile], [area])


def correction(profile: ShockProfile) -> float:
    """q to about ten digits; the pieces of a shape with few parts are halved towards the ends of its parts."""
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
        for where in alike(np.where(left, parts, 0), _MOST_TOGETHER):
            shapes = [profiles[index] for index in where], [edges[index] for index in where], halvings
            whole, *found = _by_rule(*shapes, _NODES)
            _, *fewer = _by_rule(*shapes, _FEWER)
            good = (np.abs(whole / [areas[index] for index in where] - 1) <= missed) & (found[0] > 0)
            # the area alone could agree by chance
            off = np.abs(np.subtract(fewer, found))
            good &= (off[0] <= _AGREED * found[0]) & (off[1:] <= _NEAR * np.maximum(found[2], 1)).all(axis=0)
            result[where[good]] = np.transpose(found)[good]
    return result


def _by_rule(
    profiles: Sequence[ShockProfile], breakpoints: Sequence[Sequence[float]], halvings: int, count: int
) -> tuple[FloatArray, ...]:
    """Areas, q, skewness and kurtosis of shapes with the same number of parts, shape (shapes,) each."""
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
    # from here on the pieces of all parts are on one axis
    s, force = (values.reshape(len(edges), -1, count) for values in (s, force))
    widths = (widths * np.diff(pieces(halvings))).reshape(len(edges), -1, 1)
    weights = widths * weights
    with np.errstate(all="ignore"):
        impulse, area = _integral(force, widths, weights, running)
        path, whole = _integral(impulse, widths, weights, running)
        # time from the centroid to the end
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
    """Running integrals at the nodes, shape (shapes, pieces, nodes), and whole integrals, shape (shapes,)."""
    wholes = (weights * values).sum(axis=2)
    ends = np.cumsum(wholes, axis=1)
    return (ends - wholes)[:, :, None] + widths * product(values, running), ends[:, -1]


@cache
def _running(count: int) -> tuple[FloatArray, FloatArray]:
    """Weights, shape (count,), and matrix, shape (count, count), of a rule on a piece of width 1.

    A row of values at the nodes times the matrix gives the integrals from the beginning of the piece to each node.
    """
    share, weights = gauss_legendre(0, count, count)
    # integrals of the Lagrange polynomials from 0 to each node, by the same rule
    at = interpolation(share, np.outer(share, share).ravel()).reshape(count, count, count)
    return weights, share * (weights[:, None] * at).sum(axis=1).T
