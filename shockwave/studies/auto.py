"""The model ``auto``: the cheapest of law, curve and simulation whose bound meets the tolerance.

Costs were measured (docs/auto.md): for many shocks of few shapes the short form of the law of moments costs a fraction
of a simulation, and so does a curve. The full law and section 4 cost more than a simulation by compiled code: they are
used where there is none, or where a simulation is known to be expensive, or has no answer.

It stands above prediction and simulation, which do not import it: the registry holds its address.
"""

from __future__ import annotations

import math
from contextlib import suppress

import numpy as np
import numpy.typing as npt
from attrs import evolve

from shockwave.chain.chain import Scales
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.errors import NumericalError
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import simulate_many
from shockwave.prediction import moments, section4
from shockwave.prediction.expected_error import expected_error
from shockwave.prediction.model_interface import Model, Peaks, ScaledAnswer, ScaledShock, Settings, Shocks
from shockwave.prediction.short_shock_law import short_law
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.conditions import conditions, reversal
from shockwave.profiles.guard import kept
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.simulation.backend import chosen
from shockwave.studies.universal_curve import UniversalCurve, kept_curve, made_curve
from shockwave.studies.universal_curve_fit import any_chain

#: The tolerance where none is given.
RTOL = 1e-3
# Tolerances to which a curve can be made, and a simulation run.
_CURVE_RTOL = (1e-7, 1e-2)
_SIMULATION_RTOL = (1e-13, 1e-2)
# An estimate is no bound: the bound of a simulation is so many times its estimate, that of a curve, which may miss what
# lies between its nodes, so many times its own, and so is that of the law for slow shapes;
_CAUTION = 2.0
# that of section 4 is so many times its range, which holds 98 % of the shocks on which it was measured.
_RANGES = 1.5
# An answer with a greater bound than this is none.
_USELESS = 0.5
# Waves of nearly equal height part slowly: a shock that lasts so many characteristic times, and rises again by this
# share of its peak, may take seconds to simulate.
_SLOW = 10.0
_RISES = 0.05
# For such shapes the law is not used if one part is so many times as long as another, as it was not judged on such, nor
# below this tolerance.
_UNEVEN = 30.0
_CLOSEST = 1e-2
# For so many shocks of one shape a curve is worth making at rtol 1e-2, and for more at finer ones, by this power; it is
# made for durations up to one of so many characteristic times.
_WORTH = 150
_FINER = 0.17
_LONGEST = (4.0, 8.0, 16.0, 32.0, 60.0)
# Where a simulation misses the tolerance, so many times that is asked of it, then the last.
_LOOSER = 10.0
_PLAIN = 1e-6
_UNKNOWN = "no method knows the primary of so long a shock: its waves part too slowly (shorten it)"
_ALONE = "auto tells the primary alone: later waves of a train are not listed"

Indices = npt.NDArray[np.intp]


def forget() -> None:
    """Forget the curves that are kept; answers of later calls are the same."""
    made_curve.cache_clear()


def _one(shock: ScaledShock, settings: Settings) -> ScaledAnswer:
    """As one of many, with its reason."""
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
    if peaks.method[0] == "simulation":
        return None
    amplification, _, slope = short_law().of(shocks)
    if peaks.amplification[0] == amplification[0]:
        return -float(slope[0])
    model = section4.predict if peaks.method[0] == "section-4" else moments.predict
    return model(evolve(shock, momentum_parameter=MOMENTUM), settings).sensitivity


def _many(shocks: Shocks, settings: Settings) -> Peaks:
    """By each method in turn, for all shocks at once whose bounds do not meet the tolerance yet."""
    rtol = settings.rtol or RTOL
    peaks = Peaks.of(len(shocks))
    if not len(shocks):
        return peaks
    amplification, bound, _ = short_law().of(shocks)
    peaks.better(np.arange(len(shocks)), amplification, bound, "moments")
    _by_curves(shocks, peaks, rtol)
    if chosen("auto") is None:
        _by_law(shocks, settings, peaks, _left(peaks, rtol))
        _by_section_4(shocks, settings, peaks, rtol)
    elif rtol >= _CLOSEST:
        long = np.flatnonzero(_durations(shocks) > _SLOW)
        left = np.intersect1d(_left(peaks, rtol), long)
        _by_law(shocks, settings, peaks, left[_cautions(shocks, left) > 1])
    reasons = _by_simulation(shocks, peaks, rtol)
    _by_law(shocks, settings, peaks, _left(peaks, rtol))
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


