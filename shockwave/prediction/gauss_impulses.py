"""Many impulses as a few with the same lowest moments."""

from __future__ import annotations

from contextlib import suppress
from importlib import import_module
from types import ModuleType

import numpy as np

from shockwave.quadrature import FloatArray

#: The law in C, several times as fast; None if it was built without a C compiler.
compiled: ModuleType | None = None
with suppress(ImportError):
    compiled = import_module("shockwave.prediction._moments")

# Norm of a Lanczos vector below which it is a rounding error.
_ROUNDING = 1e-14


def gauss(times: FloatArray, impulses: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Instants and impulses, shape (..., ``count``), with the same 2 ``count`` lowest moments, by Lanczos' recurrence.

    Parameters
    ----------
    times, impulses : numpy.ndarray, shape (..., points)
        Pulses as many impulses; impulses that are not positive are ignored.
    count : int
        Number of impulses to compute, at most 32: rounding errors grow in a longer recurrence. Where fewer suffice, the
        others are rounding errors.
    """
    if compiled is not None:
        instants, parts = np.empty((2, *times.shape[:-1], count))
        if compiled.gauss(times, impulses, instants, parts, times.size // times.shape[-1]):
            return instants, parts
    return numpy_gauss(times, impulses, count)


def numpy_gauss(times: FloatArray, impulses: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """`gauss` without the compiled code."""
    impulses = np.maximum(impulses, 0)
    total = impulses.sum(axis=-1, keepdims=True)
    mean = (impulses * times).sum(axis=-1, keepdims=True) / total
    scale = np.abs(times - mean).max(axis=-1, keepdims=True)
    position, vector, last = (times - mean) / scale, np.sqrt(impulses / total), np.zeros_like(times)
    jacobi, beside = np.zeros((*times.shape[:-1], count, count)), np.zeros_like(mean)
    for row in range(count):
        following = position * vector
        diagonal = (vector * following).sum(axis=-1, keepdims=True)
        jacobi[..., row, row] = diagonal[..., 0]
        jacobi[..., row, row - 1] = beside[..., 0]
        following -= diagonal * vector
        following -= beside * last
        beside = np.sqrt((following * following).sum(axis=-1, keepdims=True))
        last, vector = vector, following / np.maximum(beside, _ROUNDING)
    instants, turn = np.linalg.eigh(jacobi)
    return mean + scale * instants, total * turn[..., 0, :] ** 2
