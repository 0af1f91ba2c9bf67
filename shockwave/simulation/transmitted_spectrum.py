"""Shock response spectrum of what reaches the structure behind a chain, from simulated histories."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from attrs import evolve

from shockwave.base.errors import InvalidValueError, NumericalError, ShockwaveError
from shockwave.base.numerics import FloatArray
from shockwave.base.quantity_fields import Number, Quantity
from shockwave.base.text import percent
from shockwave.scene.shock import Shock
from shockwave.simulation.contact_setup import ChainSetup
from shockwave.simulation.convergence_runs import run, tolerances_for
from shockwave.simulation.recording import sample_times
from shockwave.simulation.shock_spectrum import (
    DAMPING,
    FREQUENCY,
    ShockSpectrum,
    greatest_responses,
    octave_fractions,
)
from shockwave.simulation.simulation_result import Simulation

_MASS = Quantity("kg", "mass on which the force acts", above=0)
# First sampling interval in characteristic times, least number of samples of the shock, and number of times that the
# interval is halved, while the tolerance of a step decreases tenfold, until two spectra differ by less than this.
_INTERVAL = 0.05
_FEWEST = 200
_HALVINGS = 5
_TIGHTER = 0.1
_AGREED = 1e-3
# Highest default frequency times the characteristic time: several periods within a solitary wave.
_HIGHEST = 5.0
# Acceleration at the end of the simulated time, over the greatest one, that is a warning.
_STILL_MOVING = 0.01
_TINY = 1e-300
_History = tuple[FloatArray, FloatArray]


def spectrum_of(
    result: Simulation, mass: Number | None, damping: Number, low: Number | None, high: Number | None
) -> ShockSpectrum:
    """Compute `Simulation.spectrum`: from histories with smaller and smaller intervals, until two spectra agree."""
    chain, end = result.chain, result.chain.end
    movable = end is not None and end.mass is not None
    if chain.count is None or chain.contact_share != 1:
        got = "an endless chain" if chain.count is None else "a packing"
        raise InvalidValueError.of("chain.granules", f"must be a finite chain for a spectrum (got {got})")
    if movable and mass is not None:
        problem = "must be left out for a movable end, whose acceleration is that of the base"
        raise InvalidValueError.of("mass", f"{problem} (got {mass})")
    if not movable and mass is None:
        raise InvalidValueError.of("mass", "must be given for a force: the mass on which it acts (got none)")
    kilograms = end.mass if end is not None and end.mass is not None else _MASS.check("mass", mass)
    ratio, options = DAMPING.check("damping", damping), result.options
    options = evolve(options, integrator=None, step=None, record=("forces",), backend=options.wanted_backend)
    case = ChainSetup.of(options, result.scene)
    if movable and case.assembly.fixed_wall:
        problem = "must let the end move (got a wall that is integrated as a fixed one; delete its mass"
        raise InvalidValueError.of("chain.end.stiffness", f"{problem}, and give that of the structure)")
    tolerance, coarse = tolerances_for(case.rtol)
    until = run(case, coarse, case.until).end if result.end is None else result.end / case.scales.time
    first, last = FREQUENCY.check("low", low), FREQUENCY.check("high", high)
    last = last or _HIGHEST / case.scales.time
    frequencies = octave_fractions(first or min(1 / (until * case.scales.time), last), last)
    spectra: list[npt.NDArray[np.float64]] = []
    errors = np.ones(len(frequencies))
    for halvings in range(_HALVINGS + 1):
        interval = _INTERVAL / 2**halvings
        try:
            histories = [_transmitted(case, interval, tolerance * _TIGHTER**halvings, until, kilograms)]
        except ShockwaveError:
            if halvings < 2:
                raise
            break
        if result.shock is not None:
            histories.append(_applied(result.shock, interval * case.scales.time, _FEWEST * 2**halvings, kilograms))
        spectra.append(np.array([greatest_responses(*each, frequencies, ratio) for each in histories]))
        if halvings:
            changes = np.abs(spectra[-1] - spectra[-2]) / np.maximum(spectra[-1], _TINY)
            errors = changes.max(axis=(0, 1))
            if errors.max() < _AGREED:
                break
    accelerations = np.abs(histories[0][1])
    if not accelerations.any():
        raise NumericalError("nothing reaches the structure by the end of the simulated time (extend until)")
    others = () if result.wave is None else result.run_warnings  # of the leading wave
    warnings = [warning for warning in result.first_warnings if warning not in others]
    if (share := accelerations[-1] / accelerations.max()) > _STILL_MOVING:
        rest = f"the acceleration is {percent(share)} of the greatest one"
        warnings.append(f"At the end of the simulated time {rest}, and later motion is left out (extend until).")
    if errors.max() >= _AGREED:
        warnings.append(f"The spectra of two simulations agree to {errors.max():.0e} only (set a smaller rtol).")
    force = "force on the wall" if case.has_wall else "force at the last contact"
    acceleration, pseudo_velocity = spectra[-1][0]
    shock = spectra[-1][1] if result.shock is not None else (None, None)
    return ShockSpectrum(
        frequencies=frequencies,
        acceleration=acceleration,
        pseudo_velocity=pseudo_velocity,
        errors=errors,
        damping=ratio,
        end=until * case.scales.time,
        base="acceleration of the movable end" if movable else f"{force} over {kilograms:g} kg",
        mass=kilograms,
        input_acceleration=shock[0],
        input_pseudo_velocity=shock[1],
        scenario=result.scenario,
        warnings=tuple(warnings),
    )


def _transmitted(case: ChainSetup, interval: float, tolerance: float, until: float, mass: float) -> _History:
    """Times [s], and acceleration of the movable end, or the dynamic force over the mass [m/s^2]."""
    scales, assembly = case.scales, case.assembly
    times = sample_times(evolve(case.options, interval=interval * scales.time), scales, until, case.granules)
    motion = run(case, tolerance, until, times)
    forces = motion.samples_forces[:, -1] - assembly.static_forces[-1]
    if len(motion.v) > case.granules:
        forces = forces - assembly.end_stiffness * motion.samples_x[:, -1]
        forces -= assembly.end_damping * motion.samples_v[:, -1]
    return times * scales.time, forces * (scales.force / mass)


def _applied(shock: Shock, interval: float, fewest: int, mass: float) -> _History:
    """Times [s], and the force of the shock over the mass [m/s^2]."""
    ratio = shock.profile.duration_ratio
    even = np.linspace(0, ratio, max(fewest, int(shock.duration / interval)) + 1)
    knots = np.union1d(even, shock.profile.breakpoints)
    return knots * shock.rise_time, shock.profile.force(knots) * (shock.peak_force / mass)
