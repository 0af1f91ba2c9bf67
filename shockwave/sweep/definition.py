"""The definition of a sweep, which the file ``sweep.json`` holds: axes, columns, scenario and versions."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal

import cattrs
import numpy as np
from attrs import evolve, field, frozen
from attrs.validators import in_, min_len

from shockwave.errors import InvalidValueError
from shockwave.fields import text_of
from shockwave.files import parse_json, read_bytes, replacing

DEFINITION = "sweep.json"
#: The last column, whose sentences may differ at every point.
NOTES = "notes"
_FORMAT = 2
_REMEDY = "give a folder that `shockwave sweep FILE --out FOLDER` has written"
# Largest file [bytes], enough for some hundred thousand values: parsing takes up to 25 times as much memory.
_MOST_BYTES = 2**24
# Most points of a sweep, as in `shockwave.scenario.sweep_block`.
_MOST_POINTS = 10**7
# Differences that a message lists.
_MOST_LISTED = 4
# Names in arrays that a variable must not have.
_TAKEN = {"status", "problem", "point"}
# What results depend on.
_CONTENT = ("format", "run", "axes", "columns", "scenario", "named", "versions")


@frozen
class Column:
    """A quantity with a value at every point.

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

    def __attrs_post_init__(self) -> None:
        for position in self.values:
            for value, _, unit in zip(position, self.names, self.units, strict=True):
                if unit is not None and not isinstance(value, int | float | None):
                    raise ValueError(f"a value with a unit must be a number (got {text_of(value)})")

    def __len__(self) -> int:
        return len(self.values)

    def along(self, name: str) -> list[Any]:
        """The values of the variable ``name``, position by position."""
        at = self.names.index(name)
        return [position[at] for position in self.values]


@frozen(kw_only=True)
class SweepDefinition:
    """What was asked of every point, of which scenes, and by which versions.

    Attributes
    ----------
    format : int
        Version of the form of the file.
    name : str
        Name of the scenario, which makes no difference.
    run : str
        What is done at every point: ``predict``, ``simulate`` or ``compare``.
    axes : tuple of SweepAxis
        In the order of the scenario; the last is gone through first.
    columns : tuple of Column
        The quantities, with units and meanings.
    scenario : dict
        The scenario in SI units, without the sweep.
    named : dict of str to str
        Hashes of the materials and files that the sweep names, which may change without a change of the scenario.
    versions, earlier_versions : dict of str to str, tuple of these
        Of what results depend on; of those with which the sweep was run before others were accepted.
    """

    format: int = field(default=_FORMAT, validator=in_([_FORMAT]))
    name: str
    run: str
    axes: tuple[SweepAxis, ...] = field(validator=min_len(1))
    columns: tuple[Column, ...]
    scenario: Any
    named: dict[str, str]
    versions: dict[str, str]
    earlier_versions: tuple[dict[str, str], ...] = ()

    def __attrs_post_init__(self) -> None:
        if not 0 < self.points <= _MOST_POINTS:
            raise ValueError(f"the axes must have 1 to {_MOST_POINTS:g} points (got {self.points})")

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of values along the axes."""
        return tuple(map(len, self.axes))

    @property
    def points(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    @property
    def variables(self) -> dict[str, str | None]:
        """Dotted names of all variables, and their units."""
        return {name: unit for axis in self.axes for name, unit in zip(axis.names, axis.units, strict=True)}

    @property
    def units(self) -> dict[str, str | None]:
        """SI units of variables and columns by name: empty for a number without one, None for text."""
        return self.variables | {column.name: column.unit for column in self.columns}

    @property
    def short_names(self) -> dict[str, str]:
        """Dotted names of the variables to names for arrays: their last part where no other has that."""
        lasts = [name.rpartition(".")[2] for name in self.variables]
        taken = _TAKEN.union(column.name for column in self.columns)
        found = {}
        for dotted, last in zip(self.variables, lasts, strict=True):
            name = last if lasts.count(last) == 1 and last not in taken else dotted
            found[dotted] = re.sub(r"\W", "_", name)
        return found

    @property
    def key(self) -> str:
        """SHA-256 over everything that results depend on."""
        return hashlib.sha256(json.dumps(self._content(), sort_keys=True).encode()).hexdigest()

    @property
    def version_notes(self) -> list[str]:
        """A sentence on earlier versions, if there are any."""
        earlier = "; ".join(", ".join(map(" ".join, versions.items())) for versions in self.earlier_versions)
        return [f"points may have been run with other versions ({earlier})"] if earlier else []

    def point(self, index: int) -> dict[str, Any]:
        """Dotted names and values of a point, counted from 0."""
        found: dict[str, Any] = {}
        for axis, position in zip(self.axes, np.unravel_index(index, self.shape), strict=True):
            found |= zip(axis.names, axis.values[position], strict=True)
        return found

    def _content(self) -> dict[str, Any]:
        """Everything that results depend on, as JSON reads it."""
        content = {name: getattr(self, name) for name in _CONTENT}
        found: dict[str, Any] = json.loads(json.dumps(cattrs.unstructure(content)))
        return found

    # ---------------------------------------------------------------- the file

    @classmethod
    def read(cls, folder: Path) -> SweepDefinition:
        """The definition in ``folder``.

        Raises
        ------
        FileAccessError
            When there is none that can be read.
        InvalidValueError
            When it is none.
        """
        file = str(folder / DEFINITION)
        document = parse_json(read_bytes(file, _MOST_BYTES, _REMEDY), file, _REMEDY)
        try:
            return cattrs.structure(document, SweepDefinition)
        except Exception as error:  # cattrs also raises what the values raise
            reasons = "; ".join(cattrs.transform_error(error))
            problem = f"must be the definition of a sweep (got {reasons[:200]}; {_REMEDY})"
            raise InvalidValueError.of(file, problem) from None

    def write(self, folder: Path) -> None:
        """Write the definition; raises FileAccessError when that is not possible."""
        names = {"name": self.name, "earlier_versions": self.earlier_versions}
        with replacing(folder / DEFINITION) as file:
            file.write(json.dumps(self._content() | names, indent=1) + "\n")

    def differences(self, other: SweepDefinition) -> dict[str, str]:
        """Dotted names of what differs, with what it is here and in ``other``."""
        changes = _changes(self._content(), other._content())
        return {name: f"{text_of(here)}, now {text_of(there)}" for name, here, there in changes}

    def resumed(self, there: SweepDefinition, folder: Path, accept_versions: bool) -> SweepDefinition:
        """The definition with which this sweep is resumed in ``folder``, which holds the definition ``there``.

        Raises
        ------
        InvalidValueError
            When the folder holds another sweep, or one by other versions that are not to be accepted.
        """
        changes = there.differences(self)
        if not changes:
            return there
        file = str(folder / DEFINITION)
        got = "; ".join([" ".join(change) for change in changes.items()][:_MOST_LISTED])
        if not all(name.startswith("versions.") for name in changes):
            problem = f"must be of the requested sweep (got {got}; choose another folder)"
            raise InvalidValueError.of(file, problem)
        if not accept_versions:
            remedy = "--accept-versions resumes with these, a new folder begins anew"
            raise InvalidValueError.of(file, f"must be of the versions in use (got {got}; {remedy})")
        return evolve(self, earlier_versions=(*there.earlier_versions, there.versions))


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
