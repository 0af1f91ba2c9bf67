"""The model ``auto``: the cheapest of law, curve and simulation whose bound meets the tolerance.

What is cheap was measured (docs/auto.md): of many shocks of few shapes the short form of the law of moments costs a
fraction of a simulation, and so does a curve. The full law and section 4 cost more than a simulation by compiled code:
they are asked where there is none, or where a simulation is known to be dear, or has no answer.

It stands above both columns, which know nothing of it: the registry holds its address.
"""

from __future__ import annotations

import math
from collections import OrderedDict
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
from shockwave.profiles.guard import is_value
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.simulation.backend import chosen
from shockwave.studies.curve.build import any_chain
from shockwave.studies.curve.universal import UniversalCurve

__all__ = ["MODEL", "RTOL", "forget"]

#: The tolerance where none is given.
RTOL = 1e-3
# Tolerances that a curve can be made to, and a simulation asked for.
_CURVE_RTOL, _SIMULATION_RTOL = (1e-7, 1e-2), (1e-13, 1e-2)
# An estimate is no bound: so many times the estimate of a simulation are taken for one, and of the range of section 4,
# which holds 98 % of the shocks on which it was measured. What is wider than the last knows nothing.
_ESTIMATES, _RANGES, _USELESS = 2.0, 1.5, 0.5
# So is that of a curve, which may miss what lies between its nodes.
_CURVES = 2.0
# Waves of nearly equal height part slowly: a shock that lasts so many natural times, and rises again by this share of
# its peak, may take seconds to simulate. Of such shapes so many times the law's bound is taken, none if one part is so
# many times as long as another, as the law was not judged on such; it is no closer than the last of these there.
_SLOW, _RISES, _LAWS, _UNEVEN, _CLOSEST = 10.0, 0.05, 2.0, 30.0, 1e-2
# For so many shocks of one shape a curve is worth making at rtol 1e-2, and for more at finer ones, by this power; it is
# made for durations up to one of so many natural times. So many curves are kept.
_WORTH, _FINER, _LONGEST, _MOST_CURVES = 150, 0.17, (4.0, 8.0, 16.0, 32.0, 60.0), 64
# What is asked of a simulation that does not meet the tolerance: so many times that, then this.
_LOOSER, _PLAIN = 10.0, 1e-6
_UNKNOWN = "no method knows the primary of so long a shock: its waves part too slowly (shorten it)"
_ALONE = "auto tells the primary alone: later waves of a train are not listed"

Indices = npt.NDArray[np.intp]

_curves: OrderedDict[tuple[ShockProfile, float, float], UniversalCurve] = OrderedDict()


def forget() -> None:
    """Forget the curves that are kept; what comes of later calls is the same."""
    _curves.clear()


# ---------------------------------------------------------------- one shock


def _one(shock: ScaledShock, settings: Settings) -> ScaledAnswer:
    """As one of many, with its reason."""
    rtol = RTOL if settings.rtol is None else settings.rtol
    shape = np.zeros(1, dtype=np.intp)
    shocks = Shocks((shock.profile,), (shock.areas,), shape, np.array([shock.rise_time]), shock.momentum_parameter)
    short = short_law().of(shocks)
    peaks = _found(shocks, settings, short)
    if peaks.failures:
        raise NumericalError(peaks.failures[0])
    peak, bound, method = float(peaks.amplification[0]), float(peaks.high[0]), str(peaks.method[0])
    warnings, reason = [_ALONE], f"the cheapest whose bound, {bound:.1e}, meets {rtol:g}"
    if bound > rtol:
        reason = f"nothing comes nearer to {rtol:g} than {bound:.1e}"
        warnings.insert(0, f"the tolerance was not met: {reason}")
    sensitivity = -float(short[2][0]) if peak == short[0][0] else _sensitivity(shock, settings, method)
    answer = moments.answer(shock, settings, peak, bound, sensitivity, warnings)
    return evolve(answer, method=method, reason=reason)


def _sensitivity(shock: ScaledShock, settings: Settings, method: str) -> float | None:
    """d ln F / d ln A of the way that was taken, or None."""
    if method == "simulation":
        return None
    model = section4.predict if method == "section-4" else moments.predict
    return model(evolve(shock, momentum_parameter=MOMENTUM), settings).sensitivity


# ---------------------------------------------------------------- many shocks


def _many(shocks: Shocks, settings: Settings) -> Peaks:
    """As for one, each method for all shocks at once; a curve is made where many have one shape."""
    return _found(shocks, settings, short_law().of(shocks)) if len(shocks) else Peaks.of(0)


