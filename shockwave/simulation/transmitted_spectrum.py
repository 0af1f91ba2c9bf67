"""Shock response spectrum of what reaches the structure behind a chain, from simulated histories."""

from __future__ import annotations

import math
from itertools import chain, repeat
from typing import Any

import numpy as np
from attrs import evolve
from scipy.linalg import expm

from shockwave.base.errors import InvalidValueError, NumericalError, ShockwaveError
from shockwave.base.numerics import FloatArray
from shockwave.base.quantity_fields import Declaration, Number
from shockwave.base.text import percent
from shockwave.scene.force_limit import name_force
from shockwave.scene.shock import Shock
from shockwave.simulation.later_forces import longer_time
from shockwave.simulation.shock_spectrum import DAMPING, FREQUENCY, ShockSpectrum, greatest_responses, octave_fractions
from shockwave.simulation.wave_setup import RTOL

_MASS = Declaration("kg", "mass on which the force acts", above=0)
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
    """Compute `Simulation.spectrum` of a result."""
    base, kilograms = _base(result, mass)
    ratio, first, last = DAMPING.check("damping", damping), FREQUENCY.check("low", low), FREQUENCY.check("high", high)
    times, accelerations = _transmitted_history(result, 0, kilograms)
    sizes, until = np.abs(accelerations), result.options.until or float(times[-1])
    if not sizes.any():
        longer = longer_time(until, result.chain.end)
        raise NumericalError(f"nothing reaches the structure by the end of the simulated time ({longer})")
    last = last or _HIGHEST / result.characteristic_time
    frequencies = octave_fractions(first or min(1 / times[-1], last), last)
    spectra, errors = _agreeing_spectra(result, kilograms, frequencies, ratio)
    others = () if result.wave is None else result.run_warnings  # of the leading wave
    warnings = [warning for warning in result.first_warnings if warning not in others]
    if (share := sizes[-1] / sizes.max()) > _STILL_MOVING:
        rest = f"the acceleration is {percent(share)} of the greatest one, and later motion is left out"
        longer = longer_time(max(until, 1 / frequencies[0]), result.chain.end)
        lacks = f"The error estimates do not include it, which matters most at low frequencies ({longer})"
        warnings.insert(0, f"At the end of the simulated time {rest}. {lacks}.")
    return ShockSpectrum(
        frequencies=frequencies,
        acceleration=spectra[0, 0],
        pseudo_velocity=spectra[0, 1],
        errors=errors,
        damping=ratio,
        end=float(times[-1]),
        base=base,
        mass=kilograms,
        input_acceleration=None if result.shock is None else spectra[1, 0],
        input_pseudo_velocity=None if result.shock is None else spectra[1, 1],
        scenario=result.scenario,
        warnings=tuple(warnings),
    )


def _base(result: Any, mass: Number | None) -> tuple[str, float]:
    """What accelerates the base, and its mass [kg]; raises for a result without a spectrum, or a wrong mass."""
    if result.chain.count is None:
        raise InvalidValueError.of("chain.granules", "must be given for a spectrum (got an endless chain)")
    if result.structure is None:
        if mass is None:
            raise InvalidValueError.of("mass", "must be given for a force: the mass on which it acts (got none)")
        kilograms: float = _MASS.check("mass", mass)
        return f"{name_force(result.chain.end)} over {kilograms:g} kg", kilograms
    if result.structure.peak_acceleration is None:
        problem = "must let the end move (got a wall that is integrated as a fixed one; delete its mass"
        raise InvalidValueError.of("chain.end.stiffness", f"{problem}, and give that of the structure)")
    if mass is not None:
        problem = "must be left out for a movable end, whose acceleration is that of the base"
        raise InvalidValueError.of("mass", f"{problem} (got {mass})")
    return "acceleration of the movable end", result.chain.end.mass


