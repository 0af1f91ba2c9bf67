"""Shocks on chains with known answers: the peak force of the front at a contact, and when it is reached."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from functools import cached_property
from typing import NamedTuple

from attrs import evolve, frozen
from scipy.optimize import brentq

from shockwave.benchmark.rows import worst
from shockwave.benchmark.timing import Clock, Limits, TooSlowError
from shockwave.chain.chain import Chain, Scales
from shockwave.chain.material import Material
from shockwave.errors import NumericalError
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import scaled, simulate_with
from shockwave.options import SimulateOptions
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.scenario.scenario import Scenario
from shockwave.simulation.backend import compiled
from shockwave.simulation.integrator import Integrator
from shockwave.simulation.march import Span, march
from shockwave.simulation.nystroem import Nystroem, Rkn86, Rkn1210
from shockwave.simulation.problem import ChainProblem, contact_forces, overlaps

__all__ = [
    "FLOOR",
    "NAMED",
    "Case",
    "Reading",
    "Reference",
    "by_search",
    "energy",
    "method_of",
    "of_scenario",
    "patience",
    "read_front",
]

_STEEL = Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
# The chain of the paper, and the force of its tables.
_CHAIN, _FORCE = Chain(material=_STEEL, radius=4.75e-3), 100.0
#: A maximum of a contact force below this, in units of the wave to come, is none of the front.
FLOOR = 0.05
# Step tolerances of references: the first that two methods reach in time.
_TIGHT = (1e-13, 1e-11, 1e-9, 1e-7)
# How many runs' time a reference may take, and how long at least [s].
_PATIENCE, _AT_LEAST = 4.0, 1.0
# Digits of a double.
_DIGITS = 2e-16
# The contact of a scenario at which it is read, at most; how far behind it the chain goes on; how much of that is free.
_FARTHEST, _AHEAD, _REACH = 200, 40, 8


class Reading(NamedTuple):
    """What a run found: peak force and its time at the contact, in scaled units, and what it took.

    ``drift`` is the relative change of the chain's energy from the end of the force until the peak was read, None
    where the force had not ended by then.
    """

    force: float
    time: float
    drift: float | None
    evaluations: int | None
    steps: int | None


class Reference(NamedTuple):
    """The answer in scaled units, its relative error, and where it is from."""

    force: float
    time: float
    error: float
    source: str


@frozen(eq=False, slots=False)
class Case:
    """A shock on a chain, and the contact at which the front is read, counted from 0.

    ``known`` are peak force and time there, in natural units, where they are known to 20 digits; ``limits`` are
    those of runs, to which the reference has to keep, None where it has none.
    """

    name: str
    description: str
    shock: Shock
    chain: Chain
    contact: int
    known: tuple[float, float] | None = None
    limits: Limits | None = None

    @cached_property
    def scaled(self) -> tuple[ChainProblem, Scales]:
        """The problem in scaled units, and the units."""
        return scaled(self.shock, self.chain)

    @property
    def problem(self) -> ChainProblem:
        """The problem in scaled units."""
        return self.scaled[0]

    @property
    def granules(self) -> int:
        """Granules of a whole chain that has not felt its end when the front is read."""
        enough = self.contact + _AHEAD
        return min(self.problem.granules or enough, enough)

    @cached_property
    def reference(self) -> Reference:
        """The answer: the digits that are known, or the tightest run in time, cross-checked by another method.

        Raises
        ------
        NumericalError
            When there is none, or none in time.
        """
        if self.known is not None:
            source = "two integrators in quadruple precision that agree to 20 digits"
            return Reference(*self.known, _DIGITS, source)
        for tolerance in _TIGHT:
            try:
                return self._reference(tolerance)
            except TooSlowError as error:
                late = error
        raise NumericalError(f"there is no reference in time ({late})")

    def _reference(self, tolerance: float) -> Reference:
        clock = None if self.limits is None else Clock(patience(self.limits), time.perf_counter())
        best, other = (
            read_front(self, method(tolerance=tolerance, compiled=compiled), clock) for method in (Rkn1210, Rkn86)
        )
        apart = worst(abs(other.force / best.force - 1), abs(other.time / best.time - 1))
        source = f"rkn1210 at a step tolerance of {tolerance:g}, cross-checked by rkn86"
        return Reference(best.force, best.time, max(apart, _DIGITS), source)

    def errors(self, reading: Reading) -> dict[str, float | None]:
        """Relative errors of a reading."""
        return {
            "peak force": abs(reading.force / self.reference.force - 1),
            "arrival time": abs(reading.time / self.reference.time - 1),
            "energy": reading.drift,
        }


def patience(limits: Limits) -> Limits:
    """How long a reference may take, where runs have these limits."""
    return evolve(limits, run=max(_PATIENCE * limits.run, _AT_LEAST))


def _power_law(rise: float, decay: float, ratio: float, rise_time: float) -> Shock:
    """A power law with the paper's peak force; its rise time is in natural units."""
    profile = PowerLaw(rise_exponent=rise, decay_exponent=decay, duration_ratio=ratio)
    unit = Scales.of(_CHAIN, _FORCE).time
    return Shock(profile=profile, peak_force=_FORCE, rise_time=rise_time * unit)


