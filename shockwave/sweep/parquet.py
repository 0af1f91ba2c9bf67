"""A sweep as a Parquet file: a row for each point, units with the columns."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import IO, Any

import pyarrow as pa  # type: ignore[import-not-found,import-untyped,unused-ignore]
import pyarrow.parquet as pq  # type: ignore[import-not-found,import-untyped,unused-ignore]

from shockwave.sweep.stored import Chunk, Header, as_text

__all__ = ["parquet"]


@contextmanager
def parquet(file: IO[Any], header: Header) -> Iterator[Callable[[Chunk], None]]:
    """Written by pyarrow, one group of rows after the other."""
    made = _Made(file, header)
    with made.writer:
        yield made.take


class _Made:
    def __init__(self, file: IO[Any], header: Header) -> None:
        fields: list[Any] = []
        for axis in header.axes:
            for name, unit in zip(axis.names, axis.units, strict=True):
                whole = unit is not None and all(isinstance(value, int | None) for value in axis.along(name))
                kind = pa.string() if unit is None else pa.int64() if whole else pa.float64()
                fields.append(_field(name, kind, unit, name))
        kinds = {"number": pa.float64(), "whole": pa.int64(), "text": pa.string()}
        fields += [_field(one.name, kinds[one.kind], one.unit, one.meaning) for one in header.columns]
        fields += [_field("status", pa.string(), None, ""), _field("problem", pa.string(), None, "")]
        told = {"name": header.name, "run": header.run, "sweep_key": header.key}
        told |= {"versions": json.dumps(header.versions), "scenario": json.dumps(header.scenario, sort_keys=True)}
        self._schema = pa.schema(fields, metadata={key: as_text(text) for key, text in told.items()})
        self._texts = [at for at, field in enumerate(fields) if field.type == pa.string()]
        self.writer = pq.ParquetWriter(file, self._schema)

    def take(self, chunk: Chunk) -> None:
        columns = [list(column) for column in zip(*chunk.points, strict=True)]
        columns += [list(column) for column in zip(*(row.values for row in chunk.rows), strict=True)]
        columns += [[row.status for row in chunk.rows], [row.problem for row in chunk.rows]]
        for at in self._texts:
            columns[at] = [as_text(value) for value in columns[at]]
        arrays = [pa.array(values, field.type) for values, field in zip(columns, self._schema, strict=True)]
        self.writer.write_batch(pa.record_batch(arrays, schema=self._schema))


def _field(name: str, kind: Any, unit: str | None, meaning: str) -> Any:
    return pa.field(name, kind, metadata={"unit": unit or "", "meaning": meaning})
