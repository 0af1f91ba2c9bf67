"""A picture of a sweep: which of its axes are drawn, and what belongs beside them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.document.units import to_si
from shockwave.errors import UnknownNameError, UsageError
from shockwave.pictures.canvas import figure
from shockwave.pictures.style import COLOURS, thousandths
from shockwave.pictures.sweep import Along, Line, sweep_lines, sweep_map
from shockwave.sweep.regimes import regimes
from shockwave.sweep.results import SweepResults
from shockwave.sweep.stored import NOT_RUN, as_text
from shockwave.text import si

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Plot", "plot"]

_FIRST = ("amplification", "predicted_amplification")
# Longer names leave the picture.
_LETTERS = 30
# Six digits of a value are enough to name it.
_CLOSE = 1e-5
# The error of a simulated quantity: relative, but of momentum.
_ERRORS = {
    "peak_force": "error_estimate",
    "amplification": "error_estimate",
    "second_peak_force": "second_error_estimate",
    "recoil_momentum": "recoil_error",
}
_ABSOLUTE = "recoil_error"
_EXACT = ("scaled_rise_time", "scaled_duration", "applied_momentum")


@frozen(eq=False)
class Plot:
    """A picture of a sweep.

    Attributes
    ----------
    figure : Figure
        What was drawn.
    column : str
        The quantity.
    notes : tuple of str
        How far to trust it, and what is missing.
    """

    figure: Figure
    column: str
    notes: tuple[str, ...]


def plot(
    results: SweepResults, column: str | None = None, x: str | None = None, at: Mapping[str, Any] | None = None
) -> Plot:
    """Draw a quantity over one axis or two of a sweep, with the borders of the regimes.

    One axis gives a line; a second one of a few values a line for each; otherwise two axes give a map.

    Parameters
    ----------
    results : SweepResults
        The sweep.
    column : str, optional
        The quantity; left out, the amplification.
    x : str, optional
        The variable from left to right; left out, that of the axis with the most values, of which the one that takes
        the most.
    at : mapping of str to number or str, optional
        Variables that are held, and at which of their values: points with other values are left out.

    Raises
    ------
    UnknownNameError
        When there is no such column or variable.
    UsageError
        When there are more than two axes left, or none; when no point has the values that are held; when points of a
        map would share a place; or when matplotlib is not installed.
    """
    made = _Selection(results, at or {})
    name = _column(results, column)
    across = made.axis_of(x)
    made.check()
    rest = [place for place in made.free if place != across]
    unit = results.units[name] or ""
    label = name.replace("_", " ")
    horizontal = made.along(across, x)
    if not rest or len(made.positions[rest[0]]) <= min(len(COLOURS) - 1, len(horizontal.values)):
        sheet, (ax,) = figure(size=(5.0, 3.2))
        vertical = made.along(rest[0]) if rest else None
        indices = made.indices(across, horizontal, *((rest[0], vertical) if vertical else ()))
        told = _lines(ax, results, horizontal, made.labels(rest[0], vertical) if vertical else [], indices, name)
    else:
        vertical = made.along(rest[0])
        made.check_apart(horizontal, vertical)
        sheet, (ax,) = figure(size=(5.0, 3.6))
        indices = made.indices(across, horizontal, rest[0], vertical)
        values = results.values(name).ravel()[indices]
        found, told = regimes(results, indices.ravel())
        inside = {regime: numbers.reshape(indices.shape) for regime, numbers in found.items()}
        sweep_map(ax, horizontal.along, vertical.along, values, label, unit, inside)
    return Plot(sheet, name, (_trust(results, name, indices), told, *_missing(results, indices)))


@frozen(eq=False)
class _Chosen:
    """An axis as it is drawn, by which variable, and the positions of the sweep's axis in that order."""

    name: str
    along: Along
    order: npt.NDArray[np.intp]

    @property
    def values(self) -> npt.NDArray[Any]:
        return self.along.values


