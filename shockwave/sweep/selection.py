"""Which points of a sweep are drawn, over which of its variables, and what these are called."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.errors import UnknownNameError, UsageError
from shockwave.pictures.style import thousandths
from shockwave.pictures.sweep import Along
from shockwave.scenario.units import to_si
from shockwave.sweep.header import as_text
from shockwave.sweep.results import SweepResults

# Longer names leave the picture.
_LETTERS = 30
# Six digits of a value are enough to name it.
_CLOSE = 1e-5
# So many values are listed.
_LISTED = 20
# Letters in a line above the picture.
_WIDTH = 90


@frozen(eq=False)
class Chosen:
    """An axis as it is drawn, by which variable, and the positions of the sweep's axis in that order.

    ``others`` are the variables that change along it, too.
    """

    name: str
    along: Along
    order: npt.NDArray[np.intp]
    others: tuple[str, ...]

    @property
    def values(self) -> npt.NDArray[Any]:
        return self.along.values


class Selection:
    """Which positions of the axes are drawn."""

    def __init__(self, results: SweepResults, at: Mapping[str, Any]) -> None:
        self.results = results
        self.positions = [self._different(axis.names) for axis in results.axes]
        for name, value in at.items():
            place = self.place_of(name)
            here = self.positions[place]
            self.positions[place] = here[self._equal(name, value, results.coordinate(name)[here])]
        self.free = [place for place, here in enumerate(self.positions) if len(here) > 1]

    def _different(self, names: tuple[str, ...]) -> npt.NDArray[np.intp]:
        """The positions of an axis, without those that repeat another."""
        told = [
            repr(values) for values in zip(*(self.results.coordinate(name).tolist() for name in names), strict=True)
        ]
        return np.sort(np.unique(told, return_index=True)[1])

    def place_of(self, name: str) -> int:
        for place, axis in enumerate(self.results.axes):
            if name in axis.names:
                return place
        raise UnknownNameError("variable of the sweep", name, [n for axis in self.results.axes for n in axis.names])

    def _equal(self, name: str, value: Any, values: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
        """Which of ``values`` are ``value``, of numbers those that are nearest to it."""
        unit = self.results.units[name]
        nothing = value is None or value == "none"
        if unit is None:
            text = "" if nothing else as_text(value)
            shown = np.array(self._shown(name, values))
            found = (values == text) | (shown == text)
        elif nothing:
            found = np.isnan(values)
        else:
            try:
                number = to_si(value, unit)
            except ValueError as error:
                raise UsageError(f"{name}: {error}") from None
            gaps = np.where(np.isnan(values), np.inf, np.abs(values - number))
            found = (gaps <= _CLOSE * abs(number)) & (gaps == gaps.min())
        if not found.any():
            got = f"got {value}; they are {self._listed(name, values, _LISTED)}"
            among = (
                "in the sweep" if len(values) == len(self.results.coordinate(name)) else "at the points that are left"
            )
            raise UsageError(f"{name}: must be one of its values {among} ({got})")
        return np.asarray(found)

    def _shown(self, name: str, values: npt.NDArray[Any], label: bool = False) -> list[str]:
        """Values as text that tells them apart: as `_equal` takes them, or short as a label."""
        unit = self.results.units[name]
        if unit is None:
            words = _words(self.results.axes[self.place_of(name)].along(name))
            return [words[text] for text in values.tolist()]
        if label and unit:
            return _digits(values, lambda value, digits: thousandths(value, unit, digits), 3)
        return _digits(values, lambda value, digits: f"{value:.{digits}g} {unit}", 3 if label else 6)

    def _listed(self, name: str, values: npt.NDArray[Any], most: int) -> str:
        told = list(dict.fromkeys(self._shown(name, values)))
        return ", ".join(told[:most] + ["..."] * (len(told) > most))

    def check(self) -> None:
        names = [self._name(place) for place in self.free]
        if not names:
            raise UsageError(
                "one axis or two can be drawn (got one point; read it in results.csv, or leave out an --at)"
            )
        if len(names) > 2:
            values = [self.results.coordinate(name)[self.positions[self.place_of(name)]] for name in names]
            told = "; ".join(f"{name}={self._listed(name, here, 3)}" for name, here in zip(names, values, strict=True))
            raise UsageError(
                f"one axis or two can be drawn (got {len(names)}; hold {len(names) - 2} of them at a value by "
                f"--at NAME=VALUE: {told})"
            )

    def check_map(self, *chosen: Chosen) -> None:
        """Whether these axes make a map."""
        for one in chosen:
            if not one.along.apart:
                remedy = "hold a variable that goes with it by --at NAME=VALUE, or choose one by --x"
                got = f"got {one.name}, which repeats a value; {remedy}"
                raise UsageError(f"points of a map must have a place each ({got})")
            if not (one.along.joined or one.along.texts):
                remedy = "hold a variable of the other axis by --at NAME=VALUE, to have marks"
                got = f"got {one.name}, with which {', '.join(one.others)} goes up and down; {remedy}"
                raise UsageError(f"points of a map must lie in an order ({got})")

    def axis_of(self, x: str | None) -> int:
        if x is None:
            return max(self.free, key=lambda place: len(self.positions[place]), default=0)
        place = self.place_of(x)
        if self._count(x) < 2:
            raise UsageError(f"{x} has one value: it cannot be drawn over it (choose another by --x)")
        return place

    def _count(self, name: str) -> int:
        place = self.place_of(name)
        return len(np.unique(self.results.coordinate(name)[self.positions[place]]))

    def _varying(self, place: int) -> list[str]:
        return [name for name in self.results.axes[place].names if self._count(name) > 1]

    def _name(self, place: int) -> str:
        """The variable of an axis that takes the most values, of several the first."""
        return max(self.results.axes[place].names, key=self._count)

    def along(self, place: int, name: str | None = None) -> Chosen:
        """The axis at ``place``, by one of its variables."""
        name, here = name or self._name(place), self.positions[place]
        unit, values = self.results.units[name], self.results.coordinate(name)[here]
        others = tuple(one for one in self._varying(place) if one != name)
        if unit is None or np.isnan(values).any():
            texts = [text.removesuffix(f" {unit}") for text in self._shown(name, values)]
            return Chosen(name, Along(np.array(texts), label_of(name)), here, others)
        order = np.argsort(values, kind="stable")
        along = (self.results.coordinate(one)[here[order]] for one in others)
        joined = all(_monotone(one) for one in along)
        return Chosen(name, Along(values[order], label_of(name), unit, joined), here[order], others)

    def labels(self, place: int, chosen: Chosen) -> list[str]:
        """What lines for the positions of an axis are called: by all variables that tell them apart."""
        told = []
        for name in self._varying(place):
            shown = self._shown(name, self.results.coordinate(name)[chosen.order], label=True)
            told.append([f"{label_of(name)} {one}" for one in shown])
        return [", ".join(parts) for parts in zip(*told, strict=True)]

    def caption(self, *drawn: Chosen) -> str:
        """What is held, and what changes along axes without being drawn."""
        told = []
        for place, axis in enumerate(self.results.axes):
            for name in axis.names:
                values = self.results.coordinate(name)
                if self._count(name) == 1 < len(np.unique(values)):
                    told.append(f"{label_of(name)} {self._shown(name, values, label=True)[self.positions[place][0]]}")
        for one in drawn:
            told += [f"{label_of(other)} changes with {label_of(one.name)}" for other in one.others]
        return textwrap.fill(", ".join(told), _WIDTH)

    def indices(self, across: int, horizontal: Chosen, up: int | None = None, vertical: Chosen | None = None) -> Any:
        """Numbers of the points, of shape (horizontal,) or (horizontal, vertical)."""
        chosen: list[Any] = [here[0] for here in self.positions]
        if up is None or vertical is None:
            chosen[across] = horizontal.order
        else:
            chosen[across], chosen[up] = horizontal.order[:, None], vertical.order[None, :]
        return np.ravel_multi_index(tuple(np.broadcast_arrays(*chosen)), self.results.shape)


def label_of(name: str) -> str:
    """What a variable is called in a picture."""
    return name.rpartition(".")[2].replace("_", " ")


def _monotone(values: npt.NDArray[Any]) -> bool:
    if values.dtype.kind != "f":
        return False
    steps = np.diff(values)
    return bool((steps >= 0).all() or (steps <= 0).all())


def _digits(values: npt.NDArray[Any], shown: Callable[[float, int], str], least: int) -> list[str]:
    """Numbers as text, of ``least`` digits or as many as tell them apart."""
    told: list[str] = []
    for digits in range(least, 18):
        told = ["none" if np.isnan(value) else shown(value, digits).rstrip() for value in values.tolist()]
        if len(set(told)) == len(np.unique(values)):
            break
    return told


def _words(values: list[Any]) -> dict[str, str]:
    """What values that are no numbers are called, by their text: mappings by their name, or by what only they have."""
    given = {as_text(value) or "": value for value in values}
    mappings = [value for value in given.values() if isinstance(value, dict)]
    names = [value.get("name") if isinstance(value, dict) else value for value in given.values()]
    called = {}
    for text, value in given.items():
        called[text] = text or "none"
        if isinstance(value, dict):
            own = {
                key: one for key, one in value.items() if len(mappings) == 1 or any(m.get(key) != one for m in mappings)
            }
            name = value.get("name")
            parts = ", ".join(f"{key} {one}" for key, one in own.items())
            called[text] = name if isinstance(name, str) and names.count(name) == 1 else parts
    if len(set(called.values())) < len(called):
        return {text: text or "none" for text in given}
    short = {text: word if len(word) <= _LETTERS else f"{word[: _LETTERS - 3]}..." for text, word in called.items()}
    return short if len(set(short.values())) == len(short) else called
