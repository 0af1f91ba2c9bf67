"""A picture of a sweep: which of its axes are drawn, and what belongs beside them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import frozen

from shockwave.errors import InvalidValueError, UnknownNameError
from shockwave.pictures.canvas import figure
from shockwave.pictures.style import COLOURS, SMALL
from shockwave.pictures.sweep import Line, sweep_lines, sweep_map
from shockwave.sweep.journal_reader import NOT_RUN
from shockwave.sweep.regimes import regimes
from shockwave.sweep.results import SweepResults
from shockwave.sweep.selection import Chosen, Selection
from shockwave.text import si

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_FIRST = ("amplification", "predicted_amplification")
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
    InvalidValueError
        When the column is text.
    UsageError
        When there are more than two axes left, or none; when no point has the values that are held; when points of a
        map would share a place or lie in no order; or when matplotlib is not installed.
    """
    made = Selection(results, at or {})
    name = _column(results, column)
    across = made.axis_of(x)
    made.check()
    rest = [place for place in made.free if place != across]
    horizontal = made.along(across, x)
    if not rest or len(made.positions[rest[0]]) <= min(len(COLOURS) - 1, len(horizontal.values)):
        sheet, (ax,) = figure(size=(5.0, 3.2))
        vertical = made.along(rest[0]) if rest else None
        indices = made.indices(across, horizontal, *((rest[0], vertical) if vertical else ()))
        told = _lines(ax, results, horizontal, made.labels(rest[0], vertical) if vertical else [], indices, name)
        caption = made.caption(horizontal)
    else:
        vertical = made.along(rest[0])
        made.check_map(horizontal, vertical)
        sheet, (ax,) = figure(size=(5.0, 3.6))
        indices = made.indices(across, horizontal, rest[0], vertical)
        told = _map(ax, results, horizontal, vertical, indices, name)
        caption = made.caption(horizontal, vertical)
    if caption:
        sheet.suptitle(caption, fontsize=SMALL, parse_math=False)
    return Plot(sheet, name, (_trust(results, name, indices), told, *_missing(results, indices)))


def _map(ax: Any, results: SweepResults, horizontal: Chosen, vertical: Chosen, indices: Any, name: str) -> str:
    """Draw a map; a sentence on the borders."""
    values = results.values(name).ravel()[indices]
    low, _, _ = _band(results, name, values, indices)
    found, told = regimes(results, indices.ravel())
    inside = {regime: numbers.reshape(indices.shape) for regime, numbers in found.items()}
    unknown = None if low is None else np.isnan(low)
    label, unit = name.replace("_", " "), results.units[name] or ""
    sweep_map(ax, horizontal.along, vertical.along, values, label, unit, inside, unknown)
    return told


def _lines(ax: Any, results: SweepResults, horizontal: Chosen, labels: list[str], indices: Any, name: str) -> str:
    """Draw a line, or one for each of ``labels``; a sentence on the borders."""
    values = results.values(name).ravel()[indices]
    low, high, band = _band(results, name, values, indices)
    if labels:
        lower, upper = ([None] * len(labels) if one is None else one.T for one in (low, high))
        lines = [Line(values[:, at], label, lower[at], upper[at], band) for at, label in enumerate(labels)]
        told = "no borders of regimes: they differ from line to line"
    else:
        found, told = regimes(results, indices)
        lines = [Line(values, "", low, high, band, regimes=found)]
        if not horizontal.along.apart:
            told = f"no borders of regimes: points share a value of {horizontal.name}"
        elif not (horizontal.along.joined or horizontal.along.texts):
            told = f"no line and no borders of regimes: {', '.join(horizontal.others)} goes up and down between points"
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
        told = f"{name}: {meaning}"
        if "known" in meaning and "error_estimate" in {column.name for column in results.columns}:
            errors = results.values("error_estimate").ravel()[indices]
            found = errors[np.isfinite(errors)]
            return f"{told}; error_estimate is " + (f"{found.max():.1e} at most" if found.size else "not known")
        return told + ("" if name in _EXACT or "error" in name else "; its error is not known")
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
    if name in {column.name for column in results.columns} - {*numbers}:
        known = ", ".join(numbers)
        raise InvalidValueError.of("column", f"must be a column of numbers (got {name}, which is text; known: {known})")
    if name not in numbers:
        raise UnknownNameError("column of numbers", name, numbers)
    return name
