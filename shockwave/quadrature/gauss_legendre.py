"""Adaptive composite Gauss-Legendre quadrature (Davis & Rabinowitz 1984, sections 2.7 and 6.2)."""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.polynomial.legendre import leggauss

from shockwave.numerics import product
from shockwave.quadrature.base import EPSILON, ROUNDINGS, FloatArray, Integral, Integrand, Quadrature

_NODES = 16
# Panels halved in one piece: a rough integrand ends here.
_MOST_HALVED = 2048
# No panel needs to be better than this share of the tolerance: those at a singular end are many but small.
_LEAST_SHARE = 1 / 64
# A panel whose estimate has come down to so many times its rounding gains nothing from halving.
_ROUNDING_REACHED = 4.0
# Narrower panels, in units of the spacing of numbers, have no room for distinct nodes.
_NARROWEST = 32.0


@functools.cache
def _rule() -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """The rule on [0, 1], once over the whole panel (coarse) and once over either half (fine).

    The coarse nodes. The points at which a panel is sampled: its ends, and the fine nodes with the middle among them,
    ascending. The weights of the fine rule at the points, 0 at middle and ends. The width around each point:
    the weight of a fine node; the part of the panel between the middle or an end and the fine nodes next to it. The
    matrix that takes values at the coarse nodes to those of their interpolating polynomial at the points.
    """
    x, w = leggauss(_NODES)
    # The rounding of the sum of the weights, 2, would stay in every integral.
    nodes, weights = (1 + x) / 2, w / w.sum()
    gap = nodes[0] / 2
    points = np.concatenate(([0.0], nodes / 2, [0.5], (1 + nodes) / 2, [1.0]))
    fine = np.concatenate(([0.0], weights / 2, [0.0], weights / 2, [0.0]))
    shares = np.concatenate(([gap], weights / 2, [2 * gap], weights / 2, [gap]))
    return nodes, points, fine, shares, interpolation(nodes, points)


def interpolation(nodes: FloatArray, points: FloatArray) -> FloatArray:
    """Lagrange's polynomials of the nodes at the points, shape (points, nodes), good to rounding."""
    others = ~np.eye(len(nodes), dtype=bool)
    here = np.where(others, points[:, None, None] - nodes, 1.0).prod(axis=2)
    return np.asarray(here / np.where(others, nodes[:, None] - nodes, 1.0).prod(axis=1))


class GaussLegendre(Quadrature):
    """Gauss-Legendre on panels, halved until a panel's polynomial fits at points it was not made from.

    A panel has the polynomial p through 16 Gauss nodes. The rule over its two halves gives the value, and,
    as it is exact for p, errs by at most the integral of ``|f - p|`` and its own approximation to it. The
    estimate is twice that approximation, with the middle and the ends of the panel answering for the gaps
    between the nodes, so that a jump cannot hide.

    References
    ----------
    Davis, P. J., & Rabinowitz, P. (1984). Methods of Numerical Integration, 2nd ed. Academic Press.
    """

    name = "gauss-legendre"

    def _piece(self, integrand: Integrand, lower: float, upper: float, tolerance: float) -> Integral:
        nodes, points, weights, shares, fit = _rule()
        # How far a point may be rounded, and how far off its distance from either end, which the integrand may use.
        spacing = EPSILON * max(abs(lower), abs(upper))
        target = tolerance * min(1.0, upper - lower)
        values, errors = [], []
        panels = [(lower, upper - lower, integrand(lower + (upper - lower) * nodes))]
        halved = 0
        while panels:
            left, width, coarse = panels.pop()
            seen = integrand(left + width * points)
            weighted = seen * weights
            misfit = np.abs(seen - product(coarse[None], fit.T)[0])
            error = 2 * width * float((misfit * shares).sum())
            # Nodes moved by a spacing move the integral by the variation times the spacing.
            variation = float(np.abs(np.diff(seen)).sum())
            rounding = ROUNDINGS * EPSILON * width * float(np.abs(weighted).sum()) + spacing * variation
            allowed = max(target * max(width / (upper - lower), _LEAST_SHARE), _ROUNDING_REACHED * rounding)
            narrow = width <= _NARROWEST * EPSILON * max(abs(left), abs(left + width))
            if error <= allowed or narrow or halved == _MOST_HALVED:
                values.append(width * float(weighted.sum()))
                errors.append(error + rounding)
            else:
                halved += 1
                # Fine values of a panel are the coarse ones of its halves.
                middle = left + width / 2
                panels.append((middle, left + width - middle, seen[_NODES + 2 : -1]))
                panels.append((left, middle - left, seen[1 : _NODES + 1]))
        evaluations = nodes.size + points.size * (len(values) + halved)
        return Integral(math.fsum(values), math.fsum(errors), evaluations, self.name)
