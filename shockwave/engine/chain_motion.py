"""Integration of chains of mixed granules in scaled units."""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import ModuleType

import numpy as np
import numpy.typing as npt
from attrs import evolve, frozen

from shockwave.base.errors import InvalidValueError, NumericalError
from shockwave.base.numerics import FloatArray
from shockwave.engine.chain_arrays import (
    KINK_TOLERANCE,
    ROWS,
    UNSAMPLED,
    Forecast,
    Job,
    Progress,
    Samples,
    Settings,
    Status,
)
from shockwave.engine.chain_assembly import Assembly
from shockwave.engine.chain_domains import run
from shockwave.engine.chain_forces import VISCOUS
from shockwave.engine.integrator import Integrator
from shockwave.engine.nystroem_integrators import Rkn86
from shockwave.engine.nystroem_tableaux import Tableau, dop853, with_velocities
from shockwave.engine.time_limit import is_limited
from shockwave.registry.registry import blame

# Least number of steps under the applied force.
_LEAST_STEPS = 8
# Largest number of evaluations of a contact force without a time limit, and its increase with the number of bodies.
_WORK = 2e9
_WORK_PER_BODY = 6e6


@frozen(eq=False, slots=False)
class ChainMotion:
    """The motion of an `Assembly`, in scaled units.

    Attributes
    ----------
    forces, force_times : array, shape (contacts,)
        Greatest total force at each contact and its first time; zeros for a contact that is never closed.
    dynamic_forces : array, shape (contacts,)
        The greatest forces minus the static ones, without cancellation.
    end : float
        End of the simulated time.
    arrival : float or None
        First maximum of the force at the last contact.
    x, v : array, shape (bodies,)
        State at the end.
    last_impulse : float
        Integral of the force at the last contact minus its static part.
    applied_impulse, work : float
        Impulse and work of the applied force, or of the weight of a striker.
    dissipated : float
        Energy dissipated by contacts and by the dashpot of the end; with the law of a plugin, all the energy that went
        into the contacts.
    kinetic : array, shape (bodies,)
        Kinetic energies at the end.
    potential : array, shape (contacts,)
        Energies of the contacts at the end, of the forces minus the static ones.
    losses : array, shape (bodies,)
        Energies dissipated by each contact, and by the dashpot of the end.
    residual_overlaps, greatest_overlaps : array, shape (contacts,), or None
        Residual and greatest overlaps of elastic-plastic contacts, and zeros; None without such contacts.
    end_energy : float
        Energy of the spring of the end.
    extremes : array, shape (2, 3)
        Greatest magnitudes of displacement, acceleration and spring force of a movable end, and their times.
    initial_energy : float
        Kinetic energy at the beginning.
    rebound : float or None
        Speed away from the chain with which a striker with a weight first leaves it.
    steps, evaluations : int
    integrator : str
        Name of the method.
    samples : Samples
    """

    forces: FloatArray
    force_times: FloatArray
    dynamic_forces: FloatArray
    end: float
    arrival: float | None
    x: FloatArray
    v: FloatArray
    last_impulse: float
    applied_impulse: float
    work: float
    dissipated: float
    kinetic: FloatArray
    potential: FloatArray
    losses: FloatArray
    residual_overlaps: FloatArray | None
    greatest_overlaps: FloatArray | None
    end_energy: float
    extremes: FloatArray
    initial_energy: float
    rebound: float | None
    steps: int
    evaluations: int
    integrator: str
    samples: Samples

    @property
    def energy_balance(self) -> float:
        """Energy at the end plus what was dissipated, minus what was there at first or came in."""
        stored = math.fsum([*self.kinetic.tolist(), *self.potential.tolist(), self.end_energy, self.dissipated])
        return stored - self.initial_energy - self.work


