"""A picture of a sweep: which of its axes are drawn, and what belongs beside them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.errors import InvalidValueError, UnknownNameError
from shockwave.pictures.canvas import figure
from shockwave.pictures.style import COLOURS, SMALL
from shockwave.pictures.sweep import Line, sweep_lines, sweep_map
from shockwave.sweep.journal import NOT_RUN
from shockwave.sweep.regimes import regimes
from shockwave.sweep.results import SweepResults
from shockwave.sweep.selection import Selection
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
    name = _column(results, column)
    made = Selection(results, at or {})
    horizontal, vertical = made.axes(x)
    points = made.points(horizontal, vertical)
    values = results.values(name).ravel()[points]
    trust = _trust(results, name, values, points)
    label, unit = name.replace("_", " "), results.units[name] or ""
    drawn = [horizontal]
    if vertical is None or len(vertical.order) <= min(len(COLOURS) - 1, len(horizontal.order)):
        sheet, (ax,) = figure(size=(5.0, 3.2))
        labels = made.labels(vertical) if vertical else [""]
        parts = (values, trust.low, trust.high)
        columns = (np.full(values.shape, None) if part is None else part for part in parts)
        bounds = zip(labels, *(column.reshape(len(values), -1).T for column in columns), strict=True)
        known = trust.low is not None
        lines = [Line(own, text, *((low, high) if known else ())) for text, own, low, high in bounds]
        borders: dict[str, npt.NDArray[np.float64]] = {}
        if vertical:
            told = "no borders of regimes: they differ from line to line"
        elif not horizontal.along.apart:
            told = f"no borders of regimes: points share a value of {horizontal.name}"
        elif not (horizontal.along.joined or horizontal.along.texts):
            told = f"no line and no borders of regimes: {', '.join(horizontal.others)} goes up and down between points"
        else:
            borders, told = regimes(results, points)
        sweep_lines(ax, horizontal.along, lines, label, unit, trust.band, borders if horizontal.along.line else None)
    else:
        made.check_map(horizontal, vertical)
        drawn.append(vertical)
        sheet, (ax,) = figure(size=(5.0, 3.6))
        flat, told = regimes(results, points.ravel())
        borders = {regime: numbers.reshape(points.shape) for regime, numbers in flat.items()}
        unknown = None if trust.low is None else np.isnan(trust.low)
        sweep_map(ax, horizontal.along, vertical.along, values, label, unit, borders, unknown)
    if caption := made.caption(drawn):
        sheet.suptitle(caption, fontsize=SMALL, parse_math=False)
    status = results.values("status").ravel()[points]
    failed = int(np.count_nonzero((status != "done") & (status != NOT_RUN)))
    missing = [f"{failed} of the {status.size} points drawn failed"] if failed else []
    return Plot(sheet, name, (trust.note, told, *missing, *results.warnings))


class _Trust(NamedTuple):
    """How far to trust what is drawn: a sentence, bounds of the true values, and what the bounds are called."""

    note: str
    low: npt.NDArray[np.float64] | None = None
    high: npt.NDArray[np.float64] | None = None
    band: str = ""


def _trust(results: SweepResults, name: str, values: npt.NDArray[np.float64], points: npt.NDArray[np.intp]) -> _Trust:
    known = {column.name: column for column in results.columns}
    column = _ERRORS.get(name)
    if column in known:
        error = results.values(column).ravel()[points]
        unit = results.units[column]
        most = np.nanmax(error, initial=0.0)
        text = si(most, unit, 2) if unit else f"{most:.1e} relative"
        note = f"{name}: simulated, known to {text} or better"
        if np.isnan(error).all():
            note = f"{name}: its error is not known"
        band = error if unit else error * np.abs(values)
        return _Trust(note, values - band, values + band, "error estimate")
    prefix = "predicted_" if name.startswith("predicted_") else ""
    sides = [f"{prefix}expected_error_{side}" for side in ("low", "high")]
    if name.removeprefix(prefix) in ("peak_force", "amplification") and known.keys() >= {*sides}:
        low, high = (results.values(side).ravel()[points] for side in sides)
        note = f"{name}: its error is not known"
        if np.isfinite(low).any():
            share = np.isfinite(low).mean()
            span = f"{np.nanmin(low):+.1%} to {np.nanmax(high):+.1%}"
            note = f"{name}: predicted, expected to err by {span}; known at {share:.0%} of the points"
        # an error of -100 % leaves the greatest open: beyond any picture
        return _Trust(note, values / (1 + high), values / np.maximum(1 + low, 1e-3), "expected of a simulation")
    meaning = known[name].meaning
    stated = name in _EXACT or "error" in name or "known" in meaning
    return _Trust(f"{name}: {meaning}" + ("" if stated else "; its error is not known"))


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
