"""Results as text for people: tables with units, and how far to trust each figure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from shockwave.profiles.conditions import Condition

if TYPE_CHECKING:
    from shockwave.comparison import Comparison
    from shockwave.measurement.result import SimulationResult
    from shockwave.prediction.outcome import Outcome
    from shockwave.scenario.load import Published

__all__ = [
    "comparison_table",
    "comparison_text",
    "outcome_table",
    "outcome_text",
    "simulation_table",
    "simulation_text",
    "si",
    "table",
]

_PREFIXES = {-12: "p", -9: "n", -6: "u", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}


def si(value: float, unit: str, digits: int = 5) -> str:
    """``value`` with an SI prefix: ``si(1.5e-5, "s")`` is ``15 us``."""
    if value == 0 or not math.isfinite(value):
        return f"{value:g} {unit}"
    exponent = 3 * math.floor(math.log10(abs(value) * (1 + 1e-12)) / 3)
    if exponent not in _PREFIXES:
        return f"{value:.{digits}g} {unit}"
    return f"{value / 10**exponent:.{digits}g} {_PREFIXES[exponent]}{unit}"


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Columns under a ruled header, as wide as they need to be."""
    lines = [list(header), *(list(row) for row in rows)]
    widths = [max(len(line[column]) for line in lines) for column in range(len(header))]
    text = ["  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in lines]
    return "\n".join([text[0], "  ".join("-" * width for width in widths), *text[1:]])


def outcome_text(outcome: Outcome) -> str:
    """One prediction in full."""
    lines = [
        f"prediction by {outcome.model}" + (f" of {outcome.scenario}" if outcome.scenario else ""),
        f"  regime            {outcome.regime}",
        f"  relation          primary {_RELATIONS[outcome.relation]} the shock's peak force",
        f"  peak force        {si(outcome.peak_force, 'N')}, {outcome.amplification:.5g} times the shock's",
        f"  expected error    {_expected(outcome.expected_error)}",
        f"  applied momentum  {si(outcome.applied_momentum, 'N s')}",
    ]
    ejection = outcome.to_dict()["ejection"]
    if ejection:
        lines += [
            f"  ejection          virtual rise time {si(ejection['virtual_rise_time'], 's')}, "
            f"added momentum {si(ejection['added_momentum'], 'N s')}"
        ]
    if outcome.exponents:
        powers = outcome.exponents
        lines.append(
            f"  goes with         R^{powers.radius:.3f} rho^{powers.density:.3f} E^{powers.youngs_modulus:.3f}"
        )
    lines += ["", _indent(_waves(outcome.waves)), ""]
    conditions = ([c.statement, f"{c.margin:+.4g} t0", "holds" if c.holds else "FAILS"] for c in outcome.conditions)
    lines += [_indent(table(("condition (3)", "margin", ""), conditions)), ""]
    steps = ((t.statement, si(t.left, "s"), si(t.right, "s"), t.outcome, t.equation) for t in outcome.trace)
    lines += [_indent(table(("decided by", "left", "right", "hence", "equation"), steps))]
    return "\n".join(lines + _notes(outcome.warnings))


def simulation_text(result: SimulationResult) -> str:
    """One simulation in full."""
    waves = (
        (
            si(wave.peak_force, "N", 8),
            f"{wave.error_estimate:.0e}",
            si(wave.momentum, "N s"),
            si(wave.energy, "J"),
            "-" if wave.speed is None else si(wave.speed, "m/s"),
            si(wave.width, "s"),
            str(wave.contact),
            si(wave.arrival_time, "s"),
        )
        for wave in result.waves
    )
    header = ("peak force", "rel. error", "momentum", "energy", "speed", "width", "contact", "arrival")
    lines = [
        f"simulation by {result.integrator}" + (f" of {result.scenario}" if result.scenario else ""),
        f"  peak force        {si(result.peak_force, 'N', 8)} within {result.error_estimate:.0e} relative, "
        f"{result.amplification:.8g} times the shock's",
        f"  applied momentum  {si(result.applied_momentum, 'N s')}, momentum defect {result.momentum_defect:.0e}, "
        f"energy defect {result.energy_defect:.0e}",
        f"  recoil            {si(result.recoil_momentum, 'N s')}, {result.ejected_granules} granules ejected",
        f"  cost              {result.cost.steps} steps, {result.cost.force_evaluations} force evaluations, "
        f"{result.cost.seconds:.2g} s",
        "",
        _indent(table(header, waves)),
        f"  (waves above {result.wave_threshold:g} of the primary; contacts are counted from 0)",
    ]
    return "\n".join(lines + _notes(result.warnings))


def comparison_text(comparison: Comparison) -> str:
    """One comparison in full."""
    lines = [
        outcome_text(comparison.predicted),
        "",
        simulation_text(comparison.simulated),
        "",
        f"error of the predicted peak force: {comparison.error:+.2%}, "
        f"expected {_expected(comparison.predicted.expected_error)}",
        f"relation to the shock's peak force: predicted {comparison.predicted.relation}, "
        f"simulated {comparison.relation}",
    ]
    return "\n".join(lines)


def outcome_table(outcomes: Sequence[Outcome]) -> str:
    """Several predictions, a row each."""
    header = ("scenario", "regime", "relation", "peak force", "expected error", "waves", "conditions (3)")
    rows = (
        (
            o.scenario or "-",
            o.regime,
            o.relation,
            si(o.peak_force, "N"),
            _expected(o.expected_error),
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
            str(len(r.waves)),
            str(r.ejected_granules),
            f"{r.momentum_defect:.0e}",
        )
        for r in results
    )
    return "\n".join([table(header, rows), *_notes_by_name((r.scenario, r.warnings) for r in results)])


def comparison_table(comparisons: Sequence[Comparison], published: Sequence[Published | None]) -> str:
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
    if any(published):
        header[7:7] = ["printed"]
        header[10:10] = ["printed"]
        for row, printed in zip(rows, published, strict=True):
            row[7:7] = ["-" if printed is None or printed.error is None else f"{printed.error:.1%}"]
            row[10:10] = [
                "-" if printed is None or printed.virtual_rise_time is None else si(printed.virtual_rise_time, "s")
            ]
    notes = _notes_by_name(
        (c.predicted.scenario, dict.fromkeys((*c.predicted.warnings, *c.simulated.warnings))) for c in comparisons
    )
    legend = [
        "",
        "relation, waves: predicted / simulated; rel. error: of the simulated peak force, estimated;",
        "error: of the predicted peak force against the simulated; expected error: range measured for such shocks",
    ]
    return "\n".join([table(header, rows), *legend, *notes])


_RELATIONS = {"less": "less than", "equal": "about equal to", "greater": "greater than"}


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
        _expected(predicted.expected_error),
        si(ejection["virtual_rise_time"], "s") if ejection else "-",
        f"{len(predicted.waves)} / {len(simulated.waves)}",
        _standing(predicted.conditions),
    ]


def _waves(waves: Iterable[object]) -> str:
    units = {"peak_force": "N", "momentum": "N s", "energy": "J", "speed": "m/s", "width": "s"}
    header = ("wave", *(name.replace("_", " ") for name in units))
    rows = (
        (str(number), *(si(getattr(wave, name), unit) for name, unit in units.items()))
        for number, wave in enumerate(waves, start=1)
    )
    return table(header, rows)


def _expected(bounds: tuple[float, float] | None) -> str:
    return "not known" if bounds is None else f"{bounds[0]:+.0%} to {bounds[1]:+.0%}"


def _standing(conditions: Iterable[Condition]) -> str:
    broken = [f"{c.statement} fails by {-c.margin:.3g}" for c in conditions if not c.holds]
    return "; ".join(broken) or "hold"


def _indent(text: str) -> str:
    return "\n".join(f"  {line}" for line in text.splitlines())


def _notes(warnings: Iterable[str]) -> list[str]:
    return ["", *(f"  note: {warning}" for warning in warnings)] if warnings else []


def _notes_by_name(items: Iterable[tuple[str | None, Iterable[str]]]) -> list[str]:
    notes = [f"{name or '-'}: {warning}" for name, warnings in items for warning in warnings]
    return ["", *notes] if notes else []
