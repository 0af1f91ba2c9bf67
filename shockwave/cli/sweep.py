"""The command that runs sweeps."""

from __future__ import annotations

import argparse
import logging
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

from shockwave.cli.output import print_json
from shockwave.errors import UsageError

if TYPE_CHECKING:
    from shockwave.sweep.report import SweepReport


# Signals that end a program: from a batch system at the end of a job, or from a closed terminal.
_ENDS = ("SIGTERM", "SIGHUP")


def sweep(options: argparse.Namespace) -> int:
    """Run or resume a sweep, or print the plan of a dry run.

    SIGTERM and SIGHUP end it as Ctrl-C does; the status is 128 plus the number of the signal.
    """
    with _interrupting() as came:
        try:
            return _sweep(options)
        except KeyboardInterrupt as interrupt:
            with suppress(OSError):  # the terminal may be closed
                print(_message(interrupt), file=sys.stderr)
            return 128 + (came[0] if came else signal.SIGINT)


@contextmanager
def _interrupting() -> Iterator[list[int]]:
    """Turn the first signal that would end the program into an interrupt, and record all such signals.

    Ignored signals remain ignored.
    """
    came: list[int] = []

    def note(number: int, _: FrameType | None) -> None:
        came.append(number)
        if len(came) == 1:
            raise KeyboardInterrupt

    known = [getattr(signal, name) for name in _ENDS if hasattr(signal, name)]
    ours = [number for number in known if signal.getsignal(number) is signal.SIG_DFL]
    for number in ours:
        signal.signal(number, note)
    try:
        yield came
    finally:
        for number in ours:
            signal.signal(number, signal.SIG_DFL)


def _message(interrupt: KeyboardInterrupt) -> str:
    """Message with the progress of the sweep, if it had started."""
    from shockwave.sweep.report import SweepInterrupt

    if not isinstance(interrupt, SweepInterrupt):
        return "interrupted"
    report = interrupt.report
    finished = f"{report.points - report.left} of {report.points} points are finished and kept"
    return f"interrupted; {finished}: the same command goes on from there"


def _sweep(options: argparse.Namespace) -> int:
    folder = options.out or f"{Path(options.file).stem}-sweep"
    asked = {name: getattr(options, name) for name in ("workers", "timeout", "retry_failed", "accept_versions")}
    if options.dry_run:
        from shockwave.sweep.plan import plan_sweep

        _print(plan_sweep(options.file, folder, options.executor, **asked), options.json)
        return 0
    from shockwave.sweep.header import HEADER
    from shockwave.sweep.runner import run_sweep

    if options.resume and not (Path(folder) / HEADER).exists():
        raise UsageError(f"{folder}: --resume must be given a sweep that was begun (got none; leave --resume out)")
    # a lost connection is reported in a sentence, without tracebacks of dask
    logging.getLogger("distributed.client").addFilter(lambda _: False)
    with _progress() as progress:
        report = run_sweep(
            options.file, folder, options.executor, fail_fast=options.fail_fast, progress=progress, **asked
        )
    _print(report, options.json)
    return report.exit_code


def _print(found: Any, as_json: bool) -> None:
    if as_json:
        print_json(found.to_dict())
    else:
        print(found)


@contextmanager
def _progress() -> Iterator[Callable[[SweepReport], None] | None]:
    """Show the progress of a sweep on a terminal: done, failed, rate, time left."""
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
