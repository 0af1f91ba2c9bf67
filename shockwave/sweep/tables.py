"""Tables of the results of a sweep: CSV and JSON Lines."""

from __future__ import annotations

import csv
import json
from functools import lru_cache
from io import StringIO
from pathlib import Path
from typing import Any

from shockwave.files import replacing
from shockwave.progress import progressed
from shockwave.sweep.definition import SweepDefinition, as_text
from shockwave.sweep.journal import Digits, Journal

# Texts of values that are kept.
_MOST_KEPT = 4096


def write_tables(definition: SweepDefinition, journal: Journal) -> tuple[Path, ...]:
    """Write ``results.csv`` and ``results.jsonl``, with a row or an object for each point in the order of the points.

    Raises
    ------
    FileAccessError
        If a file cannot be read or written. An existing table is then left unchanged.
    """
    files = (journal.folder / "results.csv", journal.folder / "results.jsonl")
    units = definition.units
    heads = [f"{name} [{unit}]" if unit else name for name, unit in units.items()]
    keys = [json.dumps(name).replace("%", "%%") for name in ("index", *units, "status", "problem")]
    entries = ", ".join(f"{key}: %s" for key in keys)
    known = lru_cache(_MOST_KEPT, typed=True)(_texts)  # most values occur at many points

    def texts_of(value: Any) -> tuple[str, str]:
        return _texts(value) if isinstance(value, dict | list) else known(value)  # those cannot be keys of the cache

    with replacing(files[0]) as table, replacing(files[1]) as objects:
        table.write(",".join(_cell(head) for head in (*heads, "status", "problem")) + "\n")
        # point by point, so that memory does not grow with their number
        for row in journal.rows(definition, Digits):
            values = [*row.point, *row.values, row.status, row.problem]
            pairs = [(value, value) if type(value) is Digits else texts_of(value) for value in values]
            cells, texts = zip(*pairs, strict=True)
            table.write(",".join(cells) + "\n")
            objects.write(f"{{{entries % (row.number, *texts)}}}\n")
            progressed("writing tables", row.number + 1, journal.points)
    return files


def _texts(value: Any) -> tuple[str, str]:
    """A value as a cell and in JSON, both with all digits."""
    return _cell(as_text(value)), json.dumps(value)


def _cell(text: str | None) -> str:
    """A text as a cell of a row, in quotation marks where it needs them."""
    row = StringIO()
    csv.writer(row, lineterminator="\n").writerow((text, None))
    return row.getvalue().removesuffix(",\n")
