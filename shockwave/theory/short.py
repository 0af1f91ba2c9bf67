r"""The law of moments for short shocks, written out: three integrals of the shape, three coefficients.

A shock of the impulse S, in that of a wave of its peak force, falls short of the impulse limit by

    F = 1.1681817 F0 S^(6/5) exp(-x / (1 + x (p0 + p1 g + p2 g^2))),   x = 1.1445 q (t0/T0)^3,

where g is the skewness of the force as a density in time, and q says how much momentum the first contact takes up
while the force acts: with s = t/t0, X(s) the double integral of the force over its impulse a and s' its centroid,

    q = sqrt(a) int_0^n X^(3/2) - max(s - s', 0)^(3/2) ds.

The first power of x is known (`shockwave.curve.short` says whence); the denominator is fitted. It has no zero, and
the error goes with x^(3/2). ``short.json`` holds the coefficients, ``docs/fit_short.py`` makes them, ``docs/auto.md``
tells how they were judged.
"""

from __future__ import annotations

import json
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from attrs import frozen

from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.guard import guarded, is_value, trusted
from shockwave.quadrature import FloatArray
from shockwave.theory.scaled import Shocks

__all__ = ["CORRECTION", "RESOURCE", "ShortLaw", "integrals", "short_law"]

#: Name of the file with the coefficients, beside this one.
RESOURCE = "short.json"

#: As of `shockwave.curve.short`: simulations at rtol 1e-12 gave 1.14440 to 1.14455.
CORRECTION = 1.1445
# What these two constants leave open: the last digit of 1.1681817, and a share of x.
_LIMIT_ERROR, _FIRST_ERROR = 5e-8, 1e-4
# How the integrals of a shape are taken: halvings of its parts towards both their ends, the share of the impulse that
# may be missed, the fewest and the most parts. A record is straight between its samples: it needs no halvings, and then
# misses nothing.
_RULES = ((0, 1e-9, 5, 100_000), (5, 1e-5, 1, 4), (12, 1e-5, 1, 64), (0, 1e-5, 65, 100_000))
_NODES = 4
# Shapes whose integrals are kept, and parts that are worked on together.
_MOST_KNOWN, _MOST_TOGETHER = 256, 20_000
_known: OrderedDict[ShockProfile, list[float]] = OrderedDict()


@frozen(eq=False)
class ShortLaw:
    """Coefficients of the law.

    Attributes
    ----------
    coefficients : numpy.ndarray, shape (3,)
        p0, p1, p2.
    error : float
        Relative error to be expected, over x^(3/2).
    farthest : float
        Of x; the law was judged up to there.
    """

    coefficients: FloatArray
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

    def bound(self, x: FloatArray) -> FloatArray:
        """Relative error to be expected, infinite where the law was not judged; same shape."""
        told = self.error * x * np.sqrt(x) + _FIRST_ERROR * x + _LIMIT_ERROR
        return np.where(x <= self.farthest, told, np.inf)

    def of(self, shocks: Shocks) -> tuple[FloatArray, FloatArray, FloatArray]:
        """F/F0, bound, and d ln(F/F0) / d ln t0 of shocks; the bound is infinite where the shape is too fine."""
        areas = [areas.total for areas in shocks.areas]
        correction, skewness = integrals(shocks.profiles, areas)[shocks.shapes].T
        x = CORRECTION * correction * shocks.rise_times**3
        strength = np.array(areas)[shocks.shapes] / MOMENTUM * shocks.rise_times
        with np.errstate(over="ignore", invalid="ignore"):
            slope = 1.2 - 3 * x / self.slope(x, skewness) ** 2
            return self.amplification(strength, x, skewness), self.bound(x), slope


@cache
def short_law() -> ShortLaw:
    """The law, read once."""
    text = resources.files(__package__).joinpath(RESOURCE).read_text(encoding="utf-8")
    entries: dict[str, Any] = json.loads(text)["law"]
    return ShortLaw(np.array(entries["coefficients"]), entries["error"], entries["farthest"])


# ---------------------------------------------------------------- the integrals of shapes


def integrals(profiles: Sequence[ShockProfile], areas: Sequence[float]) -> FloatArray:
    """q and g of shapes with these areas a1 + a2, shape (shapes, 2); NaN where one is too fine to have them."""
    if len(profiles) > _MOST_KNOWN:
        return _integrals(profiles, areas)
    # A series of shocks has few shapes; of very many, none comes again, and to look for it takes as long as the rest.
    values = [is_value(profile) for profile in profiles]
    kept = [_known.get(profile) if value else None for profile, value in zip(profiles, values, strict=True)]
    left = [index for index, found in enumerate(kept) if found is None]
    made = _integrals([profiles[index] for index in left], [areas[index] for index in left])
    for index, own in zip(left, made.tolist(), strict=True):
        kept[index] = own
        if values[index]:
            _known[profiles[index]] = own
    while len(_known) > _MOST_KNOWN:
        _known.popitem(last=False)
    return np.array(kept, dtype=float).reshape(-1, 2)