def _agreeing_spectra(
    result: Any, mass: float, frequencies: FloatArray, damping: float
) -> tuple[FloatArray, FloatArray]:
    """Spectra behind the chain and of the shock, shape (2 or 1, 2, k), and relative differences from coarser ones."""
    coarse = errors = np.zeros(0)
    for halvings in range(_HALVINGS + 1):
        try:
            histories = [_transmitted_history(result, halvings, mass)]
        except ShockwaveError:  # too many samples, or no time left
            if halvings < 2:
                raise
            break
        if result.shock is not None:
            interval = _interval(result, halvings)
            applied = _applied_history(result.shock, interval, _FEWEST * 2**halvings, mass)
            histories.append(applied if result.structure is None else _on_mounts(applied, result, interval))
        fine = np.array([greatest_responses(*history, frequencies, damping) for history in histories])
        if halvings:
            errors = np.max(np.abs(fine - coarse) / np.maximum(fine, _TINY), axis=(0, 1))
        coarse = fine
        if halvings and errors.max() < _AGREED:
            break
    return coarse, errors


def _interval(result: Any, halvings: int) -> float:
    return float(_INTERVAL * result.characteristic_time / 2**halvings)


def _transmitted_history(result: Any, halvings: int, mass: float) -> tuple[FloatArray, FloatArray]:
    """Times [s], and acceleration of a movable end, or the force less its static part over the mass [m/s^2]."""
    sensor: Any = {"contact": result.chain.count - 2 + (result.scene.impact is not None)}
    if result.chain.end is not None:
        sensor = "wall" if result.structure is None else "structure"
    method = {"integrator": None, "step": None, "backend": result.options.wanted_backend}
    rtol = max((result.options.rtol or RTOL) * _TIGHTER**halvings, _LEAST_RTOL)
    sampled = {"sensors": [sensor], "record": (), "interval": _interval(result, halvings)}
    recording = result.computation(
        "recording", evolve(result, options=evolve(result.options, **method, rtol=rtol, **sampled))
    )
    histories = {history.name.removeprefix("structure_"): history.values for history in recording.sensors}
    if sensor == "structure":
        return recording.times, histories["acceleration"]
    (forces,) = histories.values()
    return recording.times, (forces - forces[0]) / mass


def _applied_history(shock: Shock, interval: float, fewest: int, mass: float) -> tuple[FloatArray, FloatArray]:
    """Times [s], and the force of the shock over the mass [m/s^2]."""
    even = np.linspace(0, shock.profile.duration_ratio, max(fewest, int(shock.duration / interval)) + 1)
    knots = np.union1d(even, shock.profile.breakpoints)
    return knots * shock.rise_time, shock.profile.force(knots) * (shock.peak_force / mass)


def _on_mounts(applied: tuple[FloatArray, FloatArray], result: Any, interval: float) -> tuple[FloatArray, FloatArray]:
    """Times [s], and acceleration of the movable end under this force over its mass, on its spring and dashpot.

    Exact at the samples if the force is linear between them. It continues to the end of the simulated time.
    """
    times, drives = applied
    wall, steps = result.chain.end, np.diff(times) / interval
    # state: displacement, velocity, force over mass and its rate, with the interval as the unit of time
    rates = np.diag(np.ones(3), 1)
    rates[1, :2] = np.array([-wall.stiffness * interval, -wall.damping]) * interval / wall.mass
    after = np.arange(max(math.floor((result.end - times[-1]) / interval), 0) + 1)
    drives = np.append(drives, np.zeros(len(after)))  # a jump where the shock ends
    slopes = np.append(np.diff(drives[: len(times)]) / steps, np.zeros(len(after)))
    times = np.append(times, times[-1] + interval * after)
    propagators = chain(expm(rates * steps[:, None, None]), [np.eye(4)], repeat(expm(rates)))
    states = np.zeros((len(times), 2))
    for row, (propagator, drive, slope) in enumerate(zip(propagators, drives, slopes, strict=False), 1):
        states[row] = propagator[:2] @ (*states[row - 1], drive, slope)
    return times, drives + states @ rates[1, :2]
