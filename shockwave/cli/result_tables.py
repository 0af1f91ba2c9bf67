"""Several results side by side: a row each, then their warnings."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from shockwave.text import range_text, si, table

if TYPE_CHECKING:
    from shockwave.measurement.result import SimulationResult
    from shockwave.prediction.outcome import Outcome
    from shockwave.studies.comparison import Comparison


# Names of columns and their cells.
_Row = list[tuple[str, str]]

_LEGEND = """

relation: predicted / simulated{printed}; waves: predicted / simulated;
rel. error: of the simulated peak force, estimated;
error: of the predicted peak force against the simulated; expected error: range measured for such shocks"""


def outcome_table(outcomes: Sequence[Outcome]) -> str:
    """Several predictions."""
    rows = [_outcome(outcome) for outcome in outcomes]
    return _table(rows) + _notes((outcome.scenario, outcome.warnings) for outcome in outcomes)


def simulation_table(results: Sequence[SimulationResult]) -> str:
    """Several simulations."""
    rows = [_simulation(result) for result in results]
    return _table(rows) + _notes((result.scenario, result.all_warnings) for result in results)


def comparison_table(comparisons: Sequence[Comparison]) -> str:
    """Several comparisons, with printed figures where a scenario has them."""
    printed = any(both.published for both in comparisons)
    rows = [_comparison(both, printed) for both in comparisons]
    warnings = []
    for both in comparisons:
        own = (*both.predicted.warnings, *both.simulated.all_warnings)
        warnings.append((both.predicted.scenario, dict.fromkeys(own)))
    return _table(rows) + _LEGEND.format(printed=" / printed" if printed else "") + _notes(warnings)


def _table(rows: Sequence[_Row]) -> str:
    names = [name for name, _ in rows[0]]
    return table(names, [[cell for _, cell in row] for row in rows])


def _notes(warnings: Iterable[tuple[str | None, Iterable[str]]]) -> str:
    lines = [f"\n{name or '-'}: {warning}" for name, own in warnings for warning in own]
    return "\n" + "".join(lines) if lines else ""


def _outcome(outcome: Outcome) -> _Row:
    return [
        ("scenario", outcome.scenario or "-"),
        ("regime", outcome.regime),
        ("relation", outcome.relation),
        ("peak force", si(outcome.peak_force, "N")),
        ("expected error", range_text(outcome.expected_error)),
        ("waves", str(len(outcome.waves))),
        ("conditions (3)", _conditions(outcome)),
    ]


def _simulation(result: SimulationResult) -> _Row:
    primary_alone = result.options.waves == "primary"
    return [
        ("scenario", result.scenario or "-"),
        ("peak force", si(result.peak_force, "N", 8)),
        ("rel. error", f"{result.error_estimate:.0e}"),
        ("amplification", f"{result.amplification:.8g}"),
        ("waves", _wave_count(result)),
        ("ejected", "-" if primary_alone else str(result.ejected_granules)),
        ("momentum defect", f"{result.momentum_defect:.0e}"),
    ]


def _comparison(both: Comparison, with_printed: bool) -> _Row:
    predicted = both.predicted
    simulated = both.simulated
    published = both.published
    relations: list[str] = [predicted.relation, both.relation]
    printed_error = []
    printed_time = []
    if with_printed:
        relations.append((published and published.relation) or "-")
        error = published and published.error
        printed_error.append(("printed", "-" if error is None else f"{error:.1%}"))
        printed_time.append(("printed", _virtual_rise_time(published)))
    return [
        ("scenario", predicted.scenario or "-"),
        ("regime", predicted.regime),
        ("relation", " / ".join(relations)),
        ("predicted", si(predicted.peak_force, "N")),
        ("simulated", si(simulated.peak_force, "N", 8)),
        ("rel. error", f"{simulated.error_estimate:.0e}"),
        ("error", f"{both.error:+.2%}"),
        *printed_error,
        ("expected error", range_text(predicted.expected_error)),
        ("virtual t0", _virtual_rise_time(predicted)),
        *printed_time,
        ("waves", f"{len(predicted.waves)} / {_wave_count(simulated)}"),
        ("conditions (3)", _conditions(predicted)),
    ]


def _wave_count(result: SimulationResult) -> str:
    """The number of settled waves; a plus stands for more that had not settled."""
    settled = sum(wave.error_estimate is not None for wave in result.waves)
    return f"{settled}{'+' if settled < len(result.waves) else ''}"


def _conditions(outcome: Outcome) -> str:
    broken = [f"{c.statement} fails by {-c.margin:.3g}" for c in outcome.conditions if not c.holds]
    return "; ".join(broken) or "hold"


def _virtual_rise_time(owner: object) -> str:
    time = getattr(owner, "virtual_rise_time", None)
    return "-" if time is None else si(time, "s")
