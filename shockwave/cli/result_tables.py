"""Several results side by side: a row each, then their warnings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from shockwave.text import range_text, si, table

if TYPE_CHECKING:
    from shockwave.measurement.result import SimulationResult
    from shockwave.prediction.outcome import Outcome
    from shockwave.profiles.conditions import Condition
    from shockwave.studies.comparison import Comparison


_Columns = list[tuple[str, Callable[[Any], str]]]

_OUTCOME: _Columns = [
    ("scenario", lambda outcome: outcome.scenario or "-"),
    ("regime", lambda outcome: outcome.regime),
    ("relation", lambda outcome: outcome.relation),
    ("peak force", lambda outcome: si(outcome.peak_force, "N")),
    ("expected error", lambda outcome: range_text(outcome.expected_error)),
    ("waves", lambda outcome: str(len(outcome.waves))),
    ("conditions (3)", lambda outcome: _conditions(outcome.conditions)),
]
_SIMULATION: _Columns = [
    ("scenario", lambda result: result.scenario or "-"),
    ("peak force", lambda result: si(result.peak_force, "N", 8)),
    ("rel. error", lambda result: f"{result.error_estimate:.0e}"),
    ("amplification", lambda result: f"{result.amplification:.8g}"),
    ("waves", lambda result: _wave_count(result)),
    ("ejected", lambda result: "-" if result.options.waves == "primary" else str(result.ejected_granules)),
    ("momentum defect", lambda result: f"{result.momentum_defect:.0e}"),
]
_COMPARISON: _Columns = [
    ("scenario", lambda both: both.predicted.scenario or "-"),
    ("regime", lambda both: both.predicted.regime),
    ("relation", lambda both: f"{both.predicted.relation} / {both.relation}"),
    ("predicted", lambda both: si(both.predicted.peak_force, "N")),
    ("simulated", lambda both: si(both.simulated.peak_force, "N", 8)),
    ("rel. error", lambda both: f"{both.simulated.error_estimate:.0e}"),
    ("error", lambda both: f"{both.error:+.2%}"),
    ("expected error", lambda both: range_text(both.predicted.expected_error)),
    ("virtual t0", lambda both: _time(both.predicted, "virtual_rise_time")),
    ("waves", lambda both: f"{len(both.predicted.waves)} / {_wave_count(both.simulated)}"),
    ("conditions (3)", lambda both: _conditions(both.predicted.conditions)),
]
# Figures that a scenario quotes from a source, beside ours.
_WITH_PRINTED: _Columns = [
    *_COMPARISON[:2],
    ("relation", lambda both: f"{both.predicted.relation} / {both.relation} / {_printed_relation(both)}"),
    *_COMPARISON[3:7],
    ("printed", lambda both: _printed_error(both)),
    *_COMPARISON[7:9],
    ("printed", lambda both: _time(both.published, "virtual_rise_time")),
    *_COMPARISON[9:],
]
_LEGEND = """
relation: predicted / simulated{printed}; waves: predicted / simulated;
rel. error: of the simulated peak force, estimated;
error: of the predicted peak force against the simulated; expected error: range measured for such shocks"""


def outcome_table(outcomes: Sequence[Outcome]) -> str:
    """Several predictions."""
    return "\n".join([_rows(_OUTCOME, outcomes), *_notes((o.scenario, o.warnings) for o in outcomes)])


def simulation_table(results: Sequence[SimulationResult]) -> str:
    """Several simulations."""
    return "\n".join([_rows(_SIMULATION, results), *_notes((r.scenario, r.all_warnings) for r in results)])


def comparison_table(comparisons: Sequence[Comparison]) -> str:
    """Several comparisons, with printed figures where a scenario has them."""
    printed = any(both.published for both in comparisons)
    rows = _rows(_WITH_PRINTED if printed else _COMPARISON, comparisons)
    warnings = [
        (both.predicted.scenario, dict.fromkeys((*both.predicted.warnings, *both.simulated.all_warnings)))
        for both in comparisons
    ]
    return "\n".join([rows, _LEGEND.format(printed=" / printed" if printed else ""), *_notes(warnings)])


def _rows(columns: _Columns, results: Sequence[Any]) -> str:
    return table([name for name, _ in columns], ([cell(result) for _, cell in columns] for result in results))


def _notes(warnings: Iterable[tuple[str | None, Iterable[str]]]) -> list[str]:
    notes = [f"{name or '-'}: {warning}" for name, own in warnings for warning in own]
    return ["", *notes] if notes else []


def _wave_count(result: SimulationResult) -> str:
    """The number of settled waves; a plus stands for more that had not settled."""
    settled = sum(wave.error_estimate is not None for wave in result.waves)
    return f"{settled}{'+' if settled < len(result.waves) else ''}"


def _conditions(conditions: Iterable[Condition]) -> str:
    broken = [f"{c.statement} fails by {-c.margin:.3g}" for c in conditions if not c.holds]
    return "; ".join(broken) or "hold"


def _printed_relation(both: Comparison) -> str:
    return (both.published and both.published.relation) or "-"


def _printed_error(both: Comparison) -> str:
    error = both.published and both.published.error
    return "-" if error is None else f"{error:.1%}"


def _time(owner: object, name: str) -> str:
    time = getattr(owner, name, None)
    return "-" if time is None else si(time, "s")