#: The named problems. Digits of A and B: integrated in quadruple precision by two methods, steps ending on every kink.
NAMED = (
    Case(
        "A",
        "power law, t0 = 2 T0, n = 3, eta 0.5 and 1, read at contact 59: infinite slope at the start, one wave ahead",
        _power_law(0.5, 1, 3, 2),
        _CHAIN,
        59,
        (1.505133369796510557, 63.699048040316566),
    ),
    Case(
        "B",
        "power law, t0 = 10 T0, n = 10, eta 1 and 1, read at contact 199: long, a train of waves",
        _power_law(1, 1, 10, 10),
        _CHAIN,
        199,
        (2.178748500679994696, 201.244071882915959),
    ),
    Case(
        "slow",
        "power law, t0 = 40 T0, n = 2, eta 2 and 2, read at contact 99: the force is slow, its contacts swing fast",
        _power_law(2, 2, 2, 40),
        _CHAIN,
        99,
    ),
    Case(
        "short",
        "power law, t0 = 0.5 T0, n = 3, eta 0.5 and 1, read at contact 39: granules are ejected, as in Table 2, row 1",
        _power_law(0.5, 1, 3, 0.5),
        _CHAIN,
        39,
    ),
)


def of_scenario(scenario: Scenario, limits: Limits | None = None) -> Case:
    """The scene of a scenario, read where its primary is known, or at contact 200 if that is farther.

    ``limits`` are those of runs, which its reference has to keep to.

    Raises
    ------
    ShockwaveError
        When it cannot be simulated.
    """
    found = simulate_with(SimulateOptions(waves="primary"), scenario.shock, scenario.chain).found
    contact = min(int(found.contact), _FARTHEST)
    if scenario.chain.granules is not None:
        contact = max(min(contact, scenario.chain.granules - 2 - _REACH), 0)
    description = f"{type(scenario.shock.profile).__name__}, read at contact {contact}"
    return Case(scenario.name, description, scenario.shock, scenario.chain, contact, limits=limits)


def read_front(case: Case, integrator: Integrator, clock: Clock | None = None) -> Reading:
    """The front at the contact of ``case``, by an integrator, on a window that grows with it.

    Raises
    ------
    NumericalError
        When the integrator fails, takes too long, or the front has no peak at the contact.
    """
    problem, contact = case.problem, case.contact
    held = None
    for steps, span in enumerate(_spans(problem, integrator, clock), start=1):
        if span.end == problem.duration:
            held = energy(span.x1, span.v1)
        found = _peak(span, contact)
        if found is not None:
            drift = None if held is None else abs(energy(span.x1, span.v1) / held - 1)
            return Reading(*found, drift, integrator.evaluations, steps)
    raise NumericalError(f"the front has no peak of its own at contact {contact}")


def _spans(problem: ChainProblem, integrator: Integrator, clock: Clock | None) -> Iterator[Span]:
    for span in march(problem, integrator, problem.duration + 1e4):
        if clock is not None:
            clock.check()
        yield span


def _peak(span: Span, contact: int) -> tuple[float, float] | None:
    """Peak force and its time, if the force at the contact has a maximum in the span: velocities are equal there."""
    if len(span.v0) < contact + 2:
        return None

    def closing(at: float) -> float:
        _, v = span.at(at)
        return float(v[contact] - v[contact + 1])

    before, after = (float(v[contact] - v[contact + 1]) for v in (span.v0, span.v1))
    if not (before > 0 >= after and _force(span.x1, contact) > FLOOR):
        return None
    # Interpolation and step agree to rounding only.
    opposite = closing(span.begin) * closing(span.end) < 0
    top = brentq(closing, span.begin, span.end, xtol=1e-14, rtol=1e-14) if opposite else span.end
    return _force(span.at(top)[0], contact), float(top)


def _force(x: FloatArray, contact: int) -> float:
    return math.pow(max(float(x[contact] - x[contact + 1]), 0.0), 1.5)


def energy(x: FloatArray, v: FloatArray) -> float:
    """Of motion and of the contacts, 2/5 of force times overlap each, in scaled units."""
    return float(0.5 * (v @ v) + 0.4 * (contact_forces(x) @ overlaps(x)))


def by_search(case: Case, result: SimulationResult) -> Reading:
    """What the simulation tells of the contact of ``case``."""
    passage, (_, scales) = result.passage(case.contact), case.scaled
    found = result.found
    return Reading(
        passage.peak_force / scales.force,
        passage.arrival_time / scales.time,
        result.energy_defect,
        int(found.evaluations),
        int(found.steps),
    )


def method_of(method: type[Integrator], setting: float) -> Integrator:
    """The method at a tolerance or a step, by the compiled code where there is one for it."""
    if issubclass(method, Nystroem):
        return method(tolerance=setting, compiled=compiled)
    return method(tolerance=setting) if method.adaptive else method(size=setting)
