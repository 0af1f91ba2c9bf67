"""Edges of the thin layers in which a steep force rises or falls: steps and quadratures end there."""

from __future__ import annotations

# Where so many e-folds of a layer have passed. After the last of them rounding is all that is left of it.
_FOLDS = (2.0, 8.0, 36.0)
# Slower rates make no layer, and what is thinner than this share of the whole duration is a jump to every step.
_SLOWEST, _THINNEST = 100.0, 1e-9


def edges(begin: float, end: float, rate: float, duration: float) -> tuple[float, ...]:
    """Where the layer of a force that decays as exp(-rate u) has passed, u = (s - begin)/(end - begin).

    Parameters
    ----------
    begin, end : float
        Of the rise or the decay, in units of the rise time.
    rate : float
        Above zero the layer lies at ``begin``, below at ``end``.
    duration : float
        n, whole duration over rise time.

    Returns
    -------
    tuple of float
        Ascending, between ``begin`` and ``end``; none for a rate that makes no layer.
    """
    width = (end - begin) / abs(rate) if rate else 0.0
    if abs(rate) < _SLOWEST or width < _THINNEST * duration:
        return ()
    if rate > 0:
        return tuple(begin + folds * width for folds in _FOLDS)
    return tuple(end - folds * width for folds in reversed(_FOLDS))
