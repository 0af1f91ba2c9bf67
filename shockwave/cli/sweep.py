"""The command that runs sweeps."""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shockwave.cli.output import print_json
from shockwave.errors import UsageError

if TYPE_CHECKING:
    from shockwave.sweep.report import SweepReport

__all__ = ["sweep"]


def sweep(options: argparse.Namespace) -> int:
    """Run a sweep, or go on with it; or tell what that would be."""
    folder = options.out or f"{Path(options.file).stem}-sweep"
    asked = {name: getattr(options, name) for name in ("workers", "retry_failed", "accept_versions")}
    if options.dry_run:
        from shockwave.sweep.plan import plan_sweep

        _print(plan_sweep(options.file, folder, options.executor, **asked), options.json)
        return 0
    from shockwave.sweep.report import SweepInterrupt
    from shockwave.sweep.runner import run_sweep
    from shockwave.sweep.stored import HEADER

    if options.resume and not (Path(folder) / HEADER).exists():
        raise UsageError(f"{folder}: --resume must be given a sweep that was begun (got none; leave --resume out)")
    # what becomes of a connection is told in a sentence, without tracebacks of dask
    logging.getLogger("distributed.client").addFilter(lambda _: False)
    with _progress() as progress:
        try:
            report = run_sweep(
                options.file, folder, options.executor, fail_fast=options.fail_fast, progress=progress, **asked
            )
        except SweepInterrupt as interrupt:
            interrupted: SweepReport | None = interrupt.report
        else:
            interrupted = None
    if interrupted is not None:
        finished = interrupted.points - interrupted.left
        told = f"{finished} of {interrupted.points} points are finished and kept"
        print(f"interrupted; {told}: the same command goes on from there", file=sys.stderr)
        return 130
    _print(report, options.json)
    return report.exit_code


def _print(found: Any, as_json: bool) -> None:
    if as_json:
        print_json(found.to_dict())
    else:
        print(found)


@contextmanager
def _progress() -> Iterator[Callable[[SweepReport], None] | None]:
    """What shows on a terminal how far a sweep is: done, failed, rate, time left."""
    if not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    bar: tqdm[Any] | None = None

    def show(report: SweepReport) -> None:
        nonlocal bar
        if bar is None:
            bar = tqdm(total=report.points, initial=report.before, unit=" points", file=sys.stderr, dynamic_ncols=True)
        if report.failed or report.crashed:
            bar.set_postfix(failed=report.failed + report.crashed, refresh=False)
        bar.update(report.points - report.left - bar.n)

    try:
        yield show
    finally:
        if bar is not None:
            bar.close()
