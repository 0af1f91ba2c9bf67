"""Shock response spectrum of what reaches the structure behind a chain, from simulated histories."""

from __future__ import annotations

from typing import Any

import numpy as np
from attrs import evolve

from shockwave.base.errors import InvalidValueError, NumericalError, ShockwaveError
from shockwave.base.numerics import FloatArray
from shockwave.base.quantity_fields import Number, Quantity
from shockwave.base.text import percent
from shockwave.scene.shock import Shock
from shockwave.simulation.shock_spectrum import DAMPING, FREQUENCY, ShockSpectrum, greatest_responses, octave_fractions
from shockwave.simulation.wave_setup import RTOL

_MASS = Quantity("kg", "mass on which the force acts", above=0)
# First sampling interval in characteristic times, and least number of samples of the shock.
_INTERVAL = 0.05
_FEWEST = 200
# The interval is halved, and the tolerance of the simulation decreases tenfold, at most so many times, until two
# spectra differ by less than this.
_HALVINGS = 5
_TIGHTER = 0.1
_LEAST_RTOL = 1e-13
_AGREED = 1e-3
# Highest default frequency times the characteristic time: several periods within a solitary wave.
_HIGHEST = 5.0
# Acceleration at the end of the simulated time, over the greatest one, that is a warning.
_STILL_MOVING = 0.01
_TINY = 1e-300


def spectrum_of(
    result: Any, mass: Number | None, damping: Number, low: Number | None, high: Number | None
) -> ShockSpectrum:
    """Compute `Simulation.spectrum` of a result, from histories with smaller and smaller intervals."""
    structure, end, count = result.structure, result.chain.end, result.chain.count
    if count is None:
        raise InvalidValueError.of("chain.granules", "must be given for a spectrum (got an endless chain)")
    if structure is not None and structure.peak_acceleration is None:
        problem = "must let the end move (got a wall that is integrated as a fixed one; delete its mass"
        raise InvalidValueError.of("chain.end.stiffness", f"{problem}, and give that of the structure)")
    if structure is not None and mass is not None:
        problem = "must be left out for a movable end, whose acceleration is that of the base"
        raise InvalidValueError.of("mass", f"{problem} (got {mass})")
    if structure is None and mass is None:
        raise InvalidValueError.of("mass", "must be given for a force: the mass on which it acts (got none)")
    kilograms: float = _MASS.check("mass", mass) if structure is None else end.mass
    ratio, first, last = DAMPING.check("damping", damping), FREQUENCY.check("low", low), FREQUENCY.check("high", high)
    sensor: Any = {"contact": count - 2 + (result.scene.impact is not None)}
    if end is not None:
        sensor = "wall" if structure is None else "structure"
    spectra: list[FloatArray] = []
    errors = frequencies = np.ones(1)
    for halvings in range(_HALVINGS + 1):
        interval = _INTERVAL * result.characteristic_time / 2**halvings
        try:
            times, accelerations = _transmitted(result, sensor, interval, halvings, kilograms)
        except ShockwaveError:
            if halvings < 2:
                raise
            break
        if not halvings:
            last = last or _HIGHEST / result.characteristic_time
            frequencies = octave_fractions(first or min(1 / times[-1], last), last)
        histories = [(times, accelerations)]
        if result.shock is not None:
            histories.append(_applied(result.shock, interval, _FEWEST * 2**halvings, kilograms))
        spectra.append(np.array([greatest_responses(*each, frequencies, ratio) for each in histories]))
        if halvings:
            errors = np.max(np.abs(spectra[-1] - spectra[-2]) / np.maximum(spectra[-1], _TINY), axis=(0, 1))
            if errors.max() < _AGREED:
                break
    sizes = np.abs(accelerations)
    if not sizes.any():
        raise NumericalError("nothing reaches the structure by the end of the simulated time (extend until)")
    others = () if result.wave is None else result.run_warnings  # of the leading wave
    warnings = [warning for warning in result.first_warnings if warning not in others]
    if (share := sizes[-1] / sizes.max()) > _STILL_MOVING:
        rest = f"the acceleration is {percent(share)} of the greatest one"
        warnings.append(f"At the end of the simulated time {rest}, and later motion is left out (extend until).")
    force = "force at the last contact" if end is None else "force on the wall"
    shock = spectra[-1][1] if result.shock is not None else (None, None)
    return ShockSpectrum(
        frequencies=frequencies,
        acceleration=spectra[-1][0, 0],
        pseudo_velocity=spectra[-1][0, 1],
        errors=errors,
        damping=ratio,
        end=float(times[-1]),
        base="acceleration of the movable end" if structure else f"{force} over {kilograms:g} kg",
        mass=kilograms,
        input_acceleration=shock[0],
        input_pseudo_velocity=shock[1],
        scenario=result.scenario,
        warnings=tuple(warnings),
    )


def _transmitted(
    result: Any, sensor: Any, interval: float, halvings: int, mass: float
) -> tuple[FloatArray, FloatArray]:
    """Times [s], and acceleration of a movable end, or the force less its static part over the mass [m/s^2]."""
    method = {"integrator": None, "step": None, "backend": result.options.wanted_backend}
    rtol = max((result.options.rtol or RTOL) * _TIGHTER**halvings, _LEAST_RTOL)
    options = evolve(result.options, **method, rtol=rtol, sensors=[sensor], record=(), interval=interval)
    recording = result.computation.recording(evolve(result, options=options))
    histories = {history.name.removeprefix("structure_"): history.values for history in recording.sensors}
    if sensor == "structure":
        return recording.times, histories["acceleration"]
    (forces,) = histories.values()
    return recording.times, (forces - forces[0]) / mass


def _applied(shock: Shock, interval: float, fewest: int, mass: float) -> tuple[FloatArray, FloatArray]:
    """Times [s], and the force of the shock over the mass [m/s^2]."""
    even = np.linspace(0, shock.profile.duration_ratio, max(fewest, int(shock.duration / interval)) + 1)
    knots = np.union1d(even, shock.profile.breakpoints)
    return knots * shock.rise_time, shock.profile.force(knots) * (shock.peak_force / mass)
