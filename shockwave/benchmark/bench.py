"""The bench: which problems of which families are measured, and with what limits."""

from __future__ import annotations

import os
import platform
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import scipy
from attrs import evolve

from shockwave import __version__
from shockwave.benchmark import convergence_order, integrators, predictors, quadrature_problems
from shockwave.benchmark.timed_runs import Experiment, Limits, Method, measured
from shockwave.benchmark.work_precision import Problem, Row, WorkPrecision
from shockwave.errors import ShockwaveError
from shockwave.registry import plugins
from shockwave.scenario.scenario import Scenario
from shockwave.simulation.backend import compiled

_QUICK = Limits(run=0.5, repetitions=0.08, repeats=5)
_FULL = Limits(run=4.0, repetitions=0.4, repeats=15)
_FAMILIES: dict[str, Any] = {
    "quadratures": quadrature_problems,
    "predictors": predictors,
    "integrators": integrators,
}


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
        limits = Limits(longest, min(limits.repetitions, longest), limits.repeats)
    problems: list[Problem] = []
    rows: list[Row] = []
    for family in _FAMILIES:
        if families and family not in families:
            continue
        for problem, methods in _experiments(family, _distinct(scenarios), limits, quick):
            progress(f"{family}: {problem.name}")
            problems.append(problem)
            rows += [row for method in methods for row in measured(problem, method, limits)]
    return WorkPrecision(
        provenance=_provenance(quick, limits),
        problems=tuple(problems),
        rows=tuple(rows),
        orders=() if scenarios else convergence_order.orders(rows),
    )


def _experiments(family: str, scenarios: Sequence[Scenario], limits: Limits, quick: bool) -> Iterator[Experiment]:
    """Problems and their methods; a scenario that cannot be run is a problem with one method that says why."""
    module = _FAMILIES[family]
    if not scenarios:
        yield from module.named(limits, quick)
    for scenario in scenarios:
        try:
            yield module.of_scenario(scenario, limits, quick)
        except ShockwaveError as error:
            about = "there is no reference", ("peak force",), "none", 1.0
            yield Problem(family, scenario.name, *about), iter([Method.broken("reference", error)])


def _distinct(scenarios: Sequence[Scenario]) -> list[Scenario]:
    """The scenarios with distinct names, by which rows are distinguished."""
    count = Counter[str]()
    found = []
    for scenario in scenarios:
        count[scenario.name] += 1
        number = count[scenario.name]
        found.append(scenario if number == 1 else evolve(scenario, name=f"{scenario.name} ({number})"))
    return found


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
