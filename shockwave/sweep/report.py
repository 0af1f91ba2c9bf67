"""The report on a sweep that has ended or was interrupted."""

from __future__ import annotations

from datetime import timedelta
from pathlib import Path
from typing import Any

from attrs import asdict, frozen

from shockwave.text import notes


@frozen(kw_only=True)
class SweepReport:
    """How a sweep ended.

    Attributes
    ----------
    folder : pathlib.Path
        The place of journal and results.
    points, done, failed, crashed : int
        All points; those with a result; those with an error; those that ended the process that ran them.
    before : int
        Points that were finished when it began.
    seconds : float
        Wall time.
    files : tuple of pathlib.Path
        Tables of results that were written.
    notes : tuple of str
        Remarks that a reader must know.
    """

    folder: Path
    points: int
    done: int
    failed: int
    crashed: int
    before: int
    seconds: float
    files: tuple[Path, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def left(self) -> int:
        """Points that were not run."""
        return self.points - self.done - self.failed - self.crashed

    @property
    def exit_code(self) -> int:
        """Exit status of the command line: 1 if not every point has a result."""
        return 0 if self.done == self.points else 1

    def to_dict(self) -> dict[str, Any]:
        """The document that ``sweep --json`` prints."""
        files = [str(file) for file in self.files]
        plain = {"folder": str(self.folder), "files": files, "notes": list(self.notes)}
        return {**asdict(self), **plain, "left": self.left}

    def __str__(self) -> str:
        others = {"failed": self.failed, "crashed": self.crashed, "not run": self.left}
        counts = [f", {count} {state}" for state, count in others.items() if count]
        spent = timedelta(seconds=round(self.seconds))
        ran = self.points - self.left - self.before
        lines = [
            f"{self.folder}: {self.done} of {self.points} points are done{''.join(counts)}",
            f"  now          {f'{ran} run in {spent}' if ran else 'nothing to do'}",
        ]
        if self.before:
            lines.append(f"  before       {self.before}")
        if self.files:
            lines.append(f"  written      {', '.join(file.name for file in self.files)}")
        remarks = list(self.notes)
        if self.failed or self.crashed:
            remarks.append("errors stand in results.csv, column problem; --retry-failed runs these points again")
        return "\n".join(lines + notes(remarks))


class SweepInterrupt(KeyboardInterrupt):
    """Raised when the user has stopped a sweep; ``report`` has its progress."""

    def __init__(self, report: SweepReport) -> None:
        finished = f"{report.points - report.left} of {report.points} points are finished and kept"
        super().__init__(f"{finished}: the same command resumes the sweep")
        self.report = report
