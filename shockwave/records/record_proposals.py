"""Proposals of keys that would reduce a record to its pulse; loading applies none of them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view

from shockwave.base.numerics import FloatArray
from shockwave.base.text import si

# Force over the peak force, and standard deviations of the noise, beyond which a sample is part of the pulse.
_CERTAIN = 0.05
_DEVIATIONS = 5
# Force of a second pulse over the peak force, and impulse of a tail over that of the record, that are cropped.
_SECOND = 0.25
_TAIL = 0.01
# Fewest quiet samples that are a level, and share of samples at each end of the record from which noise is estimated.
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
# Band of noise below the greatest value of a clipped record, over the range of all.
_BAND = 0.01


def propose(times: FloatArray, forces: FloatArray, baseline: bool, crop: bool) -> dict[str, tuple[float, float]]:
    """Time windows [s] for the keys ``baseline`` and ``crop``, as far as they are requested and useful.

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
    low = int(np.argmax(forces < _CERTAIN * forces[0]))
    again = forces[low:] > _SECOND * forces[0]
    if low and again.any():
        forces = forces[: low + int(np.argmin(forces[low : low + int(np.argmax(again))])) + 1]
    rim = forces[-max(_FEWEST, int(_RIM * forces.size)) :]
    deviations = np.abs(forces - np.median(rim))
    certain = max(_CERTAIN * deviations[0], _DEVIATIONS * float(np.median(deviations[-rim.size :])))
    last = int(np.flatnonzero(deviations >= min(certain, deviations[0]))[-1])
    start = last + last // 2 + 1  # the force is below 5 % for a part of its rise
    quiet = np.arange(start, min(start + max(2 * last, _NEAR), forces.size))
    steps = np.diff(forces[quiet])
    up, down = np.count_nonzero(steps > 0), np.count_nonzero(steps < 0)
    if quiet.size < _FEWEST or min(up, down) < _BALANCED * (up + down):
        tail = forces[2 * last + 1 :]
        is_slow = tail.size >= _NEAR and tail.sum() > _TAIL * forces.sum()
        return (int(_find_crossing(forces, last, 1.2 * tail.max())) if is_slow else forces.size - 1), quiet[:0]
    level, noise = forces[quiet].mean(), forces[quiet].std() + _ROUNDING * deviations[0]
    near, far = (_find_crossing(forces, last, level + height * noise) for height in (2, 8))
    # a force that begins as t^2 is four times as large at twice the time
    return min(max(int(2 * near - far + _ROUNDING), last), forces.size - 1), quiet


def _find_crossing(forces: FloatArray, begin: int, force: float) -> float:
    """Number of samples, with a fraction, after which ``forces`` first fall to ``force`` after ``begin``."""
    at = max(begin + int(np.argmax(forces[begin:] <= force)), 1)
    before, behind = forces[at - 1], forces[at]
    return at - float((force - behind) / (before - behind)) if before > force >= behind else float(at)


def sample_warnings(times: FloatArray, forces: FloatArray) -> list[str]:
    """Warnings of lost samples and of a clipped top."""
    sentences, steps = list[str](), np.diff(times)
    usual, at = float(np.median(steps)), int(np.argmax(steps))
    if steps[at] > 1.5 * usual and np.quantile(np.abs(steps - usual), 0.9) < 0.1 * usual:  # a gap between even samples
        sentences.append(f"Samples are lost: {round(steps[at] / usual) - 1} after {si(times[at], 's')}.")
    if _is_clipped(forces):
        sentences.append("The record is flat at its top, as of a saturated sensor: the true peak force is greater.")
    return sentences


def glitches(forces: FloatArray) -> list[int]:
    """Samples that are far from the four on each side: by twice the range of these, and a tenth of that of all."""
    if forces.size < 9:
        return []
    near = np.delete(sliding_window_view(forces, 9), 4, axis=1)
    limits = np.maximum(2 * np.ptp(near, axis=1), 0.1 * np.ptp(forces))
    return (np.flatnonzero(np.abs(forces[4:-4] - np.median(near, axis=1)) > limits) + 4).tolist()


def _is_clipped(forces: FloatArray) -> bool:
    """Whether the top of a record is flat although its other samples differ, as from a saturated sensor."""
    high = forces[forces >= 0.5 * (forces.max() + np.median(forces))]
    _, counts = np.unique(high, return_counts=True)
    bands = np.bincount(((high.max() - high) / (_BAND * np.ptp(forces))).astype(int))
    # of a round top, the first level or band has up to 2.4 times the samples of the next
    is_flat = counts.size > 3 <= counts[-1] > 2.5 * counts[:-1].max()
    return bool(is_flat or bands[0] >= 10 * max(1, bands[1:2].sum()))
