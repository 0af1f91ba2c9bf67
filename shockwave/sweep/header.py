"""The header of a sweep, ``sweep.json``: everything about it but its results, and the hash of that."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal

import attrs
import cattrs
import numpy as np
from attrs import evolve, field, frozen

from shockwave.errors import InvalidValueError
from shockwave.fields import text_of
from shockwave.files import parse_json, read_bytes, replacing

HEADER = "sweep.json"
#: The last column, whose sentences may differ at every point.
NOTES = "notes"
_FORMAT = 1
_REMEDY = "give a folder that `shockwave sweep FILE --out FOLDER` has written"
# Largest header [bytes], enough for some hundred thousand values: parsing takes up to 25 times as much memory.
_MOST_BYTES = 2**24
# Most points of a sweep, as in `shockwave.scenario.sweep_block`.
_MOST_POINTS = 10**7
# Differences that a message lists.
_MOST_LISTED = 4
# Columns of every table after those of the sweep.
_STATE_COLUMNS = ("status", "problem")
_NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9_]")


@frozen
class Column:
    """A quantity that is known of every point.

    Attributes
    ----------
    name : str
        Its name.
    unit : str or None
        SI unit, empty for a number without one; None for text.
    kind : "number", "whole" or "text"
        The type of its values.
    meaning : str
        One line for people.
    """

    name: str
    unit: str | None
    kind: Literal["number", "whole", "text"]
    meaning: str = ""


@frozen
class SweepAxis:
    """Variables that go through their values together.

    Attributes
    ----------
    names : tuple of str
        Dotted names of the variables: one, unless it comes from ``zip`` or ``points``.
    units : tuple of str or None
        SI unit of each, empty for a number without one; None for what is no number.
    values : tuple of tuple
        For each position the values of the variables.
    """

    names: tuple[str, ...]
    units: tuple[str | None, ...]
    values: tuple[tuple[Any, ...], ...]

    def __len__(self) -> int:
        return len(self.values)

    def along(self, name: str) -> list[Any]:
        """The values of the variable ``name``, position by position."""
        at = self.names.index(name)
        return [position[at] for position in self.values]


@frozen(kw_only=True)
class Header:
    """Content of ``sweep.json``.

    Attributes
    ----------
    format : int
        Version of the form of this file.
    name : str
        Name of the scenario, which makes no difference.
    run : str
        What is done at every point.
    axes : tuple of SweepAxis
        In the order of the scenario.
    shape : tuple of int
        Numbers of values along the axes.
    points : int
        Number of points.
    columns : tuple of Column
        Quantities of the results.
    scenario : dict
        The scenario in SI units, without the sweep.
    named : dict of str to str
        Hashes of the materials and files that the scenario names, which may change without a change of it.
    versions, earlier_versions : dict of str to str, tuple of these
        Of what results depend on; of those with which the sweep was run before others were accepted.
    key : str
        SHA-256 over all of these but the name and earlier versions.
    """

    format: int = _FORMAT
    name: str
    run: str
    axes: tuple[SweepAxis, ...]
    shape: tuple[int, ...]
    points: int
    columns: tuple[Column, ...]
    scenario: Any = None
    named: dict[str, str] = field(factory=dict)
    versions: dict[str, str]
    earlier_versions: tuple[dict[str, str], ...] = ()
    key: str = ""

    def keyed(self) -> Header:
        """This header with its key."""
        content = {name: value for name, value in self.document().items() if name in _KEYED}
        return evolve(self, key=hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest())

    def document(self) -> dict[str, Any]:
        """The header as JSON reads it."""
        document: dict[str, Any] = json.loads(json.dumps(cattrs.unstructure(self)))
        return document

    @classmethod
    def read(cls, folder: Path) -> Header:
        """The header in ``folder``.

        Raises
        ------
        FileAccessError
            When there is none that can be read.
        InvalidValueError
            When it is none.
        """
        file = folder / HEADER
        document = parse_json(read_bytes(file, _MOST_BYTES, _REMEDY), str(file), _REMEDY)
        form = document.get("format") if isinstance(document, dict) else None
        if form != _FORMAT:
            problem = f"must be of format {_FORMAT}, which this shockwave reads (got {text_of(form)}; {_REMEDY})"
            raise InvalidValueError.of(str(file), problem)
        try:
            header = cattrs.structure(document, cls)
        except Exception as error:  # cattrs also raises what the values raise
            reasons = "; ".join(cattrs.transform_error(error))
            raise InvalidValueError.of(str(file), f"must be the header of a sweep (got {reasons[:200]})") from None
        if not header._consistent():
            got = f"got {header.points} points of shape {header.shape}; {_REMEDY}"
            raise InvalidValueError.of(str(file), f"must have axes, shape, points and units that agree ({got})")
        return header

    def write(self, folder: Path) -> None:
        """Write the header; raises FileAccessError when that is not possible."""
        with replacing(folder / HEADER) as file:
            file.write(json.dumps(self.document(), indent=1) + "\n")

    def _consistent(self) -> bool:
        """Whether axes, shape, points and units agree, and the values of numbers are numbers."""
        for axis in self.axes:
            for values in axis.values:
                if not len(values) == len(axis.names) == len(axis.units):
                    return False
                pairs = zip(values, axis.units, strict=True)
                if not all(unit is None or isinstance(value, int | float | None) for value, unit in pairs):
                    return False
        agree = self.shape == tuple(map(len, self.axes)) and self.points == math.prod(self.shape)
        return agree and 0 < self.points <= _MOST_POINTS

    def continued(self, there: Header, folder: Path, accept_versions: bool) -> Header:
        """The header with which this sweep goes on in ``folder``, which has the header ``there``.

        Raises
        ------
        InvalidValueError
            When the folder holds another sweep, or one by other versions that are not to be accepted.
        """
        if there.key == self.key:
            return there
        changes = list(_changes(_without_names(there), _without_names(self)))
        texts = [f"{name} {text_of(was)}, now {text_of(now)}" for name, was, now in changes[:_MOST_LISTED]]
        if len(changes) > _MOST_LISTED:
            texts.append(f"and {len(changes) - _MOST_LISTED} more")
        got = "; ".join(texts) or "another key"
        if not changes or not all(name.startswith("versions.") for name, _, _ in changes):
            problem = f"must be of the sweep that is asked for (got {got}; choose another folder)"
            raise InvalidValueError.of(str(folder / HEADER), problem)
        if not accept_versions:
            remedy = "--accept-versions goes on with these, a new folder begins anew"
            raise InvalidValueError.of(str(folder / HEADER), f"must be of the versions in use (got {got}; {remedy})")
        return evolve(self, earlier_versions=(*there.earlier_versions, there.versions))

    @property
    def version_note(self) -> str:
        """A sentence on earlier versions; empty if there are none."""
        if not self.earlier_versions:
            return ""
        earlier = "; ".join(", ".join(map(" ".join, versions.items())) for versions in self.earlier_versions)
        return f"points may have been run with other versions ({earlier})"

    @property
    def variables(self) -> dict[str, str | None]:
        """Dotted names of all variables, and their units."""
        return {name: unit for axis in self.axes for name, unit in zip(axis.names, axis.units, strict=True)}

    @property
    def short_names(self) -> dict[str, str]:
        """Dotted names of the variables to names for arrays: their last part where no other has that, of ASCII."""
        lasts = [name.rpartition(".")[2] for name in self.variables]
        taken = {column.name for column in self.columns} | {*_STATE_COLUMNS, "point"}
        unique = {last for last in lasts if lasts.count(last) == 1} - taken
        return {
            dotted: _NOT_IN_NAMES.sub("_", last if last in unique else dotted)
            for dotted, last in zip(self.variables, lasts, strict=True)
        }

    def point(self, index: int) -> dict[str, Any]:
        """Dotted names and values of a point, counted from 0."""
        found: dict[str, Any] = {}
        for axis, position in zip(self.axes, np.unravel_index(index, self.shape), strict=True):
            found |= zip(axis.names, axis.values[position], strict=True)
        return found


# What the key depends on.
_KEYED = {part.name for part in attrs.fields(Header)} - {"name", "earlier_versions", "key"}


def _without_names(header: Header) -> dict[str, Any]:
    return {name: value for name, value in header.document().items() if name in _KEYED}


def _changes(there: Any, here: Any, name: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Dotted names of what differs, with what it was and what it is."""
    if isinstance(there, Mapping) and isinstance(here, Mapping):
        for key in sorted(there.keys() | here.keys()):
            yield from _changes(there.get(key), here.get(key), f"{name}.{key}" if name else key)
    elif there != here:
        yield name, there, here


def as_text(value: Any) -> str | None:
    """A value that is no number as text; None for none."""
    return value if value is None or isinstance(value, str) else json.dumps(value)