def method_for(assembly: Assembly, integrator: type[Integrator] | None) -> tuple[str, Tableau]:
    """Name and coefficients of the method: those of ``integrator``, by default rkn86, with damping dop853.

    An integrator without coefficients gets those of rkn86, whose weights give integrals over its steps. Where forces
    depend on velocities only during plastic flow, the coefficients are extended by those for velocities at the stages.
    The pair rkn1210 is not faster, even for the tightest tolerances: contacts that open limit its steps.

    Raises
    ------
    InvalidValueError
        If the integrator cannot step this chain.
    """
    if integrator is None and assembly.is_damped:
        return "dop853", dop853()
    integrator = integrator or Rkn86
    if reason := integrator.refusal(assembly.is_damped, assembly.plastic is not None, assembly.depends_on_rate):
        raise InvalidValueError.of("integrator", reason)
    tableau = integrator.coefficients() or Rkn86.tableau
    if assembly.depends_on_rate and not tableau.damped:
        tableau = with_velocities(tableau)
    return integrator.name, tableau


def integrate(
    assembly: Assembly,
    tolerance: float,
    *,
    until: float | None = None,
    times: Sequence[float] | FloatArray = (),
    rows: npt.NDArray[np.int64] | None = None,
    compiled: ModuleType | None = None,
    integrator: type[Integrator] | None = None,
) -> ChainMotion:
    """Integrate a chain of mixed granules.

    Parameters
    ----------
    assembly : Assembly
    tolerance : float
        Largest error of a step, relative to the greatest overlap and closing velocity of each contact; or the size of
        the fixed steps of the ``integrator``.
    until : float, optional
        End of the simulated time; by default the duration of the force plus three times the arrival time.
    times : sequence of float, optional
        Times in ascending order at which the state is returned.
    rows : array of int, optional
        Bodies whose state is returned, and contacts with their numbers, in ascending order. Default: all.
    compiled : module, optional
        `shockwave.engine._chains`; by default NumPy is used.
    integrator : type of Integrator, optional

    Raises
    ------
    InvalidValueError
        If the integrator cannot step this chain.
    NumericalError
        If the integration fails, takes too many steps or reaches the time limit.
    """
    name, method = method_for(assembly, integrator)
    if rows is None:
        rows = np.arange(len(assembly.inverse_masses) * (len(times) > 0))
    job = _job(assembly, tolerance, until, np.asarray(times, dtype=float), rows, method)
    if integrator is not None and integrator.coefficients() is None:
        with blame("integrators", integrator):
            stepper = integrator(tolerance=tolerance) if integrator.adaptive else integrator(size=tolerance)
        job = evolve(job, integrator=stepper)
    compiled = None if assembly.law is not None or assembly.impedance or job.integrator else compiled
    run(job, compiled)
    _check(job)
    impulse, work = _impulse_and_work(assembly, job)
    samples = job.samples
    if assembly.force is not None and assembly.guided and (until is None or until > assembly.force.duration):
        job = _release(assembly, job, until, np.asarray(times, dtype=float))
        run(job, compiled)
        _check(job)
        samples = np.concatenate((samples, job.samples))
    return _motion_of(assembly, job, name, (impulse, work), samples)


def _impulse_and_work(assembly: Assembly, job: Job) -> tuple[float, float]:
    """Impulse of the applied force or the weight after a run, and the work of the force."""
    end, work = job.progress.time, job.progress.work
    if assembly.guided:
        first, mass = float(job.v[0]), 1 / float(assembly.inverse_masses[0])
        impulse = mass * (first - assembly.velocity) + float(job.impulses[0])
        return impulse, work + 0.5 * mass * (first**2 - assembly.velocity**2)
    return assembly.weight * end if assembly.force is None else assembly.force.free(end)[1], work


