"""Setup of a simulation of a finite or precompressed chain: units, the scaled problem, and the reported contacts."""

from __future__ import annotations

import math
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from attrs import evolve, frozen

from shockwave.base.errors import Fault, InvalidValueError, refuse
from shockwave.base.numerics import FloatArray
from shockwave.engine.backend import compiled_code
from shockwave.engine.chain_assembly import Assembly
from shockwave.engine.chain_motion import integrate
from shockwave.engine.integrator import Integrator
from shockwave.engine.scaled_problem import ScaledProblem
from shockwave.profiles.free_path import FreePath
from shockwave.registry.registry import load
from shockwave.scene.chain import Chain, Scales
from shockwave.scene.chain_end import Bar, Wall
from shockwave.scene.contact_law import BoundLaw
from shockwave.scene.feature_rules import integrator_refusal
from shockwave.scene.layout import Layout
from shockwave.scene.motion import Motion
from shockwave.scene.scene import Excitation, Scene, faults_of
from shockwave.scene.segments import MOST_GRANULES
from shockwave.scene.shock import Shock
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.scene.solitary_wave import MOMENTUM
from shockwave.simulation.recording import check_end, sample_times, select_contacts
from shockwave.simulation.wave_setup import RTOL, STEP

if TYPE_CHECKING:  # chains without such contacts do not need it
    from shockwave.engine.chain_plastic import PlasticContacts

# Contacts of an endless chain that are reported unless they are requested.
_ENDLESS = (0, 1, 2, 5, 10, 20, 50, 100)
# Simulated time after the shock, over the time at which the leading wave arrives at the last of them, as for a finite
# chain; tolerance of the step in the run that gives this time, and its significant digits.
_ARRIVALS = 3.0
_TOLERANCE = 1e-4
_DIGITS = 3
# Greatest force over that of the shock; waves reach less than half of it, and none is faster than sound under it.
_GREATEST = 8.0
# Displacement of a wall over the overlap of its contact, per relative tolerance, below which it counts as fixed.
_STILL = 1e-2
# Longest default end of the simulated time, in characteristic times per granule.
_LATEST = 10.0
# Granules ahead of a sound wave that it moves, a constant and a number per cube root of its way.
_AHEAD = 30
_AHEAD_RATE = 10


