"""What there is to tell about a scenario: both answers, or why there is none."""

from __future__ import annotations

from pathlib import Path

from attrs import evolve, frozen

from shockwave.errors import ShockwaveError
from shockwave.measurement.result import Passage, SimulationResult
from shockwave.measurement.simulate import MEASURABLE, scaled, simulate_with
from shockwave.options import SimulateOptions
from shockwave.prediction.outcome import Outcome
from shockwave.scenario.scenario import Scenario
from shockwave.studies.comparison import Comparison, compare

__all__ = ["Findings", "findings"]

# How long histories are, in natural times of the wave, and beyond the end of the shock; how many contacts of those
# that the first wave passes meanwhile, at nine tenths of a contact a natural time, are drawn.
_PASSED, _BEYOND, _RATE, _CONTACTS = 60.0, 1.15, 0.9, 120
#: Longer histories take too long, and no print shows them.
LONGEST = 400.0
# Of a longer text the beginning is shown.
_MOST_TEXT = 20_000


@frozen(kw_only=True)
class Findings:
    """Both answers to a scenario, as far as there are.

    Attributes
    ----------
    scenario : Scenario
        What was asked.
    predicted : Outcome or None
        None where the prediction failed.
    simulated : SimulationResult or None
        With histories, where they are not too long. None where the simulation failed.
    comparison : Comparison or None
        Of both.
    passages : tuple of Passage
        Of the primary at the contacts that the scenario asks for.
    failures : tuple of str
        What could not be had, and why.
    text : str
        Of the scenario's file.
    """

    scenario: Scenario
    predicted: Outcome | None
    simulated: SimulationResult | None
    comparison: Comparison | None
    passages: tuple[Passage, ...]
    failures: tuple[str, ...]
    text: str

    @property
    def warnings(self) -> tuple[str, ...]:
        """Of both answers, each once."""
        told = () if self.predicted is None else self.predicted.warnings
        found = () if self.simulated is None else self.simulated.all_warnings
        return tuple(dict.fromkeys((*told, *found)))


def findings(scenario: Scenario) -> Findings:
    """Predict and simulate ``scenario``; a failure of the one does not stop the other."""
    failures: list[str] = []
    predicted: Outcome | None = None
    simulated: SimulationResult | None = None
    comparison: Comparison | None = None
    shock, chain = scenario.shock, scenario.chain
    try:
        predicted = scenario.predictor.predict(shock, chain)
    except ShockwaveError as error:
        failures.append(f"The prediction failed: {error}.")
    try:
        options = _with_histories(scenario)
        if predicted is None:
            simulated = simulate_with(options, shock, chain)
        else:
            comparison = evolve(
                compare(shock, chain, scenario.predictor, options),
                published=scenario.published,
            )
            simulated = comparison.simulated
    except ShockwaveError as error:
        failures.append(f"The simulation failed: {error}.")
    if simulated is not None:
        simulated = _with_train(simulated, failures)
        comparison = None if comparison is None else evolve(comparison, simulated=simulated)
    passages = _passages(scenario, simulated, failures)
    return Findings(
        scenario=scenario,
        predicted=predicted,
        simulated=simulated,
        comparison=comparison,
        passages=passages,
        failures=tuple(failures),
        text=_text(scenario.path),
    )


def _with_histories(scenario: Scenario) -> SimulateOptions:
    """What the scenario asks of the simulation, and the histories that are drawn."""
    problem, scales = scaled(scenario.shock, scenario.chain)
    until = max(_BEYOND * problem.duration, _PASSED)
    if until > LONGEST:
        return evolve(scenario.simulate, record=(), interval=None, until=None)
    granules = scenario.chain.granules
    reached = int(_RATE * until) if granules is None else min(int(_RATE * until), granules - 1)
    return evolve(
        scenario.simulate,
        contacts=range(0, reached, -(-reached // _CONTACTS)),
        record=("forces", "field", "energies"),
        interval=None,
        until=until * scales.time,
    )


def _with_train(result: SimulationResult, failures: list[str]) -> SimulationResult:
    """The result with all of its waves; with the primary alone, where the others cannot be had."""
    if result.options.waves == "primary":
        return result
    try:
        # integrated here, and kept
        train = result.train
    except ShockwaveError as error:
        failures.append(f"The waves behind the primary could not be measured: {error}.")
    else:
        if result.was_measured or scaled(result.shock, result.chain)[0].duration <= MEASURABLE:
            return result
        failures += [f"Only the primary was simulated: {warning}." for warning in train.warnings]
    return evolve(result, options=evolve(result.options, waves="primary"))


def _passages(scenario: Scenario, result: SimulationResult | None, failures: list[str]) -> tuple[Passage, ...]:
    found = []
    for contact in scenario.simulate.contacts if result is not None else ():
        try:
            found.append(result.passage(contact))  # type: ignore[union-attr]
        except ShockwaveError as error:
            failures.append(f"The passage of contact {contact} could not be had: {error}.")
    return tuple(found)


def _text(path: Path | None) -> str:
    if path is None:
        return ""
    try:
        text = path.read_text(encoding="utf-8-sig", errors="replace")
    except OSError:
        return ""
    rest = len(text) - _MOST_TEXT
    return text if rest <= 0 else f"{text[:_MOST_TEXT]}\n... ({rest} more characters)\n"
