"""Text of a prediction: the answer in a few lines, the decision of section 4, or everything."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from shockwave.base.errors import Fault
from shockwave.base.quantities import unit_of
from shockwave.base.text import (
    Detail,
    alarm,
    brief,
    detail,
    error_text,
    facts,
    notes,
    paragraph,
    si,
    significant_digits,
    strong,
    table,
)
from shockwave.prediction.outcome import Outcome
from shockwave.prediction.scaled_shock import Inequality
from shockwave.prediction.section4_outcome import EjectionOutcome, Section4Outcome
from shockwave.profiles.area_conditions import Condition
from shockwave.scene.force_limit import verdict_facts
from shockwave.scene.yielding import law_facts

# Printed quantities of a wave.
_WAVE = ("peak_force", "momentum", "energy", "speed", "width")
# Most waves in the printed table.
_MOST_ROWS = 20
# Relative error that the digits of the relations show: three digits.
SHOWN_ERROR = 0.03
_REGIMES = {
    "ejection": "one wave, and the first granule rebounds",
    "single": "one wave that carries the entire impulse",
    "train": "a train of waves",
}
_RELATIONS = {"less": "less than", "equal": "about equal to", "greater": "greater than"}
# Symbols of the decision.
_SYMBOLS = "F0 peak force, t0 rise time, n t0 duration of the shock; a1, a2 areas of rise and decay, per F0 t0"


def outcome_text(outcome: Outcome) -> str:
    """The first numbers with their accuracy, the warnings, and section 4."""
    name = f"{outcome.scenario}: " if outcome.scenario else ""
    lines = [*facts([*_forces(outcome), *_section4(outcome)])]
    if detail() >= Detail.EXPLAIN and outcome.section4 is not None:
        lines += ["", *decision_lines(outcome.section4)]
    if detail() is Detail.VERBOSE:
        lines += [*_details(outcome), *notes(outcome.scene.notes)]
    certainty = facts([*verdict_facts(outcome), *law_facts(outcome.chain)])
    return brief([strong(name + lead_text(outcome)), *certainty], outcome.warnings, lines)


def lead_text(outcome: Outcome) -> str:
    """The force on a wall, of the leading wave, or the greatest one, with its accuracy."""
    wall = outcome.transmitted
    if wall is not None:
        end = outcome.chain.end_word
        return f"force on the {end} {_peak(wall)}" if wall.peak_force else f"the wave does not reach the {end}"
    if outcome.simulation is None:
        return f"leading wave {si(outcome.peak_force, 'N', error=SHOWN_ERROR)} by section 4, error not known"
    top = outcome.greatest_force if outcome.peak_force is None or outcome.chain.count is not None else None
    if top is not None:
        return f"greatest force {_peak(top)}, at contact {top.contact}"
    if outcome.peak_force is not None:
        return f"simulated leading wave {force_text(outcome.peak_force, outcome.low, outcome.high)}"
    return f"no answer: {outcome.reason}"


def force_text(force: float, low: float | None, high: float | None) -> str:
    """A force with its relative error estimate."""
    if low is None or high is None:
        return f"{si(force, 'N', 2)}, error not known"
    error = (high - low) / 2 / force
    return f"{si(force, 'N', error=error)}, estimated relative error {error:.0e}"


def _peak(peak: Any) -> str:
    """A greatest force with its time."""
    return f"{force_text(peak.peak_force, peak.low, peak.high)}, at {si(peak.time, 's', 4)}"


def _forces(outcome: Outcome) -> Iterator[tuple[str, str]]:
    """Labels and texts of the forces beside the first one."""
    first, ratio = outcome.transmitted or outcome, outcome.amplification
    top = None if outcome.transmitted is None and outcome.chain.count is not None else outcome.greatest_force
    if top is not None and first.peak_force is not None and top.peak_force > first.peak_force:
        yield "greatest force", f"{_peak(top)}, at contact {top.contact}"
    if outcome.peak_force is not None and outcome.simulation is not None and outcome.chain.count is not None:
        yield "leading wave", force_text(outcome.peak_force, outcome.low, outcome.high)
    if outcome.structure is not None:
        yield from outcome.structure.facts()
    if ratio is not None and outcome.relation is not None:
        error = SHOWN_ERROR if outcome.low is None or not outcome.peak_force else 1 - outcome.low / outcome.peak_force
        digits = min(significant_digits(ratio, error), 5)
        yield "relation", f"{_RELATIONS[outcome.relation]} the shock's peak force (ratio {ratio:.{digits}g})"


def _section4(outcome: Outcome) -> Iterator[tuple[str, str]]:
    """Labels and texts of the prediction of section 4, with its error."""
    paper = outcome.section4
    if paper is None:
        yield "section 4", f"does not apply, because of {features_text(outcome.section4_faults)}"
        return
    holds = "conditions (3) hold" if paper.holds else alarm("conditions (3) fail")
    if outcome.simulation is not None:
        error = "error not known" if paper.error is None else f"error {error_text(paper.error)}"
        yield "section 4", f"peak force {si(paper.peak_force, 'N', error=SHOWN_ERROR)}, {error}; {holds}"
    rebound = f"; {ejection_text(paper)}" if isinstance(paper, EjectionOutcome) else ""
    yield "section 4 regime", regime_text(paper) + rebound + ("" if outcome.simulation is not None else f"; {holds}")


def features_text(faults: Iterable[Fault]) -> str:
    """Features of a scene that section 4 does not cover."""
    return ", ".join(f"{fault.path} ({feature_text(fault)})" for fault in faults)


def feature_text(fault: Fault) -> str:
    """A feature that section 4 does not cover, in words."""
    return fault.problem.rpartition("(got ")[2].rstrip(")")


def regime_text(paper: Section4Outcome) -> str:
    """The regime by section 4, in words."""
    count = len(paper.waves)
    waves = f"{count} waves" if paper.regime == "train" and count > 1 else _REGIMES[paper.regime]
    return f"{paper.regime}: {waves}"


def ejection_text(paper: EjectionOutcome) -> str:
    """Virtual rise time and added momentum."""
    rise, added = si(paper.virtual_rise_time, "s", 3), si(paper.added_momentum, "N s", 3)
    return f"virtual rise time {rise}, added momentum {added}"


# ---------------------------------------------------------------- the decision


def decision_lines(paper: Section4Outcome) -> list[str]:
    """The conditions on the shape and the inequalities that decided, with every symbol."""
    a1, a2 = paper.areas.rise.value, paper.areas.decay.value
    symbols = (
        f"{_SYMBOLS}: a1 = {a1:.4g}, a2 = {a2:.4g}; A F0^(5/6) momentum of a solitary wave of peak force F0:"
        f" A F0^(-1/6) = {si(paper.wave_time, 's', 4)}; alphaF0 A F0^(-1/6) its passage time, alphaF0 = 2 less the"
        " deviations of a1 and a2 from a triangle"
    )
    conditions = [_condition_row(condition) for condition in paper.conditions]
    return [
        table(("condition (3)", "margin", ""), conditions),
        "",
        table(("section 4 decided by", "left", "right", "conclusion", "equation"), map(_step_row, paper.trace)),
        "",
        *paragraph("  ", symbols, 2),
    ]


def _condition_row(condition: Condition) -> tuple[str, ...]:
    verdict = "holds" if condition.holds else alarm("FAILS")
    return condition.statement, f"{condition.margin:+.4g} t0", verdict


def _step_row(step: Inequality) -> tuple[str, ...]:
    equation = step.equation if step.equation.startswith("(") else f"sec. {step.equation}"
    return step.statement, si(step.left, "s"), si(step.right, "s"), step.outcome, equation


# ---------------------------------------------------------------- everything


def wave_table(paper: Section4Outcome) -> str:
    """A row for each of the first predicted waves."""
    waves = []
    for number, wave in enumerate(paper.waves[:_MOST_ROWS], start=1):
        figures = [si(getattr(wave, name), unit_of(name), error=SHOWN_ERROR) for name in _WAVE]
        waves.append([str(number), *figures])
    rows = table(("wave", *(name.replace("_", " ") for name in _WAVE)), waves)
    more = len(paper.waves) - len(waves)
    return f"{rows}\n  ({more} more waves; --json lists all)" if more else rows


def _details(outcome: Outcome) -> list[str]:
    """Waves and scaling of section 4, momentum, first yield and the scene."""
    pairs = [("applied momentum", si(outcome.applied_momentum, "N s"))]
    paper, lines = outcome.section4, []
    if paper is not None:
        lines = ["", "  waves by section 4", wave_table(paper), ""]
        if powers := paper.exponents:
            pairs.append(("scales as", exponents_text(powers)))
    if outcome.yielding is not None:
        pairs += outcome.yielding.facts()
    return [*lines, *facts([*pairs, *outcome.scene.summary().lines])]


def exponents_text(powers: Any) -> str:
    """Powers of radius, density and stiffness."""
    return f"R^{powers.radius:.3f} rho^{powers.density:.3f} E^{powers.youngs_modulus:.3f}"