@frozen(eq=False)
class ChainSetup:
    """A chain with its excitation, in SI units and as a scaled problem.

    Attributes
    ----------
    scene : Scene
        Excitation and chain.
    layout : Layout
        Masses, stiffnesses and static forces in SI units.
    scales : Scales
        Units of ``assembly``; their mass and contact stiffness are the medians in the chain.
    assembly : Assembly
        The scaled problem.
    options : SimulateOptions
        The options with all defaults filled in, except the integrator.
    method : type of Integrator or None
        The integrator that the options name.
    compiled : module or None
        The compiled module, or None for NumPy.
    reported : array of int
        Contacts to report.
    end : float or None
        End of the simulated time, scaled, if the options do not state it; None for the default of a finite chain.
    """

    scene: Scene
    layout: Layout
    scales: Scales
    assembly: Assembly
    options: SimulateOptions
    method: type[Integrator] | None
    compiled: ModuleType | None
    reported: npt.NDArray[np.intp]
    end: float | None = None

    @classmethod
    def of(cls, options: SimulateOptions, scene: Scene) -> ChainSetup:
        """Lay out and scale a chain; of an endless one, as many granules as its waves reach.

        Raises
        ------
        InvalidValueError
            If a value is out of range, or a contact of the options is not one of the chain.
        NumericalError
            If the time at which the leading wave arrives at the last reported contact of an endless chain is not found.
        """
        if scene.chain.count is None and scene.shock is not None:
            return _endless(options, scene)
        layout, excitation = scene.layout, scene.excitation
        scales = _scales(layout, excitation, scene.chain)
        assembly = _assembly(layout, scales, excitation, options.rtol or RTOL, options.until)
        method = None if options.integrator is None else load("integrators", options.integrator)
        numpy_part = f"the contact law {type(layout.law).__name__}" if layout.law else ""
        numpy_part = "a bar at the end" if isinstance(layout.wall, Bar) else numpy_part
        if method is not None and method.coefficients() is None:
            numpy_part = f"the integrator {method.name}"
        if numpy_part and options.backend == "compiled":
            raise InvalidValueError.of("backend", f"must be auto or numpy for {numpy_part} (got 'compiled')")
        numpy_alone = bool(numpy_part) or compiled_code(options.backend) is None
        compiled = None if numpy_alone else import_module("shockwave.engine._chains")
        fixed = method is not None and not method.adaptive
        step, rtol = (options.step or STEP, None) if fixed else (None, options.rtol or RTOL)
        filled = evolve(options, step=step, rtol=rtol)
        reported = np.array(select_contacts(options, len(layout.pairs.stiffnesses)), dtype=np.intp)
        check_end(options, excitation)
        if options.is_recorded and options.until is not None:
            sample_times(options, scales, options.until / scales.time, len(layout.masses))
        return cls(scene, layout, scales, assembly, filled, method, compiled, reported)

    @property
    def granules(self) -> int:
        """Number of granules, including a striker."""
        return len(self.layout.masses)

    @property
    def has_wall(self) -> bool:
        """Whether the last contact is with a wall."""
        return self.layout.wall is not None

    @property
    def is_undamped(self) -> bool:
        """Whether waves never cease, because nothing takes energy from a chain under a static load."""
        assembly = self.assembly
        damped = assembly.law is not None or assembly.end_damping or assembly.damping.any()
        return not damped and bool(assembly.static_forces.any() or assembly.weight)

    @property
    def until(self) -> float | None:
        """Requested end of the simulated time, scaled."""
        until = self.options.until
        return self.end if until is None else until / self.scales.time

    @property
    def rtol(self) -> float:
        """Requested relative error."""
        return self.options.rtol or RTOL

    def judged_contacts(self, forces: FloatArray) -> npt.NDArray[np.intp]:
        """Contacts for which the tolerance holds: those requested, that of the greatest force, and the last one."""
        endless = self.scene.chain.count is None
        requested = self.reported.tolist() if self.options.contacts or endless else []
        requested += [contact for sensor in self.options.sensors for contact in sensor.contacts]
        last = [] if endless else [len(forces) - 1]
        return np.array(sorted({*requested, int(np.argmax(forces)), *last}), dtype=np.intp)


def check_setup(options: SimulateOptions, scene: Scene) -> ChainSetup | None:
    """Setup of a finite chain, None for an endless one, whose length is found by integration; nothing is integrated.

    Raises
    ------
    InvalidValueError
        If a value is out of range, a contact of the options is not one of the chain, or waves reach too many granules.
    """
    chain, faults = scene.chain, faults_of(scene.chain, scene.impact or scene.motion)
    if options.integrator is not None and not faults:
        reason = integrator_refusal(options.integrator, chain)
        faults = [Fault("integrator", reason)] if reason else []
    refuse(faults)
    if chain.count is None:
        part = _part(options, scene)
        if part.until is not None:
            granules = _granules_within(part, part.until)
            if options.is_recorded:
                sample_times(options, part.scales, part.until, granules)
        return None
    return ChainSetup.of(options, scene)


def _endless(options: SimulateOptions, scene: Scene) -> ChainSetup:
    """The part of an endless chain that the waves reach within the simulated time."""
    part = _part(options, scene)
    end = part.until
    if end is None:
        accuracy = part.options.step or _TOLERANCE
        motion = integrate(part.assembly, accuracy, compiled=part.compiled, integrator=part.method)
        duration = 0.0 if part.assembly.force is None else part.assembly.force.duration
        end = motion.end if motion.arrival is None else duration + _ARRIVALS * motion.arrival
        # rounded, so that it does not depend on the code that integrated the part
        end = float(f"{end:.{_DIGITS}g}")
    whole = ChainSetup.of(part.options, _of_length(scene, _granules_within(part, end)))
    names = ("contacts", "record", "sensors", "interval")
    filled = evolve(whole.options, **{name: getattr(options, name) for name in names})
    # with sensors, the time found is that of the last of them, in which waves do not reach contacts far beyond
    reached = part if part.until is None else whole
    reported = options.contacts or [contact for contact in _ENDLESS if contact < reached.granules - 1]
    return evolve(whole, scene=scene, options=filled, reported=np.array(reported), end=end)