class _Selection:
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
            found = values == ("" if nothing else as_text(value))
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
            given = [str(text) for text in values]
            if unit is not None:
                given = _shown(values, unit, lambda number, digits: f"{number:.{digits}g} {unit}", 6)
            told = list(dict.fromkeys(given))
            more = ", ..." if len(told) > 20 else ""
            got = f"got {value}; they are {', '.join(told[:20])}{more}"
            among = (
                "in the sweep" if len(values) == len(self.results.coordinate(name)) else "at the points that are left"
            )
            raise UsageError(f"{name}: must be one of its values {among} ({got})")
        return np.asarray(found)

    def check(self) -> None:
        names = [self._name(place) for place in self.free]
        if not names:
            raise UsageError(
                "one axis or two can be drawn (got one point; read it in results.csv, or leave out an --at)"
            )
        if len(names) > 2:
            got = f"got {', '.join(names)}; hold the others by --at {names[0]}=VALUE"
            raise UsageError(f"one axis or two can be drawn ({got})")

    def check_apart(self, *chosen: _Chosen) -> None:
        for one in chosen:
            if not one.along.apart:
                remedy = "hold a variable that goes with it by --at NAME=VALUE, or choose one by --x"
                got = f"got {one.name}, which repeats a value; {remedy}"
                raise UsageError(f"points of a map must have a place each ({got})")

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

    def _name(self, place: int) -> str:
        """The variable of an axis that takes the most values, of several the first."""
        return max(self.results.axes[place].names, key=self._count)

    def along(self, place: int, name: str | None = None) -> _Chosen:
        """The axis at ``place``, by one of its variables."""
        name, here = name or self._name(place), self.positions[place]
        unit, values = self.results.units[name], self.results.coordinate(name)[here]
        label = name.rpartition(".")[2].replace("_", " ")
        if unit is None or np.isnan(values).any():
            texts = _shown(values, unit, lambda value, digits: f"{value:.{digits}g}", 6)
            return _Chosen(name, Along(np.array(texts), label), here)
        order = np.argsort(values, kind="stable")
        return _Chosen(name, Along(values[order], label, unit), here[order])

    def labels(self, place: int, chosen: _Chosen) -> list[str]:
        """What lines for the positions of an axis are called: by one variable if that tells them apart."""
        names = [chosen.name]
        if self._count(chosen.name) < len(chosen.order):
            names = [name for name in self.results.axes[place].names if self._count(name) > 1]
        told = []
        for name in names:
            unit, label = self.results.units[name], name.rpartition(".")[2].replace("_", " ")
            shown = _shown(self.results.coordinate(name)[chosen.order], unit, _labelled(unit or ""), 3)
            told.append([f"{label} {one}" for one in shown])
        return [", ".join(parts) for parts in zip(*told, strict=True)]

    def indices(self, across: int, horizontal: _Chosen, up: int | None = None, vertical: _Chosen | None = None) -> Any:
        """Numbers of the points, of shape (horizontal,) or (horizontal, vertical)."""
        chosen: list[Any] = [here[0] for here in self.positions]
        if up is None or vertical is None:
            chosen[across] = horizontal.order
        else:
            chosen[across], chosen[up] = horizontal.order[:, None], vertical.order[None, :]
        return np.ravel_multi_index(tuple(np.broadcast_arrays(*chosen)), self.results.shape)


def _labelled(unit: str) -> Callable[[float, int], str]:
    return lambda value, digits: thousandths(value, unit, digits) if unit else f"{value:.{digits}g}"


def _shown(values: npt.NDArray[Any], unit: str | None, shown: Callable[[float, int], str], least: int) -> list[str]:
    """Values as text, ``least`` digits of numbers or as many as tell them apart."""
    if unit is None:
        texts = [str(value) or "none" for value in values]
        short = [text if len(text) <= _LETTERS else f"{text[: _LETTERS - 3]}..." for text in texts]
        return short if len(set(short)) == len(set(texts)) else texts
    told: list[str] = []
    for digits in range(least, 18):
        told = ["none" if np.isnan(value) else shown(value, digits).rstrip() for value in values.tolist()]
        if len(set(told)) == len(np.unique(values)):
            break
    return told


