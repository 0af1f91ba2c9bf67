"""Definition of a sweep, stored in ``sweep.json``: axes, columns, scenario and versions."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from attrs import asdict, evolve, field, frozen

from shockwave.base.errors import InvalidValueError
from shockwave.base.files import parse_json, read_bytes, replace_file, structure_document
from shockwave.base.quantities import Kind
from shockwave.base.quantity_fields import text_of
from shockwave.scenario.sweep_block import Sweep

DEFINITION = "sweep.json"
#: Name of the last column, whose text may differ at every point.
NOTES = "notes"
# Beginning of each note on a record in this column, after the warnings.
_NOTE = "Note: "
_FORMAT = 4
_REMEDY = "choose a folder that `shockwave sweep FILE -o FOLDER` has written"
# Largest file [bytes], more than a million numbers need; parsing takes up to 25 times as much memory.
_MOST_BYTES = 2**25
# Most differences that a message lists.
_MOST_LISTED = 4
# Names of arrays that a variable must not have.
_RESERVED = {"status", "problem", "point"}
# Attributes on which the results depend.
_CONTENT = ("format", "run", "axes", "columns", "scenario", "named", "versions")


@frozen
class Column:
    """A quantity with a value at every point.

    Attributes
    ----------
    name : str
        Its name.
    unit : str or None
        SI unit, empty for a dimensionless number; None for text.
    kind : "number", "whole" or "text"
        Type of its values.
    meaning : str
        Description in one line.
    quantity : str
        Its name in scenarios and designs.
    """

    name: str
    unit: str | None
    kind: Kind
    meaning: str = ""
    quantity: str = ""


@frozen(kw_only=True)
class SweepDefinition(Sweep):
    """Scenes, task, columns and versions of a sweep.

    Attributes
    ----------
    format : int
        Version of the file format.
    name : str
        Name of the scenario, on which the results do not depend.
    run : str
        Task at every point: ``predict``, ``simulate`` or ``compare``.
    axes : tuple of SweepAxis
        Axes in the order of the scenario; the last one varies fastest.
    columns : tuple of Column
        Quantities, with units and descriptions.
    scenario : dict
        The scenario in SI units, without the sweep.
    named : dict of str to str
        Hashes of the materials and files among the values, which may change although the scenario does not.
    versions : dict of str to str
        Versions of the software on which the results depend.
    earlier_versions : tuple of dict
        Versions with which points were run before others were accepted.
    """

    format: int = field(default=_FORMAT)
    name: str
    columns: tuple[Column, ...]
    scenario: Any
    named: dict[str, str]
    versions: dict[str, str]
    earlier_versions: tuple[dict[str, str], ...] = ()

    @format.validator
    def _check_format(self, _: Any, value: int) -> None:
        if value != _FORMAT:
            raise InvalidValueError.of("format", f"must be {_FORMAT} (got {value}, of another version of shockwave)")

    @property
    def variables(self) -> dict[str, str | None]:
        """Units of all variables by their dotted names."""
        return {name: unit for axis in self.axes for name, unit in zip(axis.names, axis.units, strict=True)}

    @property
    def units(self) -> dict[str, str | None]:
        """SI units of variables and columns by name: empty for a dimensionless number, None for text."""
        return self.variables | {column.name: column.unit for column in self.columns}

    @property
    def short_names(self) -> dict[str, str]:
        """Array names of the variables by dotted names: the last part, if it is unique."""
        lasts = [name.rpartition(".")[2] for name in self.variables]
        taken = _RESERVED.union(column.name for column in self.columns)
        short = {}
        for dotted, last in zip(self.variables, lasts, strict=True):
            name = last if lasts.count(last) == 1 and last not in taken else dotted
            short[dotted] = re.sub(r"\W", "_", name)
        return short

    @property
    def version_notes(self) -> list[str]:
        """A sentence that lists earlier versions, if there are any."""
        earlier = "; ".join(", ".join(map(" ".join, versions.items())) for versions in self.earlier_versions)
        return [f"points may have been run with other versions ({earlier})"] if earlier else []

    def _content(self) -> dict[str, Any]:
        """Everything on which the results depend, in the form that JSON returns."""
        content = {name: getattr(self, name) for name in _CONTENT}
        return dict(json.loads(json.dumps(content, default=asdict)))

    def _identity(self) -> dict[str, Any]:
        """The content as mappings, without the meanings of the columns, whose wording may change."""
        content = self._content()
        columns = {column["name"]: column["unit"] or column["kind"] for column in content["columns"]}
        axes = {", ".join(axis["names"]): _by_number(axis) for axis in content["axes"]}
        orders = {"order of axes": "; ".join(axes), "order of columns": ", ".join(columns)}
        return content | {"axes": axes, "columns": columns} | orders

    # ---------------------------------------------------------------- the file

    @classmethod
    def read(cls, folder: Path) -> SweepDefinition:
        """Read the definition in ``folder``.

        Raises
        ------
        FileAccessError
            If the file cannot be read.
        InvalidValueError
            If it does not hold the definition of a sweep.
        """
        file = str(folder / DEFINITION)
        document = parse_json(read_bytes(file, _MOST_BYTES, _REMEDY), file, _REMEDY)
        return structure_document(document, SweepDefinition, file, "the definition of a sweep", _REMEDY)

    def save(self, folder: Path) -> None:
        """Write the definition, one attribute on each line.

        Raises
        ------
        FileAccessError
            If the file cannot be written.
        """
        document = self._content() | {"name": self.name, "earlier_versions": self.earlier_versions}
        lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(value)}" for name, value in document.items())
        with replace_file(folder / DEFINITION) as file:
            file.write(f"{{\n{lines}\n}}\n")

    def differences(self, other: SweepDefinition) -> dict[str, str]:
        """Return the differences from ``other`` by dotted names, with both values."""
        changes = _changes(self._identity(), other._identity())
        # columns follow from the rest, so they come last
        ordered = sorted(changes, key=lambda change: "columns" in change[0])
        return {name: f"{text_of(here)}, now {text_of(there)}" for name, here, there in ordered}

    def resume(self, earlier: SweepDefinition, folder: Path, accept_versions: bool) -> SweepDefinition:
        """Return the definition with which this sweep resumes the one in ``folder``, with the definition ``earlier``.

        Raises
        ------
        InvalidValueError
            If the folder holds another sweep, or one of other versions and ``accept_versions`` is false.
        """
        changes = earlier.differences(self)
        if not changes:
            return earlier
        file = str(folder / DEFINITION)
        got = "; ".join([" ".join(change) for change in changes.items()][:_MOST_LISTED])
        if not all(name.startswith("versions.") for name in changes):
            problem = f"must hold the requested sweep (got {got}; choose another folder)"
            raise InvalidValueError.of((), problem, file)
        if not accept_versions:
            remedy = "use --accept-versions to resume with the installed versions, or choose a new folder"
            raise InvalidValueError.of((), f"must hold the installed versions (got {got}; {remedy})", file)
        return evolve(self, earlier_versions=(*earlier.earlier_versions, earlier.versions))


def _by_number(axis: dict[str, Any]) -> dict[str, Any]:
    """An axis with the numbers of its values, counted from 1."""
    names, values = axis["names"], axis["values"]
    by_name = (dict(zip(names, position, strict=True)) if len(names) > 1 else position[0] for position in values)
    return {"units": axis["units"], "number of values": len(values), "value": dict(enumerate(by_name, start=1))}


def _changes(left: Any, right: Any, name: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Dotted names of all differences, with both values."""
    if isinstance(left, Mapping) and isinstance(right, Mapping):
        for key in sorted(left.keys() | right.keys()):
            yield from _changes(left.get(key), right.get(key), f"{name}.{key}" if name else key)
    elif left != right:
        yield name, left, right


def remarks_of(warnings: Iterable[str], notes: Iterable[str]) -> str | None:
    """Return the text of the column of warnings and notes; None for none."""
    return " ".join(dict.fromkeys([*warnings, *(f"{_NOTE}{note}" for note in notes)])) or None


def warnings_in(remarks: str | None) -> str:
    """Return the warnings in the text of this column."""
    return (remarks or "").partition(_NOTE)[0].rstrip()


def folder_path(folder: str | os.PathLike[str]) -> Path:
    """Return the path of the folder of a sweep; raises InvalidValueError if it is not a path."""
    try:
        return Path(folder)
    except TypeError:
        problem = f"must be the path of a folder, such as 'results' (got {text_of(folder)})"
        raise InvalidValueError.of("folder", problem) from None


def as_text(value: Any) -> str | None:
    """Return a value that is not a number as text; None for None."""
    return value if value is None or isinstance(value, str) else json.dumps(value)
