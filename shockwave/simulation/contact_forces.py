"""Simulation of chains beyond equal spheres, from excitation and chain to a result with error estimates."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any, cast

import numpy as np
from attrs import evolve

from shockwave.base.errors import NumericalError
from shockwave.base.numerics import FloatArray
from shockwave.base.text import round_bound, si
from shockwave.engine.backend import compiled_code
from shockwave.engine.chain_motion import ChainMotion
from shockwave.registry.registry import load
from shockwave.scene.force_limit import AGAIN, COLLISION, STILL_ACTS, WAVE, LeavingForce, name_force
from shockwave.scene.scene import Scene
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.scene.yielding import beyond_elastic, law_error
from shockwave.simulation.chain_histories import chain_options, count_reached
from shockwave.simulation.contact_setup import ChainSetup
from shockwave.simulation.contact_validity import first_yield, warn_created_energy, warn_overlaps, warn_unjudged
from shockwave.simulation.convergence_runs import NEGLIGIBLE, Runs, runs_of, warn_missed
from shockwave.simulation.later_forces import (
    Flags,
    advice,
    are_apart,
    later_end,
    later_force,
    later_remedy,
    offsets,
    stiffnesses,
)
from shockwave.simulation.movable_end import MovableEnd
from shockwave.simulation.recording import sample_times
from shockwave.simulation.result_parts import (
    ContactForces,
    Cost,
    Dissipated,
    SegmentEnergy,
    Train,
    Transmitted,
)
from shockwave.simulation.simulation_result import Simulation
from shockwave.simulation.wave_setup import scale_scene

# Computing time of the forces at the contacts of equal granules, per squared number of granules and per characteristic
# time of the duration of the shock [s]; the equivalents of each granule, and of each step with and without compiled
# code, in squared granules.
_PAIR_SECONDS = 1.8e-7
_ROW = 20.0
_STEP_PAIRS = {"compiled": 300.0, "numpy": 2100.0}
# Duration of a shock that makes a single wave, and beyond which waves along the whole chain make the time no longer
# [characteristic times], and the equivalent of granules that fly freely.
_SINGLE = 1.4
_MANY = 25.0
_FREE = 0.2
# Factor of this time for NumPy.
_NUMPY = 40.0
# Longest computing time of the forces without a timeout or an end of the simulated time [s].
_MOST_SECONDS = 25.0
# Least dynamic force on the wall of an unfinished wave, over its greatest.
_STILL_ACTING = 0.01
# Least velocity of a granule that flies off, relative to the fastest granule.
_EJECTED = 1e-3
#: Warning for endless chains.
NO_LIMIT = (
    "The peak force of the leading wave far along the chain is not determined: under precompression it approaches its"
    " limit too slowly. The forces at the contacts are accurate."
)


def simulate_chain(
    options: SimulateOptions, scene: Scene, computation: Callable[..., Any], case: ChainSetup | None = None
) -> Simulation:
    """Simulate a finite or precompressed chain with an excitation, and estimate the errors of the forces.

    ``computation`` is that of the result; ``case`` is the setup, if it is known.

    Raises
    ------
    InvalidValueError
        If a value is out of range, or a contact of the options is not one of the chain.
    NumericalError
        If the integrator fails, or the time limit is reached.
    """
    begin = time.perf_counter()
    runs = runs_of(case or ChainSetup.of(options, scene))
    case, motion, scales = runs.case, runs.motion, runs.case.scales
    if options.record:
        sample_times(options, scales, motion.end, case.granules)
    count, on_wall = case.granules, None
    if case.has_wall:
        impulse = motion.last_impulse * scales.momentum
        (numbers,) = runs.numbers_at(np.array([len(motion.forces) - 1]))
        on_wall = Transmitted(**numbers, impulse=impulse, impulse_error=runs.impulse_error)
    movable = len(motion.v) > count and not case.assembly.impedance
    velocities = scales.velocity * motion.v[:count]
    apart = are_apart(motion.x[:count], motion.v[:count], offsets(case, motion))
    yielding = first_yield(case, motion)
    if error := beyond_elastic(scene.chain, lambda: yielding):
        raise error
    endless, later, end = scene.chain.count is None, later_force(case, motion), MovableEnd.of(runs)
    reached = count_reached(motion.v) if endless else count
    return Simulation(
        scene=scene,
        options=case.options,
        integrator=motion.integrator,
        backend="numpy" if case.compiled is None else "compiled",
        wave=None,
        forces=ContactForces(contacts=runs.reported, greatest=runs.greatest, leaving=_leaving_force(runs, later, end)),
        transmitted=on_wall,
        structure=end and end.structure,
        end=motion.end * scales.time,
        arrival_time=None if endless or motion.arrival is None else motion.arrival * scales.time,
        velocities=tuple(velocities[:reached].tolist()),
        measured=_train(case, velocities, apart),
        restitution=_restitution(case, motion, velocities, apart),
        **_balance(case, motion),
        dissipated=_dissipated_energies(case, motion),
        segments=tuple(_segments(case, motion, reached)),
        end_energy=(float(motion.kinetic[-1]) + motion.end_energy) * scales.energy if movable else None,
        first_yield=yielding,
        characteristic_time=scales.time,
        run_cost=Cost(steps=runs.steps, force_evaluations=runs.evaluations, seconds=time.perf_counter() - begin),
        run_warnings=(
            *(end.warnings() if end else ()),
            *warn_missed(runs),
            *warn_created_energy(case, motion),
            *warn_overlaps(case, motion),
            *_warn_unfinished(case, motion, velocities, apart),
            *_later_warning(case, motion, later),
            *warn_unjudged(case, yielding),
            *[NO_LIMIT] * endless,
        ),
        computation=computation,
    )


def _balance(case: ChainSetup, motion: ChainMotion) -> dict[str, Any]:
    """Applied momentum and energy, and how far the sums of the final ones are from them."""
    masses, scales = 1 / case.assembly.inverse_masses, case.scales
    momentum = motion.applied_impulse + case.assembly.velocity * float(masses[0])
    carried = math.fsum(motion.v[: case.granules] * masses[: case.granules])
    passed = motion.last_impulse if case.has_wall else 0.0
    energy = motion.work + motion.initial_energy
    return {
        "applied_momentum": momentum * scales.momentum,
        "applied_energy": energy * scales.energy,
        "momentum_defect": abs(carried + passed - momentum) / (abs(momentum) or 1.0),
        "energy_defect": abs(motion.energy_balance) / (energy or 1.0),
    }


def forces_of(result: Simulation) -> ContactForces:
    """Greatest forces at the reported contacts of a finite chain of equal granules, at all contacts, and at the last.

    Raises
    ------
    NumericalError
        If the integration would take too long, fails, or reaches the time limit.
    """
    granules, options = cast(int, result.chain.granules), chain_options(result)
    is_slow = compiled_code(options.backend) is None or load("integrators", result.integrator).coefficients() is None
    code = "numpy" if is_slow else "compiled"
    if options.timeout is None and options.until is None:
        duration = max(scale_scene(result.scene)[0].duration, _SINGLE)
        pairs = granules * granules * max(min(duration, _MANY) - _SINGLE, _FREE)
        pairs += (_ROW * granules + _STEP_PAIRS[code]) * duration
        seconds = _PAIR_SECONDS * (_NUMPY if code == "numpy" else 1) * pairs
        if seconds > _MOST_SECONDS:
            took = f"the integration of {granules} granules would take about {seconds:.0f} s or more"
            raise NumericalError(f"{took} (set until or a timeout to integrate all the same)")
    runs = runs_of(ChainSetup.of(options, result.scene))
    leaving = _leaving_force(runs, later_force(runs.case, runs.motion))
    return ContactForces(contacts=runs.reported, greatest=runs.greatest, leaving=leaving)


# ---------------------------------------------------------------- parts of the result


def _leaving_force(runs: Runs, later: float, end: MovableEnd | None = None) -> LeavingForce:
    """The force at the last contact, less than ``later`` afterwards [N], with that of the spring behind it."""
    case, motion = runs.case, runs.motion
    if case.scene.chain.count is None:
        return LeavingForce(name=WAVE, remedy="simulate a finite chain")
    arrived, remedy = motion.arrival is not None, later_remedy(case, motion, later)
    force = runs.peak(-1).leaving(name_force(case.layout.wall), arrived, later)
    spring = None if end is None else end.leaving(arrived)
    remedies: dict[str, Any] = {"later_remedy": remedy}
    if not arrived:
        remedies["remedy"] = later_end(case, motion)
    if motion.residual_overlaps is not None and motion.residual_overlaps.any():  # otherwise nothing has flowed
        remedies["law_error"] = law_error(case.scene.chain)
    return evolve(force, **remedies, spring=spring and evolve(spring, **remedies))


def _warn_unfinished(case: ChainSetup, motion: ChainMotion, velocities: FloatArray, apart: Flags) -> Iterator[str]:
    """Warnings of results that may change after the end of the simulated time."""
    if motion.arrival is None and case.scene.chain.count is not None:
        last, rest = case.scene.chain.end_word or "last contact", f"({later_end(case, motion)})"
        reached = motion.dynamic_forces[-1] > _STILL_ACTING * motion.dynamic_forces.max()
        wave = "peak of the leading wave has not passed" if reached else "leading wave has not reached"
        yield f"The {wave} the {last} by the end of the simulated time {rest}."
    if case.layout.wall and not case.layout.law_contacts[-1]:
        closing = motion.x[case.granules - 1] - (motion.x[case.granules] if len(motion.x) > case.granules else 0.0)
        stiffness, overlap = stiffnesses(case, motion)[-1], max(float(offsets(case, motion)[-1] + closing), 0.0)
        excess = float(stiffness * overlap ** case.assembly.exponents[-1] - case.assembly.static_forces[-1])
        # a striker may lie on the chain; ahead of the wave there are rounding errors
        least = max(_STILL_ACTING * motion.dynamic_forces[-1], NEGLIGIBLE * motion.dynamic_forces.max())
        if min(abs(excess), abs(excess - case.assembly.weight)) > least > 0:
            rest = f"at the end of the simulated time: its impulse is incomplete {advice(case, motion)}"
            yield f"A wave acts on the {case.layout.wall.word} {rest}."
    if not case.layout.weight and _restitution(case, motion, velocities, apart) is not None:
        others = velocities[1:]
        if others.min() < velocities[0] or (case.has_wall and others.max() > -velocities[0]):
            yield "The striker may be struck again after the simulated time: its restitution is provisional."


def _later_warning(case: ChainSetup, motion: ChainMotion, later: float) -> Iterator[str]:
    """Warning of a greater force on the wall after the end of the simulated time."""
    end = case.layout.wall
    if end is not None and motion.arrival is not None and later > case.scales.force * motion.forces[-1]:
        if later < math.inf:
            force = f"of at most {si(round_bound(later, up=True), 'N', 3)}"
            yield f"{COLLISION} on the {end.word}, {force} {advice(case, motion, again=True)}."
        elif case.assembly.force is not None and motion.end < case.assembly.force.duration:
            yield f"{STILL_ACTS}: the {name_force(end)} may still grow {advice(case, motion)}."
        elif case.assembly.weight:
            yield f"{AGAIN}, with a greater {name_force(end)} (its bound is not known)."


def _segments(case: ChainSetup, motion: ChainMotion, granules: int) -> Iterator[SegmentEnergy]:
    """Energy of each segment, of so many granules in all."""
    count, contacts = case.granules, len(motion.forces)
    values = np.zeros((2, count))
    values[0] = case.scales.energy * motion.kinetic[:count]
    halves = case.scales.energy / 2 * np.array([motion.potential, motion.losses[:contacts]])
    values[:, :-1] += halves[:, : count - 1]
    values[:, 1:] += halves[:, : count - 1]
    if case.has_wall:
        values[:, -1] += 2 * halves[:, -1]
    energies, losses = values.tolist()
    begins = [0, *(np.flatnonzero(np.diff(case.layout.segments)) + 1).tolist(), count]
    for begin, end in pairwise(begins):
        energy, dissipated = math.fsum(energies[begin:end]), math.fsum(losses[begin:end])
        yield SegmentEnergy(first=begin, last=min(end, granules) - 1, energy=energy, dissipated=dissipated)


def _dissipated_energies(case: ChainSetup, motion: ChainMotion) -> Dissipated:
    """Energies dissipated by plastic flow, damping and a dashpot at the end."""
    losses, plastic = case.scales.energy * motion.losses, case.layout.plastic
    contacts, flows = len(motion.forces), False if plastic is None else np.isfinite(plastic.strengths)
    kinds = np.where(flows, losses[:contacts], 0.0), np.where(flows, 0.0, losses[:contacts]), losses[contacts:]
    plastic_energy, damping, end = (math.fsum(kind.tolist()) for kind in kinds)
    energy = motion.dissipated * case.scales.energy
    bar, end = (end, 0.0) if case.assembly.impedance else (0.0, end)
    return Dissipated(energy=energy, plastic=plastic_energy, damping=damping, end=end, bar=bar)


def _train(case: ChainSetup, velocities: FloatArray, apart: Flags) -> Train:
    """Granules that fly off the ends; those of a chain under static forces are not known."""
    if case.layout.static_forces.any():
        return Train(recoil_momentum=None, recoil_velocities=None)
    rebounding = _leaving_velocities(-velocities, apart)
    spalls = None if case.has_wall else tuple(_leaving_velocities(velocities[::-1], apart[::-1]).tolist())
    recoil = 0.0 - math.fsum(case.layout.masses[: len(rebounding)] * rebounding)
    return Train(recoil_momentum=recoil, recoil_velocities=tuple((-rebounding).tolist()), spall_velocities=spalls)


def _leaving_velocities(outwards: FloatArray, apart: Flags) -> FloatArray:
    """Velocities of the granules that fly off an end, outermost first, from the outward velocities of all granules."""
    free = len(outwards) if apart.all() else int(np.argmin(apart))
    slow = outwards[:free] <= _EJECTED * np.abs(outwards).max()
    return outwards[: int(np.argmax(slow)) if slow.any() else free]


def _restitution(case: ChainSetup, motion: ChainMotion, velocities: FloatArray, apart: Flags) -> float | None:
    if case.layout.weight:  # it falls back
        return motion.rebound and motion.rebound / case.assembly.velocity
    if not (case.scene.impact is not None and apart[0]):
        return None
    masses = case.layout.masses[1:]
    centre = 0.0 if case.has_wall else math.fsum(masses * velocities[1:]) / math.fsum(masses)
    away = centre - float(velocities[0])
    return away / case.layout.velocity if away > 0 else None