def _lines(ax: Any, results: SweepResults, horizontal: _Chosen, labels: list[str], indices: Any, name: str) -> str:
    """Draw a line, or one for each of ``labels``; a sentence on the borders."""
    values = results.values(name).ravel()[indices]
    if labels:
        lines = [Line(values[:, at], label) for at, label in enumerate(labels)]
        told = "no borders of regimes: they differ from line to line"
    else:
        found, told = regimes(results, indices)
        lines = [Line(values, "", *_band(results, name, values, indices), regimes=found)]
        if not horizontal.along.apart:
            told = f"no borders of regimes: points share a value of {horizontal.name}"
    sweep_lines(ax, horizontal.along, lines, name.replace("_", " "), results.units[name] or "")
    return told


def _bounds(results: SweepResults, name: str) -> tuple[str, ...]:
    """The columns that tell how far a quantity is to be trusted: of its error, or of the range that is expected."""
    prefix = "predicted_" if name.startswith("predicted_") else ""
    known = {column.name for column in results.columns}
    if _ERRORS.get(name) in known:
        return (_ERRORS[name],)
    expected = f"{prefix}expected_error_low", f"{prefix}expected_error_high"
    peak = name.removeprefix(prefix) in ("peak_force", "amplification")
    return expected if peak and known.issuperset(expected) else ()


def _band(results: SweepResults, name: str, values: Any, indices: Any) -> tuple[Any, Any, str]:
    columns = _bounds(results, name)
    bounds = [results.values(column).ravel()[indices] for column in columns]
    if len(bounds) == 2:
        low, high = bounds
        # an error of -100 % leaves the greatest open: beyond any picture
        return values / (1 + high), values / np.maximum(1 + low, 1e-3), "expected of a simulation"
    if bounds:
        error = bounds[0] * (1 if columns[0] == _ABSOLUTE else np.abs(values))
        return values - error, values + error, "error estimate"
    return None, None, ""


def _trust(results: SweepResults, name: str, indices: Any) -> str:
    """How far to trust what is drawn."""
    columns = _bounds(results, name)
    bounds = [results.values(column).ravel()[indices] for column in columns]
    known = [values[np.isfinite(values)] for values in bounds]
    if not bounds:
        meaning = next(column.meaning for column in results.columns if column.name == name)
        told = name in _EXACT or "error" in name or "known" in meaning
        return f"{name}: {meaning}" + ("" if told else "; its error is not known")
    if not known[0].size:
        return f"{name}: its error is not known"
    share = f"; known at {known[0].size / indices.size:.0%} of the points"
    if len(known) == 2:
        low, high = float(known[0].min()), float(known[1].max())
        return f"{name}: predicted, expected to err by {low:+.1%} to {high:+.1%}{share}"
    most = float(known[0].max())
    error = si(most, results.units[name] or "", 2) if columns[0] == _ABSOLUTE else f"{most:.1e} relative"
    return f"{name}: simulated, known to {error} or better"


def _missing(results: SweepResults, indices: Any) -> list[str]:
    drawn = results.values("status").ravel()[indices]
    failed = int(np.count_nonzero((drawn != "done") & (drawn != NOT_RUN)))
    return ([f"{failed} of the {drawn.size} points drawn failed"] if failed else []) + list(results.warnings)


def _column(results: SweepResults, name: str | None) -> str:
    numbers = [column.name for column in results.columns if column.kind != "text"]
    if name is None:
        return next((one for one in _FIRST if one in numbers), numbers[0])
    if name not in numbers:
        raise UnknownNameError("column of numbers", name, numbers)
    return name
