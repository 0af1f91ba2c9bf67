"""The report at the end of a sweep, and the plan before it begins."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from attrs import asdict, frozen

from shockwave.text import printed


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
    batches : int
        In how many batches points were sent to workers.
    overhead : float
        Seconds of a worker for each batch that were not spent on its points: start, sending, journal.
    files : tuple of pathlib.Path
        Tables of results that were written; none if they were there.
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
    batches: int = 0
    overhead: float = 0.0
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
        return printed(self, "shockwave.sweep.sweep_text:report_text")


class SweepInterrupt(KeyboardInterrupt):
    """Raised when the user has stopped a sweep; ``report`` has its progress."""

    def __init__(self, report: SweepReport) -> None:
        super().__init__(str(report))
        self.report = report


@frozen(kw_only=True)
class SweepPlan:
    """The plan of a sweep.

    Attributes
    ----------
    run : str
        What every point does.
    axes : dict of str to int
        Names of the variables of each axis, and how many values it has.
    points, finished : int
        All points; those that the folder has already.
    tried, unbuilt : int
        Points whose scene was built on trial; those whose scene cannot be built.
    problem : str or None
        What is wrong with the first of these.
    workers : int
        How many the estimate is for.
    measured : int
        Points that were run for the estimate.
    seconds : tuple of float or None
        Lowest and highest wall time; None when nothing is left, or could be run.
    notes : tuple of str
        Remarks that a reader must know.
    """

    run: str
    axes: dict[str, int]
    points: int
    finished: int
    tried: int
    unbuilt: int
    problem: str | None
    workers: int
    measured: int
    seconds: tuple[float, float] | None
    notes: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """The document that ``sweep --dry-run --json`` prints."""
        return {**asdict(self), "seconds": self.seconds and list(self.seconds), "notes": list(self.notes)}

    def __str__(self) -> str:
        return printed(self, "shockwave.sweep.sweep_text:plan_text")
