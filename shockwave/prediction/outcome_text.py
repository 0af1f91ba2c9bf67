"""Text of a prediction's result."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from shockwave.limit import verdict_facts
from shockwave.prediction.model_interface import Inequality
from shockwave.prediction.outcome import EjectionOutcome, Estimate, Outcome, WallForce
from shockwave.profiles.conditions import Condition
from shockwave.text import alarm, facts, limits, notes, range_text, si, significant_digits, strong, table

if TYPE_CHECKING:  # only for impacts
    from shockwave.prediction.striker import StrikerOutcome

# Printed quantities of a wave, with their units.
_WAVE = {"peak_force": "N", "momentum": "N s", "energy": "J", "speed": "m/s", "width": "s"}
# Most waves in the printed table.
_MOST_ROWS = 20
_REGIMES = {
    "ejection": "one wave, and the first granule rebounds",
    "single": "one wave that carries the entire impulse",
    "train": "{count} waves",
}
# A train of which only the leading wave is listed.
_LONE = "1 wave; later waves are below wave_threshold or are not predicted"
# Advice that a simulation makes void.
_ADVICE = re.compile(r"; simulate$| \(simulate it instead\)| (?:Simulate to|A simulation gives)[^.]*\.")
# Least relative error of an answer that is wrong.
_WRONG = 1.0
_RELATIONS = {"less": "less than", "equal": "about equal to", "greater": "greater than"}


def outcome_text(outcome: Outcome) -> str:
    """The peak force with its expected error, the inequalities that decided, then the waves and the scene."""
    return _text(outcome, decision_lines(outcome))


def striker_text(outcome: StrikerOutcome) -> str:
    """The peak force with its expected error, the striker, then the waves and the scene."""
    count = outcome.wave_count
    striker = [
        ("waves", f"{count if count <= len(outcome.waves) else f'about {count}'} of 0.4 % of the leading wave or more"),
        ("striker", f"{outcome.mass_ratio:.4g} times the mass of a granule; velocity afterwards {_after(outcome)}"),
    ]
    return _text(outcome, facts(striker))


def _text(outcome: Outcome, reasons: Iterable[str]) -> str:
    """The lines of a prediction, with ``reasons`` between its warnings and its waves."""
    name = f"{outcome.scenario}: " if outcome.scenario else ""
    lines = [
        strong(name + estimate_text(outcome)),
        *facts(verdict_facts(outcome)),
        *limits(outcome_limits(outcome)),
        *reasons,
        "",
        wave_table(outcome),
        "",
        *facts([*outcome_details(outcome), *outcome.scene.facts()]),
        *notes(outcome.scene.notes),
    ]
    return "\n".join(lines)


def _after(outcome: StrikerOutcome) -> str:
    return si(outcome.velocity, "m/s", 4) if outcome.velocity else "about 0"


def estimate_text(outcome: Outcome) -> str:
    """The estimated force on the wall, if there is one, and of the leading wave with ranges, or that there is none."""
    found, wall = outcome.estimate, outcome.transmitted
    if found is None:
        unknown = "leading wave" if outcome.wall is None else "force on the wall"
        return f"{unknown} not known a priori: {outcome.no_estimate}"
    peak, ends = estimate_figures(found)
    wave = f"leading wave {peak}, range {ends} (method: {found.method})"
    return wave if wall is None else "force on the wall {}, range {}; {}".format(*estimate_figures(wall), wave)


def estimate_figures(found: Estimate | WallForce) -> tuple[str, str]:
    """The estimate and its range, with the digits that the range supports."""
    spread = max(found.high / found.peak_force - 1, 1 - found.low / found.peak_force)
    peak, low, high = (si(value, "N", error=spread) for value in (found.peak_force, found.low, found.high))
    number, unit = low.split()
    return peak, f"{number if high.endswith(f' {unit}') else low} to {high}"


def outcome_limits(outcome: Outcome) -> list[str]:
    """Warnings that limit the answer; notes on a record do not, and the first line states why there is no estimate."""
    stated = outcome.no_estimate or "\n"
    return [warning for warning in outcome.warnings if warning not in outcome.scene.notes and stated not in warning]


def without_advice(sentence: str) -> str:
    """Remove the advice to simulate from a sentence that is shown beside a simulation."""
    return _ADVICE.sub("", sentence)


def decision_lines(outcome: Outcome) -> list[str]:
    """The decision, the conditions on the shape, and the inequalities that decided."""
    conditions = [_condition_row(condition) for condition in outcome.conditions]
    steps = [_step_row(step) for step in outcome.trace]
    return [
        *facts(_decision(outcome)),
        "",
        table(("condition (3)", "margin", ""), conditions),
        "",
        table(("decided by", "left", "right", "conclusion", "equation"), steps),
    ]


def wave_table(outcome: Outcome) -> str:
    """A row for each of the first predicted waves."""
    waves = []
    for number, wave in enumerate(outcome.waves[:_MOST_ROWS], start=1):
        figures = [si(getattr(wave, name), unit, error=outcome.shown_error) for name, unit in _WAVE.items()]
        waves.append([str(number), *figures])
    rows = table(("wave", *(name.replace("_", " ") for name in _WAVE)), waves)
    more = len(outcome.waves) - len(waves)
    return f"{rows}\n  ({more} more waves; --json lists all)" if more else rows


def _decision(outcome: Outcome) -> Iterator[tuple[str, str]]:
    error = outcome.shown_error
    count = len(outcome.waves)
    if outcome.reason:
        yield "method", f"{outcome.method}: {outcome.reason}"
    elif outcome.estimate is None or outcome.estimate.method != outcome.method:
        peak = f"peak force {si(outcome.peak_force, 'N', error=error)}"
        holds = all(condition.holds for condition in outcome.conditions)
        fails, known = "does not hold here, nor do its regime, relation and waves:", outcome.expected_error
        if not holds:
            answer = alarm(f"{fails} {peak}, error not known")
        elif known and known[0] > _WRONG:
            answer = alarm(f"{fails} {peak}, {1 + known[0]:.2g} times the estimate")
        else:
            answer = f"{peak}, expected error {range_text(known)}"
        yield outcome.model, answer
    ratio = f"{outcome.amplification:.{significant_digits(outcome.amplification, error)}g}"
    waves = _LONE if outcome.regime == "train" and count == 1 else _REGIMES[outcome.regime].format(count=count)
    yield "regime", f"{outcome.regime}: {waves}"
    yield "relation", f"leading wave {_RELATIONS[outcome.relation]} the shock's peak force (ratio {ratio})"
    if isinstance(outcome, EjectionOutcome):
        rise = si(outcome.virtual_rise_time, "s", error=error)
        added = si(outcome.added_momentum, "N s", error=error)
        yield "ejection", f"virtual rise time {rise}, added momentum {added}"


def _condition_row(condition: Condition) -> tuple[str, ...]:
    verdict = "holds" if condition.holds else alarm("FAILS")
    return condition.statement, f"{condition.margin:+.4g} t0", verdict


def _step_row(step: Inequality) -> tuple[str, ...]:
    equation = step.equation if step.equation.startswith("(") else f"sec. {step.equation}"
    return step.statement, si(step.left, "s"), si(step.right, "s"), step.outcome, equation


def outcome_details(outcome: Outcome) -> Iterator[tuple[str, str]]:
    """Labels and texts of what else was predicted."""
    if powers := outcome.exponents:
        yield "scales as", f"R^{powers.radius:.3f} rho^{powers.density:.3f} E^{powers.youngs_modulus:.3f}"
    yield "applied momentum", si(outcome.applied_momentum, "N s")
    if outcome.yielding is not None:
        yield from outcome.yielding.facts()
    yield "model", outcome.model
