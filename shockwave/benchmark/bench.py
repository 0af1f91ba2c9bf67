"""The bench: the families of problems, the limits of a round, and where it was run."""

from __future__ import annotations

import os
import platform
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence

import numpy as np
import scipy
from attrs import evolve

from shockwave import __version__
from shockwave.benchmark.families import FAMILIES, named, of_scenario, orders
from shockwave.benchmark.timed_runs import Experiment, Limits, Method, measured
from shockwave.benchmark.work_precision import Problem, Row, WorkPrecision
from shockwave.errors import ShockwaveError
from shockwave.registry import plugins
from shockwave.scenario.scenario import Scenario
from shockwave.simulation.backend import compiled

_QUICK = Limits(run=0.5, repetitions=0.08, repeats=5, every=2)
_FULL = Limits(run=4.0, repetitions=0.4, repeats=15)


def run(
    scenarios: Sequence[Scenario] = (),
    families: Sequence[str] = (),
    quick: bool = False,
    longest: float | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> WorkPrecision:
    """Run the families on the named problems, or on the scenes of scenarios.

    Parameters
    ----------
    scenarios : sequence of Scenario
        Scenes that take the place of the named problems.
    families : sequence of "quadratures", "predictors", "integrators"
        All of them if left out.
    quick : bool
        Fewer problems, settings and repetitions; ends within a minute.
    longest : float, optional
        The longest that one run may take [s]; what would take longer is left out with a row that says so.
    progress : callable, optional
        Called with the name of the next problem.
    """
    limits = _QUICK if quick else _FULL
    if longest is not None:
        limits = evolve(limits, run=longest, repetitions=min(limits.repetitions, longest))
    problems: list[Problem] = []
    rows: list[Row] = []
    for family in FAMILIES:
        if families and family not in families:
            continue
        for problem, methods in _experiments(family, scenarios, quick):
            progress(f"{family}: {problem.name}")
            problems.append(problem)
            for method in methods:
                rows.extend(measured(problem, method, limits))
    return WorkPrecision(
        provenance=_provenance(quick, limits),
        problems=tuple(problems),
        rows=tuple(rows),
        orders=orders(rows),
    )


def _experiments(family: str, scenarios: Sequence[Scenario], quick: bool) -> Iterator[Experiment]:
    """Problems and their methods; a scenario that cannot be run is a problem with one method that says why."""
    if not scenarios:
        yield from named(family, quick)
    count = Counter[str]()
    for scenario in scenarios:
        count[scenario.name] += 1
        if count[scenario.name] > 1:  # rows are distinguished by the name
            scenario = evolve(scenario, name=f"{scenario.name} ({count[scenario.name]})")
        try:
            yield of_scenario(family, scenario)
        except ShockwaveError as error:
            problem = Problem(family, scenario.name, "there is no reference", ("peak force",), "none", 1.0)
            yield problem, [Method.broken("reference", error)]


def _provenance(quick: bool, limits: Limits) -> dict[str, str]:
    found = {
        "shockwave": __version__,
        "backend": "numpy" if compiled is None else "compiled",
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores",
        "round": "quick" if quick else "full",
        "longest run": f"{limits.run:g} s",
        "clock": f"time.perf_counter, {time.get_clock_info('perf_counter').resolution:g} s",
    }
    others = ", ".join(f"{p.distribution} {p.version}" for p in plugins() if not p.disabled and not p.problem)
    return {**found, "plugins": others} if others else found