def _found(shocks: Shocks, settings: Settings, short: tuple[FloatArray, FloatArray, FloatArray]) -> Peaks:
    """By all ways, given what the short form of the law says."""
    rtol = RTOL if settings.rtol is None else settings.rtol
    peaks = Peaks.of(len(shocks))
    peaks.better(np.arange(len(shocks)), short[0], short[1], "moments")
    if not len(_left(peaks, rtol)):
        return peaks
    _by_curves(shocks, peaks, rtol)
    if chosen("auto") is None:
        _by_law(shocks, settings, peaks, _left(peaks, rtol))
        _by_section_4(shocks, settings, peaks, rtol)
    elif rtol >= _CLOSEST:
        _by_law(shocks, settings, peaks, _slow(shocks, _left(peaks, rtol)))
    reasons = _by_simulation(shocks, peaks, rtol)
    left = _left(peaks, rtol)
    _by_law(shocks, settings, peaks, left)
    for index in left.tolist():
        if peaks.high[index] > max(rtol, _USELESS):
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


def _slow(shocks: Shocks, left: Indices) -> Indices:
    """Those of ``left`` whose simulation may be slow."""
    long = left[_durations(shocks)[left] > _SLOW]
    return np.asarray(long[_cautions(shocks, long) > 1])


def _cautions(shocks: Shocks, where: Indices) -> FloatArray:
    """By what the bound of the full law is multiplied for these shocks."""
    shapes, back = np.unique(shocks.shapes[where], return_inverse=True)
    return np.array([_caution(shocks.profiles[shape]) for shape in shapes], dtype=float)[back]


def _caution(profile: ShockProfile) -> float:
    if reversal(profile) <= _RISES:
        return 1.0
    parts = np.diff(profile.breakpoints)
    return _LAWS if parts.max() <= _UNEVEN * parts.min() else math.inf


def _durations(shocks: Shocks) -> FloatArray:
    return np.array([profile.duration_ratio for profile in shocks.profiles])[shocks.shapes] * shocks.rise_times


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
    if len(left) < _worth(rtol):
        return
    left = left[_durations(shocks)[left] <= _LONGEST[-1]]
    counts = np.bincount(shocks.shapes[left], minlength=len(shocks.profiles))
    for shape in np.flatnonzero(counts >= _worth(rtol)):
        profile, own = shocks.profiles[shape], left[shocks.shapes[left] == shape]
        curve = _curve(profile, float(shocks.rise_times[own].max() * profile.duration_ratio), rtol / _CURVES)
        if curve is not None:
            times = shocks.rise_times[own]
            peaks.better(own, curve.amplification(times), _CURVES * curve.error(times), "curve")


def _by_simulation(shocks: Shocks, peaks: Peaks, rtol: float) -> dict[int, str]:
    """To the tolerance, or as near as it comes; reasons of those that it does not know."""
    chain, reasons = any_chain(), {}
    unit = Scales.of(chain, 1.0).time
    for wanted in (rtol, _LOOSER * rtol, _PLAIN):
        left = _left(peaks, rtol).tolist()
        if not left:
            break
        asked = min(max(wanted / _ESTIMATES, _SIMULATION_RTOL[0]), _SIMULATION_RTOL[1])
        scenes = [(shocks.profiles[shocks.shapes[i]], float(shocks.rise_times[i]) * unit) for i in left]
        given = [Shock(profile=profile, peak_force=1.0, rise_time=time) for profile, time in scenes]
        results = simulate_many(given, chain, rtol=asked, waves="primary")
        for index, result in zip(left, results, strict=True):
            if isinstance(result, SimulationResult):
                bound = _ESTIMATES * result.error_estimate
                peaks.better(np.array([index]), result.amplification, bound, "simulation")
            else:
                reasons[index] = str(result)
    return reasons


def _worth(rtol: float) -> float:
    """For how many shocks of one shape a curve is worth making."""
    if rtol < _CURVES * _CURVE_RTOL[0]:
        return math.inf
    return float(_WORTH * (_CURVE_RTOL[1] / min(rtol, _CURVE_RTOL[1])) ** _FINER)


def _curve(profile: ShockProfile, longest: float, rtol: float) -> UniversalCurve | None:
    """A curve for durations up to ``longest`` at least, if it can be had: one that is kept, or a new one."""
    # few ends, so that one that is kept is likely to do, and is the one that would be made anew
    end = next(each for each in _LONGEST if each >= longest)
    key = (profile, min(rtol, _CURVE_RTOL[1]), end)
    if is_value(profile) and key in _curves:
        _curves.move_to_end(key)
        return _curves[key]
    try:
        curve = UniversalCurve(*key)
    except NumericalError:
        return None
    if is_value(profile):
        _curves[key] = curve
        while len(_curves) > _MOST_CURVES:
            _curves.popitem(last=False)
    return curve


#: The model as it is registered.
MODEL = Model(_one, _many)
