"""The model ``auto``: the cheapest of section 4, law, curve and simulation whose bound meets the tolerance.

What is cheap was measured (docs/auto.md): the short form of the law of moments costs a fraction of a simulation, and so
does a curve if many shocks share it; section 4 costs about as much as one, where there is one wave. The full law of
moments, and section 4 for a train, cost more, unless the simulation runs without its compiled code.

It stands above both columns, which know nothing of it: the registry holds its address.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt
from attrs import evolve, frozen

from shockwave.chain.chain import Scales
from shockwave.curve.build import any_chain
from shockwave.curve.universal import UniversalCurve
from shockwave.errors import NumericalError, ShockwaveError
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import simulate_many
from shockwave.prediction.trust import told
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.conditions import conditions
from shockwave.profiles.guard import is_value
from shockwave.profiles.shock import Shock
from shockwave.simulation.backend import chosen
from shockwave.theory import moments, section4
from shockwave.theory.pulse import pulse_of
from shockwave.theory.scaled import Model, Peaks, ScaledAnswer, ScaledShock, Settings, Shocks
from shockwave.theory.short import short_law

__all__ = ["MODEL", "RTOL", "forget"]

#: The tolerance where none is given.
RTOL = 1e-3
# Tolerances that a curve can be made to, and a simulation asked for.
_CURVE_RTOL, _SIMULATION_RTOL = (1e-7, 1e-2), (1e-13, 1e-2)
# An estimate is no bound: so many times the estimate of a simulation are taken for one, and of the range of section 4,
# which holds 98 % of the shocks on which it was measured. What is wider than the last knows nothing.
_ESTIMATES, _RANGES, _USELESS = 2.0, 1.5, 0.5
# No range of section 4 is as narrow as this.
_NARROWEST = 1e-3
# For so many shocks of one shape a curve is worth making at rtol 1e-2, and for more at finer ones, by this power; it is
# made for durations up to one of so many natural times. So many curves are kept.
_WORTH, _FINER, _LONGEST, _MOST_CURVES = 150, 0.17, (4.0, 16.0, 60.0), 64
_STEP = 1e-4  # of ln t0, for a derivative
_ALONE = "auto tells the primary alone: later waves of a train are not listed"


@frozen
class _Found:
    """An answer for one shock: F/F0, its bound, and d ln F / d ln A or None."""

    method: str
    peak: float
    bound: float
    sensitivity: float | None = None


_Way = Callable[[ScaledShock, Settings, float], _Found | None]
_curves: OrderedDict[tuple[ShockProfile, float, float], UniversalCurve] = OrderedDict()


def forget() -> None:
    """Forget the curves that are kept; what comes of later calls is the same."""
    _curves.clear()


# ---------------------------------------------------------------- one shock


def _one(shock: ScaledShock, settings: Settings) -> ScaledAnswer:
    """By the first method, from cheap to dear, whose bound meets the tolerance."""
    rtol = RTOL if settings.rtol is None else settings.rtol
    laws: tuple[_Way, ...] = (_by_short_law, _by_section_4)
    if chosen("auto") is None:
        laws = (*laws, _by_moments, _by_section_4_of_trains)
    for way in (*laws, _by_simulation):
        found = way(shock, settings, rtol)
        if found is not None and found.bound <= rtol:
            break
    assert found is not None  # the last way has an answer, or raises
    warnings, reason = [_ALONE], f"the cheapest whose bound, {found.bound:.1e}, meets {rtol:g}"
    if found.bound > rtol:
        reason = f"nothing comes nearer to {rtol:g} than {found.bound:.1e}"
        warnings.insert(0, f"the tolerance was not met: {reason}")
    answer = moments.answer(shock, settings, found.peak, found.bound, found.sensitivity, warnings)
    return evolve(answer, method=found.method, reason=reason)


def _by_short_law(shock: ScaledShock, settings: Settings, rtol: float) -> _Found | None:
    shape, ratio = np.zeros(1, dtype=np.intp), np.array([shock.rise_time])
    one = Shocks((shock.profile,), (shock.areas,), shape, ratio, shock.momentum_parameter)
    peak, bound, slope = (float(each[0]) for each in short_law().of(one))
    return _Found("moments", peak, bound, -slope)


def _by_moments(shock: ScaledShock, settings: Settings, rtol: float) -> _Found | None:
    made, pulse = moments.law(), pulse_of(shock)
    bound = made.bound(pulse)
    if bound is None or bound > rtol:
        return None
    peak, longer = made.amplification([pulse, pulse.stretched(math.exp(_STEP))]).tolist()
    return _Found("moments", peak, bound, -math.log(longer / peak) / _STEP)


def _by_section_4(shock: ScaledShock, settings: Settings, rtol: float, trains: bool = False) -> _Found | None:
    if rtol <= _NARROWEST:
        return None
    train = moments.regime(shock)[0] == "train"
    checked = conditions(shock.areas, shock.profile.duration_ratio)
    if train is not trains or not all(condition.holds for condition in checked):
        return None
    answer = section4.predict(shock, settings)
    error, _ = told(answer, shock, checked)
    if error is None:
        return None
    return _Found("section-4", answer.amplitudes[0], _RANGES * max(map(abs, error)), answer.sensitivity)


def _by_section_4_of_trains(shock: ScaledShock, settings: Settings, rtol: float) -> _Found | None:
    return _by_section_4(shock, settings, rtol, trains=True)


def _by_simulation(shock: ScaledShock, settings: Settings, rtol: float) -> _Found:
    (found,) = _simulated([(shock.profile, shock.rise_time)], rtol)
    if isinstance(found, str):
        raise NumericalError(found)
    return _Found("simulation", *found)


# ---------------------------------------------------------------- many shocks


def _many(shocks: Shocks, settings: Settings) -> Peaks:
    """As for one, each method for all shocks at once; a curve is made where many have one shape."""
    rtol = RTOL if settings.rtol is None else settings.rtol
    peaks = Peaks.of(len(shocks))
    if not len(shocks):
        return peaks
    values, bounds, _ = short_law().of(shocks)
    good = np.flatnonzero(bounds <= rtol)
    peaks.fill(good, values[good], bounds[good], "moments")
    _fill_by_curves(shocks, peaks, rtol)
    if chosen("auto") is None:
        left = _left(peaks)
        found = moments.peaks(evolve(shocks, shapes=shocks.shapes[left], rise_times=shocks.rise_times[left]), settings)
        good = np.flatnonzero(found.high <= rtol)
        peaks.fill(left[good], found.amplification[good], found.high[good], "moments")
    left = _left(peaks)
    simulated = _simulated([(shocks.profiles[shocks.shapes[i]], float(shocks.rise_times[i])) for i in left], rtol)
    for index, each in zip(left.tolist(), simulated, strict=True):
        if isinstance(each, str):
            peaks.failures[index] = each
        else:
            peaks.fill(np.array([index]), np.array(each[0]), np.array(each[1]), "simulation")
    return peaks


def _left(peaks: Peaks) -> npt.NDArray[np.intp]:
    return np.flatnonzero(np.isnan(peaks.amplification))


def _fill_by_curves(shocks: Shocks, peaks: Peaks, rtol: float) -> None:
    """Of shapes of which so many are left that a curve pays: what was asked before makes no difference."""
    left = _left(peaks)
    ratios = np.array([profile.duration_ratio for profile in shocks.profiles])[shocks.shapes[left]]
    left = left[ratios * shocks.rise_times[left] <= _LONGEST[-1]]
    counts = np.bincount(shocks.shapes[left], minlength=len(shocks.profiles))
    for shape in np.flatnonzero(counts >= _worth(rtol)):
        profile, own = shocks.profiles[shape], left[shocks.shapes[left] == shape]
        curve = _curve(profile, float(shocks.rise_times[own].max() * profile.duration_ratio), rtol)
        if curve is None:
            continue
        bounds = curve.error(shocks.rise_times[own])
        own, bounds = own[bounds <= rtol], bounds[bounds <= rtol]
        peaks.fill(own, curve.amplification(shocks.rise_times[own]), bounds, "curve")


def _worth(rtol: float) -> float:
    """For how many shocks of one shape a curve is worth making."""
    return _WORTH * (_CURVE_RTOL[1] / min(rtol, _CURVE_RTOL[1])) ** _FINER if rtol >= _CURVE_RTOL[0] else math.inf


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


def _simulated(shocks: Sequence[tuple[ShockProfile, float]], rtol: float) -> list[tuple[float, float] | str]:
    """F/F0 and bound of each shape at its t0/T0, or why there is none."""
    chain, asked = any_chain(), min(max(rtol / _ESTIMATES, _SIMULATION_RTOL[0]), _SIMULATION_RTOL[1])
    unit = Scales.of(chain, 1.0).time
    results = simulate_many(
        [Shock(profile=profile, peak_force=1.0, rise_time=ratio * unit) for profile, ratio in shocks],
        chain,
        rtol=asked,
        waves="primary",
    )
    return [_judged(result, rtol) for result in results]


def _judged(result: SimulationResult | ShockwaveError, rtol: float) -> tuple[float, float] | str:
    if isinstance(result, ShockwaveError):
        return str(result)
    bound = _ESTIMATES * result.error_estimate
    if bound > max(rtol, _USELESS):
        return "no method knows the primary of so long a shock: its waves part too slowly (shorten it)"
    return result.amplification, bound


#: The model as it is registered.
MODEL = Model(_one, _many)
