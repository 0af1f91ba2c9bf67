"""The model ``auto``: the cheapest of law, curve and simulation whose bound meets the tolerance.

Costs were measured (docs/auto.md): for many shocks of few shapes the short form of the law of moments costs a fraction
of a simulation, and so does a curve. The full law costs more than a simulation by compiled code: it is used where there
is none, or where a simulation has no answer.
"""

from __future__ import annotations

import math
from contextlib import suppress

import numpy as np
import numpy.typing as npt
from attrs import evolve

from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.errors import NumericalError
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import simulate_many
from shockwave.prediction import moments
from shockwave.prediction.model_interface import Model, Peaks, ScaledAnswer, ScaledShock, Settings, Shocks
from shockwave.prediction.short_shock_law import short_law
from shockwave.profiles.conditions import reversal
from shockwave.simulation.backend import chosen
from shockwave.studies.universal_curve import UniversalCurve, kept_curve
from shockwave.studies.universal_curve_fit import scaled_scene

#: The tolerance where none is given.
RTOL = 1e-3
# Tolerances to which a curve can be made, and a simulation run.
_CURVE_RTOL = (1e-7, 1e-2)
_SIMULATION_RTOL = (1e-13, 1e-2)
# An estimate is no bound: the bound of a simulation or a curve is so many times its estimate.
_CAUTION = 2.0
# The full law is not used for a shock that rises again by this share of its peak.
_RISES = 0.05
# An answer with a greater bound than this is none.
_USELESS = 0.5
# A curve is made for at least so many shocks of one shape, up to this duration [characteristic times].
_WORTH = 200
_LONGEST = 60.0
_UNKNOWN = "no method answers for so long a shock: its waves separate too slowly (shorten it)"
_ALONE = "auto predicts the primary alone: later waves of a train are not listed"

Indices = npt.NDArray[np.intp]


def _one(shock: ScaledShock, settings: Settings) -> ScaledAnswer:
    """Answer one shock as one of many, with the reason."""
    rtol = settings.rtol or RTOL
    shape = np.zeros(1, dtype=np.intp)
    shocks = Shocks((shock.profile,), (shock.areas,), shape, np.array([shock.rise_time]), shock.momentum_parameter)
    peaks = _many(shocks, settings)
    if peaks.failures:
        raise NumericalError(peaks.failures[0])
    bound = float(peaks.high[0])
    warnings = [_ALONE]
    reason = f"the cheapest whose bound, {bound:.1e}, meets {rtol:g}"
    if bound > rtol:
        reason = f"nothing comes nearer to {rtol:g} than {bound:.1e}"
        warnings.insert(0, f"the tolerance was not met: {reason}")
    sensitivity = _sensitivity(shock, shocks, settings, peaks)
    answer = moments.answer(shock, settings, float(peaks.amplification[0]), bound, sensitivity, warnings)
    return evolve(answer, method=str(peaks.method[0]), reason=reason)


def _sensitivity(shock: ScaledShock, shocks: Shocks, settings: Settings, peaks: Peaks) -> float | None:
    """d ln F / d ln A of the method that was used, or None."""
    if peaks.method[0] != "moments":
        return None
    amplification, _, slope = short_law().of(shocks)
    if peaks.amplification[0] == amplification[0]:
        return -float(slope[0])
    return moments.predict(evolve(shock, momentum_parameter=MOMENTUM), settings).sensitivity


def _many(shocks: Shocks, settings: Settings) -> Peaks:
    """Apply each method in turn to all shocks whose bounds do not meet the tolerance yet."""
    rtol = settings.rtol or RTOL
    peaks = Peaks.of(len(shocks))
    if not len(shocks):
        return peaks
    amplification, bound, _ = short_law().of(shocks)
    peaks.better(np.arange(len(shocks)), amplification, bound, "moments")
    _by_curves(shocks, peaks, rtol)
    if chosen("auto") is None:
        _by_law(shocks, settings, peaks, rtol)
    reasons = _by_simulation(shocks, peaks, rtol)
    _by_law(shocks, settings, peaks, rtol)
    for index in np.flatnonzero(~(peaks.high <= max(rtol, _USELESS))).tolist():
        peaks.amplification[index], peaks.method[index] = math.nan, ""
        peaks.low[index], peaks.high[index] = -math.inf, math.inf
        peaks.failures[index] = reasons.get(index, _UNKNOWN)
    missed = peaks.high[(peaks.high > rtol) & (peaks.method != "")]
    if len(missed):
        counted = f"{len(missed)} have bounds above {rtol:g}, up to {missed.max():.1e}"
        peaks.warnings.append(f"the tolerance was not met: {counted}")
    return peaks


def _left(peaks: Peaks, rtol: float) -> Indices:
    return np.asarray(np.flatnonzero(~(peaks.high <= rtol)))


def _by_law(shocks: Shocks, settings: Settings, peaks: Peaks, rtol: float) -> None:
    """By the full law of moments, for shapes that do not rise again."""
    plain = np.array([reversal(profile) <= _RISES for profile in shocks.profiles])
    left = _left(peaks, rtol)
    left = left[plain[shocks.shapes[left]]]
    if len(left):
        with suppress(NumericalError):
            some = evolve(shocks, shapes=shocks.shapes[left], rise_times=shocks.rise_times[left])
            found = moments.peaks(some, settings)
            peaks.better(left, found.amplification, found.high, "moments")


def _by_curves(shocks: Shocks, peaks: Peaks, rtol: float) -> None:
    """By curves of the shapes with enough shocks left; earlier calls make no difference."""
    asked = min(rtol / _CAUTION, _CURVE_RTOL[1])
    if asked < _CURVE_RTOL[0]:
        return
    left = _left(peaks, rtol)
    for shape, profile in enumerate(shocks.profiles):
        own = left[shocks.shapes[left] == shape]
        own = own[shocks.rise_times[own] * profile.duration_ratio <= _LONGEST]
        curve = kept_curve(profile, asked, _LONGEST) if len(own) >= _WORTH else None
        if isinstance(curve, UniversalCurve):
            times = shocks.rise_times[own]
            peaks.better(own, curve.amplification(times), _CAUTION * curve.error(times), "curve")


def _by_simulation(shocks: Shocks, peaks: Peaks, rtol: float) -> dict[int, str]:
    """By simulation to the tolerance; reasons where it has no answer."""
    left = _left(peaks, rtol)
    scenes = [
        scaled_scene(shocks.profiles[shape], float(rise_time))
        for shape, rise_time in zip(shocks.shapes[left], shocks.rise_times[left], strict=True)
    ]
    asked = float(np.clip(rtol / _CAUTION, *_SIMULATION_RTOL))
    given = [shock for shock, _ in scenes]
    results = simulate_many(given, [chain for _, chain in scenes], rtol=asked, waves="primary")
    reasons: dict[int, str] = {}
    for index, result in zip(left, results, strict=True):
        if isinstance(result, SimulationResult):
            bound = _CAUTION * result.error_estimate
            peaks.better(np.array([index]), result.amplification, bound, "simulation")
        else:
            reasons[int(index)] = str(result)
    return reasons


#: The model as it is registered.
MODEL = Model(_one, _many)
