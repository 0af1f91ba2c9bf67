"""Simulation of chains beyond equal spheres, from excitation and chain to a result with error estimates."""

from __future__ import annotations

import math
import time
from itertools import pairwise
from typing import NamedTuple, cast

import numpy as np
import numpy.typing as npt
from attrs import evolve
from numpy.lib.stride_tricks import sliding_window_view

from shockwave.chain.chain import Chain
from shockwave.chain.impact import Impact
from shockwave.errors import NumericalError
from shockwave.measurement.chain_result import ChainResult, SegmentEnergy, Transmitted
from shockwave.measurement.chain_setup import ChainSetup
from shockwave.measurement.contact_peaks import ContactPeak, Yielding, first_yield_force
from shockwave.measurement.recording import Recording, sample_times
from shockwave.measurement.result import Cost, SimulationResult
from shockwave.measurement.simulation_setup import immeasurable, scaled
from shockwave.options import SimulateOptions
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.scene_summary import ChainScene
from shockwave.simulation.assembly import Motion, integrate
from shockwave.simulation.time_limit import time_limit

# Error tolerance of a step of the first run over the requested relative error, and the factor from run to run.
_FIRST = 1.0
_TIGHTER = 0.1
# Least error tolerance of a step; below it, rounding errors dominate.
_TIGHTEST = 1e-15
# Largest number of runs: two show the error, each further one corrects a result that misses its tolerance.
_RUNS = 5
# The relative error of a force is twice the largest difference of the last two runs at this number of contacts on both
# sides, for it may vanish by chance at one of them, plus the error tolerance of a step; docs/check_chains.py measures
# how often it holds.
_NEIGHBOURS = 3
_DIFFERENCES = 2.0
# Relative rounding error of a total force.
_ROUNDING = 1e-14
# Tightest tolerance of a force, over its total; errors are relative to no smaller dynamic part than this one allows.
_LEAST_OF_TOTAL = 1e-12
# Dynamic part below which a force has no relative error of its own, over the largest dynamic part.
_NEGLIGIBLE = 1e-9
# The same if no contact ever closes: no dynamic part is zero.
_TINY = 1e-300
# Error of the time of a peak, in characteristic times, that is allowed over the tolerance of the force.
_TIME_SHARE = 10.0
# Larger differences of the times of two runs, in characteristic times, belong to different peaks of about equal force.
_OTHER_PEAK = 0.5
# Longest chain of equal granules whose contact forces are computed without being asked for.
_MOST_GRANULES = 20_000
# Least velocity of a granule that flies off, over that of the fastest granule.
_EJECTED = 1e-3


def simulate_chain(options: SimulateOptions, excitation: Shock | Impact, chain: Chain) -> ChainResult:
    """Simulate a finite chain with an excitation, and estimate the errors of the forces.

    Raises
    ------
    InvalidValueError
        If a value is out of range, or a contact of the options is not one of the chain.
    NumericalError
        If the integrator fails, or the time limit is reached.
    """
    begin = time.perf_counter()
    case = ChainSetup.of(options, excitation, chain)
    runs = _runs(case)
    return _result(case, runs, time.perf_counter() - begin)


def contact_peaks(result: SimulationResult) -> tuple[tuple[ContactPeak, ...], ContactPeak]:
    """Greatest forces at the reported contacts of a finite chain of equal granules, and at all contacts.

    Raises
    ------
    NumericalError
        If the integration would take too long, fails, or reaches the time limit.
    """
    granules = cast(int, result.chain.granules)
    if result.options.timeout is None:
        reason = immeasurable(scaled(result.shock, result.chain)[0])
        if not reason and result.options.until is None and granules > _MOST_GRANULES:
            reason = f"the chain has {granules} granules, more than {_MOST_GRANULES} (give until, or a timeout)"
        if reason:
            raise NumericalError(f"they are not computed, because {reason}")
    # the integrator of the waves may be unable to step this chain, or have a fixed step
    options = evolve(result.options, integrator=None, step=None)
    case = ChainSetup.of(options, result.shock, result.chain)
    runs = _runs(case)
    top = int(np.argmax(runs.best.forces))
    return tuple(_peak(case, runs, contact) for contact in case.reported.tolist()), _peak(case, runs, top)


# ---------------------------------------------------------------- runs and errors