def _part(options: SimulateOptions, scene: Scene) -> ChainSetup:
    """The part of an endless chain up to the last reported contact."""
    sensors = tuple(each.number for each in options.sensors)
    granules = max(options.contacts + sensors or _ENDLESS) + 2
    if granules > MOST_GRANULES:
        problem = f"must be at most {MOST_GRANULES - 2} (got {granules - 2})"
        raise InvalidValueError.of("contacts", problem)
    others = evolve(options, contacts=(), record=(), sensors=(), interval=None)
    return ChainSetup.of(others, _of_length(scene, granules))


def _of_length(scene: Scene, granules: int) -> Scene:
    """The scene of an endless chain on so many of its granules."""
    return Scene(excitation=scene.excitation, chain=evolve(scene.chain, granules=granules))


def _granules_within(part: ChainSetup, end: float) -> int:
    """Number of granules of an endless chain that waves reach by the scaled time ``end``."""
    last, until, forces = part.granules - 2, part.options.until, float(part.scene.chain.precompression)
    if part.scene.shock is not None:
        forces += _GREATEST * part.scene.shock.peak_force
    p = float(part.layout.pairs.exponents[0])  # an endless chain has one law
    reached = max(last, end * math.sqrt(p) * (forces / part.scales.force) ** ((p - 1) / (2 * p)))
    granules: int = math.ceil(reached + _AHEAD + _AHEAD_RATE * math.cbrt(reached))
    if granules > MOST_GRANULES:
        name, got = ("contacts", f"got {last}") if until is None else ("until", f"got {until:g} s")
        problem = f"must be less, since the waves reach {granules} granules, more than {MOST_GRANULES} ({got})"
        raise InvalidValueError.of(name, problem)
    return granules


