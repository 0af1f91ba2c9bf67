"""Adaptive composite Gauss-Legendre quadrature (Davis & Rabinowitz 1984, sections 2.7 and 6.2)."""

from __future__ import annotations

import functools
import math

import numpy as np
import numpy.typing as npt
from attrs import frozen
from numpy.polynomial.legendre import leggauss

from shockwave.numerics import product
from shockwave.quadrature.base import FloatArray, Integral, Integrand, Quadrature

__all__ = ["GaussLegendre", "interpolation"]

_NODES = 16
# Halving 60 times leaves less of a piece than rounding loses of it, whatever the integrand does there.
_LEVELS = 60
# Panels halved in one piece: a rough integrand ends here.
_PANELS = 2048
# No panel needs to be better than this share of the tolerance: those at a singular end are many but small.
_LEAST_SHARE = 1 / 64
# Roundings of one value and of its product with a weight, in units of the machine epsilon.
_ROUNDINGS = 4.0
# A panel whose estimate has come down to so many times its rounding gains nothing from halving.
_ROUNDING_REACHED = 4.0
# Narrower panels, in units of the spacing of numbers, have no room for distinct nodes.
_NARROWEST = 32.0

_EPSILON = float(np.finfo(float).eps)


@frozen
class _Rule:
    """The rule on [0, 1], once over the whole panel (coarse) and once over either half (fine).

    ``points`` are where a panel is seen: the fine nodes in ascending order with the middle among them, and
    then the two ends. ``weights`` are those of the fine rule at the points, 0 at middle and ends. ``shares``
    are the widths that a point answers for: the weight of a fine node; the part of the panel between the
    middle or an end and the fine nodes next to it. ``interpolation`` takes values at the coarse nodes to
    those of their interpolating polynomial at the points.
    """

    nodes: FloatArray
    points: FloatArray
    weights: FloatArray
    shares: FloatArray
    interpolation: FloatArray


@functools.cache
def _rule() -> _Rule:
    x, w = leggauss(_NODES)
    # What the sum of the weights is off 2 would stay in every integral.
    nodes, weights = (1 + x) / 2, w / w.sum()
    gap = nodes[0] / 2
    points = np.concatenate((nodes / 2, [0.5], (1 + nodes) / 2, [0.0, 1.0]))
    fine = np.concatenate((weights / 2, [0.0], weights / 2, [0.0, 0.0]))
    shares = np.concatenate((weights / 2, [2 * gap], weights / 2, [gap, gap]))
    return _Rule(nodes, points, fine, shares, interpolation(nodes, points))


def interpolation(nodes: FloatArray, points: FloatArray) -> FloatArray:
    """Lagrange's polynomials of the nodes at the points, shape (points, nodes), good to rounding."""
    others = ~np.eye(len(nodes), dtype=bool)
    here = np.where(others, points[:, None, None] - nodes, 1.0).prod(axis=2)
    return np.asarray(here / np.where(others, nodes[:, None] - nodes, 1.0).prod(axis=1))


@frozen
class _Panels:
    """Panels of equal standing: edges (k,), coarse values (k, nodes), values at either edge (k,)."""

    left: FloatArray
    right: FloatArray
    coarse: FloatArray
    at_left: FloatArray
    at_right: FloatArray


@frozen
class _Seen:
    """What the fine rule makes of panels: values (k, points), integral, error and rounding, each (k,)."""

    values: FloatArray
    integral: FloatArray
    error: FloatArray
    rounding: FloatArray


class _Sampler:
    """The integrand on panels, counting the points and keeping them within the open piece.

    At the very ends the integrand may jump: 0**eta is 0, however small eta. ``spacing`` is how far a point
    may be rounded, and how far off its distance from either end, which the integrand may make use of.
    """

    def __init__(self, integrand: Integrand, lower: float, upper: float) -> None:
        self._integrand = integrand
        self._first, self._last = math.nextafter(lower, upper), math.nextafter(upper, lower)
        self.spacing = _EPSILON * max(abs(lower), abs(upper))
        self.evaluations = 0

    def __call__(self, left: FloatArray, right: FloatArray, points: FloatArray) -> FloatArray:
        """Values at ``points`` of [0, 1] on every panel, shape (panels, points)."""
        s = left[:, None] + (right - left)[:, None] * points
        s = np.minimum(np.maximum(s, self._first), self._last)
        self.evaluations += s.size
        return np.asarray(self._integrand(s.ravel()), dtype=float).reshape(s.shape)


