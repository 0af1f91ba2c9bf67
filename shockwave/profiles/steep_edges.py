"""Edges of the thin layers in which a steep force rises or decays; steps and quadratures end there."""

from __future__ import annotations

# Edges, in e-folds from the beginning of a layer. After 36 e-folds the exponential is below the rounding error.
_FOLDS = (2.0, 8.0, 36.0)
# Least rate, in e-folds per rise or decay, of a force that has a boundary layer.
_LEAST_RATE = 100.0
# Least width of a layer, over the total duration. A thinner layer is treated as a discontinuity.
_LEAST_WIDTH = 1e-9


def find_edges(begin: float, end: float, rate: float, duration: float) -> tuple[float, ...]:
    """Edges of the boundary layer of a force that decays as exp(-rate u), u = (s - begin)/(end - begin).

    Parameters
    ----------
    begin, end : float
        Beginning and end of the rise or the decay, in units of the rise time.
    rate : float
        Rate of the decay. If it is positive, the layer lies at ``begin``, otherwise at ``end``.
    duration : float
        n, total duration over rise time.

    Returns
    -------
    tuple of float
        Edges in ascending order, between ``begin`` and ``end``; empty if there is no boundary layer.
    """
    width = (end - begin) / abs(rate) if rate else 0.0
    if abs(rate) < _LEAST_RATE or width < _LEAST_WIDTH * duration:
        return ()
    if rate > 0:
        return tuple(begin + folds * width for folds in _FOLDS)
    return tuple(end - folds * width for folds in reversed(_FOLDS))
