"""Results of a sweep: arrays with an axis for each axis of the sweep."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.errors import InvalidValueError, UnknownNameError, UsageError
from shockwave.sweep.stored import NOT_RUN, NOTES, Column, Stored, SweepAxis, as_text
from shockwave.text import notes, si, table

__all__ = ["Failure", "SweepResults", "load_sweep"]

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
    equal = (
        np.array_equal(values, other[name], equal_nan=values.dtype.kind == "f")
        for name, values in one.items()
        if name in other
    )
    return one.keys() == other.keys() and all(equal)


@frozen(kw_only=True)
class SweepResults:
    """What a sweep has found so far.

    Attributes
    ----------
    name : str
        Of the scenario.
    run : str
        What was done at every point: ``predict``, ``simulate`` or ``compare``.
    axes : tuple of SweepAxis
        In the order of the arrays' axes; the last is gone through first.
    shape : tuple of int
        Numbers of values along the axes.
    columns : tuple of Column
        What is known of every point, with units and meanings.
    failed : tuple of Failure
        Points that have no result, in their order.
    complete : bool
        Whether every point was run, be it in vain.
    versions : dict of str to str
        Of what made it.
    key : str
        SHA-256 over scenario, axes, columns and versions.
    warnings : tuple of str
        What a reader must know before using the figures.
    folder : pathlib.Path
        Where it was read.
    """

    name: str
    run: str
    axes: tuple[SweepAxis, ...]
    shape: tuple[int, ...]
    columns: tuple[Column, ...]
    failed: tuple[Failure, ...]
    complete: bool
    versions: dict[str, str]
    key: str
    warnings: tuple[str, ...]
    folder: Path = attrs.field(eq=False)
    _stored: Stored = attrs.field(eq=False, repr=False)
    _arrays: dict[str, npt.NDArray[Any]] = attrs.field(eq=attrs.cmp_using(eq=_same), repr=False)

    @property
    def units(self) -> dict[str, str | None]:
        """SI units of variables and columns by name: empty for a number without one, None for text."""
        return self._stored.header.variables | {column.name: column.unit for column in self.columns}

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
                along = self.coordinate(name)
                shape = [len(along) if at == place else 1 for at in range(len(self.shape))]
                return np.broadcast_to(along.reshape(shape), self.shape)
        raise UnknownNameError("quantity of the sweep", name, [*self._arrays, *self._stored.header.variables])

    def coordinate(self, name: str) -> npt.NDArray[Any]:
        """The values of the variable ``name`` along its axis; floats, or text, empty for none, if it is no number.

        Raises
        ------
        UnknownNameError
            When nothing of that name was varied.
        """
        axis = next((axis for axis in self.axes if name in axis.names), None)
        if axis is None:
            raise UnknownNameError("variable of the sweep", name, self._stored.header.variables)
        given = axis.along(name)
        if self.units[name] is not None:
            return np.array(given, dtype=float)
        return np.array([as_text(value) or "" for value in given])

    def point(self, index: int) -> dict[str, Any]:
        """Dotted names and values of a point, counted from 0.

        Raises
        ------
        InvalidValueError
            When there is no such point.
        """
        points = self._stored.header.points
        if not 0 <= index < points:
            raise InvalidValueError.of("index", f"must be from 0 to {points - 1} (got {index})")
        return self._stored.header.point(index)

    def to_pandas(self) -> Any:
        """A `pandas.DataFrame` with a row for each point, indexed by the variables; ``attrs`` holds the units.

        Raises
        ------
        UsageError
            When pandas is not installed.
        """
        pd: Any = _library("pandas")
        names = list(self._stored.header.variables)
        levels = [self.values(name).ravel() for name in names]
        index = pd.MultiIndex.from_arrays(levels, names=names) if len(names) > 1 else pd.Index(levels[0], name=names[0])
        frame = pd.DataFrame({name: values.ravel() for name, values in self._arrays.items()}, index=index)
        frame.attrs["units"] = self.units
        return frame

    def to_xarray(self) -> Any:
        """A `xarray.Dataset`: arrays by named axes, with units; names are those of ``results.nc``.

        Raises
        ------
        UsageError
            When xarray is not installed.
        """
        xr: Any = _library("xarray")
        dimensions = self._stored.header.dimensions
        coordinates = {
            name: (dimension.name, self.coordinate(dotted), _described(dotted, self.units[dotted]))
            for dimension in dimensions
            for name, dotted in dimension.coordinates.items()
        }
        meanings = {column.name: column.meaning for column in self.columns}
        names = [dimension.name for dimension in dimensions]
        variables = {
            name: (names, values, _described(meanings.get(name) or name, self.units.get(name)))
            for name, values in self._arrays.items()
        }
        told = {"title": self.name, "run": self.run, "sweep_key": self.key}
        return xr.Dataset(variables, coordinates, told)

    def __str__(self) -> str:
        done = int(np.count_nonzero(self.values("status") == "done"))
        run = int(np.count_nonzero(self.values("status") != NOT_RUN))
        lines = [
            f"sweep of {self.name}",
            f"  run     {self.run}",
            f"  points  {self.values('status').size}: {done} done, {run - done} failed"
            + ("" if self.complete else ", the others not run yet"),
            "",
        ]
        rows = [(name, *_range(self.coordinate(name), self.units[name])) for axis in self.axes for name in axis.names]
        lines += [f"  {line}" for line in table(("axis", "least", "greatest", "values"), rows).splitlines()] + [""]
        shown = [one for one in self.columns if one.name != NOTES]
        rows = [(one.name, *_range(self.values(one.name).ravel(), one.unit)) for one in shown]
        lines += [f"  {line}" for line in table(("column", "least", "greatest", "values"), rows).splitlines()]
        told = [f"{_text(failure.point)}: {failure.problem}" for failure in self.failed[:_SHOWN]]
        if len(self.failed) > _SHOWN:
            told.append(f"and {len(self.failed) - _SHOWN} more have failed")
        if len(shown) < len(self.columns) and (noted := np.count_nonzero(self.values(NOTES) != "")):
            told.append(f"{noted} points have notes, in the column {NOTES}")
        return "\n".join(lines + notes([*told, *self.warnings]))


def _described(name: str, unit: str | None) -> dict[str, str]:
    return {"long_name": name} | ({} if unit is None else {"units": unit or "1"})


def _library(name: str) -> ModuleType:
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError as missing:
        raise UsageError(f"this needs {name}: pip install {name}") from missing


def _text(point: Mapping[str, Any]) -> str:
    return ", ".join(
        f"{name} {value:g}" if isinstance(value, float) else f"{name} {value}" for name, value in point.items()
    )


def _range(values: npt.NDArray[Any], unit: str | None) -> tuple[str, str, str]:
    """Least, greatest and number of values, as text."""
    if unit is None:
        words = np.unique(values[values != ""])
        told = [f"{np.count_nonzero(values == word)} {word}" for word in words[:_SHOWN]]
        return "", "", ", ".join(told + ["..."] * (len(words) > _SHOWN))
    known = values[np.isfinite(values)]
    if not known.size:
        return "", "", "0"
    shown = [si(float(value), unit) if unit else f"{value:.5g}" for value in (known.min(), known.max())]
    return shown[0], shown[1], str(known.size)


def load_sweep(folder: str | os.PathLike[str]) -> SweepResults:
    """The results of a sweep, of one that is going on or was interrupted as far as they go.

    Parameters
    ----------
    folder : path-like
        What ``shockwave sweep FILE --out FOLDER`` has written. The journal is read, not the tables.

    Raises
    ------
    FileAccessError
        When it cannot be read.
    InvalidValueError
        When its header is not that of a sweep.
    """
    stored = Stored.read(folder)
    header = stored.header
    columns = [(column.name, column.kind == "text") for column in header.columns]
    parts: dict[str, list[npt.NDArray[Any]]] = {name: [] for name in (*dict(columns), "status")}
    failed: list[Failure] = []
    lost = 0
    for chunk in stored.chunks():
        for at, (name, text) in enumerate(columns):
            parts[name].append(_array([row.values[at] for row in chunk.rows], text))
        statuses = _array([row.status for row in chunk.rows], True)
        parts["status"].append(statuses)
        for at in np.flatnonzero((statuses != "done") & (statuses != NOT_RUN)).tolist():
            index, row = chunk.begin + at, chunk.rows[at]
            failed.append(Failure(index, header.point(index), row.status, row.problem or ""))
        begun = stored.offsets[chunk.begin : chunk.begin + len(chunk.rows)] >= 0
        lost += int(np.count_nonzero(begun & (statuses == NOT_RUN)))
    arrays = {name: np.concatenate(found).reshape(header.shape) for name, found in parts.items()}
    for values in arrays.values():
        values.flags.writeable = False
    damaged = (
        (f"lines of the journal that cannot be read: {lost} (delete them, and run the sweep again)",) if lost else ()
    )
    return SweepResults(
        name=header.name,
        run=header.run,
        axes=header.axes,
        shape=header.shape,
        columns=header.columns,
        failed=tuple(failed),
        complete=not lost and bool((stored.offsets >= 0).all()),
        versions=header.versions,
        key=header.key,
        warnings=stored.warnings + damaged,
        folder=stored.folder,
        stored=stored,
        arrays=arrays,
    )


def _array(values: Sequence[Any], text: bool) -> npt.NDArray[Any]:
    if text:
        return np.array(["" if value is None else str(value) for value in values])
    return np.array(values, dtype=float)
