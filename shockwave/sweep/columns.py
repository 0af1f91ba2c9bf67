"""Columns of a sweep: the quantities of every point, and their values in an answer."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from shockwave.base.result import value_at
from shockwave.prediction.outcome import Outcome
from shockwave.prediction.section4 import relation_of
from shockwave.prediction.section4_outcome import Section4Outcome
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.sweep_block import Run
from shockwave.scene.force_limit import Verdict
from shockwave.simulation.simulation_result import Simulation
from shockwave.sweep.definition import NOTES, Column

if TYPE_CHECKING:
    from shockwave.simulation.simulation_result import Simulation


class Answer(NamedTuple):
    """Results at a point; those that were not requested are None.

    ``rise_time`` and ``duration`` are in characteristic times of the chain; None for chains beyond equal granules.
    """

    rise_time: float | None = None
    duration: float | None = None
    predicted: Outcome | None = None
    simulated: Simulation | None = None

    @property
    def section4(self) -> Section4Outcome | None:
        """What section 4 predicts."""
        return None if self.predicted is None else self.predicted.section4

    @property
    def error(self) -> float | None:
        """Relative error of section 4; None without its prediction or without a limit of the leading wave."""
        if self.section4 is None or self.simulated is None or self.simulated.peak_force is None:
            return None
        return self.section4.peak_force / self.simulated.peak_force - 1

    @property
    def relation(self) -> str | None:
        """Simulated relation of the leading wave to the shock."""
        if self.predicted is None or self.simulated is None or self.simulated.amplification is None:
            return None
        return relation_of(self.simulated.amplification, self.predicted.predictor.equal_tolerance)

    @property
    def verdict(self) -> Verdict | None:
        """Verdict on the limit, of the simulation if there is one."""
        if self.predicted is not None and (self.simulated is None or self.predicted.simulation is not None):
            return self.predicted.verdict
        return None if self.simulated is None else self.simulated.verdict

    @property
    def notes(self) -> str | None:
        """All warnings."""
        if self.simulated is not None:
            return " ".join(dict.fromkeys(self.simulated.all_warnings)) or None
        assert self.predicted is not None
        unknown = (f"No answer: {self.predicted.reason}.",) * (self.predicted.reason is not None)
        return " ".join(dict.fromkeys((*unknown, *self.predicted.notes, *self.predicted.warnings))) or None


class Read(NamedTuple):
    """A column and the function that returns its value for an answer."""

    column: Column
    of: Callable[[Any], Any]


def _at(path: str) -> Callable[[Any], Any]:
    """Return a reader of the value at a dotted path."""
    return partial(value_at, path=path)


def _number(name: str, unit: str, meaning: str, path: str) -> Read:
    return Read(Column(name, unit, "number", meaning), _at(path))


def _count(name: str, meaning: str, of: Callable[[Any], Any]) -> Read:
    return Read(Column(name, "", "whole", meaning), of)


def _text(name: str, meaning: str, path: str) -> Read:
    return Read(Column(name, None, "text", meaning), _at(path))


_RELATION = "peak force of the leading wave less than, equal to or greater than that of the shock"


_SECTION4 = (
    _text("section4_regime", "by section 4: ejection, single or train", "section4.regime"),
    _text("section4_relation", f"by section 4: {_RELATION}", "section4.relation"),
    _number("section4_peak_force", "N", "by section 4, of the leading wave", "section4.peak_force"),
    _number("section4_amplification", "", "by section 4, peak force / that of the shock", "section4.amplification"),
    _count(
        "section4_waves", "number of waves by section 4", lambda answer: answer.section4 and len(answer.section4.waves)
    ),
)
_PREDICTED = (
    _text("relation", _RELATION, "predicted.relation"),
    _number("peak_force", "N", "of the leading wave, between low and high", "predicted.peak_force"),
    _number("low", "N", "peak force less its error estimate", "predicted.low"),
    _number("high", "N", "peak force plus its error estimate", "predicted.high"),
    _number("amplification", "", "peak force divided by that of the shock", "predicted.amplification"),
    *_SECTION4,
    _number("section4_error", "", "relative difference of section4_peak_force from peak_force", "section4.error"),
    _number("applied_momentum", "N s", "impulse of the shock", "predicted.applied_momentum"),
    _number("virtual_rise_time", "s", "by section 4, in the regime ejection", "section4.virtual_rise_time"),
    _number("added_momentum", "N s", "by section 4, in the regime ejection", "section4.added_momentum"),
)
_SIMULATED = (
    _number("peak_force", "N", "simulated, of the leading wave, accurate to error_estimate", "simulated.peak_force"),
    _number("amplification", "", "simulated, peak force divided by that of the shock", "simulated.amplification"),
    _number("error_estimate", "", "relative error of the simulated peak force, estimated", "simulated.error_estimate"),
)


def _leading(wave: str) -> list[Read]:
    """Return the readers of the leading wave, at the path ``wave``."""
    declared = (
        ("momentum", "N s", "of the leading wave, accurate to about foot or rtol, whichever is larger"),
        ("speed", "m/s", "of the leading wave, about as accurate as peak_force"),
        ("width", "s", "full width at half maximum of the force of the leading wave"),
        ("foot", "", "residual force beside the leading wave, over its peak force"),
    )
    return [_number(name, unit, meaning, f"{wave}.{name}") for name, unit, meaning in declared]


_TRAIN = (
    _count("waves", "number of waves above the threshold", lambda answer: len(answer.simulated.waves)),
    _number("second_peak_force", "N", "of the second strongest wave", "simulated.waves.1.peak_force"),
    _number("second_error_estimate", "", "relative error of second_peak_force", "simulated.waves.1.error_estimate"),
    _number("recoil_momentum", "N s", "of the rebounding granules", "simulated.recoil_momentum"),
    _number("recoil_error", "N s", "error estimate of recoil_momentum", "simulated.recoil_error"),
    _count("ejected_granules", "number of rebounding granules", _at("simulated.ejected_granules")),
    _number("momentum_defect", "", "relative difference of momentum and impulse", "simulated.momentum_defect"),
)


def _if_integrated(read: Read) -> Read:
    """The column of a train without a value where the train was not integrated."""
    return Read(read.column, lambda answer: read.of(answer) if answer.simulated.train.is_integrated else None)


_FINITE = (
    _number("greatest_force", "N", "greatest contact force in a finite chain", "simulated.greatest_force.peak_force"),
    _number("greatest_error", "", "relative error of greatest_force", "simulated.greatest_force.error_estimate"),
)
_COMPARED = (
    _text("relation", f"simulated: {_RELATION}", "relation"),
    *_SECTION4,
    _number("error", "", "relative error of section4_peak_force, accurate to error_estimate", "error"),
)


_LAST = (
    _number("scaled_rise_time", "", "t0/T0, rise time divided by the characteristic time of the chain", "rise_time"),
    _number("scaled_duration", "", "n t0/T0, duration divided by the characteristic time of the chain", "duration"),
    _text(NOTES, "warnings", "notes"),
)


def _forces_error(answer: Answer) -> float | None:
    """Error estimate of the contact forces; that of equal granules is of the leading wave."""
    equal = isinstance(answer.simulated, Simulation)
    error: float | None = _at(f"simulated.{'greatest_force.' if equal else ''}error_estimate")(answer)
    return error


#: Column of the verdict on a limit.
VERDICT = _text("verdict", "decision on the limit of the force: below, above or undecided", "verdict.decision")
_CHAIN = (
    _number("greatest_force", "N", "greatest force at all contacts", "simulated.greatest_force.peak_force"),
    _count("greatest_contact", "contact at which it acts", _at("simulated.greatest_force.contact")),
    _number("greatest_time", "s", "time at which it acts", "simulated.greatest_force.time"),
)
_WALL = (
    _number("transmitted_force", "N", "greatest force on the wall", "simulated.transmitted.peak_force"),
    _number("transmitted_impulse", "N s", "impulse on the wall", "simulated.transmitted.impulse"),
)
_CHAIN_ERROR = Read(Column("error_estimate", "", "number", "relative error of these forces, estimated"), _forces_error)
_STRIKER = _number("restitution", "", "coefficient of restitution of the striker", "simulated.restitution")
_DISSIPATED = _number("dissipated_energy", "J", "energy dissipated by damping", "simulated.dissipated_energy")


def chain_reads(scenario: Scenario, run: Run, section4: bool) -> tuple[Read, ...]:
    """Return the columns of a sweep of chains beyond equal granules.

    ``section4`` states whether section 4 may predict some points. Columns of a wall or a striker that no point has are
    left out.
    """
    forces = [
        _number(
            f"force_{contact}", "N", f"greatest force at contact {contact}", f"simulated.contacts.{index}.peak_force"
        )
        for index, contact in enumerate(scenario.simulate.contacts)
    ]
    wall = () if scenario.chain.end is None else _WALL
    striker = () if scenario.impact is None else (_STRIKER,)
    equal = {"compare": _COMPARED, "predict": _PREDICTED}.get(run, ()) if section4 else ()
    return (*_CHAIN, *wall, _CHAIN_ERROR, *striker, _DISSIPATED, *forces, *equal, *_LAST[-1:])


def reads(run: Run, train: bool, finite: bool = False) -> tuple[Read, ...]:
    """Return the columns of a sweep that does ``run`` and measures the whole ``train`` or the leading wave only.

    ``finite`` states whether some of the chains are finite.
    """
    if run == "predict":
        return (*_PREDICTED, *_LAST)
    more = (*(map(_if_integrated, _TRAIN) if train else ()), *(_FINITE if finite else ()))
    if run == "simulate":
        leading = _leading("simulated.waves.0" if train else "simulated.primary")
        return (*_SIMULATED, *leading, *more, *_LAST)
    return (*_SIMULATED, *_COMPARED, *more, *_LAST)


def row(columns: tuple[Read, ...], answer: Answer) -> list[Any]:
    """Return the values of the columns for an answer as numbers and text; None where a column does not apply."""
    return [_plain(column.kind, of(answer)) for column, of in columns]


def _plain(kind: str, value: Any) -> Any:
    if value is None or kind == "text":
        return value
    if kind == "whole":
        return int(value)
    number = float(value)
    return number if math.isfinite(number) else None
