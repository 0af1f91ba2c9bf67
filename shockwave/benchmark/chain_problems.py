"""Problems of shocks on chains: greatest force at one contact and its time, and their references."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

from attrs import evolve, frozen

from shockwave.benchmark.benchmark_scenes import chain_with_keys, power_law
from shockwave.engine.chain_motion import ChainMotion, integrate
from shockwave.engine.integrator import Integrator
from shockwave.engine.nystroem_integrators import Rkn86, Rkn1210
from shockwave.scenario.scenario import Scenario
from shockwave.scene.scene import Scene
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation.contact_setup import ChainSetup
from shockwave.simulation.result_parts import Cost
from shockwave.simulation.simulate import simulate_scene

# Step tolerance of references, and tolerance of the simulation that gives the end of the runs.
_TIGHT = 1e-13
_LOOSE = 1e-4
# Relative rounding error of a number.
_ROUNDING = 2e-16
# Last contact at which the front of a scenario is measured, and its least distance in contacts from a free end.
_FARTHEST = 200
_BEFORE_END = 8
# Characteristic times after the front has passed its contact at which a run ends.
_AFTER = 2.0


class Reference(NamedTuple):
    """Greatest force and its time in scaled units, their relative error, and their source."""

    force: float
    time: float
    error: float
    source: str

    def errors(self, force: float, time: float) -> dict[str, float | None]:
        """Relative errors."""
        return {"peak force": abs(force / self.force - 1), "arrival time": abs(time / self.time - 1)}


@frozen(eq=False, slots=False)
class ChainCase:
    """A shock on a chain, and the contact at which the front is measured, counted from 0; None for the wall.

    ``known`` are peak force and time there in characteristic units, if they are known to 20 digits.
    """

    name: str
    description: str
    scene: Scene
    contact: int | None = None
    known: tuple[float, float] | None = None

    @property
    def place(self) -> str:
        """Where the front is measured."""
        return "wall" if self.contact is None else f"contact {self.contact}"

    @cached_property
    def setup(self) -> ChainSetup:
        """The chain as far as the end does not affect the front at the contact, with the end of the runs."""
        chain, contact = self.scene.chain, self.contact
        if contact is None:
            return ChainSetup.of(SimulateOptions(), self.scene)
        beyond = contact + 2 + _BEFORE_END
        part = evolve(chain, granules=beyond if chain.count is None else min(beyond, chain.count))
        case = ChainSetup.of(SimulateOptions(), Scene(excitation=self.scene.excitation, chain=part))
        return evolve(case, end=self.simulate(_LOOSE)[1] / case.scales.time + _AFTER)

    def simulate(self, rtol: float) -> tuple[float, float, float | None, Cost]:
        """Force [N], its time [s], relative energy defect and cost of the function simulate."""
        contacts = () if self.contact is None else (self.contact,)
        result = simulate_scene(self.scene, SimulateOptions(rtol=rtol, waves="primary", contacts=contacts))
        if self.contact is None:
            peak = result.transmitted
            assert peak is not None
            return peak.peak_force, peak.time, result.energy_defect, result.cost
        passage = result.passage(self.contact)
        return passage.peak_force, passage.arrival_time, result.energy_defect, result.cost

    def run(self, method: type[Integrator], accuracy: float) -> ChainMotion:
        """The motion by an integrator with a tolerance or a step.

        Raises
        ------
        NumericalError
            If the integrator fails or takes too long.
        """
        setup = self.setup
        return integrate(setup.assembly, accuracy, until=setup.until, compiled=setup.compiled, integrator=method)

    def front(self, motion: ChainMotion) -> tuple[float, float]:
        """Greatest force at the contact and its time, in scaled units."""
        at = -1 if self.contact is None else self.contact
        return float(motion.forces[at]), float(motion.force_times[at])


# 20 digits, from two methods in quadruple precision with steps that end on every kink.
_KNOWN = {"A": (1.505133369796510557, 63.699048040316566), "B": (2.178748500679994696, 201.244071882915959)}
# Exponents of rise and decay, n, t0/T0, contact, property.
_POWER_LAWS = {
    "A": (0.5, 1, 3, 2, 59, "infinite slope at the start"),
    "B": (1, 1, 10, 10, 199, "long shock, wave train"),
    "slow": (2, 2, 2, 40, 99, "slow force, fast oscillations"),
    "short": (0.5, 1, 3, 0.5, 39, "ejection, as in Table 2, row 1"),
}


def _paper_case(name: str) -> ChainCase:
    """A power law with the peak force of the paper, on the chain of the paper."""
    rise, decay, ratio, rise_time, contact, remark = _POWER_LAWS[name]
    shock, chain = power_law(rise, decay, ratio, rise_time)
    description = f"power law, t0 = {rise_time:g} T0, n = {ratio:g}, eta {rise:g} and {decay:g} ({remark})"
    scene = Scene(excitation=shock, chain=chain)
    return ChainCase(name, description, scene, contact, _KNOWN.get(name))


def _wall_case() -> ChainCase:
    """A triangle on a mixed chain before a wall."""
    segments = [{"count": 12}, {"count": 8, "material": "ptfe", "diameter": "8 mm"}, {"count": 5}]
    shock, chain = chain_with_keys({"granules": segments, "end": {"wall": "same"}})
    description = "triangle, t0 = 1 T0, n = 3, on 12 steel, 8 softer and 5 steel granules before a wall"
    return ChainCase("wall", description, Scene(excitation=shock, chain=chain))


#: The named problems.
CASES = {name: _paper_case(name) for name in _POWER_LAWS} | {"wall": _wall_case()}


def case_of(scenario: Scenario) -> ChainCase:
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
    return ChainCase(scenario.name, type(scenario.shock.profile).__name__, scene, contact)


def reference(case: ChainCase) -> Reference:
    """The known digits, or a run at a tight tolerance that is checked by another method.

    Raises
    ------
    NumericalError
        If an integrator fails.
    """
    if case.known is not None:
        return Reference(*case.known, _ROUNDING, "two integrators in quadruple precision, which agree to 20 digits")
    (force, time), (other, then) = (case.front(case.run(method, _TIGHT)) for method in (Rkn1210, Rkn86))
    error = max(abs(other / force - 1), abs(then / time - 1), _ROUNDING)
    return Reference(force, time, error, f"rkn1210 at a step tolerance of {_TIGHT:g}, checked by rkn86")
