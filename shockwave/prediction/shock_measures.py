"""Quadrature points of a whole shock, and the integrals by which simulated peak forces are ordered."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from attrs import frozen

from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.prediction.model_interface import ScaledShock
from shockwave.profiles.base import ShockProfile
from shockwave.quadrature import FloatArray

# Pieces of a smooth part of the force halve towards both its ends so many times, for infinite slopes and steep decays.
_HALVINGS = 36
# A record of more parts than this needs no halving.
_SMOOTH_PARTS = 16
# Of a record of more parts than this, not every sample is used.
_MOST_PARTS = 2048
# Pieces wider than this share of a part lie in its middle.
_MIDDLE = 0.05
# Impulse by these points against the exact one: if they differ by more, they have missed something.
_MOST_MISSED = 1e-3


@frozen
class Measures:
    """Integrals of a shock by which simulated peak forces are ordered.

    Attributes
    ----------
    strength : float
        S, impulse over that of a wave of the shock's peak force, L / (A F0^(5/6)) with A exact.
    spread : float
        tau, standard deviation of the force as a density in time, over A F0^(-1/6) S^(-1/5), the time that a wave of
        the shock's impulse takes to pass.
    skewness : float
        Of that density.
    mean_force, cubic_mean_force : float
        Mean and cubic mean of the force over F0, each instant counting with its impulse: int F^2 / int F, and the
        cube root of int F^4 / int F.
    duration : float
        n t0/T0.
    """

    strength: float
    spread: float
    skewness: float
    mean_force: float
    cubic_mean_force: float
    duration: float

    def logarithms(self) -> FloatArray:
        """Of strength, mean force and cubic mean force, shape (3,)."""
        return np.log([self.strength, self.mean_force, self.cubic_mean_force])


def measures(shock: ScaledShock) -> Measures | None:
    """The measures of ``shock``; None where it is too fine, or too extreme, to have them to three digits."""
    s, weights = points(shock.profile)
    force = shock.profile.force(s)
    with np.errstate(all="ignore"):
        density = weights * force
        total = float(density.sum())
        if not abs(total / shock.areas.total - 1) <= _MOST_MISSED:
            return None
        off = s - float((density * s).sum()) / total
        means = [float((density * each).sum()) / total for each in (off**2, off**3, force, force**3)]
        variance, third_moment, mean_force, cubed_force = means
        strength = shock.impulse / MOMENTUM
        spread = math.sqrt(variance) * shock.rise_time / MOMENTUM * strength**0.2
        skewness = third_moment / variance**1.5
        found = Measures(strength, spread, skewness, mean_force, cubed_force ** (1 / 3), shock.duration)
        numbers = (found.spread, found.skewness, *found.logarithms())
    return found if np.isfinite(numbers).all() else None


def points(
    profile: ShockProfile, halvings: int = _HALVINGS, middle: int = 4, outer: int = 4
) -> tuple[FloatArray, FloatArray]:
    """Points s and weights for integrals over a whole profile.

    Parameters
    ----------
    profile : ShockProfile
        The profile; its breakpoints are the ends of the parts.
    halvings : int
        How many times the pieces of a smooth part halve towards both its ends.
    middle, outer : int
        Nodes of Gauss and Legendre on the wide pieces in the middle of a smooth part, and on the others.
    """
    breakpoints = profile.breakpoints
    parts = len(breakpoints) - 1
    if parts > _MOST_PARTS:
        breakpoints = (*breakpoints[: -1 : -(-parts // _MOST_PARTS)], breakpoints[-1])
    edges = np.array(breakpoints, dtype=float)
    # Between the samples of a record the force is linear: three nodes are exact for its fourth power.
    nodes, weights = gauss_legendre(halvings, middle, outer) if parts <= _SMOOTH_PARTS else gauss_legendre(0, 3, 3)
    widths = np.diff(edges)[:, None]
    return (edges[:-1, None] + widths * nodes).ravel(), (widths * weights).ravel()


@cache
def gauss_legendre(halvings: int, middle: int, outer: int) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre nodes and weights on [0, 1], on `pieces`; wide ones have ``middle`` nodes, others ``outer``."""
    edges = pieces(halvings)
    nodes, weights = [], []
    for begin, width in zip(edges[:-1], np.diff(edges), strict=True):
        x, own = np.polynomial.legendre.leggauss(middle if width > _MIDDLE else outer)
        nodes.append(begin + width * (1 + x) / 2)
        weights.append(width * own / 2)
    return np.concatenate(nodes), np.concatenate(weights)


def pieces(halvings: int) -> FloatArray:
    """Edges of pieces of [0, 1] that halve so many times towards both ends."""
    if not halvings:
        return np.array([0.0, 1.0])
    towards = np.append(0.0, 0.5 ** np.arange(halvings, 0, -1))
    return np.concatenate((towards, 1 - towards[-2::-1]))
