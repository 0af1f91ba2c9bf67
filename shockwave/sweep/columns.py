"""Columns of a sweep: the quantities of every point, and where each is found in an answer."""

from __future__ import annotations

import math
from collections.abc import Callable
from operator import attrgetter
from typing import Any, NamedTuple

from shockwave.measurement.result import MeasuredWave, SimulationResult
from shockwave.prediction.outcome import Outcome
from shockwave.scenario.sweep_block import Run
from shockwave.studies.comparison import Comparison
from shockwave.sweep.header import NOTES, Column


class Answer(NamedTuple):
    """The results at a point; None for what was not asked for.

    ``rise_time`` and ``duration`` are in characteristic times of the chain.
    """

    rise_time: float
    duration: float
    predicted: Outcome | None = None
    simulated: SimulationResult | None = None
    primary: MeasuredWave | None = None
    compared: Comparison | None = None


class Read(NamedTuple):
    """A column, and its value for an answer."""

    column: Column
    of: Callable[[Any], Any]


def _number(name: str, unit: str, meaning: str, of: str | Callable[[Any], Any]) -> Read:
    return Read(Column(name, unit, "number", meaning), attrgetter(of) if isinstance(of, str) else of)


def _whole(name: str, meaning: str, of: Callable[[Any], Any]) -> Read:
    return Read(Column(name, "", "whole", meaning), of)


def _text(name: str, meaning: str, of: str | Callable[[Any], Any]) -> Read:
    return Read(Column(name, None, "text", meaning), attrgetter(of) if isinstance(of, str) else of)


_LESS_OR_GREATER = "primary's peak force less, equal or greater than the shock's"
_EXPECTED = "relative error of the predicted peak force that is to be expected"
_SCENE = (
    _number("scaled_rise_time", "", "t0/T0, rise time over the natural time of the chain", "rise_time"),
    _number("scaled_duration", "", "n t0/T0, whole duration over the natural time of the chain", "duration"),
)


def _expected(side: int) -> Callable[[Any], Any]:
    return lambda answer: None if answer.predicted.expected_error is None else answer.predicted.expected_error[side]


def _predicted(prefix: str) -> tuple[Read, ...]:
    """The prediction of the primary."""
    return (
        _text(f"{prefix}regime", "predicted: ejection, single or train", "predicted.regime"),
        _text(f"{prefix}relation", f"predicted: {_LESS_OR_GREATER}", "predicted.relation"),
        _number(f"{prefix}peak_force", "N", "predicted, of the primary", "predicted.peak_force"),
        _number(f"{prefix}amplification", "", "predicted, peak force over the shock's", "predicted.amplification"),
        _number(f"{prefix}expected_error_low", "", f"lowest {_EXPECTED}", _expected(0)),
        _number(f"{prefix}expected_error_high", "", f"highest {_EXPECTED}", _expected(1)),
    )


def _of_ejection(name: str) -> Callable[[Any], Any]:
    return lambda answer: getattr(answer.predicted, name, None)


_PREDICTED = (
    _whole("waves", "how many are predicted", lambda answer: len(answer.predicted.waves)),
    _number("applied_momentum", "N s", "impulse of the shock", "predicted.applied_momentum"),
    _number("virtual_rise_time", "s", "predicted, of an ejection", _of_ejection("virtual_rise_time")),
    _number("added_momentum", "N s", "predicted, of an ejection", _of_ejection("added_momentum")),
)
_SIMULATED = (
    _number("peak_force", "N", "simulated, of the primary, known to error_estimate", "simulated.peak_force"),
    _number("amplification", "", "simulated, peak force over the shock's", "simulated.amplification"),
    _number("error_estimate", "", "relative, of the simulated peak force", "simulated.error_estimate"),
)
_PRIMARY = (
    _number("momentum", "N s", "of the primary, known about as well as its peak force", "primary.momentum"),
    _number("speed", "m/s", "of the primary, known about as well as its peak force", "primary.speed"),
    _number("width", "s", "of the primary, full width at half maximum of the force", "primary.width"),
)


def _of_train(of: Callable[[SimulationResult], Any]) -> Callable[[Any], Any]:
    return lambda answer: of(answer.simulated) if answer.simulated.options.waves == "train" else None


def _second(name: str) -> Callable[[Any], Any]:
    return _of_train(lambda found: getattr(found.waves[1], name) if len(found.waves) > 1 else None)


_TRAIN = (
    _whole("waves", "how many are stronger than the threshold", _of_train(lambda found: len(found.waves))),
    _number("second_peak_force", "N", "of the second strongest wave", _second("peak_force")),
    _number("second_error_estimate", "", "relative, of second_peak_force", _second("error_estimate")),
    _number("recoil_momentum", "N s", "of the granules thrown back", _of_train(attrgetter("recoil_momentum"))),
    _number("recoil_error", "N s", "estimate of that of recoil_momentum", _of_train(attrgetter("recoil_error"))),
    _whole("ejected_granules", "how many are thrown back", _of_train(attrgetter("ejected_granules"))),
    _number("momentum_defect", "", "momentum against impulse, relative", "simulated.momentum_defect"),
)
_COMPARED = (
    _number("error", "", "relative, of the predicted peak force, known to error_estimate", "compared.error"),
    _text("relation", f"simulated: {_LESS_OR_GREATER}", "compared.relation"),
)


def _notes(answer: Answer) -> str | None:
    warnings = answer.predicted.warnings if answer.predicted is not None else ()
    warnings += answer.simulated.all_warnings if answer.simulated is not None else ()
    return "; ".join(dict.fromkeys(warnings)) or None


_LAST = (*_SCENE, _text(NOTES, "what a reader must know before using the figures", _notes))


def reads(run: Run, train: bool) -> tuple[Read, ...]:
    """The columns of a sweep that does ``run`` at every point, and measures the ``train`` or the primary alone."""
    more = _TRAIN if train else ()
    if run == "predict":
        return (*_predicted(""), *_PREDICTED, *_LAST)
    if run == "simulate":
        return (*_SIMULATED, *_PRIMARY, *more, *_LAST)
    return (*_predicted("predicted_"), *_SIMULATED, *_COMPARED, *more, *_LAST)


def row(columns: tuple[Read, ...], answer: Answer) -> list[Any]:
    """The values of the columns for an answer: plain numbers and words, None for what does not apply."""
    return [_plain(column.kind, of(answer)) for column, of in columns]


def _plain(kind: str, value: Any) -> Any:
    if value is None or kind == "text":
        return value
    if kind == "whole":
        return int(value)
    number = float(value)
    return number if math.isfinite(number) else None
