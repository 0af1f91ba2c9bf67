"""Columns of a sweep: the quantities of every point, and their values in an answer."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from shockwave.base import quantities
from shockwave.base.errors import InvalidValueError, hint_of, text_of
from shockwave.base.quantities import Quantity, value_at
from shockwave.prediction.outcome import Outcome
from shockwave.prediction.section4 import relation_of
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.sweep_block import Run
from shockwave.scene.force_limit import Verdict
from shockwave.simulation.simulation_result import Simulation
from shockwave.sweep.definition import Column, remarks_of


class Answer(NamedTuple):
    """Results at a point; those that were not requested are None.

    ``rise_time`` and ``duration`` are in characteristic times of the chain; None for chains beyond equal granules.
    """

    rise_time: float | None = None
    duration: float | None = None
    predicted: Outcome | None = None
    simulated: Simulation | None = None

    @property
    def train(self) -> Any:
        """The simulation, if the train was integrated."""
        return self.simulated if value_at(self.simulated, "train.is_integrated") else None

    @property
    def forces_error(self) -> float | None:
        """Error estimate of the contact forces; that of equal granules is of the leading wave."""
        equal = self.simulated is not None and self.simulated.peak_force is not None
        error: float | None = value_at(self.simulated, "greatest_force.error_estimate" if equal else "error_estimate")
        return error

    @property
    def error(self) -> float | None:
        """Relative error of section 4; None without its prediction or without a limit of the leading wave."""
        section4 = None if self.predicted is None else self.predicted.section4
        if section4 is None or self.simulated is None or self.simulated.peak_force is None:
            return None
        return section4.peak_force / self.simulated.peak_force - 1

    @property
    def relation(self) -> str | None:
        """Simulated relation of the leading wave to the shock."""
        if self.predicted is None or self.simulated is None or self.simulated.amplification is None:
            return None
        return relation_of(self.simulated.amplification, self.predicted.predictor.equal_tolerance)

    @property
    def verdict(self) -> Verdict | None:
        """Verdict on the limit, of the simulation if there is one."""
        first = self.simulated or self.predicted
        return None if first is None else first.verdict

    @property
    def notes(self) -> str | None:
        """All warnings, then the notes on a record."""
        if self.simulated is not None:
            return remarks_of(self.simulated.wave_warnings, self.simulated.notes)
        assert self.predicted is not None
        unknown = (f"No answer: {self.predicted.reason}.",) * (self.predicted.reason is not None)
        return remarks_of((*unknown, *self.predicted.first_warnings), self.predicted.notes)


def columns_of(run: Run, train: bool, finite: bool = False) -> tuple[Quantity, ...]:
    """Return the columns of a sweep that does ``run`` and measures the whole ``train`` or the leading wave only.

    ``finite`` states whether some of the chains are finite.
    """
    if run == "predict":
        return (*quantities.PREDICTED, *quantities.SCALED, *quantities.NOTES)
    compared = quantities.COMPARED if run == "compare" else ()
    train_columns, forces = quantities.TRAIN if train else (), quantities.FINITE if finite else ()
    return (*quantities.LEADING_WAVE, *compared, *train_columns, *forces, *quantities.SCALED, *quantities.NOTES)


def chain_columns(scenario: Scenario, run: Run, section4: bool) -> tuple[Quantity, ...]:
    """Return the columns of a sweep of chains beyond equal granules.

    ``section4`` states whether section 4 may predict some points. Columns of a wall or a striker that no point has are
    left out.
    """
    end = scenario.chain.end
    wall = () if end is None else quantities.WALL if end.mass is None else (*quantities.WALL, *quantities.STRUCTURE)
    striker = () if scenario.impact is None else quantities.STRIKER
    contacts = quantities.contact_forces(scenario.simulate.contacts)
    equal = {"compare": quantities.COMPARED, "predict": quantities.PREDICTED}.get(run, ()) if section4 else ()
    plastic = quantities.PLASTIC if scenario.chain.is_plastic else ()
    forces = (*quantities.FORCES, *wall, *quantities.FORCES_ERROR, *striker, *quantities.DISSIPATED, *plastic)
    return (*forces, *contacts, *equal, *quantities.NOTES)


def find_requested_columns(scenario: Scenario, columns: tuple[Quantity, ...]) -> tuple[Quantity, ...]:
    """Return the columns of sensors, and those that the sweep names: energies of segments, times, or ratios.

    Those of ``columns`` are left out; a prediction has only these, and their ratios.

    Raises
    ------
    InvalidValueError
        If a name is unknown.
    """
    assert scenario.sweep is not None
    measured = scenario.simulate.sensors if scenario.sweep.run != "predict" else ()
    sensors, requested = quantities.sensor_figures(measured), []
    parts = len(scenario.chain.granules) if isinstance(scenario.chain.granules, tuple) else 1
    energies = quantities.segment_energies(parts + (scenario.impact is not None))
    others = () if scenario.sweep.run == "predict" else (*sensors, *quantities.TIMES, *energies)
    available = {each.name: each for each in (*columns, *others)}
    for index, name in enumerate(scenario.sweep.quantities):
        quantity = quantities.find_quantity(name, available)
        if quantity is None:
            got = f"got {text_of(name)}; {hint_of(name, list(available), len(available))}"
            raise InvalidValueError.of(("sweep", "quantities", index), f"must be a quantity or a ratio of two ({got})")
        requested.append(quantity)
    further = (*sensors, *quantities.sensor_errors(measured), *requested)
    return tuple(dict.fromkeys(each for each in further if each not in columns))


def column_of(quantity: Quantity) -> Column:
    """Return the column of a quantity."""
    unit = None if quantity.kind == "text" else quantity.unit
    return Column(quantity.column, unit, quantity.kind, quantity.meaning, quantity.name)


def row(columns: tuple[Quantity, ...], answer: Any) -> list[Any]:
    """Return the values of the columns for an answer as numbers and text; None where a column does not apply."""
    return [_plain(quantity, quantity.of(answer)) for quantity in columns]


def _plain(quantity: Quantity, value: Any) -> Any:
    if value is None or quantity.kind == "text":
        return value
    if quantity.kind == "whole":
        return len(value) if isinstance(value, tuple) else int(value)
    number = float(value)
    return number if math.isfinite(number) else None
