"""What is told in sentences: the outcome in one, and the decision step by step."""

from __future__ import annotations

import math

from shockwave.markup import Html, formula, joined, listed, percent, quantity, small, tag
from shockwave.measurement.result import MeasuredWave, SimulationResult
from shockwave.page.findings import Findings
from shockwave.prediction.model_interface import Inequality
from shockwave.prediction.outcome import EjectionOutcome, Outcome

__all__ = ["count", "decision", "digits_of", "expected", "known", "lead", "settled"]

_REGIMES = {
    "ejection": "one wave, and granules thrown back (ejection)",
    "single": "one wave that takes the whole impulse (single)",
    "train": "a train of waves (train)",
}
_RELATIONS = {"less": "weaker than", "equal": "about as strong as", "greater": "stronger than"}
# What follows from an inequality, by its outcome.
_HENCE = {
    "train": "the shock outlasts its first wave, so that waves follow one another in a train",
    "one wave": "the shock ends before its first wave has passed, so that all of it goes into one wave",
    "less": "the primary is weaker than the shock",
    "equal": "the primary is about as strong as the shock",
    "greater": "the primary is stronger than the shock",
    "ejection": "the impulse is less than that of a wave as strong as the shock, so that granules are thrown back",
    "single": "the impulse is enough for a wave as strong as the shock, and no granule is thrown back",
}
# Where the peak force of the primary comes from.
_SOURCES = {"ejection": "(5h)", "single": "(5f)", "train": "(5a)"}
_LEAST_DIGITS, _MOST_DIGITS = 3, 15


# ---------------------------------------------------------------- the outcome


def lead(found: Findings) -> Html:
    """One or two sentences that say the outcome."""
    told, seen = found.predicted, found.simulated
    parts = []
    if told is not None:
        head = tag("strong", _REGIMES.get(told.regime, told.regime))
        parts.append(
            joined(
                (
                    "Predicted: ",
                    head,
                    f"; the primary is {_RELATIONS[told.relation]} the shock, with a peak force of ",
                    tag("strong", quantity(told.peak_force, "N")),
                    _trust_in(told),
                    ". ",
                )
            )
        )
    if seen is not None:
        parts.append(_simulated(seen))
    if found.comparison is not None and found.predicted is not None:
        parts.append(_verdict(found.comparison.error, found.predicted.expected_error))
    return joined(parts) if parts else Html("Neither the prediction nor the simulation gave an answer.")


def _trust_in(told: Outcome) -> Html:
    if told.expected_error is None:
        return Html(" (how far off is not known)")
    return joined((" (expected error ", expected(told), ")"))


def _simulated(seen: SimulationResult) -> Html:
    waves = f"{count(seen)} {'wave' if count(seen) == '1' else 'waves'}"
    what = "the primary" if seen.options.waves == "primary" else waves
    return joined(
        (
            "Simulated: ",
            tag("strong", what),
            ", the primary with a peak force of " if what == waves else ", with a peak force of ",
            tag("strong", quantity(seen.peak_force, "N", digits_of(seen.error_estimate))),
            " (",
            known(seen.error_estimate),
            "). ",
        )
    )


def _verdict(error: float, bounds: tuple[float, float] | None) -> Html:
    side = "too high" if error > 0 else "too low"
    size = Html(percent(abs(error)).lstrip("+"))
    parts: list[str] = ["The prediction is ", tag("strong", size, f" {side}")]
    if bounds is not None:
        parts.append(", as expected" if bounds[0] <= error <= bounds[1] else ", more than expected")
    return joined((*parts, "."))


def expected(told: Outcome) -> Html:
    """The range of the relative error, or that it is not known."""
    if told.expected_error is None:
        return Html("not known")
    low, high = told.expected_error
    return joined((percent(low), " to ", percent(high)))


def known(error_estimate: float) -> Html:
    """How well a simulated figure is known."""
    return joined(("within ", small(error_estimate))) if error_estimate < 1 else Html("how far off is not known")


def digits_of(error_estimate: float | None) -> int:
    """Digits that a figure of this relative error has, and one more."""
    if error_estimate is None or not 0 < error_estimate < 1:
        return _LEAST_DIGITS
    return min(max(1 - math.floor(math.log10(error_estimate)), _LEAST_DIGITS), _MOST_DIGITS)


def settled(seen: SimulationResult) -> list[MeasuredWave]:
    """The waves whose figures mean something."""
    return [wave for wave in seen.waves if wave.error_estimate is not None]


def count(seen: SimulationResult) -> str:
    """How many waves; a plus for more that had not settled."""
    number = len(settled(seen))
    return f"{number}{'+' if number < len(seen.waves) else ''}"


# ---------------------------------------------------------------- the decision


def decision(told: Outcome) -> Html:
    """What decided, step by step, and where the peak force comes from."""
    return listed([*(_step(step) for step in told.trace), _source(told)], ordered=True)


def _step(step: Inequality) -> Html:
    hence = _HENCE.get(step.outcome, step.outcome)
    sides = joined((quantity(step.left, "s"), " against ", quantity(step.right, "s")))
    symbol = step.statement.startswith("alphaF0") or not step.statement[:2].isalpha()
    statement = formula(step.statement if symbol else step.statement[:1].upper() + step.statement[1:])
    return joined((statement, ": ", sides, f". Hence {hence}, by ", _equation(step.equation), "."))


def _source(told: Outcome) -> Html:
    if told.model != "section-4":
        return joined(("The peak force is ", quantity(told.peak_force, "N"), f", by {told.model}."))
    parts: list[str] = [f"By {_SOURCES[told.regime]} the peak force of the primary is ", quantity(told.peak_force, "N")]
    if isinstance(told, EjectionOutcome):
        parts += [
            ". To the impulse of the shock, ",
            quantity(told.applied_momentum, "N s"),
            ", ejected granules add ",
            quantity(told.added_momentum, "N s"),
            ": by (5g) a virtual shock of the rise time ",
            quantity(told.virtual_rise_time, "s"),
            f" would just make a wave of its own strength, and its last {told.window_ratio:.1%} count twice",
        ]
    if told.regime == "train" and len(told.waves) > 1:
        parts.append(f"; by (5i) {len(told.waves) - 1} more follow")
    return joined((*parts, "."))


def _equation(number: str) -> str:
    return number if number.startswith("(") else f"section {number}"
