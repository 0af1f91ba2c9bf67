"""Results of a sweep: arrays with an axis for each axis of the sweep."""

from __future__ import annotations

import importlib
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.errors import InvalidValueError, UnknownNameError, UsageError
from shockwave.sweep.header import Column, Header, SweepAxis, as_text
from shockwave.sweep.journal import NOT_RUN, SweepFolder
from shockwave.text import printed


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
class SweepResults:
    """The results of a sweep so far.

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
        The quantities, with units and meanings.
    failed : tuple of Failure
        Points that have no result, in their order.
    complete : bool
        Whether every point was run, with a result or without.
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
    _header: Header = attrs.field(eq=False, repr=False)
    _arrays: dict[str, npt.NDArray[Any]] = attrs.field(eq=attrs.cmp_using(eq=_same), repr=False)

    @property
    def units(self) -> dict[str, str | None]:
        """SI units of variables and columns by name: empty for a number without one, None for text."""
        return self._header.variables | {column.name: column.unit for column in self.columns}

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
        raise UnknownNameError("quantity of the sweep", name, [*self._arrays, *self._header.variables])

    def coordinate(self, name: str) -> npt.NDArray[Any]:
        """The values of the variable ``name`` along its axis; floats, or text, empty for none, if it is no number.

        Raises
        ------
        UnknownNameError
            When nothing of that name was varied.
        """
        axis = next((axis for axis in self.axes if name in axis.names), None)
        if axis is None:
            raise UnknownNameError("variable of the sweep", name, self._header.variables)
        if self.units[name] is None:
            return np.array([as_text(value) or "" for value in axis.along(name)])
        return np.array(axis.along(name), dtype=float)

    def point(self, index: int) -> dict[str, Any]:
        """Dotted names and values of a point, counted from 0.

        Raises
        ------
        InvalidValueError
            When there is no such point.
        """
        if not 0 <= index < self._header.points:
            raise InvalidValueError.of("index", f"must be from 0 to {self._header.points - 1} (got {index})")
        return self._header.point(index)

    def to_pandas(self) -> Any:
        """A `pandas.DataFrame` with a row for each point, indexed by the variables; ``attrs`` holds the units.

        Raises
        ------
        UsageError
            When pandas is not installed.
        """
        pd = _library("pandas")
        levels = {name: self.values(name).ravel() for name in self._header.variables}
        frame = pd.DataFrame(levels | {name: values.ravel() for name, values in self._arrays.items()})
        frame = frame.set_index(list(levels))
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
        short = self._header.short_names
        zipped = iter(["point", *(f"point_{at}" for at in range(2, len(self.axes) + 1))])
        dimensions = [next(zipped) if len(axis.names) > 1 else short[axis.names[0]] for axis in self.axes]
        coordinates = {
            short[name]: (dimension, self.coordinate(name), _described(name, self.units[name]))
            for dimension, axis in zip(dimensions, self.axes, strict=True)
            for name in axis.names
        }
        meanings = {column.name: column.meaning or column.name for column in self.columns} | {"status": "status"}
        variables = {
            name: (dimensions, values, _described(meanings[name], self.units.get(name)))
            for name, values in self._arrays.items()
        }
        about = {"title": self.name, "run": self.run, "sweep_key": self.key}
        about["scenario"] = json.dumps(self._header.scenario)
        about["source"] = ", ".join(map(" ".join, self.versions.items()))
        return xr.Dataset(variables, coordinates, about)

    def __str__(self) -> str:
        return printed(self, "shockwave.sweep.sweep_text:results_text")


def _described(name: str, unit: str | None) -> dict[str, str]:
    return {"long_name": name} | ({} if unit is None else {"units": unit or "1"})


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
        When its header is not that of a sweep.
    """
    swept = SweepFolder.read(folder)
    header = swept.header
    found: dict[str, list[Any]] = {name: [] for name in (*(column.name for column in header.columns), "status")}
    failed: list[Failure] = []
    for row in swept.rows():
        for values, value in zip(found.values(), (*row.values, row.status), strict=True):
            values.append(value)
        if row.status not in ("done", NOT_RUN):
            failed.append(Failure(row.number, header.point(row.number), row.status, row.problem or ""))
    texts = {column.name for column in header.columns if column.kind == "text"} | {"status"}
    arrays = {name: _array(values, name in texts).reshape(header.shape) for name, values in found.items()}
    for array in arrays.values():
        array.flags.writeable = False
    lost = int(np.count_nonzero((swept.offsets >= 0) & (arrays["status"].ravel() == NOT_RUN)))
    damaged = f"lines of the journal that cannot be read: {lost} (delete them, and run the sweep again)"
    return SweepResults(
        name=header.name,
        run=header.run,
        axes=header.axes,
        shape=header.shape,
        columns=header.columns,
        failed=tuple(failed),
        complete=not lost and bool((swept.offsets >= 0).all()),
        versions=header.versions,
        key=header.key,
        warnings=(*swept.warnings, *([damaged] if lost else [])),
        folder=swept.folder,
        header=header,
        arrays=arrays,
    )


def _array(values: Sequence[Any], text: bool) -> npt.NDArray[Any]:
    if text:
        return np.array(["" if value is None else str(value) for value in values])
    return np.array(values, dtype=float)
