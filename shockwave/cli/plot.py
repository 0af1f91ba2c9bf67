"""The command on results of a sweep: plot."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

from shockwave.errors import InvalidValueError, UsageError
from shockwave.files import refuse_inputs


def plot(options: argparse.Namespace) -> int:
    """Lines or a map."""
    from shockwave.pictures import figure, save
    from shockwave.sweep.plot import plot as drawn
    from shockwave.sweep.results import load_sweep

    figure()  # what the picture needs is looked for before anything is read
    held = {}
    for text in options.at:
        name, equals, value = text.partition("=")
        if not equals:
            raise UsageError(f"--at: must be NAME=VALUE (got {text!r})")
        if name.strip() in held:
            raise UsageError(f"--at: must name a variable once (got {name.strip()} again; leave one out)")
        held[name.strip()] = value.strip()
    found = drawn(load_sweep(options.folder), options.column, options.x, held)
    file = Path(options.output or Path(options.folder) / _name(found.column, options.x, held))
    results = (each for each in Path(options.folder).iterdir() if each.suffix != file.suffix)
    refuse_inputs(file, results)
    state = "replaced" if file.exists() else "written"
    try:
        save(found.figure, file)
    except InvalidValueError as error:
        raise InvalidValueError.of("--output", error.faults[0].problem) from None
    for note in found.notes:
        print(f"note: {note}", file=sys.stderr)
    print(f"{file}: {state}", file=sys.stderr)
    return 0


def _name(column: str, x: str | None, held: dict[str, str]) -> str:
    """Name of a picture in the folder, by the options, so that one does not replace another."""
    asked = [column, *(f"{name}={value}" for name, value in sorted(held.items())), *([f"over-{x}"] if x else [])]
    return re.sub(r"[^\w.=+-]+", "_", "-".join(asked)) + ".svg"
