"""Text of a comparison: the prediction of section 4, the simulation, and the errors."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from shockwave.base.text import Detail, brief, detail, error_text, facts, notes, paragraph, percent, si, strong, table
from shockwave.prediction.outcome_text import SHOWN_ERROR, decision_lines, exponents_text, features_text, wave_table
from shockwave.prediction.section4_outcome import EjectionOutcome, Section4Outcome
from shockwave.scenario.published_results import Published
from shockwave.scene.force_limit import verdict_facts
from shockwave.simulation import simulation_text
from shockwave.studies.comparison import Comparison

# Waves of a train whose momenta are listed in the short text.
_FEW = 2
# Digits of simulated numbers beside those of section 4.
_DIGITS = 4


def comparison_text(result: Comparison) -> str:
    """The simulated peak force, and the error of each prediction."""
    paper = None if result.predicted is None else result.predicted.section4
    if paper is None or result.simulated.peak_force is None:
        return _simulation_text(result)
    name = f"{result.scenario}: " if result.scenario else ""
    lines = table(("section 4", "predicted", "simulated", "error"), _errors(result, paper)).split("\n")
    if result.published is not None:
        lines += facts([("published", f"{_figures(result.published)} ({result.published.source})")])
    if detail() >= Detail.EXPLAIN:
        lines += ["", *decision_lines(paper)]
    if detail() is Detail.VERBOSE:
        lines += [
            "",
            "  waves by section 4",
            wave_table(paper),
            "",
            "  simulated",
            simulation_text.wave_tables(result.simulated),
            "",
        ]
        lines += facts([*simulation_text.details(result.simulated), *result.simulated.scene.summary().lines])
        lines += notes(result.notes)
    lead = strong(f"{name}simulated {simulation_text.lead_text(result.simulated)}")
    return brief([lead, *facts(verdict_facts(result))], result.warnings, lines)


def _simulation_text(result: Comparison) -> str:
    """The simulation alone, with the features that section 4 does not cover."""
    simulation: Any = result.simulated
    features = paragraph("  section 4 does not apply: ", features_text(result.faults), 4)
    requested = simulation_text.sensor_lines(simulation)
    return brief(
        simulation_text.head(simulation), result.warnings, [*features, *simulation_text.lines(simulation)], requested
    )


def _errors(result: Comparison, paper: Section4Outcome) -> Iterator[tuple[str, str, str, str]]:
    """Rows: a value of section 4, the simulated value, and the error."""
    errors, agrees = result.errors, result.agrees
    yield (
        *("peak force", si(paper.peak_force, "N", error=SHOWN_ERROR)),
        *(si(result.simulated.peak_force, "N", _DIGITS), error_text(errors.peak_force or 0.0)),
    )
    yield "relation", paper.relation, result.relation or "-", _agreement(agrees["relation"])
    yield "regime", paper.regime, result.regime or "-", _agreement(agrees["regime"])
    unsettled = len(result.simulated.waves) - len(result.waves)
    count = f"{len(result.waves)}{f' + {unsettled} not separated' * (unsettled > 0)}" if result.regime else "-"
    yield "waves", str(len(paper.waves)), count, _agreement(agrees["count"])
    for number, (wave, error) in enumerate([*zip(paper.waves, errors.waves, strict=True)][:_FEW], start=1):
        simulated = "-" if error.momentum is None else si(wave.momentum / (1 + error.momentum), "N s", _DIGITS)
        predicted = si(wave.momentum, "N s", error=SHOWN_ERROR)
        yield f"momentum of wave {number}", predicted, simulated, error_text(error.momentum)
    if isinstance(paper, EjectionOutcome):
        added = "-" if result.added_momentum is None else si(result.added_momentum, "N s", _DIGITS)
        prediction = si(paper.added_momentum, "N s", error=SHOWN_ERROR)
        yield "momentum added by ejection", prediction, added, error_text(errors.added_momentum)
    if paper.exponents is not None and result.exponents is not None and errors.exponents is not None:
        difference = f"{errors.exponents.radius:+.3f} (of R)"
        yield "scaling", exponents_text(paper.exponents), exponents_text(result.exponents), difference


def _agreement(agrees: bool | None) -> str:
    return "-" if agrees is None else "agrees" if agrees else "differs"


def _figures(published: Published) -> str:
    error, rise_time = published.error, published.virtual_rise_time
    figures = {
        "relation": published.relation,
        "error": None if error is None else percent(error),
        "virtual rise time": None if rise_time is None else si(rise_time, "s"),
    }
    return ", ".join(f"{name} {figure}" for name, figure in figures.items() if figure is not None)
