"""A sweep as a NetCDF file: arrays by named axes, with units and where they come from."""

from __future__ import annotations

import json
import re
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt
from scipy.io import netcdf_file, netcdf_variable

from shockwave.sweep.stored import NOTES, Chunk, Column, Header, as_text

__all__ = ["net_cdf"]

# The format is big-endian throughout.
_NUMBER, _FLAG = np.dtype(">f8"), np.dtype(">i4")
_NONE = -1
_STATUS = Column("status", None, "text", "what became of the point")
_NO_WORD = re.compile(r"[^A-Za-z0-9_.+@-]")


@contextmanager
def net_cdf(file: IO[Any], header: Header) -> Iterator[Callable[[Chunk], None]]:
    """NetCDF-3, 64-bit offset, after the CF conventions: text stands as flags with their meanings.

    Columns are gathered in a temporary file, since points come row by row and the format wants column by column.
    """
    with tempfile.TemporaryFile(dir=Path(file.name).parent) as gathered:
        made = _Made(header, gathered)
        yield made.take
        made.write(file)


class _Made:
    def __init__(self, header: Header, gathered: IO[bytes]) -> None:
        self._header, self._gathered = header, gathered
        # sentences are no flags: they stand in the other tables
        self._columns = (*(column for column in header.columns if column.name != NOTES), _STATUS)
        self._words: dict[str, dict[str, int]] = {c.name: {} for c in self._columns if c.kind == "text"}

    def take(self, chunk: Chunk) -> None:
        for place, column in enumerate(self._columns):
            if column is _STATUS:
                given: list[Any] = [row.status for row in chunk.rows]
            else:
                given = [row.values[place] for row in chunk.rows]
            if column.kind == "text":
                words = self._words[column.name]
                given = [None if word is None else words.setdefault(str(word), len(words)) for word in given]
            self._gathered.seek(_NUMBER.itemsize * (place * self._header.points + chunk.begin))
            # None becomes NaN
            self._gathered.write(np.array(given, dtype=float).astype(_NUMBER).tobytes())

    def write(self, file: IO[bytes]) -> None:
        self._gathered.flush()
        shape = (len(self._columns), *self._header.shape)
        gathered = np.memmap(self._gathered, dtype=_NUMBER, mode="r", shape=shape)
        with netcdf_file(file, "w", version=2) as made:
            self._provenance(made)
            coordinates = self._axes(made)
            dimensions = tuple(dimension.name for dimension in self._header.dimensions)
            for column, values in zip(self._columns, gathered, strict=True):
                variable = _variable(made, column, dimensions, values, self._words.get(column.name))
                if coordinates:
                    variable.coordinates = coordinates
            made.flush()

    def _provenance(self, made: Any) -> None:
        header = self._header
        versions = ", ".join(f"{name} {version}" for name, version in header.versions.items())
        told = {
            "Conventions": "CF-1.11",
            "title": header.name,
            "source": f"shockwave sweep, run: {header.run}, with {versions}",
            "history": f"made by shockwave {header.versions.get('shockwave', '')}".rstrip(),
            "scenario": json.dumps(header.scenario, sort_keys=True),
            "sweep_key": header.key,
            "earlier_versions": json.dumps(header.earlier_versions),
        }
        for name, text in told.items():
            setattr(made, name, _bytes(text))

    def _axes(self, made: Any) -> str:
        """Make dimensions and coordinates; names of the coordinates that are not dimensions."""
        beside: list[str] = []
        for dimension, axis in zip(self._header.dimensions, self._header.axes, strict=True):
            made.createDimension(dimension.name, len(axis))
            for name, dotted in dimension.coordinates.items():
                given, unit = axis.along(dotted), self._header.variables[dotted]
                if unit is None:
                    told = [as_text(value) for value in given]
                    words = {word: at for at, word in enumerate(dict.fromkeys(w for w in told if w is not None))}
                    given = [None if word is None else words[word] for word in told]
                column = Column(name, unit, "text" if unit is None else "number", dotted)
                values = np.array(given, dtype=float).astype(_NUMBER)
                _variable(made, column, (dimension.name,), values, words if unit is None else None)
                beside += [name] if name != dimension.name else []
        return " ".join(beside)


def _variable(
    made: Any,
    column: Column,
    dimensions: tuple[str, ...],
    values: npt.NDArray[np.float64],
    words: dict[str, int] | None,
) -> Any:
    """Add a variable that takes ``values`` as they are, without a copy in memory unless they are flags."""
    if words is not None:
        values = np.where(np.isnan(values), _NONE, values).astype(_FLAG)
    kind = values.dtype
    variable: Any = netcdf_variable(values, kind.char, kind.itemsize, values.shape, dimensions)
    made.variables[column.name] = variable
    variable.long_name = _bytes(column.meaning or column.name)
    if words is None:
        variable.units = _bytes(column.unit or "1")
        variable._FillValue = np.array(np.nan, dtype=kind)
    else:
        variable._FillValue = np.array(_NONE, dtype=kind)
        if words:
            variable.flag_values = np.arange(len(words), dtype=kind)
            variable.flag_meanings = " ".join(_plain(list(words))).encode()
    return variable


def _bytes(text: str) -> bytes:
    return text.encode(errors="backslashreplace")


def _plain(words: Sequence[str]) -> list[str]:
    """Words as flags may be called: without blanks, each once."""
    plain = [_NO_WORD.sub("_", word) or "_" for word in words]
    return [word if plain.count(word) == 1 else f"{word}_{at}" for at, word in enumerate(plain)]
