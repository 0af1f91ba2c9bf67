"""A picture of a sweep: the quantity, lines or a map, its errors and the borders of the regimes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.errors import UnknownNameError, UsageError
from shockwave.pictures.drawing import COLOURS
from shockwave.pictures.figures import SMALL, figure
from shockwave.pictures.sweep import Line, sweep_lines, sweep_map
from shockwave.sweep.journal import NOT_RUN
from shockwave.sweep.plotted_axes import PlottedAxes, label_of
from shockwave.sweep.results import SweepResults
from shockwave.text import si

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_FIRST = ("amplification", "predicted_amplification")
_REGIMES = ("regime", "predicted_regime")
# The error of a simulated quantity: relative, but of momentum.
_ERRORS = {
    "peak_force": "error_estimate",
    "amplification": "error_estimate",
    "second_peak_force": "second_error_estimate",
    "recoil_momentum": "recoil_error",
}


@frozen(eq=False)
class Plot:
    """A picture of a sweep.

    Attributes
    ----------
    figure : Figure
        The drawn figure.
    column : str
        The quantity.
    notes : tuple of str
        How accurate it is, and what is missing.
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
        When there is no such column of numbers, or no such variable.
    UsageError
        When there are more than two axes left, or none; when no point has the values that are held; when points of a
        map would share a place; or when matplotlib is not installed.
    """
    numbers = [one.name for one in results.columns if one.kind != "text"]
    name = column or next((one for one in _FIRST if one in numbers), numbers[0])
    if name not in numbers:
        raise UnknownNameError("column of numbers", name, numbers)
    chosen = PlottedAxes(results, at or {}, x)
    values = chosen.pick(name)
    bounds = _bounds(chosen, name, values)
    quantity = label_of(name), results.units[name] or ""
    regime = next((one.name for one in results.columns if one.name in _REGIMES), None)
    regimes = chosen.pick(regime) if regime else None
    across, *up = [axis.drawn for axis in chosen.axes]
    if not up or len(up[0].places) <= min(len(COLOURS) - 1, len(across.places)):
        sheet, (ax,) = figure(size=(5.0, 3.2))
        columns = (array.reshape(len(values), -1).T for array in (values, bounds.low, bounds.high))
        lines = [Line(*line) for line in zip(chosen.labels(), *columns, strict=True)]
        sweep_lines(ax, across, lines, quantity, bounds.name, None if up or not across.joined else regimes)
    else:
        _check_places(chosen)
        sheet, (ax,) = figure(size=(5.0, 3.6))
        sweep_map(ax, across, up[0], values, quantity, regimes)
    if caption := chosen.caption():
        sheet.suptitle(caption, fontsize=SMALL, parse_math=False)
    status = chosen.pick("status")
    failed = int(np.count_nonzero((status != "done") & (status != NOT_RUN)))
    missing = [f"{failed} of the {status.size} points drawn failed"] if failed else []
    return Plot(sheet, name, (bounds.note, *missing, *results.warnings))


def _check_places(chosen: PlottedAxes) -> None:
    for axis in chosen.axes:
        if (np.diff(axis.drawn.places) <= 0).any():
            remedy = "hold a variable of the same axis by --at NAME=VALUE, or choose one by --x"
            got = f"got {axis.name}, which repeats a value; {remedy}"
            raise UsageError(f"points of a map must have a place each ({got})")


class _Bounds(NamedTuple):
    """Bounds of the true values, not a number where they are not known; their name, and a sentence on them."""

    low: npt.NDArray[np.float64]
    high: npt.NDArray[np.float64]
    name: str
    note: str


def _bounds(chosen: PlottedAxes, name: str, values: npt.NDArray[np.float64]) -> _Bounds:
    results = chosen.results
    columns = {column.name: column for column in results.columns}
    column = _ERRORS.get(name)
    if not np.isfinite(values).any():
        nothing = np.full(values.shape, np.nan)
        return _Bounds(nothing, nothing, "", f"{name}: no point drawn has a value")
    if column in columns:
        error = chosen.pick(column)
        unit = results.units[column]
        most = np.nanmax(error, initial=0.0)
        text = si(most, unit, 2) if unit else f"{most:.1e} relative"
        band = error if unit else error * np.abs(values)
        note = f"{name}: simulated, accurate to {text} or better"
        return _Bounds(values - band, values + band, "error estimate", note)
    note = f"{name}: {columns[name].meaning}"
    low = high = np.full(values.shape, np.nan)
    prefix = "predicted_" if name.startswith("predicted_") else ""
    sides = [f"{prefix}expected_error_{side}" for side in ("low", "high")]
    if name.removeprefix(prefix) in ("peak_force", "amplification") and columns.keys() >= {*sides}:
        note += "; its error is not known"
        low, high = (chosen.pick(side) for side in sides)
        if np.isfinite(low).any():
            share = np.isfinite(low).mean()
            span = f"{np.nanmin(low):+.1%} to {np.nanmax(high):+.1%}"
            note = f"{name}: predicted, expected error {span}, known at {share:.0%} of the points"
    # an error of -100 % leaves the greatest open: beyond any picture
    return _Bounds(values / (1 + high), values / np.maximum(1 + low, 1e-3), "expected of a simulation", note)
