"""Prediction beside simulation: how right the relations are for one shock on one chain."""

from __future__ import annotations

import math
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, cast

from attrs import asdict, frozen

from shockwave.chain.chain import Chain
from shockwave.errors import InvalidValueError, NotCoveredError
from shockwave.fields import text_of
from shockwave.limit import Verdict, plain_verdict, verdict_facts
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.result_text import lead_text, result_answer, result_details, result_limits, wave_tables
from shockwave.measurement.simulate import simulate, simulate_with
from shockwave.options import SimulateOptions
from shockwave.prediction.model_interface import Relation
from shockwave.prediction.outcome import Outcome
from shockwave.prediction.outcome_text import (
    decision_lines,
    estimate_text,
    outcome_details,
    outcome_limits,
    wave_table,
    without_advice,
)
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.shock import Shock
from shockwave.result_base import VERSION, Result
from shockwave.scenario.scenario import Published
from shockwave.tables import Table, column, coordinate
from shockwave.text import error_text, facts, limits, notes, paragraph, si, strong

if TYPE_CHECKING:
    from shockwave.chain.impact import Impact
    from shockwave.measurement.chain_result import ChainResult
    from shockwave.measurement.contact_peaks import ContactPeak


@frozen(kw_only=True, repr=False)
class Comparison(Result):
    """A prediction and a simulation of the same scene.

    Attributes
    ----------
    predicted : Outcome or None
        The prediction; None where the model does not cover the scene.
    simulated : SimulationResult or ChainResult
        The simulation; a ChainResult for a chain beyond equal spheres.
    error : float or None
        Relative error of the predicted peak force, uncertain by ``simulated.error_estimate``; None without prediction,
        and for a ChainResult.
    relation : str or None
        ``less``, ``equal`` or ``greater`` by simulation, with the predictor's tolerance of equality; None where
        ``error`` is.
    published : Published or None
        Figures printed in a source for the same scene.
    reason : str or None
        Reason why there is no prediction.
    """

    predicted: Outcome | None
    simulated: SimulationResult | Any
    error: float | None
    relation: Relation | None
    published: Published | None = None
    reason: str | None = None

    _brief = (
        *("simulated.scenario", "simulated.peak_force", "greatest_force.peak_force"),
        *("predicted.estimate.peak_force", "predicted.model", "predicted.peak_force", "error", "relation"),
    )
    _tables = (("waves", "wave"),)

    def _table(self, name: str) -> Table | None:
        if self.predicted is None or not self.simulated.waves:
            return self.simulated._main_table()
        parts = (self.predicted, self.simulated)
        forces = [*zip_longest(*([wave.peak_force for wave in part.waves] for part in parts), fillvalue=math.nan)]
        table = coordinate("wave", range(len(forces))) | coordinate("source", ["predicted", "simulated"])
        holds = [all(condition.holds for condition in self.predicted.conditions)] * len(forces)
        return table | column("peak_force", forces, "wave", "source") | column("conditions_hold", holds, "wave")

    def to_dict(self) -> dict[str, Any]:
        """The document that ``compare --json`` prints."""
        predicted = self.predicted
        return {
            **VERSION,
            "scenario": self.simulated.scenario,
            "predicted": predicted and predicted.to_dict(),
            "simulated": self.simulated.to_dict(),
            "errors": predicted and {"peak_force": self.error, "transmitted": self.wall_error},
            "relations": predicted and {"predicted": predicted.relation, "simulated": self.relation},
            "published": None if self.published is None else asdict(self.published),
            "reason": self.reason,
            "verdict": plain_verdict(self),
        }

    @property
    def greatest_force(self) -> ContactPeak | None:
        """Greatest simulated contact force where no peak force of a leading wave is simulated; else None."""
        found: ContactPeak | None = self.simulated.greatest_force if self.simulated.peak_force is None else None
        return found

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings that limit one of the answers."""
        limiting = map(without_advice, outcome_limits(self.predicted) if self.predicted else [])
        return tuple(dict.fromkeys([*limiting, *result_limits(self.simulated)]))

    @property
    def wall_error(self) -> float | None:
        """Relative error of the predicted force on the wall; None where it is not predicted."""
        return wall_error(self.predicted, self.simulated)

    @property
    def verdict(self) -> Verdict | None:
        """Verdict of the simulation on the limit; None without a limit."""
        found: Verdict | None = self.simulated.verdict
        return found

    def __str__(self) -> str:
        return comparison_text(self)


def compare(
    shock: Shock | Impact,
    chain: Chain,
    predictor: Predictor | None = None,
    options: SimulateOptions | None = None,
    **asked: Any,
) -> Comparison:
    """Predict and simulate ``shock`` on ``chain``; simulate alone where the model does not cover the scene.

    Parameters
    ----------
    shock, chain : Shock or Impact, Chain
        The scene.
    predictor : Predictor, optional
        Left out, one with its defaults.
    options : SimulateOptions, optional
        How to simulate, such as ``scenario.simulate``; or else
    **asked
        the arguments of `simulate`.
    """
    predictor = predictor or Predictor()
    if not isinstance(predictor, Predictor):
        raise InvalidValueError.of("predictor", f"must be a Predictor (got {text_of(predictor)})")
    predicted, reason = None, None
    try:
        predicted = predictor.predict(cast(Shock, shock), chain)
    except NotCoveredError as error:
        features = ", ".join(fault.path for fault in error.faults)
        reason = f"{predictor.model} covers chains of equal granules with free ends or a fixed wall, without {features}"
    simulated = simulate_with(options, shock, chain) if options is not None else simulate(shock, chain, **asked)
    if predicted is None:
        return Comparison(predicted=None, simulated=simulated, error=None, relation=None, reason=reason)
    return beside(predicted, simulated, predictor.equal_tolerance)


def beside(predicted: Outcome, simulated: SimulationResult | ChainResult, equal_tolerance: float) -> Comparison:
    """The two answers side by side; forces that differ by less than ``equal_tolerance`` are called equal."""
    if simulated.peak_force is None or simulated.amplification is None:
        return Comparison(predicted=predicted, simulated=simulated, error=None, relation=None)
    excess = simulated.amplification - 1
    relation: Relation = "equal" if abs(excess) <= equal_tolerance else "greater" if excess > 0 else "less"
    error = predicted.peak_force / simulated.peak_force - 1
    return Comparison(predicted=predicted, simulated=simulated, error=error, relation=relation)


def wall_error(predicted: Outcome | None, simulated: Any) -> float | None:
    """Relative error of the predicted force on the wall; None where it is not predicted or the wave does not arrive."""
    if predicted is None or predicted.transmitted is None or not simulated.transmitted.peak_force:
        return None
    return float(predicted.transmitted.peak_force / simulated.transmitted.peak_force - 1)


def _figures(published: Published) -> str:
    error, rise_time = published.error, published.virtual_rise_time
    figures = {
        "relation": published.relation,
        "error": None if error is None else f"{error:.1%}",
        "virtual rise time": None if rise_time is None else si(rise_time, "s"),
    }
    return ", ".join(f"{name} {figure}" for name, figure in figures.items() if figure is not None)


def comparison_text(both: Comparison) -> str:
    """The error of the prediction, both answers, what decided the prediction, and the waves of both."""
    predicted, simulated = both.predicted, both.simulated
    if predicted is None:
        return "\n".join([str(simulated), "", *paragraph("  no prediction: ", both.reason or "", 4)])
    answers = [("estimate", without_advice(estimate_text(predicted)))]
    if both.error is None:
        error = [] if both.wall_error is None else [("error", f"wall force {error_text(both.wall_error)}")]
        return "\n".join([str(simulated), "", "  predicted", *facts(answers + error), "", wave_table(predicted)])
    name = f"{predicted.scenario}: " if predicted.scenario else ""
    waves = wave_tables(simulated)  # integrates the train, whose warnings and cost belong to the lines around
    answers += [
        ("error", f"{predicted.model} {error_text(both.error)}"),
        ("relation", f"predicted {predicted.relation}, simulated {both.relation} (relative to the shock)"),
    ]
    if both.published is not None:
        answers.append(("published", f"{_figures(both.published)} ({both.published.source})"))
    lines = [
        strong(f"{name}simulated {lead_text(simulated)}"),
        *facts(verdict_facts(both)),
        *limits(both.warnings),
        *facts(answers),
        *decision_lines(predicted),
        "",
        "  predicted",
        wave_table(predicted),
        "",
        "  simulated",
        *facts(result_answer(simulated)),
        waves,
        "",
        *facts({**dict(outcome_details(predicted)), **dict(result_details(simulated))}.items()),
        *facts(predicted.scene.facts()),
        *notes(predicted.scene.notes),
    ]
    return "\n".join(lines)