class GaussLegendre(Quadrature):
    """Gauss-Legendre on panels, halved until a panel's polynomial fits at points it was not made from.

    A panel has the polynomial p through 16 Gauss nodes. The rule over its two halves gives the value, and,
    as it is exact for p, errs by at most the integral of ``|f - p|`` and its own approximation to it. The
    estimate is twice that approximation, with the middle and the ends of the panel answering for the gaps
    between the nodes, so that a jump cannot hide. All panels of a level are taken in one call.

    References
    ----------
    Davis, P. J., & Rabinowitz, P. (1984). Methods of Numerical Integration, 2nd ed. Academic Press.
    """

    name = "gauss-legendre"

    def _piece(self, integrand: Integrand, lower: float, upper: float, tolerance: float) -> Integral:
        sample = _Sampler(integrand, lower, upper)
        width = upper - lower
        target = tolerance * min(1.0, width)
        panels = _whole(sample, lower, upper)
        settled: list[tuple[FloatArray, FloatArray]] = []
        room = _PANELS
        for level in range(_LEVELS + 1):
            seen = _see(sample, panels)
            halved = _unfinished(panels, seen, target, width)[: room if level < _LEVELS else 0]
            keep = np.ones(len(panels.left), dtype=bool)
            keep[halved] = False
            settled.append((seen.integral[keep], (seen.error + seen.rounding)[keep]))
            if not halved.size:
                break
            room -= halved.size
            panels = _halves(panels, seen, halved)
        value, error = (math.fsum(np.concatenate(parts)) for parts in zip(*settled, strict=True))
        return Integral(value, error, sample.evaluations, self.name)


def _whole(sample: _Sampler, lower: float, upper: float) -> _Panels:
    left, right = np.array([lower]), np.array([upper])
    rule = _rule()
    values = sample(left, right, np.concatenate((rule.nodes, [0.0, 1.0])))
    return _Panels(left, right, values[:, :-2], values[:, -2], values[:, -1])


def _see(sample: _Sampler, panels: _Panels) -> _Seen:
    rule = _rule()
    inner = sample(panels.left, panels.right, rule.points[:-2])
    values = np.column_stack((inner, panels.at_left, panels.at_right))
    width = panels.right - panels.left
    misfit = np.abs(values - product(panels.coarse, rule.interpolation.T))
    # Nodes moved by a spacing move the integral by the variation times the spacing.
    variation = np.abs(np.diff(inner, axis=1)).sum(axis=1)
    weighted = values * rule.weights
    rounding = _ROUNDINGS * _EPSILON * width * np.abs(weighted).sum(axis=1) + sample.spacing * variation
    error = 2 * width * (misfit * rule.shares).sum(axis=1)
    return _Seen(values, width * weighted.sum(axis=1), error, rounding)


def _unfinished(panels: _Panels, seen: _Seen, target: float, width: float) -> npt.NDArray[np.intp]:
    """Indices of the panels worth halving, the worst first; none if together they reach the target."""
    widths = panels.right - panels.left
    allowed = np.maximum(target * np.maximum(widths / width, _LEAST_SHARE), _ROUNDING_REACHED * seen.rounding)
    spacing = _EPSILON * np.maximum(np.abs(panels.left), np.abs(panels.right))
    candidates = np.flatnonzero((seen.error > allowed) & (widths > _NARROWEST * spacing))
    if seen.error[candidates].sum() <= target:
        return candidates[:0]
    return candidates[np.argsort(-seen.error[candidates], kind="stable")]


def _halves(panels: _Panels, seen: _Seen, which: npt.NDArray[np.intp]) -> _Panels:
    """Both halves of the panels of those indices; fine values of a panel are coarse ones of its halves."""
    left, right, values = panels.left[which], panels.right[which], seen.values[which]
    middle, at_middle = left + (right - left) / 2, values[:, _NODES]
    return _Panels(
        np.concatenate((left, middle)),
        np.concatenate((middle, right)),
        np.concatenate((values[:, :_NODES], values[:, _NODES + 1 : 2 * _NODES + 1])),
        np.concatenate((panels.at_left[which], at_middle)),
        np.concatenate((at_middle, panels.at_right[which])),
    )