def _motion_of(
    assembly: Assembly, job: Job, integrator: str, applied: tuple[float, float], samples: FloatArray
) -> ChainMotion:
    """The motion after the last run; ``applied`` are impulse and work of the applied force."""
    contacts, masses, x, v = len(assembly.overlaps), 1 / assembly.inverse_masses, job.x[:-1], job.v[:-1]
    peaks, progress = job.peaks[0, :contacts], job.progress
    residual = greatest = None
    if assembly.plastic is None:
        potential = assembly.potential(x)
    else:
        residual, greatest, potential = _deformations(assembly, job)
    losses = job.losses.copy()
    losses[:contacts] *= assembly.dissipates  # at the others there are rounding errors
    return ChainMotion(
        forces=assembly.static_forces + peaks,
        force_times=job.peaks[1, :contacts],
        dynamic_forces=peaks,
        end=progress.time,
        arrival=None if progress.arrival < 0 else progress.arrival,
        x=x,
        v=v,
        last_impulse=float(job.impulses[1]),
        applied_impulse=applied[0],
        work=applied[1] + assembly.weight * float(x[0]),
        dissipated=math.fsum(losses.tolist()),
        kinetic=0.5 * masses * v * v * (np.arange(len(v)) < len(v) - (assembly.impedance > 0)),
        potential=potential,
        losses=losses,
        residual_overlaps=residual,
        greatest_overlaps=greatest,
        end_energy=0.5 * assembly.end_stiffness * float(x[-1]) ** 2,
        extremes=progress.extremes,
        initial_energy=0.5 * float(masses[0]) * assembly.velocity**2,
        rebound=-progress.rebound if progress.rebound < 0 else None,
        steps=int(progress.steps),
        evaluations=int(progress.evaluations),
        integrator=integrator,
        samples=Samples(job.watched[UNSAMPLED:], *samples.swapaxes(0, 1)),
    )


