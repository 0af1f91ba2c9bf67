"""The command on results of a sweep: plot."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from shockwave.errors import UsageError

__all__ = ["plot"]


def plot(options: argparse.Namespace) -> int:
    """Lines or a map."""
    from shockwave.pictures.canvas import figure, save
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
    file = options.output or Path(options.folder) / f"{found.column}.svg"
    save(found.figure, file)
    for note in found.notes:
        print(f"note: {note}", file=sys.stderr)
    print(f"{file}: written", file=sys.stderr)
    return 0
