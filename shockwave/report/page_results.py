"""Results that a page shows: prediction and simulation of a scenario, or the reasons why they failed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from attrs import evolve, frozen

from shockwave.base.errors import NotCoveredError, ShockwaveError
from shockwave.base.quantity_fields import join
from shockwave.prediction.outcome import Outcome
from shockwave.prediction.outcome_text import feature_text
from shockwave.scenario.scenario import Scenario
from shockwave.scene.plausibility import unusual_warnings
from shockwave.scene.sensors import STRUCTURE, Sensor
from shockwave.simulation.result_parts import Passage
from shockwave.simulation.simulate import simulate_scene
from shockwave.simulation.simulation_result import Simulation
from shockwave.simulation.wave_setup import immeasurable, scale_scene
from shockwave.studies.comparison import Comparison

# Least duration of the histories [characteristic times].
_PASSED = 60.0
# Least duration of the histories, relative to that of the shock.
_BEYOND = 1.15
# Contacts that the leading wave passes in a characteristic time.
_RATE = 0.9
# Most contacts in the space-time diagram.
_CONTACTS = 120
# Most samples of the histories of a chain beyond equal spheres, and their shortest interval [characteristic times].
_SAMPLES = 2000
_SHORTEST = 0.05

_T = TypeVar("_T")


@frozen(kw_only=True)
class PageResults:
    """Prediction and simulation of a scenario.

    Attributes
    ----------
    scenario : Scenario
        The scenario.
    predicted : Outcome or None
        The prediction by section 4; None if it failed or does not cover the scene.
    simulated : Simulation or None
        The simulation, with histories unless the shock is too long; None if it failed.
    comparison : Comparison or None
        The comparison; None if either failed, or for a chain beyond equal spheres.
    passages : tuple of Passage
        Passages of the leading wave at the requested contacts.
    failures : tuple of str
        A sentence on each failure.
    text : str
        Text of the scenario file.
    reason : str
        Features that section 4 does not cover, or an empty string.
    exit_code : int
        Greatest exit status of the failures; 0 without one.
    """

    scenario: Scenario
    predicted: Outcome | None
    simulated: Simulation | None
    comparison: Comparison | None
    passages: tuple[Passage, ...]
    failures: tuple[str, ...]
    text: str
    reason: str = ""
    exit_code: int = 0

    @property
    def is_beyond(self) -> bool:
        """Whether the scene has features beyond a shock on equal granules with free ends."""
        return self.scenario.scene.uniform is None

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the simulation; without one, of the prediction."""
        if self.simulated is not None:
            return self.simulated.warnings
        if self.predicted is not None:
            return self.predicted.warnings
        return unusual_warnings(self.scenario.scene.excitation, self.scenario.chain)


def compute_results(scenario: Scenario) -> PageResults:
    """Predict and simulate ``scenario``; if one fails, the other is still computed."""
    failures: dict[str, int] = {}  # with their exit statuses
    tolerance = scenario.predictor.equal_tolerance
    scenario = evolve(scenario, chain=scenario.scene.line)
    scene = scenario.scene
    predicted, reason = None, ""
    try:
        predicted = evolve(scenario.predictor, model="section-4").predict_scene(scene)
    except NotCoveredError as error:
        reason = f"it does not cover {join([*dict.fromkeys(map(feature_text, error.faults))], 'and')}"
    except ShockwaveError as error:
        failures[f"The prediction failed: {scene.locate_error(error)}."] = error.exit_code
    simulate = _simulate_chain if scene.uniform is None else _simulate
    simulated = _attempt(failures, "The simulation failed", simulate, scenario)
    passages = []
    if simulated is not None and simulated.waves:
        failure = "The waves behind the leading wave could not be measured"
        # computed here, and cached
        if simulated.options.waves == "train" and _attempt(failures, failure, getattr, simulated, "train") is None:
            simulated = evolve(simulated, options=evolve(simulated.options, waves="primary"))
        for contact in scenario.simulate.contacts:
            failure = f"The passage of contact {contact} could not be computed"
            passages.append(_attempt(failures, failure, simulated.passage, contact))
    return PageResults(
        scenario=scenario,
        predicted=predicted,
        simulated=simulated,
        comparison=Comparison(predicted=predicted, simulated=simulated, equal_tolerance=tolerance)
        if predicted and simulated and scene.uniform
        else None,
        passages=tuple(filter(None, passages)),
        failures=tuple(failures),
        text="" if scenario.document is None else scenario.document.text.removeprefix("\ufeff"),
        reason=reason,
        exit_code=max(failures.values(), default=0),
    )


def _attempt(failures: dict[str, int], failure: str, compute: Callable[..., _T], *arguments: Any) -> _T | None:
    try:
        return compute(*arguments)
    except ShockwaveError as error:
        located = arguments[0].scene.locate_error(error) if isinstance(arguments[0], Scenario) else error
        failures[f"{failure}: {located}."] = error.exit_code
        return None


def _simulate(scenario: Scenario) -> Simulation:
    """Simulate as requested, with the histories that are drawn."""
    problem, scales = scale_scene(scenario.scene)
    if immeasurable(problem):
        primary = evolve(scenario.simulate, waves="primary", record=(), interval=None, until=None)
        return simulate_scene(scenario.scene, primary)
    until = max(_BEYOND * problem.duration, _PASSED)
    reached, count = int(_RATE * until), scenario.chain.count
    reached = reached if count is None else min(reached, count - 1)
    options = evolve(
        scenario.simulate,
        contacts=range(0, reached, -(-reached // _CONTACTS)),
        record=("forces", "energies"),
        interval=None,
        until=until * scales.time,
    )
    return simulate_scene(scenario.scene, options)


def _simulate_chain(scenario: Scenario) -> Simulation:
    """Simulate a chain beyond equal spheres, with the forces that are drawn."""
    plain = evolve(scenario.simulate, contacts=(), record=(), interval=None)
    result = simulate_scene(scenario.scene, plain)
    contacts = result.scene.contact_count or len(result.velocities)
    sensors: Any = result.options.sensors
    if result.structure is not None and Sensor(STRUCTURE) not in sensors:
        sensors = (*sensors, Sensor(STRUCTURE))
    options = evolve(
        result.options,
        sensors=sensors,
        contacts=range(0, contacts, -(-contacts // _CONTACTS)),
        record=("forces", "field"),
        interval=max(result.end / _SAMPLES, _SHORTEST * result.characteristic_time),
    )
    return evolve(result, options=options)