def _durations(shocks: Shocks) -> FloatArray:
    return np.array([profile.duration_ratio for profile in shocks.profiles])[shocks.shapes] * shocks.rise_times


def _cautions(shocks: Shocks, where: Indices) -> FloatArray:
    """By what the bound of the full law is multiplied for these shocks."""
    profiles = [shocks.profiles[shape] for shape in shocks.shapes[where]]
    return np.array([_caution(profile) for profile in profiles], dtype=float)


@kept
def _caution(profile: ShockProfile) -> float:
    if reversal(profile) <= _RISES:
        return 1.0
    parts = np.diff(profile.breakpoints)
    return _CAUTION if parts.max() <= _UNEVEN * parts.min() else math.inf


def _by_law(shocks: Shocks, settings: Settings, peaks: Peaks, left: Indices) -> None:
    """The full law of moments."""
    if not len(left):
        return
    with suppress(NumericalError):
        found = moments.peaks(evolve(shocks, shapes=shocks.shapes[left], rise_times=shocks.rise_times[left]), settings)
        peaks.better(left, found.amplification, found.high * _cautions(shocks, left), "moments")


def _by_section_4(shocks: Shocks, settings: Settings, peaks: Peaks, rtol: float) -> None:
    for index in _left(peaks, rtol).tolist():
        # its errors were measured with the exact coefficient
        shock = evolve(shocks.shock(index), momentum_parameter=MOMENTUM)
        checked = conditions(shock.areas, shock.profile.duration_ratio)
        with suppress(NumericalError):
            answer = section4.predict(shock, settings)
            error, _ = expected_error(answer, shock, checked)
            if error is not None:
                peaks.better(np.array([index]), answer.amplitudes[0], _RANGES * max(map(abs, error)), "section-4")


def _by_curves(shocks: Shocks, peaks: Peaks, rtol: float) -> None:
    """Of shapes of which so many are left that a curve pays: what was asked before makes no difference."""
    left = _left(peaks, rtol)
    left = left[_durations(shocks)[left] <= _LONGEST[-1]]
    counts = np.bincount(shocks.shapes[left], minlength=len(shocks.profiles))
    for shape in np.flatnonzero(counts >= _worth(rtol)):
        own = left[shocks.shapes[left] == shape]
        # few lengths, so that a curve that is kept is likely to do, and is the one that would be made anew
        longest = next(each for each in _LONGEST if each >= _durations(shocks)[own].max())
        curve = kept_curve(shocks.profiles[shape], min(rtol / _CAUTION, _CURVE_RTOL[1]), longest)
        if isinstance(curve, UniversalCurve):
            times = shocks.rise_times[own]
            peaks.better(own, curve.amplification(times), _CAUTION * curve.error(times), "curve")


def _by_simulation(shocks: Shocks, peaks: Peaks, rtol: float) -> dict[int, str]:
    """To the tolerance, or as near as it comes; reasons of those that it does not know."""
    reasons: dict[int, str] = {}
    chain = any_chain()
    unit = Scales.of(chain, 1.0).time
    for wanted in (rtol, _LOOSER * rtol, _PLAIN):
        left = _left(peaks, rtol)
        asked = float(np.clip(wanted / _CAUTION, *_SIMULATION_RTOL))
        given = [
            Shock(profile=shocks.profiles[shape], peak_force=1.0, rise_time=float(rise_time) * unit)
            for shape, rise_time in zip(shocks.shapes[left], shocks.rise_times[left], strict=True)
        ]
        results = simulate_many(given, chain, rtol=asked, waves="primary")
        for index, result in zip(left, results, strict=True):
            if isinstance(result, SimulationResult):
                bound = _CAUTION * result.error_estimate
                peaks.better(np.array([index]), result.amplification, bound, "simulation")
            else:
                reasons[int(index)] = str(result)
    return reasons


def _worth(rtol: float) -> float:
    """For how many shocks of one shape a curve is worth making."""
    if rtol < _CAUTION * _CURVE_RTOL[0]:
        return math.inf
    return float(_WORTH * (_CURVE_RTOL[1] / min(rtol, _CURVE_RTOL[1])) ** _FINER)


#: The model as it is registered.
MODEL = Model(_one, _many)
