"""The command that runs sweeps."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

from shockwave.cli.output import print_result
from shockwave.errors import UsageError

if TYPE_CHECKING:
    from shockwave.sweep.report import SweepReport


def sweep(options: argparse.Namespace) -> int:
    """Run or resume a sweep, or print the plan of a dry run.

    SIGTERM and SIGHUP end it as Ctrl-C does; the status is 128 plus the number of the signal.
    """
    came = [int(signal.SIGINT)]

    def interrupt(number: int, _: FrameType | None) -> None:
        signal.signal(number, signal.SIG_IGN)  # `timeout` sends it twice
        came[0] = number
        raise KeyboardInterrupt

    # from a batch system at the end of a job, or from a closed terminal
    known = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    ours = [number for number in known if signal.getsignal(number) is signal.SIG_DFL]
    for number in ours:
        signal.signal(number, interrupt)
    # worker processes begin with the current folder on their path
    os.environ.setdefault("PYTHONSAFEPATH", "1")
    try:
        return _sweep(options)
    except KeyboardInterrupt as interrupted:
        progress = f"; {interrupted}" if str(interrupted) else ""
        with suppress(OSError):  # the terminal may be closed
            print(f"interrupted{progress}", file=sys.stderr)
        return 128 + came[0]
    finally:
        for number in ours:
            signal.signal(number, signal.SIG_DFL)


def _sweep(options: argparse.Namespace) -> int:
    folder = options.out or f"{Path(options.file).stem}-sweep"
    asked = {name: getattr(options, name) for name in ("workers", "retry_failed", "accept_versions")}
    if options.dry_run:
        from shockwave.sweep.dry_run import plan_sweep
        from shockwave.sweep.workers import check_executor

        check_executor(options.executor or "processes")
        print_result(plan_sweep(options.file, folder, **asked), options.json)
        return 0
    from shockwave.sweep.definition import DEFINITION
    from shockwave.sweep.runner import run_sweep

    if options.resume and not (Path(folder) / DEFINITION).exists():
        raise UsageError(f"{folder}: --resume must be given a sweep that was begun (got none; leave --resume out)")
    with _progress() as progress:
        report = run_sweep(
            options.file,
            folder,
            options.executor,
            timeout=options.timeout,
            fail_fast=options.fail_fast,
            progress=progress,
            **asked,
        )
    print_result(report, options.json)
    return report.exit_code


@contextmanager
def _progress() -> Iterator[Callable[[SweepReport], None] | None]:
    """Show the progress of a sweep on a terminal: done, failed, rate, time left."""
    if not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    with tqdm(unit=" points", file=sys.stderr, dynamic_ncols=True) as bar:

        def show(report: SweepReport) -> None:
            if bar.total is None:
                bar.total = report.points
                bar.initial = bar.n = report.before
            if report.failed or report.crashed:
                bar.set_postfix(failed=report.failed + report.crashed, refresh=False)
            bar.update(report.points - report.left - bar.n)

        yield show
