"""Granules that rebound from the loaded end of a chain, and granules that leave its free end."""

from __future__ import annotations

import numpy as np

from shockwave.base.numerics import FloatArray
from shockwave.engine.stretch import free_granules

#: Least backward velocity of an ejected granule, over the peak velocity of the granules in the leading wave.
EJECTED = 1e-3


def find_rebounding(v: FloatArray, ejected: float) -> tuple[tuple[float, ...], float]:
    """Velocities of the rebounding granules, and the momentum that they may still exchange with others.

    They extend from the loaded end to the last ejected granule and the granules that follow it backwards. Further on,
    a backward drift is caused by passing waves.
    """
    last = max((v < -ejected).nonzero()[0].tolist(), default=0)
    forward = last + int((v[last:] >= 0).argmax())
    end = forward if v[forward] >= 0 else len(v)
    region, beyond = v[:end], v[end:]
    loose = float(np.maximum(region, 0.0).sum() - np.minimum(beyond, 0.0).sum())
    return tuple(region[region < 0].tolist()), loose


def count_departed(x: FloatArray, v: FloatArray) -> int:
    """Number of granules that have left the free end: out of contact, and no two of them approaching each other."""
    return free_granules(-x[::-1], -v[::-1])
