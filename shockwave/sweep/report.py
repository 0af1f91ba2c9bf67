"""What a sweep tells when it ends, and before it begins."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from attrs import asdict, frozen

from shockwave.text import notes as lines_of
from shockwave.text import si

__all__ = ["SweepInterrupt", "SweepPlan", "SweepReport", "duration"]


@frozen(kw_only=True)
class SweepReport:
    """How a sweep ended.

    Attributes
    ----------
    folder : pathlib.Path
        Where journal and results stand.
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
        What a reader must know.
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
        """What the command line ends with: 1 if not every point has a result."""
        return 0 if self.done == self.points else 1

    def to_dict(self) -> dict[str, Any]:
        """What ``sweep --json`` prints."""
        found = {**asdict(self), "folder": str(self.folder), "files": [str(file) for file in self.files]}
        return {**found, "left": self.left, "notes": list(self.notes)}

    def __str__(self) -> str:
        ran = self.points - self.left - self.before
        head = f"{self.folder}: {self.done} of {self.points} points are done"
        others = {"failed": self.failed, "crashed": self.crashed, "not run": self.left}
        head += "".join(f", {count} {what}" for what, count in others.items() if count)
        lines = [
            head,
            f"  now          {ran} run in {duration(self.seconds)}" if ran else "  now          nothing to do",
        ]
        if self.batches:
            lines.append(f"  batches      {self.batches}, overhead of each {si(self.overhead, 's', 3)} of a worker")
        if self.before:
            lines.append(f"  before       {self.before}")
        if self.files:
            lines.append(f"  written      {', '.join(file.name for file in self.files)}")
        more = list(self.notes)
        if self.failed or self.crashed:
            more.append("errors stand in results.csv, column problem; --retry-failed runs these points again")
        return "\n".join(lines + lines_of(more))


class SweepInterrupt(KeyboardInterrupt):
    """The user has stopped a sweep; ``report`` says how far it is."""

    def __init__(self, report: SweepReport) -> None:
        super().__init__(str(report))
        self.report = report


@frozen(kw_only=True)
class SweepPlan:
    """What a sweep would do.

    Attributes
    ----------
    run : str
        What is done at every point.
    axes : dict of str to int
        Names of the variables of each axis, and how many values it has.
    points, finished : int
        All points; those that the folder has already.
    tried, unbuilt : int
        Points of which it was tried to make the scene; those of which none can be made.
    problem : str or None
        What is wrong with the first of these.
    workers : int
        How many the estimate is for.
    measured : int
        Points that were run for the estimate.
    seconds : tuple of float or None
        Between what wall times it will take; None when nothing is left, or could be run.
    notes : tuple of str
        What a reader must know.
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
        """What ``sweep --dry-run --json`` prints."""
        return {**asdict(self), "seconds": self.seconds and list(self.seconds), "notes": list(self.notes)}

    def __str__(self) -> str:
        shape = ", ".join(f"{length} of {names}" for names, length in self.axes.items())
        lines = [f"{self.points} points, {self.run}: {shape}", f"  left out     {self.finished} that are finished"]
        tried = "" if self.tried == self.points else f" of {self.tried} that were tried"
        lines.append(f"  cannot be    {self.unbuilt}{tried}" + (f": {self.problem}" if self.problem else ""))
        if self.seconds is not None:
            low, high = map(duration, self.seconds)
            told = low if low == high else f"{low} to {high}"
            lines.append(f"  will take    {told} on {self.workers} workers, measured on {self.measured} points")
        return "\n".join(lines + lines_of(self.notes))


def duration(seconds: float) -> str:
    """A time for people, to two digits at most."""
    for unit, size in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds:.2g} s"
