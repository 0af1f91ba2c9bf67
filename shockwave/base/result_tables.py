"""Tables of results: arrays with units and named axes, and their conversion for pandas, xarray and pages."""

from __future__ import annotations

import csv
import importlib
import io
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from shockwave import OWN_DISTRIBUTION, __version__
from shockwave.base.errors import UsageError, message_of, shorten
from shockwave.base.files import write_file
from shockwave.base.quantities import unit_of
from shockwave.base.text import si

_SCALARS = (bool, int, float, str, type(None))


class TableColumn(NamedTuple):
    """A quantity along one axis or more; a ``unit`` of None marks text, an empty one a dimensionless number."""

    values: npt.NDArray[Any]
    unit: str | None
    axes: tuple[str, ...]
    meaning: str = ""
    is_coordinate: bool = False


#: Columns by name; the first is the coordinate of the rows.
Table: TypeAlias = dict[str, TableColumn]


def coordinate(name: str, values: npt.ArrayLike, unit: str | None = None) -> Table:
    """A coordinate and its axis, to begin a table with."""
    return {name: column(name, values, name, unit=unit)[name]._replace(is_coordinate=True)}


def column(name: str, values: npt.ArrayLike, *axes: str, unit: str | None = None) -> Table:
    """A quantity along ``axes``; text if its values are."""
    array = np.asarray(values)
    return {
        name: TableColumn(array, None if array.dtype.kind in "OU" else unit_of(name) if unit is None else unit, axes)
    }


def along(row: str, places: Any, quantities: Mapping[str, Any], units: Mapping[str, str | None] | None = None) -> Table:
    """Table of ``quantities`` at the ``places`` of its rows; ``units`` are those that differ from `unit_of`."""
    units_by_name = units or {}
    table = coordinate(row, places, units_by_name.get(row))
    for name, values in quantities.items():
        table |= column(name, values, row, unit=units_by_name.get(name))
    return table


def table_of(objects: Sequence[Any], row: str) -> Table:
    """Table of the numbers and texts in attrs objects of a kind; rows are numbered if they have no field ``row``.

    NaN stands for None in a column of numbers. Objects may state their own ``units``.
    """
    columns = {}
    for name in (field.name for field in attrs.fields(type(objects[0])) if field.repr):
        values = [getattr(each, name) for each in objects]
        if all(isinstance(value, _SCALARS) for value in values) and any(value is not None for value in values):
            blank: Any = "" if any(isinstance(value, str) for value in values) else np.nan
            columns[name] = [blank if value is None else value for value in values]
    stated = [getattr(each, "units", {}) for each in objects]
    table = along(row, columns.pop(row, range(len(objects))), columns, stated[0])
    mixed = [name for name, unit in stated[0].items() if any(each[name] != unit for each in stated)]
    return table | {name: table[name]._replace(unit=None) for name in mixed}


def dataset(table: Table, about: Mapping[str, Any]) -> Any:
    """The `xarray.Dataset` of a table, with attributes ``about``, lists as lines; raises UsageError without xarray."""
    xarray = library("xarray")
    variables: dict[bool, dict[str, Any]] = {False: {}, True: {}}
    for name, (values, unit, axes, meaning, is_coordinate) in table.items():
        units = {} if unit is None else {"units": unit or "1"}
        variables[is_coordinate][name] = (axes, values, {"long_name": meaning or name.replace("_", " "), **units})
    texts = {name: text if isinstance(text, str) else "\n".join(text) for name, text in about.items()}
    return xarray.Dataset(variables[False], variables[True], {"source": f"shockwave {__version__}"} | texts)


def frame(table: Table, about: Mapping[str, Any]) -> Any:
    """The `pandas.DataFrame` of a table, with units and ``about`` in ``attrs``; raises UsageError without pandas."""
    pandas = library("pandas")
    (row, index), *rest = _flat(table)
    data_frame = pandas.DataFrame(
        {name: one.values for name, one in rest}, index=pandas.Index(index.values, name=row), copy=True
    )
    data_frame.attrs |= {"units": {name: one.unit for name, one in [(row, index), *rest]}, **about}
    return data_frame


def write_table(table: Table, about: Mapping[str, Any], file: str) -> None:
    """Write a table to a file: CSV with the units in the heads of the columns, or NetCDF for the ending ``.nc``."""
    if file.lower().endswith(".nc"):
        write_file(file, bytes(dataset(table, about).to_netcdf()))
        return
    columns = dict(_flat(table))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(f"{name} [{each.unit}]" if each.unit else name for name, each in columns.items())
    writer.writerows(zip(*(each.values.tolist() for each in columns.values()), strict=True))
    write_file(file, text.getvalue())


def cells(table: Table, most: int, most_columns: int, besides: Sequence[int] = ()) -> dict[str, Any]:
    """Header, at most ``most`` evenly chosen rows and those ``besides``, columns likewise, and all numbers, as text."""
    columns = list(_flat(table))
    count = len(columns[0][1].values)
    shown = np.union1d(evenly(count, most), besides).astype(np.intp)
    chosen = [columns[index] for index in evenly(len(columns), most_columns)]
    rows = zip(*([_cell(value, one.unit) for value in one.values[shown].tolist()] for _, one in chosen), strict=True)
    return {"header": [name for name, _ in chosen], "rows": list(rows), "count": count, "columns": len(columns)}


def evenly(count: int, most: int) -> npt.NDArray[np.intp]:
    """Indices of at most ``most`` of ``count`` places, evenly chosen, with both ends."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(np.intp))


def _cell(value: Any, unit: str | None) -> str:
    return si(value, unit or "") if isinstance(value, float) else shorten(str(value))


def _flat(table: Table) -> Iterator[tuple[str, TableColumn]]:
    """Columns along the rows; a quantity with another axis gives a column for each of its values."""
    row = next(iter(table))
    for name, table_column in table.items():
        if table_column.axes == (row,):
            yield name, table_column
        elif table_column.axes[:1] == (row,):
            for index, label in enumerate(table[table_column.axes[1]].values):
                yield f"{name}[{label}]", table_column._replace(values=table_column.values[:, index], axes=(row,))


def library(name: str, extra: str = "tables") -> Any:
    """An optional package; raises UsageError if it cannot be imported; ``extra`` installs it."""
    try:
        return importlib.import_module(name)
    except ImportError as missing:
        remedy = f'python -m pip install "{OWN_DISTRIBUTION}[{extra}]"'
        raise UsageError(f"{name} must be installed (got {missing}; {remedy})") from missing
    except Exception as error:  # for example, matplotlib rejects a setting of the environment
        raise UsageError(f"{name} must be importable (got {message_of(error)})") from error