class _Runs(NamedTuple):
    """The best run, its error estimates (contacts,), relative to the dynamic parts, and the cost of all runs."""

    best: Motion
    other: Motion
    tolerance: float
    errors: FloatArray
    missed: bool
    steps: int
    evaluations: int


def _runs(case: ChainSetup) -> _Runs:
    """Integrate with smaller and smaller tolerances until the difference of two runs shows that they are met."""
    tolerance = max(_FIRST * case.rtol, _TIGHTEST / _TIGHTER)
    coarse = _run(case, tolerance)
    steps, evaluations = coarse.steps, coarse.evaluations
    until = case.until if case.until is not None else coarse.end
    best: _Runs | None = None
    for _ in range(_RUNS - 1):
        tolerance = max(tolerance * _TIGHTER, _TIGHTEST)
        try:
            fine = _run(case, tolerance, until)
        except NumericalError:
            if best is None:
                raise
            break
        steps, evaluations = steps + fine.steps, evaluations + fine.evaluations
        errors, missed = _errors(case, coarse, fine, tolerance)
        if best is None or errors[case.reported].max() < best.errors[case.reported].max():
            best = _Runs(fine, coarse, tolerance, errors, missed, steps, evaluations)
        if not missed or tolerance <= _TIGHTEST:
            break
        coarse = fine
    assert best is not None
    return best._replace(steps=steps, evaluations=evaluations)


def _run(case: ChainSetup, tolerance: float, until: float | None = None, times: FloatArray | None = None) -> Motion:
    return integrate(
        case.assembly,
        tolerance,
        until=case.until if until is None else until,
        times=() if times is None else times,
        compiled=case.compiled,
        integrator=case.method,
    )


def _errors(case: ChainSetup, coarse: Motion, fine: Motion, tolerance: float) -> tuple[FloatArray, bool]:
    """Relative error estimates of the forces at all contacts, and whether a reported one misses its tolerance."""
    forces, dynamic, rtol = fine.forces, fine.dynamic_forces, case.rtol
    least = max(_NEGLIGIBLE * float(dynamic.max()), _TINY)
    base = np.maximum(np.maximum(dynamic, least), _LEAST_OF_TOTAL / rtol * forces)
    near = 2 * _NEIGHBOURS + 1
    changes = sliding_window_view(np.pad(np.abs(dynamic - coarse.dynamic_forces), _NEIGHBOURS), near)
    bases = np.maximum(sliding_window_view(np.pad(base, _NEIGHBOURS), near), base[:, None])
    errors = _DIFFERENCES * (changes / bases).max(axis=1) + tolerance + _ROUNDING * forces / base
    errors[forces <= 0] = 0.0
    judged = case.judged(forces)
    late = np.abs(fine.force_times - coarse.force_times)[judged]
    late = late[late < _OTHER_PEAK].max(initial=0.0)
    return errors, bool(errors[judged].max() > rtol or late > _TIME_SHARE * rtol)


# ---------------------------------------------------------------- the result


