"""Progress and outcome of a sweep."""

from __future__ import annotations

import math
from datetime import timedelta
from pathlib import Path
from typing import Any

from attrs import asdict, frozen

from shockwave.base.result import VERSION, Result
from shockwave.base.text import facts, limits, notes, strong


@frozen(kw_only=True, repr=False)
class SweepReport(Result):
    """Outcome of a sweep, or its progress.

    Attributes
    ----------
    folder : pathlib.Path
        Folder of the journal and the results.
    points : int
        Number of points of the sweep.
    done : int
        Points with a result.
    failed : int
        Points with an error.
    crashed : int
        Points that terminated the process that ran them.
    before : int
        Points that earlier runs had finished.
    seconds : float
        Wall time of this run [s].
    warned : int
        Points with warnings, counted at the end.
    files : tuple of pathlib.Path
        Tables that were written.
    notes : tuple of str
        Remarks on versions.
    """

    folder: Path
    points: int
    done: int
    failed: int
    crashed: int
    before: int
    seconds: float
    warned: int = 0
    files: tuple[Path, ...] = ()
    notes: tuple[str, ...] = ()

    _brief = ("folder", "points", "done", "failed", "crashed")

    @property
    def left(self) -> int:
        """Number of points that have not been run."""
        return self.points - self.done - self.failed - self.crashed

    @property
    def warnings(self) -> tuple[str, ...]:
        """Advice on points without a result or with warnings."""
        failed = "column problem of results.csv has the errors; --retry-failed runs them again"
        missing = "the same command runs the missing points"
        warned = f"{_points(self.warned)} with warnings, which are in column notes of results.csv"
        parts = {failed: self.failed or self.crashed, missing: self.left, warned: self.warned}
        return tuple(sentence for sentence, count in parts.items() if count)

    @property
    def exit_code(self) -> int:
        """Exit status of the command line, 0 if every point has a result, else 1."""
        return 0 if self.done == self.points else 1

    def to_dict(self) -> dict[str, Any]:
        """The document that ``sweep --json`` prints."""
        files = [str(file) for file in self.files]
        plain = {"folder": str(self.folder), "files": files, "notes": list(self.notes)}
        return {**VERSION, **asdict(self), **plain, "left": self.left}

    def __str__(self) -> str:
        others = {"failed": self.failed, "crashed": self.crashed, "not run": self.left}
        counts = [f", {count} {state}" for state, count in others.items() if count]
        ran = self.points - self.left - self.before
        spent = timedelta(seconds=math.ceil(self.seconds))
        details = [("this run", f"{_points(ran)} in {spent}" if ran else "nothing to do")]
        if self.before:
            details.append(("earlier runs", _points(self.before)))
        if self.files:
            details.append(("tables", ", ".join(file.name for file in self.files)))
        answer = f"{self.done} of {self.points} points done{''.join(counts)}; results in {self.folder}"
        return "\n".join([strong(answer), *limits(self.warnings), *facts(details), *notes(self.notes)])


def _points(count: int) -> str:
    return "1 point" if count == 1 else f"{count} points"


class SweepInterrupt(KeyboardInterrupt):
    """Raised when the user stops a sweep; ``report`` holds its progress."""

    def __init__(self, report: SweepReport) -> None:
        saved = f"{report.points - report.left} of {report.points} points are saved"
        super().__init__(f"{saved}; run the same command to resume")
        self.report = report