def _integrals(profiles: Sequence[ShockProfile], areas: Sequence[float]) -> FloatArray:
    result, edges = np.full((len(profiles), 2), np.nan), [profile.breakpoints for profile in profiles]
    left = list(range(len(profiles)))
    for halvings, missed, fewest, most in _RULES:
        for where in _by_parts(edges, left, fewest, most):
            area = np.array([areas[index] for index in where])
            whole, *found = _by_rule([profiles[index] for index in where], [edges[index] for index in where], halvings)
            good = (np.abs(whole / area - 1) <= missed) & (found[0] > 0) & np.isfinite(found[1])
            result[where[good]] = np.transpose(found)[good]
        left = np.flatnonzero(np.isnan(result[:, 0])).tolist()
    return result


def _by_parts(edges: Sequence[Sequence[float]], left: Sequence[int], fewest: int, most: int) -> Iterator[Any]:
    """Indices of shapes that have so many parts, arrays of those with equally many, and not too many at once."""
    found: dict[int, list[int]] = {}
    for index in left:
        found.setdefault(len(edges[index]) - 1, []).append(index)
    for parts, indices in found.items():
        if fewest <= parts <= most:
            size = max(1, _MOST_TOGETHER // parts)
            yield from (np.array(indices[begin : begin + size]) for begin in range(0, len(indices), size))


def _by_rule(
    profiles: Sequence[ShockProfile], breakpoints: Sequence[Sequence[float]], halvings: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Areas, q and g of shapes with equally many parts, shape (shapes,) each."""
    nodes, weights, running = _rule(halvings)
    edges = np.array(breakpoints, dtype=float)
    widths = np.diff(edges)[..., None]
    s, weights = edges[:, :-1, None] + widths * nodes, widths * weights
    force = _forces(profiles, breakpoints, s, nodes)
    with np.errstate(all="ignore"):
        impulse, area = _integral(force, widths, weights, running)
        path, whole = _integral(impulse, widths, weights, running)
        # the time from the centroid to the end, after which the path is a straight line
        after = whole / area
        path = np.maximum(path / area[:, None, None], 0)
        held = (weights * path * np.sqrt(path)).sum(axis=(1, 2))
        off, mass = s - (edges[:, -1] - after)[:, None, None], weights * force
        squared = mass * off * off
        skewness = (squared * off).sum(axis=(1, 2)) / area / (squared.sum(axis=(1, 2)) / area) ** 1.5
        return area, np.sqrt(area) * (held - np.sqrt(after) * after**2 / 2.5), skewness


def _forces(
    profiles: Sequence[ShockProfile], breakpoints: Sequence[Sequence[float]], s: FloatArray, nodes: FloatArray
) -> FloatArray:
    """At the nodes of each part, shape (shapes, parts, nodes): none of them lies on the border of rise and decay."""
    if all(type(profile).__name__ == "Tabulated" and trusted(profile) for profile in profiles):
        # read off the samples, not searched for: that would be most of the work
        values = np.array([profile._pulse.values for profile in profiles])  # type: ignore[attr-defined]
        return np.asarray(values[:, :-1, None] + np.diff(values)[..., None] * nodes)
    force = np.empty_like(s)
    for profile, edges, at, here in zip(profiles, breakpoints, s, force, strict=True):
        rising = edges.index(1.0)
        here[:rising], here[rising:] = guarded(profile, "rise", at[:rising]), guarded(profile, "decay", at[rising:])
    return force


def _integral(values: FloatArray, widths: FloatArray, weights: FloatArray, running: FloatArray) -> Any:
    """The running integrals at the nodes, shape (shapes, parts, nodes), and the whole ones, shape (shapes,)."""
    wholes = (weights * values).sum(axis=2)
    ends = np.cumsum(wholes, axis=1)
    return (ends - wholes)[:, :, None] + widths * (values @ running), ends[:, -1]


@cache
def _rule(halvings: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Gauss-Legendre nodes and weights on [0, 1], on pieces that halve towards both ends; and running integrals.

    The last, of shape (nodes, nodes), makes of values at the nodes, a row, their integrals from 0 to each node.
    """
    towards = np.append(0.0, 0.5 ** np.arange(halvings, 0, -1))
    edges = np.concatenate((towards, 1 - towards[-2::-1])) if halvings else np.array([0.0, 1.0])
    x, weights = np.polynomial.legendre.leggauss(_NODES)
    powers = np.arange(1, _NODES + 1)
    share = (1 + x) / 2
    # integrals of the polynomials that are 1 at one node and 0 at the others
    own = np.linalg.solve(share[:, None] ** (powers - 1), np.eye(_NODES)).T @ (
        share ** powers[:, None] / powers[:, None]
    )
    pieces = np.diff(edges)
    nodes = (edges[:-1, None] + pieces[:, None] * share).ravel()
    every = (pieces[:, None] * weights / 2).ravel()
    count = len(nodes)
    running = np.zeros((count, count))
    for index, width in enumerate(pieces):
        here = slice(index * _NODES, (index + 1) * _NODES)
        running[here, here] = width * own
        running[here, here.stop :] = every[here, None]
    return nodes, every, running
