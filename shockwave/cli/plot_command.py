"""The command that plots results of a sweep."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

from shockwave.base.errors import UsageError
from shockwave.base.files import refuse_inputs, refuse_link
from shockwave.base.text import limits, paragraph
from shockwave.cli.output import PICTURES, announce_file, check_output, report_name_as_usage
from shockwave.pictures import figure, save
from shockwave.sweep.results import load_sweep
from shockwave.sweep.sweep_picture import plot as draw_results

# Width and height [in].
_SIZE = (5.0, 3.4)


def plot(options: argparse.Namespace) -> int:
    """Draw lines or a map."""
    sheet, (ax,) = figure(size=_SIZE)  # fails early without matplotlib
    check_output(options.output, *PICTURES)
    fixed = {}
    for text in options.at:
        name, equals, value = text.partition("=")
        if not equals:
            raise UsageError(f"--at: must be NAME=VALUE (got {text!r})")
        if name.strip() in fixed:
            raise UsageError(f"--at: must name a variable once (got {name.strip()} twice)")
        fixed[name.strip()] = value.strip()
    with report_name_as_usage():
        picture = draw_results(load_sweep(options.folder), options.column, options.x, fixed, ax=ax)
    file = Path(options.output or Path(options.folder) / _name(picture.column, options.x, fixed))
    if not options.output:  # the folder may come from elsewhere
        refuse_link(file)
    results = (each for each in Path(options.folder).iterdir() if each.suffix != file.suffix)
    refuse_inputs(file, results)
    with announce_file(file):
        save(sheet, file)
    accuracy, *missing = picture.notes
    lines = [*limits(missing), *paragraph("  ", accuracy, 2)]
    print("\n".join(lines), file=sys.stderr)
    return 0


def _name(column: str, x: str | None, fixed: dict[str, str]) -> str:
    """File name of a picture, made from the options, so that pictures do not replace each other."""
    parts = [column, *(f"{name}={value}" for name, value in sorted(fixed.items())), *([f"over-{x}"] if x else [])]
    return re.sub(r"[^\w.=+-]+", "_", "-".join(parts)) + ".svg"
