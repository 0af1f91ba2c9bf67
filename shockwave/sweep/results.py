"""Results of a sweep: arrays with an axis for each axis of the sweep."""

from __future__ import annotations

import importlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.errors import UnknownNameError, UsageError
from shockwave.sweep.definition import NOTES, SweepDefinition, as_text
from shockwave.sweep.journal import NOT_RUN, Journal
from shockwave.text import notes, si, table

# Failed points, and words of a column, that are listed.
_SHOWN = 5


@frozen
class Failure:
    """A point that has no result.

    Attributes
    ----------
    index : int
        Its number, counted from 0.
    point : dict
        Dotted names and values.
    status : str
        ``failed``, or ``crashed`` where it ended its process.
    problem : str
        What was wrong.
    """

    index: int
    point: dict[str, Any]
    status: str
    problem: str


def _same(one: Mapping[str, npt.NDArray[Any]], other: Mapping[str, npt.NDArray[Any]]) -> bool:
    return one.keys() == other.keys() and all(
        np.array_equal(values, other[name], equal_nan=values.dtype.kind == "f") for name, values in one.items()
    )


@frozen(kw_only=True)
class SweepResults(SweepDefinition):
    """The results of a sweep so far, and its definition.

    Attributes
    ----------
    failed : tuple of Failure
        Points that have no result, in their order.
    warnings : tuple of str
        What a reader must know before using the figures.
    folder : pathlib.Path
        Where it was read.
    """

    failed: tuple[Failure, ...]
    warnings: tuple[str, ...]
    folder: Path = attrs.field(eq=False)
    _arrays: dict[str, npt.NDArray[Any]] = attrs.field(eq=attrs.cmp_using(eq=_same), repr=False)

    @property
    def complete(self) -> bool:
        """Whether every point was run, with a result or without."""
        return NOT_RUN not in self._arrays["status"]

    def values(self, name: str) -> npt.NDArray[Any]:
        """A quantity at every point.

        Parameters
        ----------
        name : str
            A column; ``status``; or the dotted name of a variable.

        Returns
        -------
        array, shape ``shape``
            Floats [the unit of the column], not a number where there is no value; or text, empty there. It cannot be
            written to.

        Raises
        ------
        UnknownNameError
            When there is no such quantity.
        """
        if name in self._arrays:
            return self._arrays[name]
        for place, axis in enumerate(self.axes):
            if name in axis.names:
                shape = [1] * len(self.shape)
                shape[place] = len(axis)
                return np.broadcast_to(self.coordinate(name).reshape(shape), self.shape)
        raise UnknownNameError("quantity of the sweep", name, [*self._arrays, *self.variables])

    def coordinate(self, name: str) -> npt.NDArray[Any]:
        """The values of the variable ``name`` along its axis; floats, or text, empty for none, if it is no number.

        Raises
        ------
        UnknownNameError
            When nothing of that name was varied.
        """
        for axis in self.axes:
            if name in axis.names:
                return _array(axis.along(name), self.units[name] is None)
        raise UnknownNameError("variable of the sweep", name, self.variables)

    def to_pandas(self) -> Any:
        """A `pandas.DataFrame` with a row for each point, indexed by the variables; ``attrs`` holds the units.

        Raises
        ------
        UsageError
            When pandas is not installed.
        """
        pd = _library("pandas")
        names = [*self.variables, *self._arrays]
        frame = pd.DataFrame({name: self.values(name).ravel() for name in names})
        frame = frame.set_index(list(self.variables))
        frame.attrs["units"] = self.units
        return frame

    def to_xarray(self) -> Any:
        """A `xarray.Dataset`: arrays by named axes, with units.

        Axes have the last part of the names of their variables; variables that go together share an axis ``point``.
        ``long_name`` has the name in full.

        Raises
        ------
        UsageError
            When xarray is not installed.
        """
        xr = _library("xarray")
        short = self.short_names
        meanings = {column.name: column.meaning for column in self.columns}
        dimensions: list[str] = []
        coordinates = {}
        for place, axis in enumerate(self.axes):
            joined = "point" if "point" not in dimensions else f"point_{place + 1}"
            dimensions.append(joined if len(axis.names) > 1 else short[axis.names[0]])
            for name in axis.names:
                coordinates[short[name]] = (dimensions[-1], self.coordinate(name), self._described(name, name))
        variables = {
            name: (dimensions, values, self._described(name, meanings.get(name) or name))
            for name, values in self._arrays.items()
        }
        about = {
            "title": self.name,
            "run": self.run,
            "sweep_key": self.key,
            "scenario": json.dumps(self.scenario),
            "source": ", ".join(map(" ".join, self.versions.items())),
        }
        return xr.Dataset(variables, coordinates, about)

    def _described(self, name: str, meaning: str) -> dict[str, str]:
        unit = self.units.get(name)
        return {"long_name": meaning} | ({} if unit is None else {"units": unit or "1"})

    def __str__(self) -> str:
        status = self.values("status")
        done, run = (int(np.count_nonzero(of)) for of in (status == "done", status != NOT_RUN))
        missing = "" if self.complete else ", the others not run yet"
        columns = [column.name for column in self.columns if column.name != NOTES]
        lines = [
            f"sweep of {self.name}",
            f"  run     {self.run}",
            f"  points  {status.size}: {done} done, {run - done} failed{missing}",
        ]
        for kind, names in (("axis", self.variables), ("column", columns)):
            rows = [(name, *self._range(name)) for name in names]
            text = table((kind, "least", "greatest", "values"), rows, margin=0)
            lines += ["", *(f"  {line}" for line in text.splitlines())]
        remarks = [f"{_point(failure.point)}: {failure.problem}" for failure in self.failed[:_SHOWN]]
        return "\n".join(lines + notes([*remarks, *self.warnings]))

    def _range(self, name: str) -> tuple[str, str, str]:
        """Least, greatest and number of values, as text."""
        values = self.coordinate(name) if name in self.variables else self.values(name).ravel()
        unit = self.units[name]
        if unit is None:
            words, counts = np.unique(values[values != ""], return_counts=True)
            texts = [f"{count} {word}" for word, count in zip(words[:_SHOWN], counts, strict=False)]
            return "", "", ", ".join(texts + ["..."] * (len(words) > _SHOWN))
        known = values[np.isfinite(values)]
        if not known.size:
            return "", "", "0"
        low, high = (si(float(value), unit) if unit else f"{value:.5g}" for value in (known.min(), known.max()))
        return low, high, str(known.size)


