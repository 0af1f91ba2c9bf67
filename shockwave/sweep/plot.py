"""A picture of a sweep: which of its axes are drawn, and what belongs beside them."""

from __future__ import annotations

from collections.abc import Mapping
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

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Plot", "plot"]

_FIRST = ("amplification", "predicted_amplification")
_CLOSE = 1e-6


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
        The variable from left to right; left out, that of the axis with the most values, of which the first.
    at : mapping of str to number or str, optional
        Variables that are held, and at which of their values.

    Raises
    ------
    UnknownNameError
        When there is no such column or variable.
    UsageError
        When there are more than two axes left, or none, or matplotlib is not installed.
    """
    made = _Selection(results, at or {})
    name = _column(results, column)
    across = made.axis_of(x)
    made.check()
    rest = [place for place in made.free if place != across]
    unit = results.units[name] or ""
    label = name.replace("_", " ")
    horizontal = made.along(across, x)
    if not rest or len(results.axes[rest[0]]) <= min(len(COLOURS) - 1, len(horizontal.values)):
        sheet, (ax,) = figure(size=(5.0, 3.2))
        told = _lines(ax, results, made, across, horizontal, name)
    else:
        vertical = made.along(rest[0])
        sheet, (ax,) = figure(size=(5.0, 3.6))
        indices = made.indices(across, horizontal, rest[0], vertical)
        values = results.values(name).ravel()[indices]
        found, told = regimes(results, indices.ravel())
        inside = {regime: numbers.reshape(indices.shape) for regime, numbers in found.items()}
        sweep_map(ax, horizontal.along, vertical.along, values, label, unit, inside)
    return Plot(sheet, name, (*_trust(results, name), told, *_missing(results)))


@frozen(eq=False)
class _Chosen:
    """An axis as it is drawn, and the positions of the sweep's axis in that order."""

    along: Along
    order: npt.NDArray[np.intp]

    @property
    def values(self) -> npt.NDArray[Any]:
        return self.along.values


class _Selection:
    """Which positions of the axes are drawn."""

    def __init__(self, results: SweepResults, at: Mapping[str, Any]) -> None:
        self.results = results
        self.held = dict(self._held(name, value) for name, value in at.items())
        places = [place for place in range(len(results.axes)) if place not in self.held]
        self.free = [place for place in places if len(results.axes[place]) > 1]
        self.held |= {place: 0 for place in places if place not in self.free}

    def place_of(self, name: str) -> int:
        for place, axis in enumerate(self.results.axes):
            if name in axis.names:
                return place
        raise UnknownNameError("variable of the sweep", name, [n for axis in self.results.axes for n in axis.names])

    def _held(self, name: str, value: Any) -> tuple[int, int]:
        place, unit = self.place_of(name), self.results.units[name]
        values = self.results.coordinate(name)
        if unit is None:
            found = np.flatnonzero(values == str(value))
        else:
            try:
                number = to_si(value, unit)
            except ValueError as error:
                raise UsageError(f"{name}: {error}") from None
            found = np.flatnonzero(np.abs(values - number) <= _CLOSE * abs(number))
        if not found.size:
            told = ", ".join(f"{one:g}" if unit is not None else str(one) for one in values[:20].tolist())
            more = ", ..." if len(values) > 20 else ""
            raise UsageError(f"{name}: must be one of its values in the sweep (got {value}; they are {told}{more})")
        return place, int(found[0])

    def check(self) -> None:
        names = [self.results.axes[place].names[0] for place in self.free]
        if not 1 <= len(names) <= 2:
            got = ", ".join(names) or "none"
            raise UsageError(
                f"one axis or two can be drawn (got {got}; hold the others by --at {(names or ['NAME'])[0]}=VALUE)"
            )

    def axis_of(self, x: str | None) -> int:
        if x is None:
            return max(self.free, key=lambda place: len(self.results.axes[place]), default=0)
        place = self.place_of(x)
        if place not in self.free:
            raise UsageError(f"{x} has one value: it cannot be drawn over it (choose another by --x)")
        return place

    def along(self, place: int, name: str | None = None) -> _Chosen:
        """The axis at ``place``, by one of its variables."""
        name = name or self.results.axes[place].names[0]
        unit, values = self.results.units[name], self.results.coordinate(name)
        label = name.rpartition(".")[2].replace("_", " ")
        if unit is None or np.isnan(values).any():
            texts = [str(value) if unit is None else "none" if np.isnan(value) else f"{value:g}" for value in values]
            return _Chosen(Along(np.array(texts), label), np.arange(len(values)))
        ordered, order = np.unique(values, return_index=True)
        return _Chosen(Along(ordered, label, unit), order)

    def indices(self, across: int, horizontal: _Chosen, up: int | None = None, vertical: _Chosen | None = None) -> Any:
        """Numbers of the points, of shape (horizontal,) or (horizontal, vertical)."""
        chosen: list[Any] = [self.held.get(place, 0) for place in range(len(self.results.axes))]
        if up is None or vertical is None:
            chosen[across] = horizontal.order
        else:
            chosen[across], chosen[up] = horizontal.order[:, None], vertical.order[None, :]
        return np.ravel_multi_index(tuple(np.broadcast_arrays(*chosen)), self.results.shape)


