"""Chains of mixed granules in scaled units, and their integration."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from types import ModuleType

import numpy as np
from attrs import frozen

from shockwave.base.errors import InvalidValueError, NumericalError
from shockwave.base.numerics import FloatArray
from shockwave.engine.integrator import Integrator
from shockwave.engine.mixed_chain_arrays import LARGEST, ROWS, Forecast, Job, Status
from shockwave.engine.mixed_chain_domains import run
from shockwave.engine.mixed_chain_forces import FAR, VISCOUS
from shockwave.engine.nystroem_integrators import Nystroem, Rkn86
from shockwave.engine.nystroem_tableaux import GeneralTableau, dop853, of_nystroem
from shockwave.engine.scaled_problem import ChainProblem
from shockwave.engine.time_limit import is_limited
from shockwave.scene.contact_law import BoundLaw

# Least fraction of closing velocity and overlap at one contact that is expected at the next, and of their estimates at
# the first one.
_EXPECTED = 0.1
# Least scale of errors, over that at the first contact.
_LEAST = 1e-60
# First step, over the time in which the first contact closes.
_FIRST_STEP = 0.05
# Least number of steps under the applied force.
_LEAST_STEPS = 8
# Largest number of evaluations of a contact force without a time limit, and its increase with the number of bodies.
_WORK = 2e9
_WORK_PER_BODY = 6e6
# Rate in characteristic times beyond which it makes the steps short.
_FAST = 30.0
# Gauss-Legendre rule on (0, 1) for the energy of contacts with a static overlap: nodes and weights.
_RULE = (np.polynomial.legendre.leggauss(12) + np.array([[1.0], [0.0]])) / 2


@frozen(eq=False, slots=False)
class Assembly:
    """A chain of mixed granules, in scaled units.

    Positions x are displacements from the initial ones. Contact j lies between bodies j and j + 1, the last one between
    the last body and the wall if there is a fixed one. With the overlap d = d0 + x_j - x_{j+1} its force is
    F = max(k d^p + c d^q d', 0) where d > 0, else 0. Static forces k d0^p are balanced by constant forces.

    Attributes
    ----------
    inverse_masses : array, shape (bodies,)
        The last body is the end if that is movable.
    stiffnesses : array, shape (contacts,)
        k.
    overlaps : array, shape (contacts,)
        d0, negative for a gap.
    exponent : float
        p.
    fixed_wall : bool
        Whether the last contact is with a fixed flat: then there are as many contacts as bodies, else one less.
    damping : array, shape (contacts,)
        c.
    damping_power : float
        q.
    end_stiffness, end_damping : float
        Spring and dashpot between the last body and the ground.
    force : ChainProblem or None
        The applied force on body 0; its ``granules`` are not used.
    velocity, weight : float
        Initial velocity of body 0, and a constant force on it: the weight of a striker.
    law : BoundLaw or None
        Contact law of a plugin, which replaces stiffness and damping.
    """

    inverse_masses: FloatArray
    stiffnesses: FloatArray
    overlaps: FloatArray
    exponent: float
    fixed_wall: bool
    damping: FloatArray
    damping_power: float
    end_stiffness: float = 0.0
    end_damping: float = 0.0
    force: ChainProblem | None = None
    velocity: float = 0.0
    weight: float = 0.0
    law: BoundLaw | None = None

    @cached_property
    def is_damped(self) -> bool:
        """Whether the forces depend on the velocities."""
        return self.law is not None or self.end_damping > 0 or bool(np.any(self.damping > 0))

    @cached_property
    def static_forces(self) -> FloatArray:
        """Static contact forces, shape (contacts,)."""
        return np.asarray(self.stiffnesses * np.maximum(self.overlaps, 0.0) ** self.exponent)

    @property
    def _first_scales(self) -> tuple[float, float]:
        """Orders of magnitude of closing velocity and force, minus the static one, at the first contact."""
        p, k = self.exponent, float(self.stiffnesses[0])
        linear = p * k * max(float(self.overlaps[0]), 0.0) ** (p - 1)
        mass = 1 / float(np.sum(self.inverse_masses[:2]))
        force = self.weight if self.force is None else self.force.peak_force
        overlap = min((force / k) ** (1 / p), force / linear if linear else math.inf)
        velocity = math.sqrt(overlap * force / mass)
        if self.force is None:
            velocity, force = max(self.velocity, velocity), math.inf
        else:
            velocity = min(velocity, self.force.free(self.force.duration)[1] * float(self.inverse_masses[0]))
        reached = ((p + 1) / 2 * mass * velocity**2 / k) ** (1 / (p + 1))
        return velocity, min(force, max(k * reached**p, velocity * math.sqrt(mass * linear)))

    @cached_property
    def beginning(self) -> tuple[FloatArray, FloatArray, float]:
        """Rows of a `Job` that describe the chain, the scales of errors at the beginning, and the first step."""
        inverse, p = np.asarray(self.inverse_masses, dtype=float), self.exponent
        bodies, contacts = len(inverse), len(self.overlaps)
        k, offsets, c = np.zeros((3, bodies))
        k[:contacts], offsets[:contacts], c[:contacts] = self.stiffnesses, self.overlaps, self.damping
        offsets[contacts:] = -FAR
        base, gap = np.maximum(offsets, 0.0), np.minimum(offsets, 0.0)
        before = np.append(inverse[0], inverse[:-1])
        velocity, force = self._first_scales
        # overlap of each contact under the force at the first one
        extent = np.minimum((force / np.where(k > 0, k, 1.0)) ** (1 / p), _ratio(force, p * k * base ** (p - 1)))
        reach = np.array([2 * inverse / (before + inverse), extent / np.append(extent[0], extent[:-1])])
        reach = _EXPECTED * np.minimum(reach, 1.0)
        scales = np.multiply.accumulate(np.column_stack(([1.0, 1.0], reach[:, 1:])), axis=1)
        scales = np.maximum(scales, _LEAST) * (_EXPECTED * np.array([[velocity], [extent[0]]]))
        scales[:, contacts:] = LARGEST
        first = _FIRST_STEP * float(scales[1, 0] / scales[0, 0])
        return np.array([inverse, k, gap, base, np.sqrt(base), k * base**p, c, *reach]), scales, first

    def cause_of_work(self) -> str:
        """Keys of the scenario that make the steps of a run short or many."""
        inverse, p, last = self.inverse_masses, self.exponent, float(self.inverse_masses[-1])
        lighter = np.maximum(inverse, np.append(inverse[1:], 0.0))[: len(self.overlaps)]
        force = self._first_scales[1] + float(self.static_forces.max())
        overlaps = (force / self.stiffnesses) ** (1 / p)
        elastic = np.sqrt(p * force / overlaps * lighter)
        rates = {
            f"the mass or the stiffness at contact {np.argmax(elastic)} (chain.granules, chain.end)": elastic.max(),
            "chain.damping": (self.damping * overlaps**self.damping_power * lighter).max(),
            "chain.end.stiffness and the mass of the wall": math.sqrt(self.end_stiffness * last),
            "chain.end.damping and the mass of the wall": self.end_damping * last,
        }
        cause = max(rates, key=lambda each: float(rates[each]))
        long = "simulate.until, the duration of the shock, or the length of the chain"
        return cause if rates[cause] > _FAST else long

    def potential(self, x: FloatArray) -> FloatArray:
        """Integral of the contact force minus its static part from the initial state to ``x``, shape (contacts,).

        Zeros for the law of a plugin: its energy depends on the history, and counts as dissipated.
        """
        if self.law is not None:
            return np.zeros(len(self.overlaps))
        changes = (x - np.append(x[1:], 0.0))[: len(self.overlaps)]
        static, p = np.maximum(self.overlaps, 0.0), self.exponent
        closed = np.maximum(self.overlaps + changes, 0.0)
        whole = (closed ** (p + 1) - static ** (p + 1)) / (p + 1) - static**p * changes
        if not static.any():
            return np.asarray(self.stiffnesses * whole)
        # Gauss-Legendre quadrature of a force that is nearly linear avoids the difference of large numbers
        shares, weights = _RULE[:, :, None]
        strain = changes / np.where(static > 0, static, 1.0)
        near = (static > 0) & (np.abs(strain) < 0.5)
        inner = np.where(near, strain, 0.0) * shares
        slight = np.add.reduce(weights * np.expm1(p * np.log1p(inner)), axis=0) * static**p * changes
        return np.asarray(self.stiffnesses * np.where(near, slight, whole))


@frozen(eq=False, slots=False)
class Motion:
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
    end_energy : float
        Energy of the spring of the end.
    initial_energy : float
        Kinetic energy at the beginning.
    rebound : float or None
        Speed away from the chain with which a striker with a weight first leaves it.
    steps, evaluations : int
    integrator : str
        Name of the method.
    samples_x, samples_v : array, shape (times, bodies)
    samples_forces : array, shape (times, contacts)
        States and total contact forces at the requested times.
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
    end_energy: float
    initial_energy: float
    rebound: float | None
    steps: int
    evaluations: int
    integrator: str
    samples_x: FloatArray
    samples_v: FloatArray
    samples_forces: FloatArray

    @property
    def energy_balance(self) -> float:
        """Energy at the end plus what was dissipated, minus what was there at first or came in."""
        stored = math.fsum([*self.kinetic.tolist(), *self.potential.tolist(), self.end_energy, self.dissipated])
        return stored - self.initial_energy - self.work


def method_for(assembly: Assembly, integrator: type[Integrator] | None) -> tuple[str, GeneralTableau]:
    """Name and coefficients of the method: those of ``integrator``, by default rkn86, with damping dop853.

    The pair rkn1210 is not faster, even for the tightest tolerances: contacts that open limit its steps.

    Raises
    ------
    InvalidValueError
        If the integrator cannot step this chain.
    """
    if integrator is None:
        if assembly.is_damped:
            return "dop853", dop853()
        integrator = Rkn86
    if reason := integrator.refusal(assembly.is_damped):
        raise InvalidValueError.of("integrator", reason)
    return integrator.name, of_nystroem(integrator) if issubclass(integrator, Nystroem) else dop853()


def integrate(
    assembly: Assembly,
    tolerance: float,
    *,
    until: float | None = None,
    times: Sequence[float] | FloatArray = (),
    compiled: ModuleType | None = None,
    integrator: type[Integrator] | None = None,
) -> Motion:
    """Integrate a chain of mixed granules.

    Parameters
    ----------
    assembly : Assembly
    tolerance : float
        Largest error of a step, relative to the greatest overlap and closing velocity of each contact.
    until : float, optional
        End of the simulated time; by default the duration of the force plus three times the arrival time.
    times : sequence of float, optional
        Times in ascending order at which the state is returned.
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
    job = _job(assembly, tolerance, until, np.asarray(times, dtype=float), method)
    run(job, compiled if assembly.law is None else None)
    _check(job)
    contacts = len(assembly.overlaps)
    x, v = job.x[:-1], job.v[:-1]
    found, weight, end = job.found, assembly.weight, float(job.found[1])
    impulse = weight * end if assembly.force is None else assembly.force.free(end)[1]
    masses = 1 / assembly.inverse_masses
    peaks = job.peaks[0, :contacts]
    return Motion(
        forces=assembly.static_forces + peaks,
        force_times=job.peaks[1, :contacts],
        dynamic_forces=peaks,
        end=end,
        arrival=None if found[2] < 0 else float(found[2]),
        x=x,
        v=v,
        last_impulse=float(found[9]),
        applied_impulse=impulse,
        work=float(found[3]) + weight * float(x[0]),
        dissipated=math.fsum(job.losses.tolist()),
        kinetic=0.5 * masses * v * v,
        potential=assembly.potential(x),
        end_energy=0.5 * assembly.end_stiffness * float(x[-1]) ** 2,
        initial_energy=0.5 * float(masses[0]) * assembly.velocity**2,
        rebound=-float(found[6]) if found[6] < 0 else None,
        steps=int(found[4]),
        evaluations=int(found[5]),
        integrator=name,
        samples_x=job.samples[:, 0, :-1],
        samples_v=job.samples[:, 1, :-1],
        samples_forces=job.samples[:, 2, :contacts],
    )


def _job(assembly: Assembly, tolerance: float, until: float | None, times: FloatArray, method: GeneralTableau) -> Job:
    """Arrays of a run."""
    bodies, problem = len(assembly.inverse_masses), assembly.force
    chain, scales, first = assembly.beginning
    first = _first_step(assembly, first, tolerance * float(scales[0, 0]))
    pulse = (0.0, 1.0, 0.0) if problem is None else (problem.duration, problem.rise_time, problem.peak_force)
    work = math.inf if is_limited() else _WORK + _WORK_PER_BODY * bodies
    settings = [assembly.exponent, assembly.damping_power, tolerance, math.inf if until is None else until, *pulse]
    settings += [first, pulse[0] / _LEAST_STEPS, len(assembly.overlaps), assembly.end_stiffness, assembly.end_damping]
    settings += [work, assembly.is_damped, assembly.weight]
    job = Job(
        method=method,
        problem=problem,
        law=assembly.law,
        settings=np.array(settings, dtype=float),
        stops=np.array([] if problem is None else problem.stops),
        times=times,
        samples=np.zeros((len(times), 3, bodies + 1)),
        watched=(len(assembly.overlaps) - 1,) * 2,
        found=np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, first, 0.0, 0.0]),
        table=np.zeros((ROWS, bodies + 1)),
        forecast=Forecast.of(settings, assembly.static_forces, assembly.cause_of_work),
    )
    job.chain[:], job.scales[:] = chain, scales
    inverse = chain[0]
    job.switches[:] = inverse + np.append(inverse[1:], 0.0), np.ones(bodies)
    job.v[0] = assembly.velocity
    return job


