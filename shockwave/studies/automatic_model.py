"""The model ``auto``: the cheapest of law, curve and simulation whose error bound meets the tolerance.

The costs were measured (docs/auto.md). For many shocks of few shapes, the short form of the law of moments and curves
cost a fraction of a simulation. The full law costs more than a simulation by compiled code; it is used without compiled
code, and if a simulation fails.
"""

from __future__ import annotations

import math
from contextlib import suppress

import numpy as np
import numpy.typing as npt
from attrs import evolve

from shockwave.chain.chain import HERTZ
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.errors import NumericalError
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import simulate, simulate_many
from shockwave.prediction import moments
from shockwave.prediction.model_interface import Model, Peaks, ScaledAnswer, ScaledShock, Settings, Shocks
from shockwave.prediction.shock_impulses import turns
from shockwave.prediction.short_shock_law import short_law
from shockwave.simulation.backend import chosen
from shockwave.studies.universal_curve import UniversalCurve, cached_curve
from shockwave.studies.universal_curve_fit import SCALED, scaled_shock

#: The tolerance if none is given.
RTOL = 1e-3
# Ranges of the tolerances of curves and of simulations.
_CURVE_RTOL = (1e-7, 1e-2)
_SIMULATION_RTOL = (1e-13, 1e-2)
# Error bound of a simulation or a curve over its error estimate, which is not a bound.
_SAFETY = 2.0
# Results with a greater error bound are failures.
_LARGEST_BOUND = 0.5
# Least number of shocks of one shape for which a curve is computed.
_SHOCKS_FOR_CURVE = 200
# Longest duration of such a curve [characteristic times].
_LONGEST = 60.0
_NO_METHOD = "no method covers a shock of this duration: its waves separate too slowly (shorten the shock)"
_LEADING_ONLY = "auto predicts only the leading wave: later waves of a train are not listed"

Indices = npt.NDArray[np.intp]


def _one(shock: ScaledShock, settings: Settings) -> ScaledAnswer:
    """Predict one shock, with the reason for the choice of the method."""
    rtol = settings.rtol or RTOL
    shocks = shock.alone
    peaks = _many(shocks, settings) if shock.exponent == HERTZ else _with_exponent(shock, settings, rtol)
    if peaks.failures:
        raise NumericalError(peaks.failures[0])
    bound = float(peaks.high[0])
    warnings = [_LEADING_ONLY]
    reason = f"the cheapest method accurate to {rtol:g} (error bound {bound:.1e})"
    if bound > rtol:
        reason = f"the smallest error bound is {bound:.1e} (requested: {rtol:g})"
        warnings.insert(0, f"the tolerance was not met: {reason}")
    sensitivity = _sensitivity(shock, shocks, settings, peaks)
    answer = moments.answer(shock, settings, float(peaks.amplification[0]), bound, sensitivity, warnings)
    return evolve(answer, method=str(peaks.method[0]), reason=reason)


def _sensitivity(shock: ScaledShock, shocks: Shocks, settings: Settings, peaks: Peaks) -> float | None:
    """d ln F / d ln A by the law of moments, or None if another method was used."""
    if peaks.method[0] != "moments":
        return None
    if shock.exponent == HERTZ:
        amplification, _, slope = short_law().of(shocks)
        if peaks.amplification[0] == amplification[0]:
            return -float(slope[0])
    return moments.predict(evolve(shock, momentum_parameter=MOMENTUM), settings).sensitivity


def _with_exponent(shock: ScaledShock, settings: Settings, rtol: float) -> Peaks:
    """Apply the law of moments and, if needed, simulation to a shock in a chain with another contact exponent."""
    peaks, only, message = Peaks.of(1), np.zeros(1, dtype=np.intp), _NO_METHOD
    with suppress(NumericalError):
        found = moments.predict(shock, settings)
        assert found.expected_error is not None
        peaks.better(only, found.amplitudes[0], found.expected_error[1], "moments")
    if peaks.high[0] > rtol:
        from shockwave.chain.contact_law import PowerContact  # Hertz's law does not need it

        chain = evolve(SCALED, contact=PowerContact(exponent=shock.exponent, stiffness=1.0))
        scaled = scaled_shock(shock.profile, shock.rise_time, chain)
        try:
            result = simulate(scaled, chain, rtol=float(np.clip(rtol / _SAFETY, *_SIMULATION_RTOL)), waves="primary")
            peaks.better(only, result.amplification, _SAFETY * result.error_estimate, "simulation")
        except NumericalError as error:
            message = str(error)
    if peaks.high[0] > max(rtol, _LARGEST_BOUND):
        peaks.failures[0] = message
    return peaks