def _lines(ax: Any, results: SweepResults, made: _Selection, across: int, horizontal: _Chosen, name: str) -> str:
    """Draw a line, or one for each value of the other axis; a sentence on the borders."""
    others = [place for place in made.free if place != across]
    lines, told = [], ""
    if others:
        vertical = made.along(others[0])
        indices = made.indices(across, horizontal, others[0], vertical)
        unit = vertical.along.unit
        for at, value in enumerate(vertical.values.tolist()):
            shown = value if isinstance(value, str) else thousandths(value, unit) if unit else f"{value:.4g}"
            label = shown if isinstance(value, str) else f"{vertical.along.name} {shown}"
            lines.append(Line(results.values(name).ravel()[indices[:, at]], label))
        told = "no borders of regimes: they differ from line to line"
    else:
        indices = made.indices(across, horizontal)
        found, told = regimes(results, indices)
        values = results.values(name).ravel()[indices]
        lines.append(Line(values, "", *_band(results, name, values, indices), regimes=found))
    sweep_lines(ax, horizontal.along, lines, name.replace("_", " "), results.units[name] or "")
    return told


def _bounds(results: SweepResults, name: str) -> tuple[str, ...]:
    """The columns that tell how far a peak force or an amplification is to be trusted."""
    prefix = "predicted_" if name.startswith("predicted_") else ""
    if name.removeprefix(prefix) not in ("peak_force", "amplification"):
        return ()
    expected = f"{prefix}expected_error_low", f"{prefix}expected_error_high"
    known = {column.name for column in results.columns}
    found = (
        bounds for bounds in (() if prefix else ("error_estimate",), expected) if bounds and known.issuperset(bounds)
    )
    return next(found, ())


def _band(results: SweepResults, name: str, values: Any, indices: Any) -> tuple[Any, Any, str]:
    bounds = [results.values(column).ravel()[indices] for column in _bounds(results, name)]
    if len(bounds) == 2:
        low, high = bounds
        # an error of -100 % leaves the greatest open: beyond any picture
        return values / (1 + high), values / np.maximum(1 + low, 1e-3), "expected of a simulation"
    if bounds:
        return values * (1 - bounds[0]), values * (1 + bounds[0]), "error estimate"
    return None, None, ""


def _trust(results: SweepResults, name: str) -> list[str]:
    bounds = [results.values(column) for column in _bounds(results, name)]
    known = [values[np.isfinite(values)] for values in bounds]
    if not bounds:
        meanings = {column.name: column.meaning for column in results.columns}
        return [f"{name}: {meanings[name]}"]
    if not known[0].size:
        return [f"{name}: its error is not known"]
    if len(known) == 1:
        return [f"{name}: simulated, known to {float(known[0].max()):.1e} relative or better"]
    share = known[0].size / bounds[0].size
    low, high = float(known[0].min()), float(known[1].max())
    return [f"{name}: predicted, expected to err by {low:+.1%} to {high:+.1%}; known at {share:.0%} of the points"]


def _missing(results: SweepResults) -> list[str]:
    failed = len(results.failed)
    return ([f"{failed} of {results.values('status').size} points failed"] if failed else []) + list(results.warnings)


def _column(results: SweepResults, name: str | None) -> str:
    numbers = [column.name for column in results.columns if column.kind != "text"]
    if name is None:
        return next((one for one in _FIRST if one in numbers), numbers[0])
    if name not in numbers:
        raise UnknownNameError("column of numbers", name, numbers)
    return name
