"""Axes of a sweep that are drawn: the points that `--at` leaves, the variables from left to right and upwards."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.errors import UsageError
from shockwave.pictures.drawing import si_label
from shockwave.pictures.sweep import DrawnAxis
from shockwave.scenario.units import to_si
from shockwave.sweep.results import SweepResults

# Six digits of a value are enough to name it.
_DIGITS = 6
_CLOSE = 1e-5
# So many values are listed.
_LISTED = 20
# Letters in a line above the picture.
_WIDTH = 90


@frozen(eq=False)
class PlottedAxis:
    """An axis of a sweep as it is drawn.

    Attributes
    ----------
    place : int
        Which axis of the sweep it is.
    name : str
        The variable over which it is drawn.
    others : tuple of str
        The variables that change along it, too.
    positions : array of int
        The positions along the sweep's axis, in the order as drawn.
    drawn : DrawnAxis
        What is drawn.
    """

    place: int
    name: str
    others: tuple[str, ...]
    positions: npt.NDArray[np.intp]
    drawn: DrawnAxis


class PlottedAxes:
    """One axis or two of a sweep, at the values in ``at`` of other variables.

    Raises
    ------
    UnknownNameError
        When there is no such variable.
    UsageError
        When there are more axes, or none; when no point has the values that are held.
    """

    def __init__(self, results: SweepResults, at: Mapping[str, Any], x: str | None) -> None:
        self.results = results
        self.positions = [np.arange(len(axis)) for axis in results.axes]
        for name, value in at.items():
            place = self._place(name)
            here = self.positions[place]
            self.positions[place] = here[self._equal(name, value)]
        free = [place for place, here in enumerate(self.positions) if len(here) > 1]
        if not free:
            got = "got one point; read it in results.csv, or leave out an --at"
            raise UsageError(f"one axis or two can be drawn ({got})")
        if len(free) > 2:
            names = [self._longest(place) for place in free]
            known = "; ".join(f"{name}={self._listed(name, 3)}" for name in names)
            hint = f"hold {len(free) - 2} of them at a value by --at NAME=VALUE: {known}"
            raise UsageError(f"one axis or two can be drawn (got {len(free)}; {hint})")
        if x is not None and self._count(x) < 2:
            raise UsageError(f"{x} has one value: it cannot be drawn over it (choose another by --x)")
        across = self._place(x) if x else max(free, key=lambda place: len(self.positions[place]))
        names = [self._longest(place) for place in free if place != across]
        self.axes = [self._plotted(name) for name in (x or self._longest(across), *names)]

    def _place(self, name: str) -> int:
        self.results.coordinate(name)  # raises if there is no such variable
        return next(place for place, axis in enumerate(self.results.axes) if name in axis.names)

    def _values(self, name: str) -> npt.NDArray[Any]:
        """The values of a variable at the positions that are drawn."""
        return self.results.coordinate(name)[self.positions[self._place(name)]]

    def _count(self, name: str) -> int:
        return len(np.unique(self._values(name)))

    def _longest(self, place: int) -> str:
        """The variable of an axis that takes the most values, of several the first."""
        return max(self.results.axes[place].names, key=self._count)

    def _texts(self, name: str) -> list[str]:
        """The values of a variable as text, at the positions that are drawn."""
        place = self._place(name)
        unit = self.results.units[name]
        values = self.results.axes[place].along(name)
        return [_text(values[position], unit, position) for position in self.positions[place].tolist()]

    def _listed(self, name: str, most: int = _LISTED) -> str:
        texts = list(dict.fromkeys(self._texts(name)))
        return ", ".join(texts[:most] + ["..."] * (len(texts) > most))

    def _equal(self, name: str, value: Any) -> npt.NDArray[np.bool_]:
        """At which positions the variable has this value."""
        unit = self.results.units[name]
        if unit is None or value == "none":
            found = np.array(self._texts(name)) == str(value)
        else:
            try:
                number = to_si(value, unit)
            except ValueError as error:
                raise UsageError(f"{name}: {error}") from None
            found = np.isclose(self._values(name), number, rtol=_CLOSE, atol=0)
        if not found.any():
            raise UsageError(f"{name}: must be one of its values (got {value}; they are {self._listed(name)})")
        return np.asarray(found)

    def _plotted(self, name: str) -> PlottedAxis:
        place = self._place(name)
        here = self.positions[place]
        values = self._values(name)
        unit = self.results.units[name]
        others = tuple(one for one in self.results.axes[place].names if one != name and self._count(one) > 1)
        if unit is None or np.isnan(values).any():
            places = np.arange(len(here), dtype=float)
            drawn = DrawnAxis(label_of(name), "", places, self._texts(name), joined=False)
            return PlottedAxis(place, name, others, here, drawn)
        order = np.argsort(values, kind="stable")
        drawn = DrawnAxis(label_of(name), unit, values[order], joined=not others)
        return PlottedAxis(place, name, others, here[order], drawn)

    def pick(self, name: str) -> npt.NDArray[Any]:
        """A quantity at the points that are drawn, in the order of `axes`."""
        chosen = [here[:1] for here in self.positions]
        for axis in self.axes:
            chosen[axis.place] = axis.positions
        found = self.results.values(name)[np.ix_(*chosen)].squeeze()
        return found if self.axes[0].place <= self.axes[-1].place else found.T

    def labels(self) -> list[str]:
        """Names of lines for the values of the second axis: all variables that distinguish them."""
        if len(self.axes) == 1:
            return [""]
        axis = self.axes[1]
        order = np.searchsorted(self.positions[axis.place], axis.positions)
        names = [name for name in self.results.axes[axis.place].names if name == axis.name or name in axis.others]
        columns = [[f"{label_of(name)} {text}" for text in self._texts(name)] for name in names]
        return [", ".join(texts[position] for texts in columns) for position in order]

    def caption(self) -> str:
        """What is held, and what changes along axes without being drawn."""
        parts = []
        for axis in self.results.axes:
            for name in axis.names:
                if self._count(name) == 1 < len(np.unique(self.results.coordinate(name))):
                    parts.append(f"{label_of(name)} {self._texts(name)[0]}")
        for one in self.axes:
            parts += [f"{label_of(other)} changes with {label_of(one.name)}" for other in one.others]
        return textwrap.fill(", ".join(parts), _WIDTH)


def label_of(name: str) -> str:
    """The name of a variable or a quantity in a picture."""
    return name.rpartition(".")[2].replace("_", " ")


def _text(value: Any, unit: str | None, position: int) -> str:
    """A value as text; a mapping by its name, or else by its number among the values."""
    if value is None:
        return "none"
    if isinstance(value, Mapping):
        return str(value.get("name") or f"#{position + 1}")
    if unit is None:
        return str(value)
    return si_label(value, unit, _DIGITS) if unit else f"{value:.{_DIGITS}g}"
