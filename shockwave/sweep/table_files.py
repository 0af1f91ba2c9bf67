"""Tables of the results of a sweep: CSV and JSON Lines."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

from shockwave.base.files import replace_file
from shockwave.base.progress import report_progress
from shockwave.base.text import replace_unfit
from shockwave.sweep.definition import NOTES, SweepDefinition, as_text, warnings_in
from shockwave.sweep.journal import Journal

# First characters of a cell that a spreadsheet may run as a formula.
_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def write_tables(definition: SweepDefinition, journal: Journal) -> tuple[tuple[Path, ...], int]:
    """Write ``results.csv`` and ``results.jsonl``, with a row or an object for each point in the order of the points.

    Returns
    -------
    tuple of pathlib.Path, int
        The files, and the number of points with warnings.

    Raises
    ------
    FileAccessError
        If a file cannot be read or written. An existing table is then left unchanged.
    """
    files = (journal.folder / "results.csv", journal.folder / "results.jsonl")
    units = definition.units
    heads = [f"{name} [{unit}]" if unit else name for name, unit in units.items()]
    keys = ("index", *units, "status", "problem")
    warned = 0
    with replace_file(files[0]) as table, replace_file(files[1]) as objects:
        writer = csv.writer(table, lineterminator="\n")
        writer.writerow((*heads, "status", "problem"))
        # point by point, so that memory does not grow with their number
        for row in journal.rows(definition):
            values = [*row.point, *row.values, row.status, row.problem]
            writer.writerow([_cell(value) for value in values])
            named = dict(zip(keys, (row.number, *values), strict=True))
            warned += bool(warnings_in(named.get(NOTES)))
            objects.write(json.dumps(named) + "\n")
            report_progress("writing tables", row.number + 1, journal.points)
    return files, warned


def _cell(value: Any) -> Any:
    """The value in CSV; text that a spreadsheet could run as a formula begins with an apostrophe."""
    if isinstance(value, float):
        return value
    text = as_text(value)
    if isinstance(value, str) and value.startswith(_FORMULA):
        try:
            float(value)
        except ValueError:
            text = f"'{value}"
    # not all versions of Python quote a carriage return; a terminal that shows the file would obey control characters
    return text and replace_unfit(text.replace("\r", "\n"))
