"""Draw the work-precision diagram of the README.

    python docs/draw_benchmark.py

runs the quick benchmark of the predictors, and SciPy on the whole chain, and draws a panel for each problem. The run
times are those of the machine that draws it.
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
#: Titles of the problems.
TITLES = {"short": "short shock", "A": "a wave and its tail", "B": "a train"}
#: Longest run time of SciPy [s].
LONGEST = 0.5


def main() -> None:
    """Run the benchmark and draw it."""
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