def _first_step(assembly: Assembly, first: float, tolerance: float) -> float:
    """First step, shorter where the force presses a damped contact together that has no overlap.

    The force of the contact then begins with a broken power of the time, which the error estimate of a step does not
    detect. ``tolerance`` is that of the closing velocity.
    """
    c, q, rate = float(assembly.damping[0]), assembly.damping_power, float(assembly.inverse_masses[0])
    if assembly.force is None or assembly.law is not None or q == 0 or assembly.overlaps[0] != 0:
        return first
    allowed = tolerance / float(np.sum(assembly.inverse_masses[:2]))
    path, impulse = assembly.force.free(first)
    while VISCOUS * first * c * max(rate * path, 0.0) ** q * rate * impulse > allowed:
        first /= 2
        path, impulse = assembly.force.free(first)
    return first


def _ratio(one: float, others: FloatArray) -> FloatArray:
    """Quotients, infinite where a divisor is zero."""
    return np.asarray(np.where(others > 0, one / np.where(others > 0, others, 1.0), math.inf))


def _check(job: Job) -> None:
    """Raise the error of a failed run."""
    status, at = Status(int(job.found[0])), f"at {job.found[1]:.4g} characteristic times"
    if status is Status.DONE:
        return
    reasons = {
        Status.TOO_LONG: f"the chain takes too many steps because of {job.forecast.cause()}: {job.found[4]:.0f}"
        f" {at} (set a timeout to continue, simulate a shorter time, use a shorter chain, or loosen the tolerance)",
        Status.FAILED: f"the step size vanishes {at} (the ratios of masses or stiffnesses are too large, or the damping"
        " is too strong)",
        Status.RUNNING: f"the time limit was reached {at} (allow more, loosen the tolerance, or simulate a shorter time"
        " with until)",
    }
    raise NumericalError(reasons[status])
