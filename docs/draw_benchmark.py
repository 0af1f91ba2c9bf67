"""The figure of error against run time that stands in the README.

    python docs/draw_benchmark.py

runs the predictors' quick round, and SciPy on the whole chain, and draws them on common axes, a problem a panel. Times
are those of the machine that draws it.
"""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

from compare_simulators import measured

from shockwave.benchmark.bench import run
from shockwave.pictures import figure, save, work_precision

FILE = Path(__file__).parent / "benchmarks" / "predictors.svg"
ERROR = "peak force"
#: Problem -> what it is, in words.
TITLES = {"short": "short shock", "A": "a wave and its tail", "B": "a train"}
LONGEST = 0.5  # s


def main() -> None:
    """Run and draw."""
    result = run(families=["predictors"], quick=True)
    panels, axes = figure(1, len(TITLES), (9.0, 3.6))
    for ax, (name, title) in zip(axes, TITLES.items(), strict=True):
        rows: list[Any] = [row for row in result.rows if row.case == name and not row.problem]
        for found in measured(name, LONGEST, "SciPy DOP853"):
            rows.append(
                SimpleNamespace(method=found.method, error=found.force_error, seconds=found.seconds, problem="")
            )
        work_precision(ax, rows, f"error of the {ERROR}, {title}")
    FILE.parent.mkdir(exist_ok=True)
    save(panels, FILE)


if __name__ == "__main__":
    main()
