"""Commands that run the software against itself: bench, stress."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from shockwave.cli.output import print_json, written
from shockwave.cli.scenes import loaded

if TYPE_CHECKING:
    from shockwave.benchmark.stress import Stress
    from shockwave.benchmark.work_precision import WorkPrecision


def bench(options: argparse.Namespace) -> int:
    """Work and precision."""
    from shockwave.benchmark.bench import run
    from shockwave.benchmark.bench_output import check_output, page

    scenarios = loaded(options.files, output=options.output)
    if options.output:
        check_output(options.output)
    found = run(scenarios, options.family, options.quick, options.longest, _progress)
    _print(found, options.json)
    if options.output:  # last, so that a page that cannot be written costs no result
        return written(page(found), options.output, anew=False)
    return 0


def stress(options: argparse.Namespace) -> int:
    """The catalogue of extremes."""
    from shockwave.benchmark.stress import stress as run

    found = run(options.names, options.backend, _progress)
    _print(found, options.json)
    return found.exit_code


def _print(found: WorkPrecision | Stress, as_json: bool) -> None:
    if as_json:
        print_json(found.to_dict())
    else:
        print(found)


def _progress(text: str) -> None:
    if sys.stderr.isatty():
        print(text, file=sys.stderr)
