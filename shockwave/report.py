"""Several results side by side, as tables for people."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from shockwave.text import range_text, si, table

if TYPE_CHECKING:
    from shockwave.measurement.result import SimulationResult
    from shockwave.prediction.outcome import Outcome
    from shockwave.profiles.conditions import Condition
    from shockwave.studies.comparison import Comparison

__all__ = ["comparison_table", "outcome_table", "simulation_table"]


def outcome_table(outcomes: Sequence[Outcome]) -> str:
    """Several predictions, a row each."""
    header = ("scenario", "regime", "relation", "peak force", "expected error", "waves", "conditions (3)")
    rows = (
        (
            o.scenario or "-",
            o.regime,
            o.relation,
            si(o.peak_force, "N"),
            range_text(o.expected_error),
            str(len(o.waves)),
            _standing(o.conditions),
        )
        for o in outcomes
    )
    return "\n".join([table(header, rows), *_notes_by_name((o.scenario, o.warnings) for o in outcomes)])


def simulation_table(results: Sequence[SimulationResult]) -> str:
    """Several simulations, a row each."""
    header = ("scenario", "peak force", "rel. error", "amplification", "waves", "ejected", "momentum defect")
    rows = (
        (
            r.scenario or "-",
            si(r.peak_force, "N", 8),
            f"{r.error_estimate:.0e}",
            f"{r.amplification:.8g}",
            _count(r),
            "-" if r.options.waves == "primary" else str(r.ejected_granules),
            f"{r.momentum_defect:.0e}",
        )
        for r in results
    )
    return "\n".join([table(header, rows), *_notes_by_name((r.scenario, r.all_warnings) for r in results)])


def comparison_table(comparisons: Sequence[Comparison]) -> str:
    """Several comparisons, a row each, with figures printed elsewhere beside ours where a scenario has them."""
    header = [
        "scenario",
        "regime",
        "relation",
        "predicted",
        "simulated",
        "rel. error",
        "error",
        "expected error",
        "virtual t0",
        "waves",
        "conditions (3)",
    ]
    rows = [_comparison_row(comparison) for comparison in comparisons]
    published = [comparison.published for comparison in comparisons]
    if any(published):
        header[7:7] = ["printed"]
        header[10:10] = ["printed"]
        for row, printed in zip(rows, published, strict=True):
            row[2] += f" / {printed.relation if printed and printed.relation else '-'}"
            row[7:7] = ["-" if printed is None or printed.error is None else f"{printed.error:.1%}"]
            row[10:10] = [
                "-" if printed is None or printed.virtual_rise_time is None else si(printed.virtual_rise_time, "s")
            ]
    notes = _notes_by_name(
        (c.predicted.scenario, dict.fromkeys((*c.predicted.warnings, *c.simulated.all_warnings))) for c in comparisons
    )
    legend = [
        "",
        "relation: predicted / simulated"
        + (" / printed" if any(published) else "")
        + "; waves: predicted / simulated;",
        "rel. error: of the simulated peak force, estimated;",
        "error: of the predicted peak force against the simulated; expected error: range measured for such shocks",
    ]
    return "\n".join([table(header, rows), *legend, *notes])


def _comparison_row(comparison: Comparison) -> list[str]:
    predicted, simulated = comparison.predicted, comparison.simulated
    ejection = predicted.to_dict()["ejection"]
    return [
        predicted.scenario or "-",
        predicted.regime,
        f"{predicted.relation} / {comparison.relation}",
        si(predicted.peak_force, "N"),
        si(simulated.peak_force, "N", 8),
        f"{simulated.error_estimate:.0e}",
        f"{comparison.error:+.2%}",
        range_text(predicted.expected_error),
        si(ejection["virtual_rise_time"], "s") if ejection else "-",
        f"{len(predicted.waves)} / {_count(simulated)}",
        _standing(predicted.conditions),
    ]


def _count(result: SimulationResult) -> str:
    """How many waves; a plus for more that had not settled."""
    settled = sum(wave.error_estimate is not None for wave in result.waves)
    return f"{settled}{'+' if settled < len(result.waves) else ''}"


def _standing(conditions: Iterable[Condition]) -> str:
    broken = [f"{c.statement} fails by {-c.margin:.3g}" for c in conditions if not c.holds]
    return "; ".join(broken) or "hold"


def _notes_by_name(items: Iterable[tuple[str | None, Iterable[str]]]) -> list[str]:
    notes = [f"{name or '-'}: {warning}" for name, warnings in items for warning in warnings]
    return ["", *notes] if notes else []