def _many(shocks: Shocks, settings: Settings) -> Peaks:
    """Apply one method after another to the shocks whose error bounds do not meet the tolerance yet."""
    rtol = settings.rtol or RTOL
    peaks = Peaks.of(len(shocks))
    if not len(shocks):
        return peaks
    amplification, bound, _ = short_law().of(shocks)
    peaks.better(np.arange(len(shocks)), amplification, bound, "moments")
    _by_curves(shocks, peaks, rtol)
    if chosen("auto") is None:
        _by_law(shocks, settings, peaks, rtol)
    messages = _by_simulation(shocks, peaks, rtol)
    _by_law(shocks, settings, peaks, rtol)
    for index in np.flatnonzero(~(peaks.high <= max(rtol, _LARGEST_BOUND))).tolist():
        peaks.amplification[index], peaks.method[index] = math.nan, ""
        peaks.low[index], peaks.high[index] = -math.inf, math.inf
        peaks.failures[index] = messages.get(index, _NO_METHOD)
    missed = peaks.high[(peaks.high > rtol) & (peaks.method != "")]
    if len(missed):
        largest = f"the largest error bound is {missed.max():.1e} (requested: {rtol:g})"
        peaks.warnings.append(f"the tolerance was not met for {len(missed)} of {len(shocks)} shocks: {largest}")
    return peaks


def _left(peaks: Peaks, rtol: float) -> Indices:
    """Indices of the shocks whose error bounds do not meet the tolerance."""
    return np.asarray(np.flatnonzero(~(peaks.high <= rtol)))


def _by_law(shocks: Shocks, settings: Settings, peaks: Peaks, rtol: float) -> None:
    """Apply the full law of moments to shocks with one peak."""
    left = _left(peaks, rtol)
    left = left[[not turns(shocks.shock(index)) for index in left]]
    if len(left):
        with suppress(NumericalError):
            some = evolve(shocks, shapes=shocks.shapes[left], rise_times=shocks.rise_times[left])
            found = moments.peaks(some, settings)
            peaks.better(left, found.amplification, found.high, "moments")


def _by_curves(shocks: Shocks, peaks: Peaks, rtol: float) -> None:
    """Apply curves to shapes with enough shocks left, whether or not a curve is cached."""
    requested = min(rtol / _SAFETY, _CURVE_RTOL[1])
    if requested < _CURVE_RTOL[0]:
        return
    left = _left(peaks, rtol)
    for shape, profile in enumerate(shocks.profiles):
        own = left[shocks.shapes[left] == shape]
        own = own[shocks.rise_times[own] * profile.duration_ratio <= _LONGEST]
        curve = cached_curve(profile, requested, _LONGEST) if len(own) >= _SHOCKS_FOR_CURVE else None
        if isinstance(curve, UniversalCurve):
            times = shocks.rise_times[own]
            peaks.better(own, curve.amplification(times), _SAFETY * curve.error(times), "curve")


def _by_simulation(shocks: Shocks, peaks: Peaks, rtol: float) -> dict[int, str]:
    """Simulate to the tolerance; returns the messages of failed simulations by index."""
    left = _left(peaks, rtol)
    some = zip(shocks.shapes[left], shocks.rise_times[left].tolist(), strict=True)
    scaled = [scaled_shock(shocks.profiles[shape], rise_time) for shape, rise_time in some]
    requested = float(np.clip(rtol / _SAFETY, *_SIMULATION_RTOL))
    results = simulate_many(scaled, SCALED, rtol=requested, waves="primary")
    messages: dict[int, str] = {}
    for index, result in zip(left, results, strict=True):
        if isinstance(result, SimulationResult):
            bound = _SAFETY * result.error_estimate
            peaks.better(np.array([index]), result.amplification, bound, "simulation")
        else:
            messages[int(index)] = str(result)
    return messages


#: The registered model.
MODEL = Model(_one, _many)