def _result(case: ChainSetup, runs: _Runs, seconds: float) -> ChainResult:
    layout, scales, motion = case.layout, case.scales, runs.best
    peaks = [_peak(case, runs, contact) for contact in case.reported.tolist()]
    top = _peak(case, runs, int(np.argmax(motion.forces)))
    momentum, energy = _applied(case, motion)
    x, v = motion.x[: case.granules], motion.v[: case.granules]
    segments, end_energy = _energies(case, motion)
    held = bool(layout.static_forces.any())
    recoil, loss = (None, None) if held else (_rebounding(case, motion), _rebounding(case, runs.other))
    masses = layout.masses / scales.mass
    recoil_momentum = None if recoil is None else math.fsum(masses[: len(recoil)] * recoil)
    recoil_other = 0.0 if loss is None else math.fsum(masses[: len(loss)] * loss)
    wall = float(motion.impulses[-1]) if case.has_wall else 0.0
    carried = math.fsum(masses * v)
    final = math.fsum([*(energy for _, _, energy in segments), end_energy or 0.0])
    spalls = None if held or case.has_wall else _spalls(case, motion)
    return ChainResult(
        excitation=case.excitation,
        chain=case.chain,
        options=case.options,
        integrator=motion.integrator,
        backend="numpy" if case.compiled is None else "compiled",
        scene=ChainScene.of(case.excitation, case.chain),
        contact_count=len(layout.stiffnesses),
        contacts=tuple(peaks),
        greatest_force=top,
        transmitted=_transmitted(case, runs) if case.has_wall else None,
        end=motion.end * scales.time,
        arrival_time=None if motion.arrival is None else motion.arrival * scales.time,
        velocities=tuple((v * scales.velocity).tolist()),
        recoil_velocities=None if recoil is None else tuple((recoil * scales.velocity).tolist()),
        recoil_momentum=None if recoil_momentum is None else recoil_momentum * scales.momentum,
        recoil_error=None if recoil_momentum is None else abs(recoil_momentum - recoil_other) * scales.momentum,
        spall_velocities=None if spalls is None else tuple((spalls * scales.velocity).tolist()),
        restitution=_restitution(case, x, v),
        applied_momentum=momentum * scales.momentum,
        applied_energy=energy * scales.energy,
        dissipated_energy=motion.dissipated * scales.energy,
        segments=tuple(SegmentEnergy(first=a, last=b, energy=each * scales.energy) for a, b, each in segments),
        end_energy=None if end_energy is None else end_energy * scales.energy,
        yielding=_yielding(case, motion),
        momentum_defect=abs(carried + wall - momentum) / momentum,
        energy_defect=abs(final + motion.dissipated - energy) / energy,
        characteristic_time=scales.time,
        cost=Cost(steps=runs.steps, force_evaluations=runs.evaluations, seconds=seconds),
        warnings=(*_notes(case.excitation), *_missed(case, runs)),
        on_demand=_record,
    )


def _notes(excitation: Shock | Impact) -> tuple[str, ...]:
    return tuple(excitation.profile.notes) if isinstance(excitation, Shock) else ()


def _missed(case: ChainSetup, runs: _Runs) -> list[str]:
    """Warning if a shown force does not meet the tolerance."""
    if not runs.missed:
        return []
    judged = case.judged(runs.best.forces)
    worst = int(judged[np.argmax(runs.errors[judged])])
    reached = f"the relative error of the greatest force at contact {worst} is estimated as {runs.errors[worst]:.1e}"
    return [f"The tolerance was not met: {reached}, not {case.rtol:.1e}."]


def _peak(case: ChainSetup, runs: _Runs, contact: int) -> ContactPeak:
    motion = runs.best
    return ContactPeak(
        contact=contact,
        peak_force=float(motion.forces[contact]) * case.scales.force,
        time=float(motion.force_times[contact]) * case.scales.time,
        error_estimate=float(runs.errors[contact]),
        static_force=float(case.layout.static_forces[contact]),
    )


def _transmitted(case: ChainSetup, runs: _Runs) -> Transmitted:
    last = _peak(case, runs, len(runs.best.forces) - 1)
    return Transmitted(
        peak_force=last.peak_force,
        time=last.time,
        impulse=float(runs.best.impulses[-1]) * case.scales.momentum,
        error_estimate=last.error_estimate,
        static_force=last.static_force,
    )


def _applied(case: ChainSetup, motion: Motion) -> tuple[float, float]:
    """Momentum and energy that the excitation has brought in, scaled."""
    velocity = case.assembly.velocity
    if case.assembly.force is None:
        mass = 1 / float(case.assembly.inverse_masses[0])
        return mass * velocity, 0.5 * mass * velocity**2
    return motion.applied_impulse, motion.work


def _energies(case: ChainSetup, motion: Motion) -> tuple[list[tuple[int, int, float]], float | None]:
    """First granule, last granule and energy of each segment; energy of a movable wall and its spring."""
    granules = case.granules
    behind = motion.potential[: granules - 1] / 2
    each = motion.kinetic[:granules].copy()
    each[:-1] += behind
    each[1:] += behind
    if case.has_wall:
        each[-1] += motion.potential[-1]
    segments = np.asarray(case.layout.segments)
    begins = [0, *(np.flatnonzero(np.diff(segments)) + 1).tolist(), granules]
    parts = pairwise(begins)
    found = [(begin, end - 1, math.fsum(each[begin:end])) for begin, end in parts]
    movable = len(motion.kinetic) > granules
    return found, float(motion.kinetic[-1]) + motion.end_energy if movable else None


