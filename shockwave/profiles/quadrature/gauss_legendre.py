"""Adaptive composite Gauss-Legendre quadrature (Davis & Rabinowitz 1984, sections 2.7 and 6.2)."""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.polynomial.legendre import leggauss

from shockwave.base.numerics import FloatArray, product
from shockwave.profiles.quadrature.base import EPSILON, ROUNDINGS, Integral, Integrand, Quadrature

# Nodes of a panel.
_NODES = 16
# Largest number of bisections in one piece, for integrands that are not smooth.
_MAX_BISECTIONS = 2048
# Smallest fraction of the tolerance that is required of a panel; panels at a singular end are many but small.
_MIN_SHARE = 1 / 64
# Ratio of error estimate and rounding error below which a panel is not bisected.
_ROUNDING_REACHED = 4.0
# Smallest width of a panel in units of the spacing of floating-point numbers; the nodes must be distinct.
_MIN_WIDTH = 32.0


@functools.cache
def _rule() -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """The rule on [0, 1], over the whole panel (coarse) and over both halves (fine).

    Returns, in this order: the coarse nodes; the points at which a panel is sampled, which are its ends, its middle and
    the fine nodes, in ascending order; the weights of the fine rule at the points, 0 at middle and ends; the width
    around each point, which is the weight of a fine node, or the distance from the middle or an end to the next fine
    nodes; and the matrix that interpolates values from the coarse nodes to the points.
    """
    x, w = leggauss(_NODES)
    # Normalized weights: the rounding error of their sum would enter every integral.
    nodes, weights = (1 + x) / 2, w / w.sum()
    gap = nodes[0] / 2
    points = np.concatenate(([0.0], nodes / 2, [0.5], (1 + nodes) / 2, [1.0]))
    fine = np.concatenate(([0.0], weights / 2, [0.0], weights / 2, [0.0]))
    shares = np.concatenate(([gap], weights / 2, [2 * gap], weights / 2, [gap]))
    return nodes, points, fine, shares, interpolate(nodes, points)


def interpolate(nodes: FloatArray, points: FloatArray) -> FloatArray:
    """Lagrange polynomials of the nodes at the points, shape (points, nodes), accurate to rounding."""
    others = ~np.eye(len(nodes), dtype=bool)
    here = np.where(others, points[:, None, None] - nodes, 1.0).prod(axis=2)
    return np.asarray(here / np.where(others, nodes[:, None] - nodes, 1.0).prod(axis=1))


class GaussLegendre(Quadrature):
    """Gauss-Legendre quadrature on panels that are bisected until their interpolation is accurate.

    In each panel the polynomial p interpolates the integrand f at 16 Gauss nodes. The rule over the two halves gives
    the value. It is exact for p, so its error is at most the integral of ``|f - p|`` plus its approximation by the same
    rule. The error estimate is twice this approximation. It includes the middle and the ends of the panel, so that
    jumps in the gaps between the nodes are detected.

    References
    ----------
    Davis, P. J., & Rabinowitz, P. (1984). Methods of Numerical Integration, 2nd ed. Academic Press.
    """

    name = "gauss-legendre"

    def _piece(self, integrand: Integrand, lower: float, upper: float, tolerance: float) -> Integral:
        nodes, points, weights, shares, fit = _rule()
        # Rounding error of a point, and of its distance from either end, which the integrand may use.
        spacing = EPSILON * max(abs(lower), abs(upper))
        target = tolerance * min(1.0, upper - lower)
        values, errors = [], []
        panels = [(lower, upper - lower, integrand(lower + (upper - lower) * nodes))]
        bisections = 0
        while panels:
            left, width, coarse = panels.pop()
            seen = integrand(left + width * points)
            weighted = seen * weights
            misfit = np.abs(seen - product(coarse[None], fit.T)[0])
            error = 2 * width * float((misfit * shares).sum())
            # Rounding of the nodes changes the integral by at most the variation times the spacing.
            variation = float(np.abs(np.diff(seen)).sum())
            rounding = ROUNDINGS * EPSILON * width * float(np.abs(weighted).sum()) + spacing * variation
            allowed = max(target * max(width / (upper - lower), _MIN_SHARE), _ROUNDING_REACHED * rounding)
            narrow = width <= _MIN_WIDTH * EPSILON * max(abs(left), abs(left + width))
            if error <= allowed or narrow or bisections == _MAX_BISECTIONS:
                values.append(width * float(weighted.sum()))
                errors.append(error + rounding)
            else:
                bisections += 1
                # The fine values of a panel are the coarse values of its halves.
                middle = left + width / 2
                panels.append((middle, left + width - middle, seen[_NODES + 2 : -1]))
                panels.append((left, middle - left, seen[1 : _NODES + 1]))
        evaluations = nodes.size + points.size * (len(values) + bisections)
        return Integral(math.fsum(values), math.fsum(errors), evaluations, self.name)
