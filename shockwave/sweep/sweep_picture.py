"""Picture of a sweep: lines or a map of a quantity, with the borders of the regimes."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import frozen

from shockwave.base.errors import UnknownNameError, UsageError
from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import COLOURS, literal, mark
from shockwave.pictures.sweep import sweep_lines, sweep_map
from shockwave.sweep.column_errors import accuracy_of, main_quantity
from shockwave.sweep.definition import NOTES, warnings_in
from shockwave.sweep.journal import NOT_RUN
from shockwave.sweep.plotted_axes import PlottedAxes, label_of
from shockwave.sweep.results import SweepResults

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@frozen(eq=False)
class Plot:
    """A picture of a sweep.

    Attributes
    ----------
    ax : Axes
        The axes.
    column : str
        The quantity that is drawn.
    notes : tuple of str
        The accuracy of the quantity; points without a value; warnings of the sweep.
    """

    ax: Axes
    column: str
    notes: tuple[str, ...]


def draw_sweep(results: SweepResults, *, ax: Axes | None = None) -> Axes:
    """Draw the main quantity of a sweep."""
    return plot(results, ax=ax).ax


def plot(
    results: SweepResults,
    column: str | None = None,
    x: str | None = None,
    at: Mapping[str, Any] | None = None,
    *,
    ax: Axes | None = None,
) -> Plot:
    """Draw a quantity over one or two axes of a sweep.

    One axis gives a line. A second axis of a few values gives a line for each of them; otherwise two axes give a map
    with the borders of the regimes.

    Parameters
    ----------
    results : SweepResults
        The sweep.
    column : str, optional
        Name of the column, or of its quantity in the scenario; default: the amplification.
    x : str, optional
        Variable of the abscissa; default: of the axis with the most values, the variable with the most values.
    at : mapping of str to number or str, optional
        Fixed values of variables; points with other values are left out.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.

    Raises
    ------
    UnknownNameError
        If there is no such numeric column, or no such variable.
    UsageError
        If no axis or more than two axes remain, if no point has the fixed values, if points of a map coincide, or if
        matplotlib is not installed.
    """
    numeric = [each for each in results.columns if each.kind != "text"]
    numbers = [each.name for each in numeric]
    by_name = {each.quantity: each.name for each in numeric} | {name: name for name in numbers}
    if column is not None and (column := by_name.get(re.sub(r"\s*/\s*", " / ", column), column)) not in numbers:
        raise UnknownNameError.of("numeric column", column, numbers)
    axes = PlottedAxes(results, at or {}, x)
    drawable = [each for each in numbers if np.isfinite(axes.pick(each)).any()]
    name = column or main_quantity(drawable or numbers)
    ax = _draw(axes, name, ax)
    if caption := axes.caption():
        ax.set_xlabel(f"{ax.get_xlabel()}\n{literal(caption)}")
    status = axes.pick("status")
    failed = int(np.count_nonzero((status != "done") & (status != NOT_RUN)))
    missing = [f"{failed} of the {status.size} drawn points failed"] if failed else []
    warned = sum(map(bool, map(warnings_in, axes.pick(NOTES).flat))) if NOTES in results.units else 0
    if warned:
        with canvas(ax, legend=False):
            mark(ax, f"! {warned} of {status.size} points with warnings")
    accuracy = accuracy_of(name, results.units, axes.pick)
    sentence = accuracy.sentence or next(each.meaning for each in results.columns if each.name == name)
    return Plot(ax, name, (f"{name}: {sentence}", *missing, *results.warnings))


def _draw(axes: PlottedAxes, name: str, ax: Axes | None) -> Axes:
    """Draw lines or a map of the column ``name``."""
    results, values = axes.results, axes.pick(name)
    quantity = label_of(name), results.units[name] or ""
    across, *up = [axis.drawn for axis in axes.axes]
    if not up or len(up[0].places) <= min(len(COLOURS) - 1, len(across.places)):
        lines = zip(axes.labels(), values.reshape(len(values), -1).T, strict=True)
        return sweep_lines(across, list(lines), quantity, ax)
    for axis in axes.axes:
        if (np.diff(axis.drawn.places) <= 0).any():
            remedy = "fix another variable of that axis with --at NAME=VALUE, or choose another with --x"
            got = f"got {axis.name}, which repeats a value; {remedy}"
            raise UsageError(f"points of a map must have different coordinates ({got})")
    regimes = axes.pick("section4_regime") if "section4_regime" in results.units else None
    return sweep_map(across, up[0], values, quantity, regimes, ax)