def _point(values: Mapping[str, Any]) -> str:
    texts = {name: f"{value:g}" if isinstance(value, float) else str(value) for name, value in values.items()}
    return ", ".join(f"{name} {text}" for name, text in texts.items())


def _library(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as missing:
        raise UsageError(f"this needs {name}: pip install {name}") from missing


def load_sweep(folder: str | os.PathLike[str]) -> SweepResults:
    """The results of a sweep, of one that is running or was interrupted as far as they go.

    Parameters
    ----------
    folder : path-like
        What ``shockwave sweep FILE --out FOLDER`` has written. The journal is read, not the tables.

    Raises
    ------
    FileAccessError
        When it cannot be read.
    InvalidValueError
        When its definition or its journal is not that of a sweep.
    """
    place = Path(folder)
    definition = SweepDefinition.read(place)
    journal = Journal(place, definition.points)
    warnings = [*journal.read(definition.columns), *definition.version_notes]
    left = journal.count(NOT_RUN)
    if left:
        warnings.append(f"{left} of {journal.points} points are not done: run the sweep again to resume it")
    texts = {column.name: column.kind == "text" for column in definition.columns} | {"status": True}
    found: dict[str, list[Any]] = {name: [] for name in texts}
    failed = []
    for row in journal.rows(definition):
        for values, value in zip(found.values(), [*row.values, row.status], strict=True):
            values.append(value)
        if row.problem is not None:
            failed.append(Failure(row.number, definition.point(row.number), row.status, row.problem))
    arrays = {name: _array(values, texts[name]).reshape(definition.shape) for name, values in found.items()}
    for array in arrays.values():
        array.flags.writeable = False
    return SweepResults(
        **attrs.asdict(definition, recurse=False),
        failed=tuple(failed),
        warnings=tuple(warnings),
        folder=place,
        arrays=arrays,
    )


def _array(values: list[Any], text: bool) -> npt.NDArray[Any]:
    if text:
        return np.array([as_text(value) or "" for value in values])
    return np.array(values, dtype=float)
