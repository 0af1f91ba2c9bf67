"""Signs that a record is not a pulse alone, and the keys that would make it one; loading applies none of them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from shockwave.quadrature import FloatArray

# Force over the peak force, and standard deviations of the noise, beyond which a sample is part of the pulse.
_CERTAIN = 0.05
_DEVIATIONS = 5
# Fewest quiet samples that are a level, and samples at each end of the record from which noise is estimated.
_FEWEST = 5
_RIM = 0.1
# Quiet samples from which a level is taken: near the pulse because of hum, but enough to average noise.
_NEAR = 20
# Share of steps up and of steps down among those of a quiet lead; a rising force has almost no steps down.
_BALANCED = 0.25
# Rounding of numbers in a file, over the peak force, and of numbers of samples.
_ROUNDING = 1e-6
# Smallest level, over the peak force, that is proposed as a baseline.
_LEVEL = 0.002
# Fewest equal samples at the greatest value of a clipped record, and pairs of them to each pair of equal ones below.
_FLAT = 3
_LONGER = 6
# Smallest step beside a clipped top over the median step: the top of a smooth pulse has smaller ones.
_EDGE = 0.02


def proposed(times: FloatArray, forces: FloatArray, baseline: bool, crop: bool) -> dict[str, tuple[float, float]]:
    """Time windows [s] for the keys ``baseline`` and ``crop``, as far as they are asked for and of use.

    Parameters
    ----------
    times, forces : array of float, shape (k,)
        Samples [s] and [N].
    baseline, crop : bool
        Whether to propose these keys.
    """
    peak, windows = int(np.argmax(forces)), {}
    (before, lead), (after, tail) = _side(forces[peak::-1]), _side(forces[peak:])
    quiet = peak - lead[::-1] if lead.size else peak + tail
    if baseline and quiet.size:
        level = float(forces[quiet].mean())
        if abs(level) > _LEVEL * (forces[peak] - level):
            windows["baseline"] = float(times[quiet[0]]), float(times[quiet[-1]])
    if crop and (before, after) != (peak, forces.size - 1 - peak):
        windows["crop"] = float(times[peak - before]), float(times[peak + after])
    return windows


def _side(forces: FloatArray) -> tuple[int, npt.NDArray[np.intp]]:
    """End of a pulse whose ``forces`` begin at the peak, and quiet samples beyond it, as far as they are a level."""
    rim = forces[-max(_FEWEST, int(_RIM * forces.size)) :]
    deviations = np.abs(forces - np.median(rim))
    certain = max(_CERTAIN * deviations[0], _DEVIATIONS * float(np.median(deviations[-rim.size :])))
    last = int(np.flatnonzero(deviations >= min(certain, deviations[0]))[-1])
    start = last + last // 2 + 1  # the force is below 5 % for a part of its rise
    quiet = np.arange(start, min(start + max(2 * last, _NEAR), forces.size))
    steps = np.diff(forces[quiet])
    up, down = np.count_nonzero(steps > 0), np.count_nonzero(steps < 0)
    if quiet.size < _FEWEST or min(up, down) < _BALANCED * (up + down):
        return forces.size - 1, quiet[:0]
    level, noise = forces[quiet].mean(), forces[quiet].std() + _ROUNDING * deviations[0]
    near, far = (_crossing(forces, last, level + height * noise) for height in (2, 8))
    # a force that begins as t^2 is four times as large at twice the time
    return min(max(int(2 * near - far + _ROUNDING), last), forces.size - 1), quiet


def _crossing(forces: FloatArray, begin: int, force: float) -> float:
    """Number of samples, with a fraction, after which ``forces`` first fall to ``force`` behind ``begin``."""
    at = max(begin + int(np.argmax(forces[begin:] <= force)), 1)
    before, behind = forces[at - 1], forces[at]
    return at - float((force - behind) / (before - behind)) if before > force >= behind else float(at)


def is_clipped(forces: FloatArray) -> bool:
    """Whether the top of a record is flat although its other samples differ, as that of a saturated sensor."""
    high = forces[forces >= 0.5 * (forces.max() + np.median(forces))]
    steps, at_top = np.abs(np.diff(high)), high[1:] == high.max()
    top, below = np.count_nonzero((steps == 0) & at_top), np.count_nonzero((steps == 0) & ~at_top)
    if top < _FLAT - 1 or top <= _LONGER * below or np.count_nonzero(steps) < _FLAT:
        return False
    return bool(high.max() - high[high < high.max()].max() > _EDGE * np.median(steps[steps > 0]))
