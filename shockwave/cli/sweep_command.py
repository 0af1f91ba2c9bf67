"""The command that runs sweeps."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

from shockwave.base.errors import UsageError
from shockwave.base.progress import report_progress
from shockwave.base.text import paragraph
from shockwave.cli.output import print_result, progress_on_stderr
from shockwave.sweep.fork_server import start_server

if TYPE_CHECKING:
    from shockwave.sweep.progress_text import SweepReport


def sweep(options: argparse.Namespace) -> int:
    """Run or resume a sweep, or report what a run would take.

    SIGTERM and SIGHUP stop it like Ctrl-C. The exit status is then 128 plus the number of the signal.
    """
    received = [int(signal.SIGINT)]

    def interrupt(number: int, _: FrameType | None) -> None:
        signal.signal(number, signal.SIG_IGN)  # `timeout` sends it twice
        received[0] = number
        raise KeyboardInterrupt

    # sent by a batch system at the end of a job, or by a terminal that is closed
    present = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    handled = [number for number in present if signal.getsignal(number) is signal.SIG_DFL]
    for number in handled:
        signal.signal(number, interrupt)
    # otherwise worker processes start with the current folder on their path
    os.environ.setdefault("PYTHONSAFEPATH", "1")
    try:
        return _sweep(options)
    except KeyboardInterrupt as interrupted:
        text = str(interrupted)
        lines = paragraph("interrupted: " if text else "interrupted", text, 2)
        print("\n".join(lines), file=sys.stderr)
        return 128 + received[0]
    finally:
        for number in handled:
            signal.signal(number, signal.SIG_DFL)


def _sweep(options: argparse.Namespace) -> int:
    if not options.dry_run:
        start_server()
    # imported while the server loads its own modules
    from shockwave.cli.scenario_files import load_with_changes, stem_of
    from shockwave.sweep.definition import DEFINITION
    from shockwave.sweep.runner import dry_run, run_sweep
    from shockwave.sweep.workers import check_workers

    folder = options.output or f"{stem_of(options.file)}-sweep"
    settings = {name: getattr(options, name) for name in ("workers", "retry_failed", "accept_versions")}
    if options.dry_run:
        check_workers(None, options.workers, options.timeout)
        if options.json:
            raise UsageError("--json: must be omitted with --dry-run (got both; the dry run prints text)")
        print(dry_run(load_with_changes(options.file, options), folder, **settings))
        return 0
    if options.resume and not os.path.exists(Path(folder) / DEFINITION):
        raise UsageError(f"{folder}: must hold a sweep to resume (got none; omit --resume to begin one)")
    settings |= {"timeout": options.timeout, "fail_fast": options.fail_fast, "progress": _show}
    with progress_on_stderr():  # ends before an interrupt is reported
        report = run_sweep(load_with_changes(options.file, options), folder, **settings)
    print_result(report, options.json)
    return report.exit_code


def _show(report: SweepReport) -> None:
    report_progress("points", report.points - report.left - report.before, report.points - report.before)