def _apart(case: ChainSetup, motion: Motion) -> npt.NDArray[np.bool_]:
    """Whether each contact between granules is open, and its granules do not approach each other."""
    x, v = motion.x[: case.granules], motion.v[: case.granules]
    open_ = case.assembly.overlaps[: case.granules - 1] + (x[:-1] - x[1:]) <= 0
    return np.asarray(open_ & (v[:-1] <= v[1:]))


def _rebounding(case: ChainSetup, motion: Motion) -> FloatArray:
    """Velocities of the granules at the struck end that fly backwards, scaled."""
    v = motion.v[: case.granules]
    free = v[: _leading(_apart(case, motion))]
    return free[: _leading(free < -_EJECTED * np.abs(v).max())]


def _spalls(case: ChainSetup, motion: Motion) -> FloatArray:
    """Velocities of the granules that fly off the free end, last granule first, scaled."""
    v = motion.v[: case.granules]
    free = v[::-1][: _leading(_apart(case, motion)[::-1])]
    return free[: _leading(free > _EJECTED * np.abs(v).max())]


def _leading(flags: npt.NDArray[np.bool_]) -> int:
    """Number of true values before the first false one; one more granule than contacts if all are true."""
    return int(np.argmin(flags)) if not flags.all() else len(flags) + 1


def _restitution(case: ChainSetup, x: FloatArray, v: FloatArray) -> float | None:
    assembly, masses = case.assembly, case.layout.masses[1:]
    if assembly.force is not None or assembly.overlaps[0] + (x[0] - x[1]) > 0:
        return None
    centre = 0.0 if case.has_wall else math.fsum(masses * v[1:]) / math.fsum(masses)
    away = centre - float(v[0])
    return away / assembly.velocity if away > 0 else None


def _yielding(case: ChainSetup, motion: Motion) -> Yielding | None:
    """First yield by the softer material of each contact, where the yield strength is known."""
    layout = case.layout
    known = [math.inf if each.yield_strength is None else each.yield_strength for each in layout.materials]
    if layout.wall is not None:
        known.append(getattr(layout.wall.material, "yield_strength", None) or math.inf)
    softer = np.minimum(known[:-1], known[1:])
    at = np.flatnonzero(np.isfinite(softer))
    if not at.size or layout.law is not None:
        return None
    radii, moduli = layout.reduced_radii[at], layout.moduli[at]
    first = first_yield_force(radii, moduli, softer[at])
    ratios = motion.forces[at] * case.scales.force / first
    return Yielding(first_yield_force=float(first.min()), peak_ratio=float(ratios.max()))


# ---------------------------------------------------------------- histories


def _record(result: ChainResult) -> Recording:
    """Histories that the options of ``result`` request, by another integration of the chain.

    Raises
    ------
    InvalidValueError
        If the histories have too many values.
    """
    options = result.options
    allowed = options.timeout
    with time_limit(None if allowed is None else allowed - result.cost.seconds):
        case = ChainSetup.of(options, result.excitation, result.chain)
        end = result.end / case.scales.time
        times = sample_times(options, case.scales, end, case.granules)
        motion = _run(case, max(_FIRST * case.rtol * _TIGHTER, _TIGHTEST), end, times)
    scales = case.scales
    x, v = motion.samples_x[:, : case.granules], motion.samples_v[:, : case.granules]
    recording = Recording(times=times * scales.time, contacts=options.contacts)
    if "forces" in options.record:
        forces = scales.force * motion.samples_forces
        wall = forces[:, -1] if case.has_wall else None
        recording = evolve(recording, forces=forces[:, list(options.contacts)], wall_force=wall)
    if "field" in options.record:
        displacements = scales.energy / scales.force * x
        recording = evolve(recording, displacements=displacements, velocities=scales.velocity * v)
    if "energies" in options.record:
        kinetic = 0.5 * np.add.reduce(v * v / case.assembly.inverse_masses[: case.granules], axis=1)
        contact = np.add.reduce([case.assembly.potential(each) for each in motion.samples_x], axis=1)
        energies = scales.energy * kinetic, scales.energy * contact
        recording = evolve(recording, kinetic_energy=energies[0], contact_energy=energies[1])
    return recording
