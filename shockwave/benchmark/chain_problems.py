"""Problems of shocks on chains: peak force and arrival time of the front at one contact, and their references."""

from __future__ import annotations

from typing import NamedTuple

from attrs import frozen

from shockwave.base.errors import NumericalError
from shockwave.benchmark.benchmark_scenes import power
from shockwave.benchmark.work_precision import Clock
from shockwave.engine.backend import compiled
from shockwave.engine.integrator import Integrator
from shockwave.engine.nystroem_integrators import Nystroem, Rkn86, Rkn1210
from shockwave.engine.scaled_problem import chain_energy
from shockwave.scenario.scenario import Scenario
from shockwave.scene.scene import Scene
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation.integration_stretches import Course
from shockwave.simulation.simulate import simulate_scene
from shockwave.simulation.wave_setup import scale_scene

# Smallest maximum of a contact force that counts as that of the front, in units of the peak force of the shock.
_FLOOR = 0.05
# Step tolerance of references.
_TIGHT = 1e-13
# Relative rounding error of a number.
_ROUNDING = 2e-16
# Last contact at which the front of a scenario is measured, and its least distance in contacts from a free end.
_FARTHEST = 200
_BEFORE_END = 8
# Longest time that a front takes from the end of the shock to its contact, in characteristic times.
_LONGEST = 1e4
# Interval at which the front is looked for, in characteristic times.
_INTERVAL = 2.0


class Reading(NamedTuple):
    """Peak force and its time at the contact, in scaled units, and the number of steps.

    ``drift`` is the relative change of the energy of the chain from the end of the force to the peak; None if the force
    still acts.
    """

    force: float
    time: float
    drift: float | None
    steps: int


class Reference(NamedTuple):
    """Peak force and its time in scaled units, their relative error, and their source."""

    force: float
    time: float
    error: float
    source: str

    def errors(self, force: float, time: float) -> dict[str, float | None]:
        """Relative errors."""
        return {"peak force": abs(force / self.force - 1), "arrival time": abs(time / self.time - 1)}


@frozen(eq=False)
class Case:
    """A shock on a chain, and the contact at which the front is measured, counted from 0.

    ``known`` are peak force and time there in characteristic units, if they are known to 20 digits.
    """

    name: str
    description: str
    scene: Scene
    contact: int
    known: tuple[float, float] | None = None


# 20 digits, from two methods in quadruple precision with steps that end on every kink.
_KNOWN = {"A": (1.505133369796510557, 63.699048040316566), "B": (2.178748500679994696, 201.244071882915959)}
# Exponents of rise and decay, n, t0/T0, contact, property.
_POWER_LAWS = {
    "A": (0.5, 1, 3, 2, 59, "infinite slope at the start"),
    "B": (1, 1, 10, 10, 199, "long shock, wave train"),
    "slow": (2, 2, 2, 40, 99, "slow force, fast oscillations"),
    "short": (0.5, 1, 3, 0.5, 39, "ejection, as in Table 2, row 1"),
}


def _paper_case(name: str) -> Case:
    """A power law with the peak force of the paper, on the chain of the paper."""
    rise, decay, ratio, rise_time, contact, remark = _POWER_LAWS[name]
    shock, chain = power(rise, decay, ratio, rise_time)
    description = f"power law, t0 = {rise_time:g} T0, n = {ratio:g}, eta {rise:g} and {decay:g} ({remark})"
    scene = Scene(excitation=shock, chain=chain)
    return Case(name, description, scene, contact, _KNOWN.get(name))


#: The named problems.
CASES = {name: _paper_case(name) for name in _POWER_LAWS}


def case_of(scenario: Scenario) -> Case:
    """The problem of a scenario, at the contact where its leading wave is found, at most 200.

    Raises
    ------
    ShockwaveError
        If it cannot be simulated.
    """
    scene, count = scenario.scene, scenario.chain.count
    contact = min(int(simulate_scene(scene, SimulateOptions(waves="primary")).wave.scaled.contact), _FARTHEST)
    if count is not None:
        contact = max(min(contact, count - 2 - _BEFORE_END), 0)
    return Case(scenario.name, type(scenario.shock.profile).__name__, scene, contact)


def reference(case: Case) -> Reference:
    """The known digits, or a run at a tight tolerance that is checked by another method.

    Raises
    ------
    NumericalError
        If the front has no peak at the contact.
    """
    if case.known is not None:
        return Reference(*case.known, _ROUNDING, "two integrators in quadruple precision, which agree to 20 digits")
    best = read_front(case, at_setting(Rkn1210, _TIGHT), Clock())
    other = read_front(case, at_setting(Rkn86, _TIGHT), Clock())
    error = max(abs(other.force / best.force - 1), abs(other.time / best.time - 1), _ROUNDING)
    return Reference(best.force, best.time, error, f"rkn1210 at a step tolerance of {_TIGHT:g}, checked by rkn86")


def at_setting(method: type[Integrator], setting: float) -> Integrator:
    """The method at a tolerance or step size, with the compiled code if it has one."""
    if issubclass(method, Nystroem):
        return method(tolerance=setting, compiled=compiled)
    return method(tolerance=setting) if method.adaptive else method(size=setting)


def read_front(case: Case, integrator: Integrator, clock: Clock) -> Reading:
    """Measure the front of ``case`` by an integrator on a window that grows with the front.

    Raises
    ------
    NumericalError
        If the integrator fails or takes too long, or the front has no peak at the contact.
    """
    problem, _ = scale_scene(case.scene)
    course, last = Course(problem, integrator, kept=False), problem.duration + _LONGEST
    initial = 0.0
    while course.now < last:
        clock.check()
        driven = course.now < problem.duration
        stretch = course.advance(min(course.now + _INTERVAL, problem.duration if driven else last))
        energy = chain_energy(stretch.x[-1], stretch.v[-1])
        if driven:
            initial = energy
        fronts = [peak for peak in course.log.at(case.contact) if peak.force > _FLOOR]
        if fronts:
            force, time = fronts[-1].force, fronts[-1].time
            return Reading(force, time, None if driven else abs(energy / initial - 1), course.steps)
    raise NumericalError(f"the front has no peak of its own at contact {case.contact}")
