"""Quantities of results, from which sweeps, designs, tables and data frames take names, units, labels and meanings."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cached_property, lru_cache
from typing import Any, Literal

from attrs import evolve, field, frozen

#: Types of values.
Kind = Literal["number", "whole", "text"]


@frozen(slots=False)
class Quantity:
    """A quantity of results.

    Attributes
    ----------
    name : str
        Name in the JSON of its source, such as ``waves[1].peak_force``.
    unit : str
        SI unit, empty without one.
    meaning : str
        Description in one line.
    column : str
        Name in sweeps; by default ``name`` with underscores.
    label : str
        Printed name; by default ``column`` with spaces.
    source : str
        The result that has it, an attribute of the answer at a point of a sweep; empty for the answer itself.
    errors : tuple of str
        Columns with its error, of which the first that a sweep has counts. Errors without a unit are relative.
    kind : "number", "whole" or "text"
        Type of the values; the whole number of a list is its length.
    over : Quantity or None
        The divisor, if the quantity is a ratio.
    """

    name: str
    unit: str
    meaning: str = ""
    column: str = field()
    label: str = field()
    source: str = "simulated"
    errors: tuple[str, ...] = ()
    kind: Kind = "number"
    over: Quantity | None = None

    @column.default
    def _column_of_name(self) -> str:
        return self.name.replace(".", "_")

    @label.default
    def _label_of_column(self) -> str:
        return self.column.replace("_", " ")

    @cached_property
    def path(self) -> str:
        """Dotted names of the attributes of the source."""
        return re.sub(r"\[(\d+)\]", r".\1", self.name.partition(" /")[0].replace("yield.", "yielding."))

    @cached_property
    def path_in_answer(self) -> str:
        """Dotted names of the attributes of an answer, which has the source as an attribute."""
        return f"{self.source}.{self.path}" if self.source else self.path

    def of(self, answer: Any) -> Any:
        """Value in an answer; None if there is none."""
        value, divisor = value_at(answer, self.path_in_answer), 1.0 if self.over is None else self.over.of(answer)
        return value if self.over is None else value / divisor if value is not None and divisor else None

    def figures(self, result: Any) -> tuple[float, float] | None:
        """Value in a simulation and its estimated relative error; None if there is none.

        A quantity without an error estimate takes that of the simulation.
        """
        value = value_at(result, self.path)
        if value is None:
            return None
        part, _, last = self.path.rpartition(".")
        owner = value_at(result, part) if part else result
        error = getattr(owner, f"{last}_error", getattr(owner, "error_estimate", result.error_estimate))
        divisor, its_error = (1.0, 0.0) if self.over is None else self.over.figures(result) or (0.0, 0.0)
        return (float(value) / divisor, float(error) + its_error) if divisor else None


def value_at(value: Any, path: str) -> Any:
    """Value at a dotted path, such as ``simulated.waves.1.peak_force``; None if there is none."""
    for step in _split_path(path):
        if isinstance(step, str):
            value = getattr(value, step, None)
        else:
            value = value[step] if value and step < len(value) else None
    return value


@lru_cache(maxsize=256)  # a sweep reads the same paths at every point
def _split_path(path: str) -> tuple[str | int, ...]:
    return tuple(int(step) if step.isdigit() else step for step in path.split("."))


def _group(source: str, *quantities: Quantity) -> tuple[Quantity, ...]:
    return tuple(evolve(quantity, source=source) for quantity in quantities)


_RELATION = "peak force of the leading wave less than, equal to or greater than that of the shock"
_PEAK_ERRORS = "low", "error_estimate"

#: Leading wave, where it has a limit.
LEADING_WAVE = (
    Quantity("peak_force", "N", "simulated, of the leading wave, accurate to error_estimate", errors=_PEAK_ERRORS),
    Quantity("amplification", "", "simulated, peak force divided by that of the shock", errors=_PEAK_ERRORS),
    Quantity("error_estimate", "", "relative error of the simulated peak force, estimated"),
    Quantity("waves[0].momentum", "N s", "of the leading wave, accurate to about foot or rtol", "momentum"),
    Quantity("waves[0].speed", "m/s", "of the leading wave, about as accurate as peak_force", "speed"),
    Quantity("waves[0].width", "s", "full width at half maximum of the force of the leading wave", "width"),
    Quantity("waves[0].foot", "", "residual force beside the leading wave, over its peak force", "foot"),
)
#: Later waves and rebounding granules, where the train was integrated.
TRAIN = _group(
    "train",
    Quantity("waves", "", "number of waves above the threshold", kind="whole"),
    Quantity("waves[1].peak_force", "N", "of the second strongest wave", "second_peak_force"),
    Quantity("waves[1].error_estimate", "", "relative error of second_peak_force", "second_error_estimate"),
    Quantity("recoil_momentum", "N s", "of the rebounding granules", errors=("recoil_error",)),
    Quantity("recoil_error", "N s", "error estimate of recoil_momentum"),
    Quantity("ejected_granules", "", "number of rebounding granules", kind="whole"),
    Quantity("momentum_defect", "", "relative difference of momentum and impulse"),
)
_GREATEST = "greatest_error", "error_estimate"
#: Greatest force of a finite chain beside the leading wave.
FINITE = (
    Quantity("greatest_force.peak_force", "N", "greatest contact force", "greatest_force", errors=_GREATEST),
    Quantity("greatest_force.error_estimate", "", "relative error of greatest_force", "greatest_error"),
)
#: Forces in other chains, with their error.
FORCES = (
    FINITE[0],
    Quantity("greatest_force.contact", "", "contact at which it acts", "greatest_contact", kind="whole"),
    Quantity("greatest_force.time", "s", "time at which it acts", "greatest_time"),
)
#: Force on a wall.
WALL = (
    Quantity("transmitted.peak_force", "N", "greatest force on the wall", "transmitted_force", "wall force"),
    Quantity(
        "transmitted.impulse",
        "N s",
        "impulse on the wall beyond the static force",
        "transmitted_impulse",
        "wall impulse",
    ),
)
#: Motion of a movable end.
STRUCTURE = (
    Quantity("structure.peak_displacement", "m", "greatest displacement of the movable end"),
    Quantity("structure.peak_acceleration", "m/s^2", "greatest acceleration of the movable end"),
    Quantity("structure.peak_spring_force", "N", "greatest force of its spring and dashpot on the ground"),
)
FORCES_ERROR = (Quantity("forces_error", "", "relative error of these forces, estimated", "error_estimate", source=""),)
STRIKER = (Quantity("restitution", "", "coefficient of restitution of the striker"),)
DISSIPATED = (Quantity("dissipated.energy", "J", "dissipated energy"),)
#: Plastic flow of contacts.
PLASTIC = (
    Quantity("dissipated.plastic", "J", "energy dissipated by plastic flow of contacts", "plastic_energy"),
    Quantity("yield.yielded_contacts", "", "number of contacts beyond first yield", "yielded_contacts", kind="whole"),
)
#: Section 4 beside a prediction or a simulation.
SECTION4 = _group(
    "predicted",
    Quantity("section4.regime", "", "by section 4: ejection, single or train", kind="text"),
    Quantity("section4.relation", "", f"by section 4: {_RELATION}", kind="text"),
    Quantity("section4.peak_force", "N", "by section 4, of the leading wave"),
    Quantity("section4.amplification", "", "by section 4, peak force / that of the shock"),
    Quantity("section4.waves", "", "number of waves by section 4", kind="whole"),
)
COMPARED = (
    Quantity("relation", "", f"simulated: {_RELATION}", kind="text", source=""),
    *SECTION4,
    Quantity("error", "", "relative error of section4_peak_force, accurate to error_estimate", source=""),
)
PREDICTED = _group(
    "predicted",
    Quantity("relation", "", _RELATION, kind="text"),
    Quantity("peak_force", "N", "of the leading wave, between low and high", errors=_PEAK_ERRORS),
    Quantity("low", "N", "peak force less its error estimate"),
    Quantity("high", "N", "peak force plus its error estimate"),
    Quantity("amplification", "", "peak force divided by that of the shock", errors=_PEAK_ERRORS),
    *SECTION4,
    Quantity("section4.error", "", "relative difference of section4_peak_force from peak_force"),
    Quantity("applied_momentum", "N s", "impulse of the shock"),
    Quantity("section4.virtual_rise_time", "s", "by section 4, in the regime ejection", "virtual_rise_time"),
    Quantity("section4.added_momentum", "N s", "by section 4, in the regime ejection", "added_momentum"),
)
SCALED = _group(
    "",
    Quantity("rise_time", "", "t0/T0, rise time divided by the characteristic time of the chain", "scaled_rise_time"),
    Quantity("duration", "", "n t0/T0, duration divided by the characteristic time of the chain", "scaled_duration"),
)
VERDICT = _group(
    "", Quantity("verdict.decision", "", "below, above or undecided, on the limit", "verdict", kind="text")
)
NOTES = _group("", Quantity("notes", "", "warnings, and notes on a record", kind="text"))
#: Steady wave of the peak force of the leading wave, and its neighbours.
STEADY_WAVE = _group(
    "steady",
    Quantity("momentum", "N s", "integral of the contact force"),
    Quantity("energy", "J", "integral of the contact force times the velocity of the granule"),
    Quantity("speed", "m/s", "speed along the chain"),
    Quantity("width", "s", "full width at half maximum of the contact force in time"),
    Quantity("granule_velocity", "m/s", "peak velocity of the granule behind the contact"),
)
YIELD = (
    Quantity("yield.peak_ratio", "", "largest ratio of a peak force to first yield", label="ratio to first yield"),
)
#: Granules, without a simulation.
GRANULES = _group(
    "granules",
    Quantity("chain.mass", "kg", "mass of the granules"),
    Quantity("chain.length", "m", "length of the chain"),
)
# Units of further numbers in results.
_OTHERS = {
    "N": ("force", "forces", "wall_force", "applied_force", "static_force", "first_yield_force", "roots"),
    "J": ("kinetic_energy", "contact_energy", "applied_energy", "end_energy", "dissipated"),
    "m/s": ("velocity", "velocities", "recoil_velocities", "spall_velocities"),
    "s": ("times", "end", "arrival_time", "seconds"),
    "m": ("displacements", "residual_overlap"),
}


def contact_forces(contacts: Sequence[int]) -> tuple[Quantity, ...]:
    """Greatest forces at the reported ``contacts``."""
    names = ((f"contacts[{index}].peak_force", contact) for index, contact in enumerate(contacts))
    return tuple(
        Quantity(name, "N", f"greatest force at contact {contact}", f"force_{contact}", f"force at contact {contact}")
        for name, contact in names
    )


#: Times of a chain beyond equal granules.
TIMES = (
    Quantity("arrival_time", "s", "arrival of the leading wave at the end"),
    Quantity("end", "s", "end of the simulated time"),
)


def segment_energies(count: int) -> tuple[Quantity, ...]:
    """Energies of so many segments, a striker being the first."""
    names = ((f"segments[{index}].energy", f"segment_{index}_energy") for index in range(count))
    return tuple(Quantity(name, "J", "energy at the end of the simulated time", column) for name, column in names)


# Figures of the first pulse of a sensor, and its greatest value, with their units, empty for that of the sensor.
_FIGURES = {
    "peak": ("", "peak of the first pulse, less the static force"),
    "arrival": ("s", "when the first pulse has risen to half of its peak"),
    "width": ("s", "time from there to the fall to half of the peak"),
    "impulse": ("N s", "impulse of the first pulse"),
    "speed": ("m/s", "mean speed of the wave from the preceding sensor of the same kind"),
    "greatest": ("", "greatest value, with the static force"),
}


def sensor_figures(sensors: Sequence[Any]) -> tuple[Quantity, ...]:
    """Figures of the first pulses of sensors, and their greatest values."""
    figures = []
    for index, sensor in enumerate(sensors):
        has_speed = sensor[::2] in [each[::2] for each in sensors[:index]]  # place and quantity
        left_out = ("impulse" if sensor.unit != "N" else "", "" if has_speed else "speed")
        for figure, (unit, meaning) in _FIGURES.items():
            if figure not in left_out:
                name, column = f"sensors[{index}].{figure}", f"{sensor.name}_{figure}"
                shown = "greatest value" if figure == "greatest" else f"first-pulse {figure}"
                label = f"{sensor.name.replace('_', ' ')} {shown}"
                figures.append(Quantity(name, unit or sensor.unit, meaning, column, label))
    return tuple(figures)


def sensor_errors(sensors: Sequence[Any]) -> tuple[Quantity, ...]:
    """Errors of the first pulses of sensors."""
    meaning = "largest relative error of the figures of the first pulse"
    names = ((f"sensors[{index}].error_estimate", f"{sensor.name}_error") for index, sensor in enumerate(sensors))
    return tuple(Quantity(name, "", meaning, column) for name, column in names)


def find_quantity(name: str, quantities: Mapping[str, Quantity]) -> Quantity | None:
    """The quantity of this name or column, or a ratio of two, ``sensors[1].peak / sensors[0].peak``; else None."""
    quantities = {**{each.column: each for each in quantities.values()}, **quantities}
    above, slash, below = (part.strip() for part in name.partition("/"))
    quantity, over = quantities.get(above), quantities.get(below)
    if not slash or quantity is None or over is None:
        return None if slash else quantity
    unit = "" if quantity.unit == over.unit else f"{quantity.unit or 1}/({over.unit})" if over.unit else quantity.unit
    ratio: dict[str, Any] = {
        name: f"{getattr(quantity, name)} / {getattr(over, name)}" for name in ("name", "column", "label")
    }
    return evolve(quantity, unit=unit, meaning="ratio", over=over, **ratio)


_ALL = (
    *(*LEADING_WAVE, *TRAIN, *FINITE, *FORCES, *WALL, *FORCES_ERROR, *STRIKER, *DISSIPATED, *COMPARED, *PREDICTED),
    *(*PLASTIC, *STRUCTURE, *SCALED, *VERDICT, *NOTES, *STEADY_WAVE, *YIELD, *GRANULES),
)
_UNITS = {name: unit for unit, names in _OTHERS.items() for name in names}
_UNITS |= {each.name.rpartition(".")[2]: each.unit for each in _ALL if each.unit}
_ERRORS = {each.column: each.errors for each in _ALL}


def unit_of(name: str) -> str:
    """SI unit of a quantity with this name in a result or as the last part of its name; empty without one."""
    return _UNITS.get(name.rpartition(".")[2], "")


def errors_of(column: str) -> tuple[str, ...]:
    """Columns of a sweep with the error of a column, of which the first that the sweep has counts."""
    is_force = column in (WALL[0].column, *(each.column for each in STRUCTURE)) or column.startswith("force_")
    return (FORCES_ERROR[0].column,) if is_force else _ERRORS.get(column, (f"{column.rpartition('_')[0]}_error",))
