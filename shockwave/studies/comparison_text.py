"""Text of a comparison: the prediction of section 4, the simulation, and the errors."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from shockwave.base.text import Detail, brief, detail, error_text, facts, notes, paragraph, si, strong, table
from shockwave.prediction.outcome_text import SHOWN_ERROR, decision_lines, exponents_text, features_text, wave_table
from shockwave.prediction.section4_outcome import EjectionOutcome, Section4Outcome
from shockwave.scenario.published import Published
from shockwave.scene.force_limit import verdict_facts
from shockwave.simulation import simulation_text
from shockwave.studies.comparison import Comparison

# Waves of a train whose momenta are listed in the short text.
_FEW = 2
# Digits of simulated numbers beside those of section 4.
_DIGITS = 4


def comparison_text(both: Comparison) -> str:
    """The simulated peak force, and the error of each prediction."""
    paper = None if both.predicted is None else both.predicted.section4
    if paper is None or both.simulated.peak_force is None:
        return _simulated(both)
    name = f"{both.scenario}: " if both.scenario else ""
    lines = table(("section 4", "predicted", "simulated", "error"), _errors(both, paper)).split("\n")
    if both.published is not None:
        lines += facts([("published", f"{_figures(both.published)} ({both.published.source})")])
    if detail() >= Detail.EXPLAIN:
        lines += ["", *decision_lines(paper)]
    if detail() is Detail.VERBOSE:
        lines += [
            "",
            "  waves by section 4",
            wave_table(paper),
            "",
            "  simulated",
            simulation_text.wave_tables(both.simulated),
            "",
        ]
        lines += [*facts([*simulation_text.details(both.simulated), *both.simulated.scene.summary().facts()])]
        lines += notes(both.notes)
    answer = [strong(f"{name}simulated {simulation_text.lead_text(both.simulated)}"), *facts(verdict_facts(both))]
    return brief(answer, both.warnings, lines)


def _simulated(both: Comparison) -> str:
    """The simulation alone, with the features that section 4 does not cover."""
    result: Any = both.simulated
    features = paragraph("  section 4 does not apply: ", features_text(both.faults), 4)
    return brief(simulation_text.head(result), both.warnings, [*features, *simulation_text.lines(result)])


def _errors(both: Comparison, paper: Section4Outcome) -> Iterator[tuple[str, str, str, str]]:
    """Rows: a value of section 4, the simulated value, and the error."""
    errors, agrees = both.errors, both.agrees
    yield (
        *("peak force", si(paper.peak_force, "N", error=SHOWN_ERROR)),
        *(si(both.simulated.peak_force, "N", _DIGITS), error_text(errors.peak_force or 0.0)),
    )
    yield "relation", paper.relation, both.relation or "-", _agreement(agrees["relation"])
    yield "regime", paper.regime, both.regime or "-", _agreement(agrees["regime"])
    count = str(len(both.waves)) if both.regime else "-"
    yield "waves", str(len(paper.waves)), count, _agreement(agrees["count"])
    for number, (wave, error) in enumerate([*zip(paper.waves, errors.waves, strict=True)][:_FEW], start=1):
        simulated = "-" if error.momentum is None else si(wave.momentum / (1 + error.momentum), "N s", _DIGITS)
        predicted = si(wave.momentum, "N s", error=SHOWN_ERROR)
        yield f"momentum of wave {number}", predicted, simulated, _percent(error.momentum)
    if isinstance(paper, EjectionOutcome):
        added = "-" if both.added_momentum is None else si(both.added_momentum, "N s", _DIGITS)
        promised = si(paper.added_momentum, "N s", error=SHOWN_ERROR)
        yield "momentum added by ejection", promised, added, _percent(errors.added_momentum)
    if paper.exponents is not None and both.exponents is not None and errors.exponents is not None:
        difference = f"{errors.exponents.radius:+.3f} (of R)"
        yield "scaling", exponents_text(paper.exponents), exponents_text(both.exponents), difference


def _percent(error: float | None) -> str:
    return "-" if error is None else error_text(error)


def _agreement(agrees: bool | None) -> str:
    return "-" if agrees is None else "agrees" if agrees else "differs"


def _figures(published: Published) -> str:
    error, rise_time = published.error, published.virtual_rise_time
    figures = {
        "relation": published.relation,
        "error": None if error is None else f"{error:.1%}",
        "virtual rise time": None if rise_time is None else si(rise_time, "s"),
    }
    return ", ".join(f"{name} {figure}" for name, figure in figures.items() if figure is not None)