def _scales(layout: Layout, excitation: Excitation, chain: Chain) -> Scales:
    """Units in which a typical granule, a typical contact and the force on it are about 1.

    The unit of force is the peak force of the shock or, for a short shock, approximately that of its wave; for a
    striker it is the force that stops a granule of the same velocity, and its weight.
    """
    power = float(layout.pairs.exponents[0])
    # stiffnesses of contacts with different exponents have different units
    alike = layout.pairs.stiffnesses[layout.pairs.exponents == power]
    mass, stiffness = (float(np.sort(each)[len(each) // 2]) for each in (layout.masses, alike))

    def of(force: float) -> Scales:
        """Units with T0 = m^(1/2) k^(-1/(2p)) F^(-(p-1)/(2p))."""
        time = math.sqrt(mass) * stiffness ** (-0.5 / power) * force ** (-0.5 * (power - 1) / power)
        return Scales(force, time, mass, chain.spacing, chain.contact_share)

    if not isinstance(excitation, Shock):
        # (m^p v^2p k)^(1/(p+1)), factor by factor so that no intermediate power overflows
        force = mass ** (power / (power + 1)) * layout.top_speed ** (2 * power / (power + 1))
        return of(force * stiffness ** (1 / (power + 1)) + layout.weight)
    scales = of(excitation.peak_force)
    strength = scales.rise_time(excitation.rise_time) * excitation.profile.total_area / MOMENTUM
    return scales if strength >= 1 else of(excitation.peak_force * strength ** (2 * power / (power + 1)))


def _is_rigid(layout: Layout, scales: Scales, wall: Wall | Bar, rtol: float, until: float | None) -> bool:
    """Whether spring and dashpot hold a wall so still that its motion changes no force by more than ``rtol``.

    The displacement of the wall is compared with the overlap of its contact, under forces of up to `_GREATEST`, or that
    which stores the whole energy of a striker in the contact.
    """
    power, stiffness = float(layout.pairs.exponents[-1]), float(layout.pairs.stiffnesses[-1])
    heaviest = float(max(layout.masses))
    stopped = (layout.velocity * math.sqrt(float(layout.masses[0]) * (power + 1) / 2)) ** (2 / (power + 1))
    force = max(_GREATEST * scales.force, stopped**power * stiffness ** (1 / (power + 1)))
    force += layout.weight + float(layout.static_forces[-1])
    overlap = (force / stiffness) ** (1 / power)
    span = _LATEST * len(layout.masses) * scales.time * math.sqrt(heaviest / scales.mass) if until is None else until
    return bool(power * force < _STILL * rtol * overlap * max(wall.stiffness, wall.damping / span))


def _plastic(layout: Layout, stiffnesses: FloatArray, length: float, velocity: float) -> PlasticContacts | None:
    """Elastic-plastic contacts in units of length and velocity, from scaled stiffnesses; None if there are none."""
    if layout.plastic is None:
        return None
    from shockwave.engine.chain_plastic import PlasticContacts
    from shockwave.scene.elastic_plastic import RATE, Loading

    loading = Loading(stiffnesses, layout.pairs.radii / length, layout.plastic.strengths / layout.pairs.moduli)
    return PlasticContacts(loading, layout.plastic.rate_constants, RATE * layout.plastic.lengths / velocity)


def _assembly(layout: Layout, scales: Scales, excitation: Excitation, rtol: float, until: float | None) -> Assembly:
    powers, rates = layout.pairs.exponents, layout.damping_powers
    length = scales.energy / scales.force
    force = None
    if isinstance(excitation, Shock):
        rise_time = scales.rise_time(excitation.rise_time)
        force = ScaledProblem(excitation.profile, rise_time, excitation.peak_force / scales.force)
    elif isinstance(excitation, Motion):
        force = _problem_of(excitation, scales)
    wall, law = layout.wall or Wall(), layout.law
    guided = isinstance(excitation, Motion)
    if wall.mass is not None and not guided and _is_rigid(layout, scales, wall, rtol, until):
        wall = Wall(material=wall.material)
    bodies = layout.masses if wall.mass is None else np.append(layout.masses, wall.mass)
    impedance = wall.resistance * scales.velocity / scales.force if isinstance(wall, Bar) else 0.0
    stiffnesses = layout.pairs.stiffnesses * (length**powers / scales.force)
    return Assembly(
        inverse_masses=np.append(scales.mass / bodies, [1 / impedance] if impedance else []),
        stiffnesses=stiffnesses,
        overlaps=layout.overlaps / length,
        exponents=powers,
        fixed_wall=layout.wall is not None and wall.mass is None and not impedance,
        impedance=impedance,
        damping=layout.damping_coefficients * (length**rates * scales.velocity / scales.force),
        damping_powers=rates,
        end_stiffness=wall.stiffness * length / scales.force,
        end_damping=wall.damping * scales.velocity / scales.force,
        force=force,
        velocity=layout.velocity / scales.velocity,
        weight=layout.weight / scales.force,
        movable_end=wall.mass is not None,
        guided=guided,
        top_speed=layout.top_speed / scales.velocity,
        law=None if law is None else BoundLaw(law, layout.pairs, length, scales.velocity, scales.force),
        law_contacts=None if law is None else layout.law_contacts,
        plastic=_plastic(layout, stiffnesses, length, scales.velocity),
    )


# ---------------------------------------------------------------- prescribed motion

# Degree of the polynomials of the displacement.
_DEGREE = 4


@frozen(eq=False)
class _Shape:
    """What a `ScaledProblem` reads of a profile: knots in units of half the duration, and their path."""

    duration_ratio: float
    breakpoints: tuple[float, ...]
    path: FreePath

    def free_path(self) -> FreePath:
        return self.path


def _problem_of(motion: Motion, scales: Scales) -> ScaledProblem:
    """The acceleration of a motion, beyond its first velocity, as a force on a granule of unit mass."""
    course, speed, half = motion.course, motion.top_speed, motion.duration / 2
    first, edges = float(course(0.0, 1)), course.x / half
    path = FreePath.of_polynomials(
        edges,
        lambda s: (course(s * half) - first * s * half) / (speed * half),
        lambda s: (course(s * half, 1) - first) / speed,
        _DEGREE,
    )
    shape: Any = _Shape(2.0, tuple(edges.tolist()), path)
    time = half / scales.time
    return ScaledProblem(shape, time, speed / scales.velocity / time)
