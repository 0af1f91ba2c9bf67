"""Base of all results: a short repr, HTML for notebooks, and their tables for pandas and xarray."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import attrs

from shockwave.base.errors import InvalidValueError, UnknownNameError, UsageError, shorten, text_of
from shockwave.base.quantities import unit_of, value_at
from shockwave.base.quantity_fields import join
from shockwave.base.text import Detail, function_at, html_of, render_on_screen, si

if TYPE_CHECKING:  # a result that is only printed needs no arrays
    from matplotlib.axes import Axes

    from shockwave.base.result_tables import Table

#: Version of the JSON documents: the next one when a key is removed or changes its meaning; new keys do not count.
VERSION = {"version": 2}
_T = TypeVar("_T")
# Rows and columns of a table in a notebook, warnings there, and length of the text.
_MOST_ROWS = 8
_MOST_COLUMNS = 40
_MOST_WARNINGS = 12
_LONGEST_TEXT = 10_000
# Attributes with other names than their keys in documents.
_ATTRIBUTES = {"yield": "yielding"}


class cached_property(functools.cached_property[_T]):  # noqa: N801
    """A cached property without the lock of Python 3.11, so that several objects can compute it at the same time."""

    def __get__(self, instance: Any, owner: type | None = None) -> _T:  # type: ignore[override]
        if instance is None:
            return self  # type: ignore[return-value]
        value = instance.__dict__[self.attrname] = self.func(instance)
        return value


def plain(value: Any) -> Any:
    """``value`` for a document: lists in place of tuples and arrays, mappings in place of objects."""
    if isinstance(value, Result):
        return value.to_dict()
    if attrs.has(type(value)):
        return fields_of(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    return [plain(each) for each in value] if isinstance(value, tuple) else value


def fields_of(value: Any) -> dict[str, Any]:
    """Fields of an object that its repr shows, for a document."""
    shown = (each.name for each in attrs.fields(type(value)) if each.repr)
    return {name: plain(getattr(value, name)) for name in shown}


class Result:
    """Base of results; a subclass names its parts, and overrides `_table` if its tables are arrays.

    Attributes
    ----------
    _brief : tuple of str
        Dotted names of the attributes in the repr; they must not need an integration.
    _tables : tuple of (str, str)
        Names of the tables, the main one first, with the names of their rows. The default `_table` reads the attribute
        of this name: a tuple of attrs objects, or a result that is a table itself.
    _picture : str
        Address of the function that draws the result.
    """

    __slots__ = ()
    _brief: ClassVar[tuple[str, ...]] = ()
    _tables: ClassVar[tuple[tuple[str, str], ...]] = ()
    _picture: ClassVar[str] = ""

    def __repr__(self) -> str:
        found = ((name, value_at(self, name)) for name in self._brief)
        shown = (f"{name}={_text(name, value)}" for name, value in found if value is not None)
        return f"<{type(self).__name__} {', '.join(shown)}>"

    def text(self, detail: str = "verbose") -> str:
        """Text of the result: ``short``, as it is printed, ``explain`` with the decision, or ``verbose``.

        Raises
        ------
        InvalidValueError
            If ``detail`` is none of them.
        """
        names = [each.name.lower() for each in Detail]
        if detail not in names:
            raise InvalidValueError.of("detail", f"must be {join(names)} (got {text_of(detail)})")
        return render_on_screen(self, detail=Detail[detail.upper()])

    def _repr_html_(self) -> str:
        """HTML for notebooks: answer, warnings, main table, and the full text to unfold."""
        answer = render_on_screen(self, columns=10_000, wide=True).partition("\n")[0]
        table, rows = self._main_table(), None
        if table is not None:
            from shockwave.base.result_tables import cells

            rows = cells(table, _MOST_ROWS, _MOST_COLUMNS)
        remarks = {kind: sentences[:_MOST_WARNINGS] for kind, sentences in self.remarks().items()}
        text = shorten(self.text(), _LONGEST_TEXT)
        template = Path(__file__).with_name("notebook.html.jinja")
        return html_of(template, answer=answer, remarks=remarks, rows=rows, text=text)

    def _document(self, *names: str) -> dict[str, Any]:
        """Attributes for a document, by their keys."""
        return {name: plain(getattr(self, _ATTRIBUTES.get(name, name))) for name in names}

    def to_dict(self) -> dict[str, Any]:
        """The document that a command prints as JSON."""
        return self._document()

    def write(self, file: str) -> None:
        """Write the main table as CSV, with the units in the heads of the columns, or as NetCDF (``.nc``).

        Raises
        ------
        FileAccessError
            If the file cannot be written.
        UsageError
            If xarray is not installed, for NetCDF, or the result has no table.
        """
        from shockwave.base.result_tables import write_table

        write_table(self._find_table(None), {}, file)

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the picture of the result; `shockwave.pictures` has others.

        Parameters
        ----------
        ax : Axes, optional
            Axes of matplotlib to draw on; default: those of a new figure, ``ax.figure``, which ``pyplot.show`` shows.

        Raises
        ------
        InvalidValueError
            If the result does not have what the picture shows.
        UsageError
            If there is no picture of such a result, or matplotlib is not installed.
        """
        if not self._picture:
            raise UsageError(f"{type(self).__name__} has no picture")
        drawn: Axes = function_at(self._picture)(self, ax=ax)
        return drawn

    def remarks(self) -> dict[str, list[str]]:
        """All ``warnings``, which limit the result, and its ``notes`` on a record."""
        warnings = getattr(self, "warnings", ())
        return {"warnings": list(dict.fromkeys(warnings)), "notes": [*getattr(self, "notes", ())]}

    def _table(self, name: str) -> Table | None:
        """The table of this name; None if the result does not have it."""
        from shockwave.base.result_tables import table_of

        value = getattr(self, name)
        if isinstance(value, Result):
            return value._main_table()
        return table_of(value, dict(self._tables)[name]) if value else None

    def _main_table(self) -> Table | None:
        return next(filter(None, map(self._table, dict(self._tables))), None)

    def _find_table(self, name: str | None) -> Table:
        known = [one for one in dict(self._tables) if name in (None, one)]
        table = next(filter(None, map(self._table, known)), None)
        if table is None:
            names = list(filter(self._table, dict(self._tables)))
            if not names:
                raise UsageError(f"{type(self).__name__} has no table and cannot be converted")
            raise UnknownNameError.of("table of this result", str(name), names)
        return table

    def to_pandas(self, table: str | None = None) -> Any:
        """Return a table as a `pandas.DataFrame`.

        Its ``attrs`` have the SI ``units`` of the columns, and the ``warnings`` and ``notes`` of the result.

        Parameters
        ----------
        table : str, optional
            Name of the table, such as ``waves`` or ``contacts``; by default the main one.

        Raises
        ------
        UnknownNameError
            If the result does not have the table.
        UsageError
            If the result has no tables, or pandas is not installed.
        """
        from shockwave.base.result_tables import frame

        return frame(self._find_table(table), self.remarks())

    def to_xarray(self, table: str | None = None) -> Any:
        """Return a table as an `xarray.Dataset`, in which each variable has the attribute ``units``.

        Parameters and errors as for `to_pandas`, with xarray.
        """
        from shockwave.base.result_tables import dataset

        return dataset(self._find_table(table), {"title": type(self).__name__, **self.remarks()})


def _text(name: str, value: Any) -> str:
    if isinstance(value, float):
        return si(value, unit_of(name))
    return repr(value) if isinstance(value, str) else str(len(value) if isinstance(value, tuple) else value)
