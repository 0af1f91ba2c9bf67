"""Histories of a chain as a whole, and the setup of another integration of it from its result."""

from __future__ import annotations

from typing import Any

import numpy as np
from attrs import evolve

from shockwave.base.numerics import FloatArray
from shockwave.registry.registry import load
from shockwave.scene.motion import Motion
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation.contact_setup import ChainSetup
from shockwave.simulation.convergence_runs import run, tolerances_for
from shockwave.simulation.recording import AFTER, Recording, sample_times
from shockwave.simulation.simulation_result import Simulation


def record_chain(result: Simulation) -> Recording:
    """Histories that the options of ``result`` request, by another integration of the chain.

    Raises
    ------
    InvalidValueError
        If the histories have too many values.
    """
    if result.wave is not None and not result.options.sensors:
        result = evolve(result, options=evolve(result.options, until=_end_of_wave(result)))
    case, end = setup_of_result(result)
    options, scales, count = result.options, case.scales, case.granules
    times = sample_times(options, scales, end, count, result.characteristic_time)
    motion = run(case, tolerances_for(case.rtol)[0], end, times)
    if result.chain.count is None:
        count = count_reached(motion.v)
    recorded: dict[str, Any] = {}
    if options.sensors:
        from shockwave.simulation.sensor_signals import histories_of  # most simulations have none

        recorded["sensors"] = histories_of(case, motion)
    if "forces" in options.record:
        forces = scales.contact_force * motion.samples_forces
        recorded["forces"] = forces[:, case.reported]
        if case.has_wall:
            recorded["wall_force"] = forces[:, -1]
        if result.scene.motion is not None:
            recorded["applied_force"] = _applied_force(result.scene.motion, case, times * scales.time, forces[:, 0])
    if "field" in options.record:
        recorded["displacements"] = scales.energy / scales.force * motion.samples_x[:, :count]
        recorded["velocities"] = scales.velocity * motion.samples_v[:, :count]
    if "energies" in options.record:
        squares = motion.samples_v**2 / case.assembly.inverse_masses
        recorded["kinetic_energy"] = scales.energy / 2 * np.add.reduce(squares, axis=1)
        if case.layout.law is None:
            contacts = np.add.reduce(case.assembly.potentials(motion.samples_x, motion.samples_energies), axis=1)
            spring = case.assembly.end_stiffness / 2 * motion.samples_x[:, -1] ** 2
            recorded["contact_energy"] = scales.energy * (contacts + spring)
    return Recording(times=times * scales.time, contacts=tuple(case.reported.tolist()), **recorded)


def _end_of_wave(result: Simulation) -> float:
    """Default end of the histories of a leading wave [s]."""
    options = result.options
    if options.until is not None:
        return options.until
    last = result.passage(max(options.contacts)) if options.contacts else result.primary
    return float(last.arrival_time + AFTER * result.characteristic_time)


def _applied_force(motion: Motion, case: ChainSetup, times: FloatArray, contact: FloatArray) -> FloatArray:
    """Force that a prescribed motion takes, from that at the first contact."""
    needed = case.layout.masses[0] * motion.course(times, 2) + contact
    return np.where(times <= motion.duration, needed, 0.0)


def chain_options(result: Simulation) -> SimulateOptions:
    """Options for the chain as a whole; without the integrator of the waves if that cannot step it."""
    options = result.options
    if result.wave is None:
        return options
    refused = load("integrators", result.integrator).refusal(damped=False)
    integrator = None if refused else result.integrator
    return evolve(options, step=None, integrator=integrator, backend=options.wanted_backend)


def setup_of_result(result: Simulation) -> tuple[ChainSetup, float]:
    """Setup of the chain of a result, of an endless one of the part that the waves reach, and its scaled end."""
    case = ChainSetup.of(chain_options(result), result.scene)
    if result.end is not None:
        return case, result.end / case.scales.time
    until = case.until
    return case, run(case, tolerances_for(case.rtol)[1], None).end if until is None else until


def count_reached(v: FloatArray) -> int:
    """Number of granules that the waves have reached."""
    return 1 + int(np.flatnonzero(v).max(initial=0))
