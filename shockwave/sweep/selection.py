"""Which points of a sweep are drawn, over which of its variables, and what these are called."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.errors import UnknownNameError, UsageError
from shockwave.pictures.style import thousandths
from shockwave.pictures.sweep import Along
from shockwave.scenario.units import to_si
from shockwave.sweep.definition import as_text
from shockwave.sweep.results import SweepResults

# Six digits of a value are enough to name it.
_DIGITS = 6
_CLOSE = 1e-5
# So many values are listed.
_LISTED = 20
# Letters in a line above the picture.
_WIDTH = 90


@frozen(eq=False)
class Chosen:
    """An axis as it is drawn.

    Attributes
    ----------
    place : int
        Which axis of the sweep it is.
    name : str
        The variable over which it is drawn.
    along : Along
        What is drawn.
    order : array of int
        The positions of the sweep's axis, in the order as drawn.
    others : tuple of str
        The variables that change along it, too.
    """

    place: int
    name: str
    along: Along
    order: npt.NDArray[np.intp]
    others: tuple[str, ...]


class Selection:
    """The positions of the axes that are drawn: those at which the variables in ``at`` have their values."""

    def __init__(self, results: SweepResults, at: Mapping[str, Any]) -> None:
        self.results = results
        self.positions = [_different(axis.values) for axis in results.axes]
        for name, value in at.items():
            place = self._place_of(name)
            here = self.positions[place]
            self.positions[place] = here[self._equal(name, value, results.coordinate(name)[here])]

    def _place_of(self, name: str) -> int:
        places = {one: place for place, axis in enumerate(self.results.axes) for one in axis.names}
        if name not in places:
            raise UnknownNameError("variable of the sweep", name, places)
        return places[name]

    def _equal(self, name: str, value: Any, values: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
        """Which of ``values`` are ``value``, of numbers those that are nearest to it."""
        unit = self.results.units[name]
        if value is None or value == "none":
            found = values == "" if unit is None else np.isnan(values)
        elif unit is None:
            text = as_text(value)
            found = (values == text) | (np.array(self._shown(name, values)) == text)
        else:
            try:
                number = to_si(value, unit)
            except ValueError as error:
                raise UsageError(f"{name}: {error}") from None
            gaps = np.nan_to_num(np.abs(values - number), nan=np.inf)
            found = (gaps <= _CLOSE * abs(number)) & (gaps == gaps.min())
        if not found.any():
            raise UsageError(f"{name}: must be one of its values (got {value}; they are {self._listed(name, values)})")
        return np.asarray(found)

    def _shown(self, name: str, values: npt.NDArray[Any]) -> list[str]:
        """Values as text, as `_equal` takes them."""
        unit = self.results.units[name]
        if unit is None:
            words = _words(self.results.axes[self._place_of(name)].along(name))
            return [words[text] for text in values.tolist()]
        texts = [thousandths(value, unit, _DIGITS) if unit else f"{value:.{_DIGITS}g}" for value in values.tolist()]
        return ["none" if np.isnan(value) else text for text, value in zip(texts, values, strict=True)]

    def _listed(self, name: str, values: npt.NDArray[Any], most: int = _LISTED) -> str:
        told = list(dict.fromkeys(self._shown(name, values)))
        return ", ".join(told[:most] + ["..."] * (len(told) > most))

    def _values(self, name: str) -> npt.NDArray[Any]:
        """The values of a variable at the positions that are drawn."""
        return self.results.coordinate(name)[self.positions[self._place_of(name)]]

    def _count(self, name: str) -> int:
        return len(np.unique(self._values(name)))

    def _name(self, place: int) -> str:
        """The variable of an axis that takes the most values, of several the first."""
        return max(self.results.axes[place].names, key=self._count)

    def axes(self, x: str | None) -> tuple[Chosen, Chosen | None]:
        """The axis from left to right, that of the variable ``x`` or the longest, and the other one, if there is one.

        Raises
        ------
        UsageError
            When there is none, or more than two.
        """
        free = [place for place, here in enumerate(self.positions) if len(here) > 1]
        if x is not None and self._count(x) < 2:
            raise UsageError(f"{x} has one value: it cannot be drawn over it (choose another by --x)")
        if not free:
            got = "got one point; read it in results.csv, or leave out an --at"
            raise UsageError(f"one axis or two can be drawn ({got})")
        if len(free) > 2:
            names = [self._name(place) for place in free]
            told = "; ".join(f"{name}={self._listed(name, self._values(name), 3)}" for name in names)
            hint = f"hold {len(free) - 2} of them at a value by --at NAME=VALUE: {told}"
            raise UsageError(f"one axis or two can be drawn (got {len(free)}; {hint})")
        across = self._place_of(x) if x else max(free, key=lambda place: len(self.positions[place]))
        rest = [self._chosen(self._name(place)) for place in free if place != across]
        return self._chosen(x or self._name(across)), rest[0] if rest else None

    def _chosen(self, name: str) -> Chosen:
        """The axis of a variable, as it is drawn over that."""
        place = self._place_of(name)
        here = self.positions[place]
        values = self._values(name)
        unit = self.results.units[name]
        others = tuple(one for one in self.results.axes[place].names if one != name and self._count(one) > 1)
        if unit is None or np.isnan(values).any():
            texts = np.array(self._shown(name, values))
            return Chosen(place, name, Along(texts, label_of(name)), here, others)
        order = here[np.argsort(values, kind="stable")]
        joined = all(_monotone(self.results.coordinate(one)[order]) for one in others)
        along = Along(self.results.coordinate(name)[order], label_of(name), unit, joined)
        return Chosen(place, name, along, order, others)

    def check_map(self, *chosen: Chosen) -> None:
        """Raise a UsageError unless these axes make a map."""
        for one in chosen:
            if not one.along.apart:
                remedy = "hold a variable that goes with it by --at NAME=VALUE, or choose one by --x"
                got = f"got {one.name}, which repeats a value; {remedy}"
                raise UsageError(f"points of a map must have a place each ({got})")
            if not (one.along.joined or one.along.texts):
                remedy = "hold a variable of the other axis by --at NAME=VALUE, to have marks"
                got = f"got {one.name}, with which {', '.join(one.others)} goes up and down; {remedy}"
                raise UsageError(f"points of a map must lie in an order ({got})")

    def labels(self, chosen: Chosen) -> list[str]:
        """What lines for the positions of an axis are called: by all variables that tell them apart."""
        found = [""] * len(chosen.order)
        for name in self.results.axes[chosen.place].names:
            if name == chosen.name or name in chosen.others:
                shown = self._shown(name, self.results.coordinate(name)[chosen.order])
                found = [f"{text}, {label_of(name)} {one}" for text, one in zip(found, shown, strict=True)]
        return [text.removeprefix(", ") for text in found]

    def caption(self, drawn: Sequence[Chosen]) -> str:
        """What is held, and what changes along axes without being drawn."""
        told = []
        for axis in self.results.axes:
            for name in axis.names:
                if self._count(name) == 1 < len(np.unique(self.results.coordinate(name))):
                    told.append(f"{label_of(name)} {self._shown(name, self._values(name))[0]}")
        for one in drawn:
            told += [f"{label_of(other)} changes with {label_of(one.name)}" for other in one.others]
        return textwrap.fill(", ".join(told), _WIDTH)

    def points(self, horizontal: Chosen, vertical: Chosen | None) -> npt.NDArray[np.intp]:
        """Numbers of the points, of shape (horizontal,) or (horizontal, vertical)."""
        chosen: list[Any] = [here[0] for here in self.positions]
        chosen[horizontal.place] = horizontal.order
        if vertical:
            chosen[horizontal.place] = horizontal.order[:, None]
            chosen[vertical.place] = vertical.order
        return np.asarray(np.ravel_multi_index(tuple(np.broadcast_arrays(*chosen)), self.results.shape))


def label_of(name: str) -> str:
    """What a variable is called in a picture."""
    return name.rpartition(".")[2].replace("_", " ")


def _different(values: Sequence[Any]) -> npt.NDArray[np.intp]:
    """The positions of values, without those that repeat another."""
    first = {repr(value): position for position, value in reversed([*enumerate(values)])}
    return np.array(sorted(first.values()), dtype=np.intp)


def _monotone(values: npt.NDArray[Any]) -> bool:
    if values.dtype.kind != "f":
        return False
    steps = np.diff(values)
    return bool((steps >= 0).all() or (steps <= 0).all())


def _words(values: list[Any]) -> dict[str, str]:
    """What values that are no numbers are called, by their text: mappings by a name of their own, or their number."""
    given = {as_text(value) or "": value for value in values}
    names = [value.get("name") if isinstance(value, dict) else value for value in given.values()]
    found = {}
    for number, (text, value) in enumerate(given.items(), start=1):
        found[text] = text or "none"
        if isinstance(value, dict):
            name = value.get("name")
            found[text] = name if name and names.count(name) == 1 else f"#{number}"
    return found
