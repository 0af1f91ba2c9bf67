"""Results of predictions and their text: a frozen class per regime for one shock, arrays for many shocks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
import numpy.typing as npt
from attrs import asdict, field, frozen

from shockwave.chain.solitary_wave import SolitaryWave
from shockwave.prediction.model_interface import Inequality, Regime, Relation
from shockwave.profiles.base import Areas
from shockwave.profiles.conditions import Condition
from shockwave.quadrature import FloatArray
from shockwave.scene_summary import Scene
from shockwave.text import alarm, facts, limits, notes, range_text, si, significant_digits, strong, table

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
_RELATIONS = {"less": "less than", "equal": "about equal to", "greater": "greater than"}


@frozen
class Exponents:
    """Local scaling exponents of the peak force of the leading wave: d ln F / d ln of each property of the granules.

    For example, with ``radius`` -1.6 the peak force scales as R^-1.6 for a given shock.
    """

    radius: float
    density: float
    youngs_modulus: float

    @classmethod
    def of(cls, sensitivity: float) -> Exponents:
        """Make the exponents from d ln F / d ln A; A scales as R^(4/3) rho^(1/2) E^(-1/3), eq. (4c)."""
        return cls(4 / 3 * sensitivity, sensitivity / 2, -sensitivity / 3)


@frozen
class Estimate:
    """Best a-priori estimate of the peak force of the leading wave.

    Attributes
    ----------
    peak_force, low, high : float
        Estimate and the ends of its range [N], in which the peak force lies for at least 98 % of shocks of any kind.
    method : str
        Method of the estimate.
    """

    peak_force: float
    low: float
    high: float
    method: str


_Estimate = TypeVar("_Estimate")
_Error = TypeVar("_Error")


@frozen
class Accuracy(Generic[_Estimate, _Error]):
    """Accuracy of one prediction or of many; see `Outcome` and `Predictions`."""

    estimate: _Estimate
    no_estimate: str | None
    expected_error: _Error
    warnings: tuple[str, ...]


class _OnDemand(Generic[_Estimate, _Error]):
    """Attributes that are computed when one of them is first accessed."""

    on_demand: Callable[[], Accuracy[_Estimate, _Error]]

    @cached_property
    def accuracy(self) -> Accuracy[_Estimate, _Error]:
        return self.on_demand()

    @property
    def estimate(self) -> _Estimate:
        return self.accuracy.estimate

    @property
    def no_estimate(self) -> str | None:
        return self.accuracy.no_estimate

    @property
    def expected_error(self) -> _Error:
        return self.accuracy.expected_error

    @property
    def warnings(self) -> tuple[str, ...]:
        return self.accuracy.warnings


def _plain(_: object, __: object, value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


@frozen(kw_only=True, slots=False)
class Outcome(_OnDemand[Estimate | None, tuple[float, float] | None]):
    """A prediction; its class corresponds to its regime.

    The estimate, the expected error and the warnings are computed when one of them is first accessed, and then kept.

    Attributes
    ----------
    scenario, model : str or None, str
        Name of the scenario, if there is one; name of the model.
    method, reason : str
        Method that gave the peak force: the model itself, or the method that it selected, with the reason.
    relation : str
        ``less``, ``equal`` or ``greater``: peak force of the leading wave relative to that of the shock, (5d) or (5e).
    peak_force : float
        Peak force of the leading wave [N].
    amplification : float
        Peak force of the leading wave over that of the shock.
    waves : tuple of SolitaryWave
        Waves, leading wave first.
    applied_momentum : float
        Impulse of the shock [N s].
    conditions : tuple of Condition
        Conditions (3).
    estimate, no_estimate : Estimate or None, str or None
        Best a-priori estimate of the peak force; the reason why there is none.
    expected_error : tuple of float or None
        Range of the relative error of ``peak_force``, lowest and highest, observed in simulations of similar shocks;
        None if no errors were measured or they have no useful bound.
    warnings : tuple of str
        Sentences on the limits of the prediction.
    trace : tuple of Inequality
        Inequalities that decided; both sides in seconds.
    exponents : Exponents or None
        Scaling with radius, density and stiffness; None where the relation has no derivative.
    areas : Areas
        Areas a1 and a2 with their errors, eq. (3).
    momentum_coefficient : float
        Leading number of A, eq. (4c).
    scene : Scene
        Summary of shock and chain.
    on_demand : callable
        Function that computes the accuracy when it is accessed.
    """

    regime: ClassVar[Regime]

    scenario: str | None = None
    model: str
    method: str
    reason: str = ""
    relation: Relation
    peak_force: float
    amplification: float
    waves: tuple[SolitaryWave, ...]
    applied_momentum: float
    conditions: tuple[Condition, ...]
    trace: tuple[Inequality, ...]
    exponents: Exponents | None
    areas: Areas
    momentum_coefficient: float
    scene: Scene
    on_demand: Callable[[], Accuracy[Estimate | None, tuple[float, float] | None]] = field(eq=False, repr=False)

    @property
    def shown_error(self) -> float:
        """Relative error that limits the printed digits; where it is not known, two digits are printed."""
        return 0.3 if self.expected_error is None else max(map(abs, self.expected_error))

    def to_dict(self) -> dict[str, Any]:
        """Document printed by ``predict --json``: SI floats, no NaN."""
        values = asdict(self, filter=lambda attribute, _: attribute.name != "on_demand", value_serializer=_plain)
        own = {"regime": self.regime, "reason": self.reason or None, "ejection": None, "scene": self.scene.to_dict()}
        return {**values, **asdict(self.accuracy, value_serializer=_plain), **own}

    def __str__(self) -> str:
        return outcome_text(self)


@frozen(kw_only=True, slots=False)
class EjectionOutcome(Outcome):
    """One wave, weaker than the shock, and the first granule rebounds (section 4.2.2).

    Attributes
    ----------
    virtual_rise_time : float
        Rise time of the virtual shock, whose wave has the peak force of the shock, (5g) [s].
    added_momentum : float
        Momentum that the ejected granule transfers to the others, (5h) [N s].
    window_ratio : float
        Duration of the window of (5h) over that of the virtual shock; measured errors are ordered by it.
    """

    regime: ClassVar[Regime] = "ejection"

    virtual_rise_time: float
    added_momentum: float
    window_ratio: float

    def to_dict(self) -> dict[str, Any]:
        document = super().to_dict()
        own = ("virtual_rise_time", "added_momentum", "window_ratio")
        document["ejection"] = {name: document.pop(name) for name in own}
        return document


@frozen(kw_only=True, slots=False)
class SingleOutcome(Outcome):
    """One wave that carries the entire impulse (section 4.2.3)."""

    regime: ClassVar[Regime] = "single"


@frozen(kw_only=True, slots=False)
class TrainOutcome(Outcome):
    """A wave train (sections 4.2.4 and 4.2.5).

    Attributes
    ----------
    roots : tuple of float
        All peak forces [N] that satisfy the relation for the leading wave; with constant alpha there is one.
    """

    regime: ClassVar[Regime] = "train"

    roots: tuple[float, ...] = ()


def outcome_text(outcome: Outcome) -> str:
    """The peak force with its expected error, the inequalities that decided, then the waves and the scene."""
    name = f"{outcome.scenario}: " if outcome.scenario else ""
    lines = [
        strong(name + estimate_text(outcome)),
        *limits(outcome_limits(outcome)),
        *decision_lines(outcome),
        "",
        wave_table(outcome),
        "",
        *facts([*outcome_details(outcome), *outcome.scene.facts()]),
        *notes(outcome.scene.notes),
    ]
    return "\n".join(lines)


def estimate_text(outcome: Outcome) -> str:
    """The estimated peak force with its range, or that there is none."""
    found = outcome.estimate
    if found is None:
        return f"leading wave not known a priori: {outcome.no_estimate}"
    peak, ends = estimate_figures(found)
    return f"leading wave {peak}, range {ends} (method: {found.method})"


def estimate_figures(found: Estimate) -> tuple[str, str]:
    """The estimate and its range, with the digits that the range supports."""
    spread = max(found.high / found.peak_force - 1, 1 - found.low / found.peak_force)
    peak, low, high = (si(value, "N", error=spread) for value in (found.peak_force, found.low, found.high))
    number, unit = low.split()
    return peak, f"{number if high.endswith(f' {unit}') else low} to {high}"


def outcome_limits(outcome: Outcome) -> list[str]:
    """Warnings that limit the answer; notes on a record do not, and the first line states why there is no estimate."""
    stated = outcome.no_estimate or "\n"
    return [warning for warning in outcome.warnings if warning not in outcome.scene.notes and stated not in warning]


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
        fails = f"does not hold here, nor do its regime, relation and waves: {peak}, error not known"
        yield outcome.model, f"{peak}, expected error {range_text(outcome.expected_error)}" if holds else alarm(fails)
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
    yield "model", outcome.model


@frozen(kw_only=True, eq=False, slots=False)
class Predictions(_OnDemand[FloatArray, FloatArray]):
    """Leading waves of many shocks, in the order of the shocks; the accuracy is computed as for `Outcome`.

    Attributes
    ----------
    model : str
        Name of the model.
    peak_force, amplification : numpy.ndarray, shape (shocks,)
        Peak force of the leading wave [N], and the same over that of the shock; NaN for a shock in ``failures``.
    method : numpy.ndarray of str, shape (shocks,)
        Method that gave each answer; empty for a shock in ``failures``.
    failures : tuple of (int, str)
        Indices of the shocks without an answer, ascending, each with the reason.
    estimate : numpy.ndarray, shape (shocks, 3)
        Best a-priori estimate of the peak force and the ends of its range [N]; NaN if there is none.
    expected_error : numpy.ndarray, shape (shocks, 2)
        Lowest and highest expected relative error of ``peak_force``; infinite if it is not known.
    warnings : tuple of str
        Sentences on the limits of the predictions; those on single shocks begin with their indices.
    """

    model: str
    peak_force: FloatArray
    amplification: FloatArray
    method: npt.NDArray[np.str_]
    failures: tuple[tuple[int, str], ...]
    on_demand: Callable[[], Accuracy[FloatArray, FloatArray]] = field(repr=False)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Predictions) and self.to_dict() == other.to_dict()

    def to_dict(self) -> dict[str, Any]:
        """Lists of SI floats, with None for unknown numbers."""
        return {
            "model": self.model,
            "peak_force": _numbers(self.peak_force),
            "amplification": _numbers(self.amplification),
            "estimate": [triple if None not in triple else None for triple in map(_numbers, self.estimate)],
            "expected_error": [pair if None not in pair else None for pair in map(_numbers, self.expected_error)],
            "method": self.method.tolist(),
            "failures": [{"index": index, "reason": reason} for index, reason in self.failures],
            "warnings": list(self.warnings),
        }

    def __str__(self) -> str:
        """Counts by method, and the first failure."""
        head = f"{len(self.method)} predictions by {self.model}"
        pairs = [(f"by {name}", str(count)) for name, count in Counter(self.method.tolist()).most_common() if name]
        if self.failures:
            index, reason = self.failures[0]
            pairs.append(("no answer", f"{len(self.failures)}; the first, shock {index}: {reason}"))
        return "\n".join([strong(head), *limits(self.warnings), *facts(pairs)])


def _numbers(values: FloatArray) -> list[float | None]:
    return [value if np.isfinite(value) else None for value in values.tolist()]
