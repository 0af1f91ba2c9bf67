"""Commands that run the software against itself: bench, stress."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from shockwave.cli.output import print_json
from shockwave.cli.scenes import loaded

if TYPE_CHECKING:
    from shockwave.benchmark.stress.runner import Row

__all__ = ["bench", "stress"]


def bench(options: argparse.Namespace) -> int:
    """Work and precision."""
    from shockwave.benchmark.bench import NotWrittenError, run

    scenarios, status = loaded(options.files, output=options.output)
    if status:
        return status
    tell = _tell if sys.stderr.isatty() else None
    failure = None
    try:
        found = run(scenarios, options.family, options.quick, options.output, options.longest, tell)
    except NotWrittenError as error:  # what was found is not lost with the page
        found, failure = error.result, error
    if options.json:
        print_json(found.to_dict())
    else:
        print(found)
    if failure is not None:
        raise failure
    if options.output:
        print(f"{options.output}: written", file=sys.stderr)
    return 0


def stress(options: argparse.Namespace) -> int:
    """The catalogue of extremes."""
    from shockwave.benchmark.stress.runner import stress as run

    def tell(row: Row) -> None:
        _tell(f"{row.name} ({row.backend}): {'passed' if row.passed else 'FAILED'}")

    found = run(options.names, options.backend, tell if sys.stderr.isatty() else None)
    if options.json:
        print_json(found.to_dict())
    else:
        print(found)
    return found.exit_code


def _tell(text: str) -> None:
    print(text, file=sys.stderr)
