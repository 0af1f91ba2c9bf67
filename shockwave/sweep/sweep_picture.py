"""Picture of a sweep: lines or a map of a quantity, with the borders of the regimes."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.base.errors import UnknownNameError, UsageError
from shockwave.base.numerics import FloatArray
from shockwave.base.units import to_si
from shockwave.pictures import picture_elements as elements
from shockwave.pictures.colour_maps import colour_cells, colours_of, edges_of, regime_borders
from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import COLOURS, Axes, literal, si_label
from shockwave.scenario.dotted_names import name_in_words
from shockwave.sweep.definition import NOTES, warnings_in
from shockwave.sweep.journal import NOT_RUN
from shockwave.sweep.results import SweepResults, accuracy_of, main_quantity


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
        The accuracy of the quantity; points without a value; warnings of the drawn points.
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
            elements.mark(ax, f"! {warned} of {status.size} points with warnings")
    accuracy = accuracy_of(name, results.units, axes.pick)
    sentence = accuracy.sentence or next(each.meaning for each in results.columns if each.name == name)
    return Plot(ax, name, (f"{name}: {sentence}", *missing, *results.warnings_of(axes.points())))


def _draw(axes: PlottedAxes, name: str, ax: Axes | None) -> Axes:
    """Draw lines or a map of the column ``name``."""
    across, *up = axes.axes
    are_lines = not up or len(up[0].places) <= min(len(COLOURS) - 1, len(across.places))
    quantity = label_of(name), axes.results.units[name] or ""
    return (_draw_lines if are_lines else _draw_map)(axes, axes.pick(name), quantity, ax)


def _draw_lines(axes: PlottedAxes, values: FloatArray, quantity: tuple[str, str], ax: Axes | None) -> Axes:
    """Draw a quantity over one axis, with a line for each of a few values of another axis, if there is one."""
    x = axes.axes[0]
    with canvas(ax) as ax:
        for index, (label, line) in enumerate(zip(axes.labels(), values.reshape(len(values), -1).T, strict=True)):
            look = elements.series(index, marked=not x.joined or len(x.places) <= _MARKERS)
            look["linestyle"] = look["linestyle"] if x.joined else ""
            ax.plot(x.places, line, label=literal(label) or None, **look)
        if not np.isfinite(values).any():
            ax.set_xlim(x.places[0], x.places[-1])
        ax.margins(y=0.12)
        if not (values < 0).any():
            ax.set_ylim(bottom=0)
        x.scale(ax, "x")
        elements.label_axis(ax, "y", quantity)
        return ax


def _draw_map(axes: PlottedAxes, values: FloatArray, quantity: tuple[str, str], ax: Axes | None) -> Axes:
    """Draw a quantity over two axes as colours, with the borders of the regimes and a line at an amplification of 1."""
    x, y = axes.axes
    for axis in (x, y):
        if (np.diff(axis.places) <= 0).any():
            remedy = "fix another variable of that axis with --at NAME=VALUE, or choose another with --x"
            got = f"got {axis.name}, which repeats a value; {remedy}"
            raise UsageError(f"points of a map must have different coordinates ({got})")
    edges = edges_of(x.places, x.log), edges_of(y.places, y.log)
    with canvas(ax, legend=False) as ax:
        drawn = colour_cells(ax, edges, values, **colours_of(values[np.isfinite(values)]))
        x.scale(ax, "x")
        y.scale(ax, "y")
        bar = elements.colour_scale(ax, drawn, quantity)
        if quantity[0] == "amplification" and drawn.norm.vmin < 1 < drawn.norm.vmax:
            look: dict[str, Any] = {"colors": [elements.ink()], "linestyles": "--", "linewidths": 0.9}
            ones = ax.contour(x.places, y.places, values.T, [1.0], **look)
            bar.add_lines(ones)
            ones.set(path_effects=elements.halo())
        if "section4_regime" in axes.results.units:
            regime_borders(ax, edges, axes.pick("section4_regime"))
        return ax


# ---------------------------------------------------------------- axes

# Digits of a value in labels, and the relative tolerance for values given with `--at`.
_DIGITS = 6
_CLOSE = 1e-5
# Most values listed in a message.
_MOST_LISTED = 20
# Characters in a line of the caption.
_CAPTION_WIDTH = 90
# Greatest value on a logarithmic axis, whose ticks may lie decades beyond its values.
_MOST_DRAWN = 1e150
# Most tick labels with names along an axis.
_TICKS = 25
# Most points of a line with markers.
_MARKERS = 30


@frozen(eq=False)
class PlottedAxis:
    """An axis of a sweep that is drawn.

    Attributes
    ----------
    place : int
        Number of the axis of the sweep, counted from 0.
    name, label, unit : str
        Variable that is drawn, its label, and its SI unit, empty for a dimensionless number.
    positions : array of int
        Positions along the axis of the sweep, in the order in which they are drawn.
    places : array, shape (p,)
        Coordinates of the values, ascending.
    texts : sequence of str
        Names of the values, if they are not numbers.
    joined : bool
        Whether values are connected by a line.
    """

    place: int
    name: str
    label: str
    unit: str
    positions: npt.NDArray[np.intp]
    places: FloatArray
    texts: Sequence[str]
    joined: bool

    @property
    def log(self) -> bool:
        """Whether the values are spaced more evenly on a logarithmic axis."""
        low, middle, high = self.places[[0, len(self.places) // 2, -1]].tolist()
        if self.texts or not 0 < 3 * low < high < _MOST_DRAWN:
            return False
        return bool(abs(middle - (low * high) ** 0.5) < abs(middle - (low + high) / 2))

    def scale(self, ax: Axes, axis: Literal["x", "y"]) -> None:
        """Set scale, ticks and label of an axis."""
        if self.texts:
            every = -(-len(self.texts) // _TICKS)
            slanted: dict[str, Any] = {"rotation": 30, "ha": "right"} if axis == "x" else {}
            chosen = ax.xaxis if axis == "x" else ax.yaxis
            chosen.set_ticks(self.places[::every], [literal(text) for text in self.texts[::every]], **slanted)
        elif self.log:
            (ax.set_xscale if axis == "x" else ax.set_yscale)("log")
        elements.label_axis(ax, axis, (self.label, self.unit))


class PlottedAxes:
    """One or two axes of a sweep, with variables fixed at the values in ``at``.

    Raises
    ------
    UnknownNameError
        If there is no such variable.
    UsageError
        If no axis or more than two axes remain, or if no point has the fixed values.
    """

    def __init__(self, results: SweepResults, at: Mapping[str, Any], x: str | None) -> None:
        self.results = results
        self.positions = [np.arange(len(axis)) for axis in results.axes]
        for name, value in at.items():
            place = self.results.place(name)
            here = self.positions[place]
            self.positions[place] = here[self._find_value(name, value)]
        free = [place for place, here in enumerate(self.positions) if len(here) > 1]
        if not 1 <= len(free) <= 2:
            got = "got one point; see results.csv, or omit an --at"
            if free:
                known = "; ".join(f"{name}={self._list_values(name, 3)}" for name in map(self._longest, free))
                got = f"got {len(free)}; fix {len(free) - 2} of them with --at NAME=VALUE: {known}"
            raise UsageError(f"a plot must have one or two axes ({got})")
        if x is not None and self._count(x) < 2:
            raise UsageError(f"--x: must be a variable with several values (got {x}, which has one)")
        across = self.results.place(x) if x else max(free, key=lambda place: len(self.positions[place]))
        names = [self._longest(place) for place in free if place != across]
        self.axes = [self._choose_axis(name) for name in (x or self._longest(across), *names)]

    def _values(self, name: str) -> npt.NDArray[Any]:
        """Values of a variable at the drawn positions."""
        return self.results.coordinate(name)[self.positions[self.results.place(name)]]

    def _count(self, name: str) -> int:
        return len(np.unique(self._values(name)))

    def _longest(self, place: int) -> str:
        """The first variable of an axis with the most different values."""
        return max(self.results.axes[place].names, key=self._count)

    def _texts(self, name: str, positions: npt.NDArray[np.intp]) -> list[str]:
        """Values of a variable at positions along its axis, as text."""
        unit = self.results.units[name]
        values = self.results.axes[self.results.place(name)].along(name)
        return [_text(values[position], unit, position) for position in positions.tolist()]

    def _list_values(self, name: str, most: int = _MOST_LISTED) -> str:
        texts = list(dict.fromkeys(self._texts(name, self.positions[self.results.place(name)])))
        return ", ".join(texts[:most] + ["..."] * (len(texts) > most))

    def _find_value(self, name: str, value: Any) -> npt.NDArray[np.bool_]:
        """Whether the variable has this value, for each drawn position."""
        unit = self.results.units[name]
        if unit is None or value == "none":
            equal = np.array(self._texts(name, self.positions[self.results.place(name)])) == str(value)
        else:
            try:
                number = to_si(value, unit)
            except ValueError as error:
                raise UsageError(f"{name}: {error}") from None
            equal = np.isclose(self._values(name), number, rtol=_CLOSE, atol=0)
        if not equal.any():
            raise UsageError(f"{name}: must be one of its values (got {value}; they are {self._list_values(name)})")
        return np.asarray(equal)

    def _choose_axis(self, name: str) -> PlottedAxis:
        place = self.results.place(name)
        positions, values, unit = self.positions[place], self._values(name), self.results.units[name]
        if unit is None or np.isnan(values).any():
            places, texts = np.arange(len(positions), dtype=float), self._texts(name, positions)
            return PlottedAxis(place, name, self.label(name), "", positions, places, texts, joined=False)
        order = np.argsort(values, kind="stable")
        alone = all(self._count(other) == 1 for other in self.results.axes[place].names if other != name)
        return PlottedAxis(place, name, self.label(name), unit, positions[order], values[order], (), joined=alone)

    def pick(self, name: str) -> npt.NDArray[Any]:
        """Return a quantity at the drawn points, in the order of `axes`."""
        return self._take(self.results.values(name))

    def points(self) -> list[int]:
        """Return the numbers of the drawn points."""
        numbers = np.arange(self.results.points).reshape(self.results.shape)
        return [int(number) for number in self._take(numbers).flat]

    def _take(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        indices = [here[:1] for here in self.positions]
        for axis in self.axes:
            indices[axis.place] = axis.positions
        picked = values[np.ix_(*indices)].squeeze()
        return picked if self.axes[0].place <= self.axes[-1].place else picked.T

    def label(self, name: str) -> str:
        """Return the label of a variable: the last part of its name; all of it for a segment or if others end alike."""
        ends = [label_of(each) for each in self.results.variables]
        whole = "granules[" in name or ends.count(label_of(name)) > 1
        return name_in_words(name.removeprefix("chain.")) if whole else label_of(name)

    def labels(self) -> list[str]:
        """Return a label for each value of the second axis."""
        return [
            f"{self.label(axis.name)} {text}"
            for axis in self.axes[1:]
            for text in self._texts(axis.name, axis.positions)
        ] or [""]

    def caption(self) -> str:
        """Return the fixed values."""
        fixed = [
            f"{self.label(name)} {self._texts(name, here[:1])[0]}"
            for axis, here in zip(self.results.axes, self.positions, strict=True)
            for name in axis.names
            if self._count(name) == 1 < len(np.unique(self.results.coordinate(name)))
        ]
        return textwrap.fill(", ".join(fixed), _CAPTION_WIDTH)


def label_of(name: str) -> str:
    """Return the label of a quantity or a variable in a picture, from the last part of its name."""
    return name.rpartition(".")[2].replace("_", " ")


def _text(value: Any, unit: str | None, position: int) -> str:
    """Return a value as text; for a mapping its name, or else its number among the values."""
    if value is None:
        return "none"
    if isinstance(value, Mapping):
        return str(value.get("name") or f"#{position + 1}")
    return str(value) if unit is None else si_label(value, unit, _DIGITS)