def _deformations(assembly: Assembly, job: Job) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Residual and greatest overlaps of elastic-plastic contacts, and the energies of all contacts."""
    from shockwave.engine.chain_plastic import settle

    assert assembly.plastic is not None
    rest, law, contacts = settle(job), assembly.plastic.loading, len(assembly.overlaps)
    forces = assembly.static_forces + job.peaks[0, :contacts]
    greatest = np.maximum(rest.reached, (forces / law.stiffnesses) ** (2 / 3) * (rest.residual == 0))
    potential = assembly.changed_potential(job.x[:-1], rest.residual, rest.energies)
    return rest.residual, np.where(np.isinf(law.strengths), 0.0, greatest), potential


def _job(
    assembly: Assembly,
    tolerance: float,
    until: float | None,
    times: FloatArray,
    rows: npt.NDArray[np.int64],
    method: Tableau,
) -> Job:
    """Arrays of a run."""
    bodies, problem, plastic = len(assembly.inverse_masses), assembly.force, assembly.plastic
    settings, last = _settings(assembly, tolerance, until, method), len(assembly.overlaps) - 1
    if assembly.guided:
        times = times[times <= settings.until]
    cause = assembly.cause_of_work if method.adaptive else lambda: f"the fixed step of {tolerance:g}"
    job = Job(
        method=method,
        problem=problem,
        law=assembly.law,
        by_law=np.zeros(bodies, dtype=bool),
        settings=settings,
        stops=np.array([] if problem is None else problem.stops),
        times=times,
        samples=np.zeros((len(times), 4 if plastic is None else 5, len(rows))),
        watched=np.append([0 if assembly.guided else last, last], rows).astype(np.int64),
        impulses=np.zeros(UNSAMPLED + len(rows)),
        progress=Progress(size=settings.first),
        table=np.zeros((ROWS, bodies + 1)),
        plastic=np.empty((0, 0)) if plastic is None else plastic.table(assembly.overlaps, bodies),
        curves=np.empty(0) if plastic is None else plastic.curves[0],
        forecast=Forecast.of(settings, assembly.static_forces, cause),
        bar=assembly.impedance > 0,
    )
    if assembly.movable_end:
        job.progress.extremes[:] = 0.0
    _fill_table(assembly, job)
    return job


def _settings(assembly: Assembly, tolerance: float, until: float | None, method: Tableau) -> Settings:
    """Settings of a run with a tolerance or, by a method with fixed steps, with this step."""
    problem, (_chain, scales, first) = assembly.force, assembly.beginning
    first, end = _first_step(assembly, first, tolerance * float(scales[0, 0])), math.inf if until is None else until
    duration, rise_time, peak_force = 0.0, 1.0, 0.0
    if problem is not None:
        duration, rise_time, peak_force = problem.duration, problem.rise_time, problem.peak_force
    return Settings(
        tolerance=tolerance if method.adaptive else KINK_TOLERANCE,
        until=min(end, duration) if assembly.guided else end,
        duration=duration,
        rise_time=rise_time,
        peak_force=peak_force,
        first=first if method.adaptive else tolerance,
        longest=duration / _LEAST_STEPS if method.adaptive else tolerance,
        contacts=len(assembly.overlaps),
        end_stiffness=assembly.end_stiffness,
        end_damping=assembly.end_damping,
        most_work=math.inf if is_limited() else _WORK + _WORK_PER_BODY * len(assembly.inverse_masses),
        damped=assembly.is_damped,
        weight=assembly.weight,
        guided=assembly.guided,
    )


def _fill_table(assembly: Assembly, job: Job) -> None:
    """Fill the rows of a job that describe the chain, its state at the beginning, and the scales of errors."""
    job.chain[:], job.scales[:], _first = assembly.beginning
    job.exponents[:] = assembly.powers_of_contacts
    if assembly.law_contacts is not None:
        job.by_law[: len(assembly.overlaps)] = assembly.law_contacts
    inverse = job.chain[0].copy()
    inverse[0] *= not assembly.guided
    job.switches[0], job.switches[1] = inverse, 1.0
    job.switches[0, :-1] += inverse[1:]
    if assembly.guided:
        job.chain[0, 0] = 1.0
    if assembly.impedance:
        job.switches[0, -2] = inverse[-2]
    job.v[0] = assembly.velocity


def _release(assembly: Assembly, job: Job, until: float | None, times: FloatArray) -> Job:
    """The job that follows, from the end of the given path of body 0, which then moves freely."""
    time, arrival = job.progress.time, job.progress.arrival
    end = until or (max(time + 3 * arrival, time) if arrival >= 0 else math.inf)
    settings = job.settings._replace(guided=False, until=end)
    job.chain[0, 0] = assembly.inverse_masses[0]
    job.switches[0, 0] += job.chain[0, 0]
    later = times[times > time]
    return evolve(
        job,
        problem=None,
        settings=settings,
        stops=job.stops[:0],
        times=later,
        samples=np.zeros((len(later), *job.samples.shape[1:])),
        progress=evolve(job.progress, status=0.0),
        window=len(job.v) - 1,
        forecast=Forecast.of(settings, assembly.static_forces, job.forecast.cause),
    )


def _first_step(assembly: Assembly, first: float, tolerance: float) -> float:
    """First step, shorter where the force presses a damped contact together that has no overlap.

    The force of the contact then begins with a broken power of the time, which the error estimate of a step does not
    detect. ``tolerance`` is that of the closing velocity.
    """
    c, q, rate = (float(each[0]) for each in (assembly.damping, assembly.damping_powers, assembly.inverse_masses))
    rate = 1.0 if assembly.guided else rate
    by_law = assembly.law_contacts is not None and assembly.law_contacts[0]
    if assembly.force is None or by_law or q == 0 or assembly.overlaps[0] != 0:
        return first
    allowed = tolerance / float(np.sum(assembly.inverse_masses[:2]))
    path, impulse = assembly.force.free(first)
    while VISCOUS * first * c * max(rate * path, 0.0) ** q * rate * impulse > allowed:
        first /= 2
        path, impulse = assembly.force.free(first)
    return first


def _check(job: Job) -> None:
    """Raise the error of a failed run."""
    status, at = Status(int(job.progress.status)), f"at {job.progress.time:.4g} characteristic times"
    if status is Status.DONE:
        return
    reasons = {
        Status.TOO_LONG: f"the chain takes too many steps because of {job.forecast.cause()}: {job.progress.steps:.0f}"
        f" {at} (set a timeout to continue, simulate a shorter time, use a shorter chain, or loosen the tolerance)",
        Status.FAILED: f"the step size vanishes {at} (the ratios of masses or stiffnesses are too large, or the damping"
        " is too strong)"
        if job.method.adaptive
        else f"values are not finite {at} (use a smaller step)",
        Status.RUNNING: f"the time limit was reached {at} (allow more, loosen the tolerance, or simulate a shorter time"
        " with until)",
    }
    raise NumericalError(reasons[status])
