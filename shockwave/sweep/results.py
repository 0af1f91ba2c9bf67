"""Results of a sweep: arrays with one axis for each axis of the sweep."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import attrs
import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.base.errors import UnknownNameError, shorten
from shockwave.base.numerics import FloatArray
from shockwave.base.progress import report_progress
from shockwave.base.quantities import errors_of, unit_of
from shockwave.base.result import VERSION, Result
from shockwave.base.result_tables import Table, TableColumn, along, dataset, library
from shockwave.base.text import facts, limits, si, significant_digits, strong, table
from shockwave.studies.warning_groups import WarningGroups
from shockwave.sweep.definition import NOTES, SweepDefinition, as_text, folder_path, warnings_in
from shockwave.sweep.journal import NOT_RUN, Journal

# Main quantity of a sweep: the first of these columns that it has; a simulated one, where there is one.
_MAIN = ("amplification", "section4_amplification")
# Significant digits of variables, and of quantities without a known error.
_VARIABLE_DIGITS = 5
_USUAL_DIGITS = 3
# Failed points, and different texts of a column, that are listed.
_MOST_LISTED = 5
# Blanks between the sentences of warnings.
_BETWEEN_SENTENCES = r"(?<=\.) (?=\S)"
# Attributes that the document contains under their names.
_DOCUMENT = (
    *("name", "run", "axes", "columns", "scenario", "named", "versions", "earlier_versions", "failed", "warnings"),
)


@frozen
class Failure:
    """A point without a result.

    Attributes
    ----------
    index : int
        Its number, counted from 0.
    point : dict
        Values of the variables by their dotted names.
    status : str
        ``failed``, or ``crashed`` if it terminated its process.
    problem : str
        The error.
    """

    index: int
    point: dict[str, Any]
    status: str
    problem: str


def _are_equal(arrays: Mapping[str, npt.NDArray[Any]], others: Mapping[str, npt.NDArray[Any]]) -> bool:
    return arrays.keys() == others.keys() and all(
        np.array_equal(values, others[name], equal_nan=values.dtype.kind == "f") for name, values in arrays.items()
    )


@frozen(kw_only=True, repr=False)
class SweepResults(Result, SweepDefinition):
    """Definition of a sweep, with the results so far.

    Attributes
    ----------
    failed : tuple of Failure
        Points that failed or crashed, in the order of the points.
    warnings : tuple of str
        Remarks on missing points and other versions; the warnings of the points, by kind.
    folder : pathlib.Path
        Folder of the sweep.
    """

    failed: tuple[Failure, ...]
    _remarks: tuple[str, ...]
    folder: Path = attrs.field(eq=False)
    _arrays: dict[str, npt.NDArray[Any]] = attrs.field(eq=attrs.cmp_using(eq=_are_equal), repr=False)

    _brief = ("name", "run", "points", "complete")
    _picture = "shockwave.sweep.sweep_picture:draw_sweep"
    _tables = (("points", "point"),)

    def _table(self, name: str) -> Table:
        (first, *_), row = self.variables, "point"
        places: Any = range(self.points)
        if len(self.variables) == 1 and self.units[first] is not None:
            row, places = first, self.coordinate(first)
        main = main_quantity([one.name for one in self.columns if one.kind != "text"])
        names = dict.fromkeys((main, *self.variables, *self._arrays))
        return along(row, places, {each: self.values(each).ravel() for each in names if each != row}, self.units)

    @property
    def warnings(self) -> tuple[str, ...]:
        return self.warnings_of(range(self.points))

    def warnings_of(self, points: Iterable[int]) -> tuple[str, ...]:
        """Return the remarks on the sweep, and the warnings of ``points`` by kind."""
        groups = WarningGroups()
        for point in sorted(points) if NOTES in self._arrays else ():
            text = warnings_in(self._arrays[NOTES].flat[point])
            groups.add(filter(None, re.split(_BETWEEN_SENTENCES, text)), point)
        return (*self._remarks, *groups.sentences("points", numbered=True))

    @property
    def complete(self) -> bool:
        """Whether every point was run, with or without a result."""
        return NOT_RUN not in self._arrays["status"]

    def values(self, name: str) -> npt.NDArray[Any]:
        """Return a quantity at every point.

        Parameters
        ----------
        name : str
            Name of a column, ``status``, or dotted name of a variable.

        Returns
        -------
        array, shape ``shape``
            Read-only array of floats [unit of the column], NaN where there is no value; or of text, empty where there
            is none.

        Raises
        ------
        UnknownNameError
            If there is no such quantity.
        """
        if name in self._arrays:
            return self._arrays[name]
        if name not in self.variables:
            raise UnknownNameError.of("quantity of the sweep", name, [*self._arrays, *self.variables])
        later = len(self.axes) - 1 - self.place(name)
        return np.broadcast_to(self.coordinate(name).reshape(-1, *[1] * later), self.shape)

    def coordinate(self, name: str) -> npt.NDArray[Any]:
        """Return the values of the variable ``name`` along its axis: floats, or text if they are not numbers.

        Raises
        ------
        UnknownNameError
            If there is no such variable.
        """
        return _array(self.axes[self.place(name)].along(name), self.units[name] is None)

    def place(self, name: str) -> int:
        """Return the number of the axis along which the variable ``name`` changes; it may raise like `coordinate`."""
        for place, axis in enumerate(self.axes):
            if name in axis.names:
                return place
        raise UnknownNameError.of("variable of the sweep", name, self.variables)

    def to_dict(self) -> dict[str, Any]:
        """Return a document for JSON: axes, columns, their values, failed points, scenario and versions.

        ``values`` holds nested lists in the shape of the sweep, in SI units, by the names of the columns and
        ``status``; a missing value is None.
        """
        named = {name: getattr(self, name) for name in _DOCUMENT}
        document = json.loads(json.dumps(named, default=attrs.asdict))
        values = {}
        for name, array in self._arrays.items():
            some = array.astype(object)
            some[~np.isfinite(array) if array.dtype.kind == "f" else array == ""] = None
            values[name] = some.tolist()
        own = {"points": self.points, "complete": self.complete, "folder": str(self.folder), "values": values}
        return {**VERSION, **document, **own}

    def to_pandas(self, table: str | None = None) -> Any:
        """Return a `pandas.DataFrame` with a row for each point, indexed by the variables; ``attrs`` holds the units.

        Raises
        ------
        UnknownNameError
            If ``table`` is neither None nor ``points``.
        UsageError
            If pandas is not installed.
        """
        self._find_table(table)
        pd = library("pandas")
        names = [*self.variables, *self._arrays]
        frame = pd.DataFrame({name: self.values(name).ravel() for name in names})
        frame = frame.set_index(list(self.variables))
        frame.attrs |= {"units": self.units, **self.remarks()}
        return frame

    def to_xarray(self, table: str | None = None) -> Any:
        """Return a `xarray.Dataset` of arrays with named axes and units.

        An axis is named after the last part of its variable's name; variables that change together share an axis
        ``point``. The attribute ``long_name`` holds the full name.

        Raises
        ------
        UnknownNameError
            If ``table`` is neither None nor ``points``.
        UsageError
            If xarray is not installed.
        """
        self._find_table(table)
        short = self.short_names
        meanings = {column.name: column.meaning for column in self.columns}
        dimensions: list[str] = []
        columns: Table = {}
        for place, axis in enumerate(self.axes):
            joined = "point" if "point" not in dimensions else f"point_{place + 1}"
            dimensions.append(joined if len(axis.names) > 1 else short[axis.names[0]])
            for name in axis.names:
                values, unit = self.coordinate(name), self.units[name]
                columns[short[name]] = TableColumn(values, unit, (dimensions[-1],), name, is_coordinate=True)
        for name, values in self._arrays.items():
            columns[name] = TableColumn(values, self.units.get(name), tuple(dimensions), meanings.get(name) or name)
        about = {
            "title": self.name,
            "run": self.run,
            "scenario": json.dumps(self.scenario),
            "source": ", ".join(map(" ".join, self.versions.items())),
            **self.remarks(),
        }
        return dataset(columns, about)

    def __str__(self) -> str:
        done = int(np.count_nonzero(self.values("status") == "done"))
        numbers = [column.name for column in self.columns if column.kind != "text"]
        texts = [column.name for column in self.columns if column.kind == "text" and column.name != NOTES]
        main = main_quantity(numbers)
        least, greatest, _ = self._range(main)
        answer = f"{done} of {self.points} points done" + (f"; {main} {least} to {greatest}" if least else "")
        failures = (f"{_point(failure.point)}: {failure.problem}" for failure in self.failed)
        remarks = [
            *_first(failures, len(self.failed), "more points failed; the attribute failed lists all"),
            *_first(self.warnings, len(self.warnings), "more; the attribute warnings lists all"),
        ]
        accuracy = accuracy_of(main, self.units, self.values).sentence
        lines = [strong(answer), *facts([("accuracy", accuracy or "not known")])]
        lines += [*limits(remarks), *facts([("sweep", self.name), ("task", self.run)])]
        for kind, count, names in (("variable", "values", self.variables), ("quantity", "points", numbers)):
            rows = [(name, *self._range(name)) for name in names]
            lines += ["", table((kind, "least", "greatest", count), rows, spare=[count])]
        if texts:
            lines += ["", table(("result", "points"), [(name, self._counts(name)) for name in texts])]
        return "\n".join(lines)

    def _range(self, name: str) -> tuple[str, str, str]:
        """Least value, greatest value and number of values, as text."""
        values = self.coordinate(name) if name in self.variables else self.values(name).ravel()
        if self.units[name] is None:
            return "", "", str(len(values))
        finite = np.flatnonzero(np.isfinite(values))
        if not finite.size:
            return "", "", "0"
        ends = finite[[values[finite].argmin(), values[finite].argmax()]].tolist()
        least, greatest = (self._text(name, float(values[end]) + 0.0, end) for end in ends)  # no sign of zero
        return least, greatest, str(finite.size)

    def _text(self, name: str, value: float, index: int) -> str:
        """A value of a variable, or of a column at a point, with the digits that its error allows."""
        digits = _VARIABLE_DIGITS
        if name not in self.variables:
            error = accuracy_of(name, self.units, self.values).errors.flat[index] / (abs(value) or 1.0)
            digits = significant_digits(value, error) if math.isfinite(error) else _USUAL_DIGITS
        unit = self.units[name]
        return si(value, unit, digits) if unit else f"{value:.{digits}g}"

    def _counts(self, name: str) -> str:
        """Number of points with each of the most frequent texts of a column."""
        values = self.values(name)
        words, counts = np.unique(values[values != ""], return_counts=True)
        most = np.argsort(-counts, kind="stable")[:_MOST_LISTED]
        return ", ".join([f"{counts[at]} {words[at]}" for at in most] + ["..."] * (len(words) > _MOST_LISTED))


def _first(sentences: Iterable[str], count: int, remainder: str) -> list[str]:
    """The first of ``count`` sentences, and the number of the others before the text of the ``remainder``."""
    more = [f"{count - _MOST_LISTED} {remainder}"] if count > _MOST_LISTED else []
    return [*islice(sentences, _MOST_LISTED), *more]


def _point(values: Mapping[str, Any]) -> str:
    texts = {name: f"{value:g}" if isinstance(value, float) else shorten(str(value)) for name, value in values.items()}
    return ", ".join(f"{name} {text}" for name, text in texts.items())


def load_sweep(folder: str | os.PathLike[str]) -> SweepResults:
    """Load the results of a sweep; of a running or interrupted one, the finished points.

    Parameters
    ----------
    folder : path-like
        Folder that ``shockwave sweep FILE -o FOLDER`` has written. The journal is read, not the tables.

    Raises
    ------
    FileAccessError
        If the folder cannot be read.
    InvalidValueError
        If ``folder`` is not a path, or its definition or its journal is not that of a sweep.
    """
    place = folder_path(folder)
    definition = SweepDefinition.read(place)
    journal = Journal(place, definition.points)
    journal.read()
    remarks = [*definition.version_notes]
    left = journal.count(NOT_RUN)
    if left:
        remarks.append(f"{left} of {journal.points} points have not been run; run the sweep again to resume it")
    texts = {column.name: column.kind == "text" for column in definition.columns} | {"status": True}
    contents: dict[str, list[Any]] = {name: [] for name in texts}
    failed = []
    for row in journal.rows(definition):
        for values, value in zip(contents.values(), [*row.values, row.status], strict=True):
            values.append(value)
        if row.problem is not None:
            failed.append(Failure(row.number, definition.point(row.number), row.status, row.problem))
        report_progress("loading results", row.number + 1, journal.points)
    arrays = {name: _array(values, texts[name]).reshape(definition.shape) for name, values in contents.items()}
    for array in arrays.values():
        array.flags.writeable = False
    return SweepResults(
        **attrs.asdict(definition, recurse=False),
        failed=tuple(failed),
        remarks=tuple(remarks),
        folder=place,
        arrays=arrays,
    )


def _array(values: list[Any], text: bool) -> npt.NDArray[Any]:
    if text:
        return np.array([as_text(value) or "" for value in values])
    return np.array(values, dtype=float)


# ---------------------------------------------------------------- accuracy of the columns


def main_quantity(columns: Sequence[str]) -> str:
    """Name of the main quantity of a sweep with these ``columns`` of numbers."""
    return next((name for name in _MAIN if name in columns), columns[0])


class Accuracy(NamedTuple):
    """Absolute errors of the values, NaN where not known, and a sentence, empty if the column has no error."""

    errors: FloatArray
    sentence: str


def accuracy_of(name: str, units: Mapping[str, str | None], values_of: Callable[[str], FloatArray]) -> Accuracy:
    """Return the accuracy of the column ``name`` of a sweep, whose columns have these ``units`` and ``values_of``."""
    values = values_of(name)
    unknown = np.full(values.shape, np.nan)
    if not np.isfinite(values).any():
        return Accuracy(unknown, "no point has a value")
    columns = [next((each for each in errors_of(part) if each in units), "") for part in name.split(" / ")]
    column = columns[0]
    if not all(columns):
        return Accuracy(unknown, "")
    errors = np.sum([values_of(each) for each in columns], axis=0)
    if column == "low":
        errors = (values_of("high") - errors) / 2 / values_of("peak_force")
        if not np.isfinite(errors).any():
            return Accuracy(unknown, "by section 4, error not known")
    elif unit := unit_of(column):
        return Accuracy(errors, f"error at most {si(np.nanmax(errors, initial=0.0), unit, 2)}")
    return Accuracy(errors * np.abs(values), f"relative error at most {np.nanmax(errors, initial=0.0):.1e}")
