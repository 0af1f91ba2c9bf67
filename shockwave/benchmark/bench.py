"""The bench: which problems, which families, and what is made of them."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable, Iterator, Sequence
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from attrs import evolve

from shockwave import __version__
from shockwave.benchmark import chains, integrators, predictors, quadratures, smooth
from shockwave.benchmark.chains import Case
from shockwave.benchmark.quadratures import Areas
from shockwave.benchmark.rows import FAMILIES, Problem, Row, WorkPrecision
from shockwave.benchmark.timing import Limits
from shockwave.errors import FileAccessError, InvalidValueError, ShockwaveError, UsageError
from shockwave.fields import Quantity, text_of
from shockwave.files import write_file
from shockwave.registry import plugins
from shockwave.scenario.scenario import Scenario
from shockwave.simulation.backend import compiled

__all__ = ["LONGEST", "NotWrittenError", "run"]

#: The longest that one run may take.
LONGEST = Quantity("s", "longest time of one run", above=0, at_most=3600)
# Longest run, repetitions at one setting together, and the most of them.
_QUICK, _FULL = Limits(0.5, 0.08, 5), Limits(4.0, 0.4, 15)
_QUICK_CASES = {"predictors": ("short", "A", "B"), "integrators": ("A",)}
_CASES = {"predictors": ("short", "A", "B", "slow"), "integrators": ("A", "B", "slow")}
_SUFFIXES = (".html", ".htm", ".svg")

_Part = tuple[Problem, Iterator[Row]]


class NotWrittenError(FileAccessError):
    """Everything was run, and the page cannot be written; ``result`` is what was found."""

    result: WorkPrecision


def run(
    files: Sequence[Scenario] = (),
    families: Sequence[str] = (),
    quick: bool = False,
    output: str | os.PathLike[str] | None = None,
    longest: float | None = None,
    progress: Callable[[str], None] | None = None,
) -> WorkPrecision:
    """Run the families on the named problems, or on the scenes of scenarios.

    Parameters
    ----------
    files : sequence of Scenario
        Scenes that take the place of the named problems.
    families : sequence of "quadratures", "predictors", "integrators"
        All of them if left out.
    quick : bool
        Fewer problems, settings and repetitions; ends within a minute.
    output : path-like, optional
        A page (``.html``) or the figures alone (``.svg``), written at the end; it needs matplotlib.
    longest : float, optional
        The longest that one run may take [s]; what would take longer is left out and says so.
    progress : callable, optional
        Told what is run next.

    Raises
    ------
    InvalidValueError
        When a family is unknown, or ``longest`` out of range.
    UsageError
        When ``output`` is neither, or matplotlib is missing.
    FileAccessError
        When ``output`` cannot be written; before anything is run if that is seen, else `NotWrittenError`, which holds
        what was found.
    """
    chosen = _checked(families)
    path = None if output is None else _writable(output)
    limits = _limits(quick, longest)
    scenes = _distinct(files)
    problems: list[Problem] = []
    rows: list[Row] = []
    steps: list[Row] = []
    tell = progress or (lambda _: None)
    for family in chosen:
        if family == "integrators" and not scenes:
            tell(f"{family}: {smooth.NAME}")
            problems.append(smooth.problem())
            steps = [row for name in smooth.names() for row in smooth.rows(name, limits, quick)]
            rows += steps
        for about, found in _parts(family, scenes, limits, quick):
            tell(f"{family}: {about.name}")
            problems.append(about)
            rows += found
    result = WorkPrecision(
        problems=tuple(problems),
        rows=tuple(rows),
        orders=smooth.orders(steps),
        provenance=_provenance(quick, limits),
    )
    if path is not None:
        _write(result, path)
    return result


def _checked(families: Sequence[str]) -> list[str]:
    unknown = [family for family in families if family not in FAMILIES]
    if unknown:
        raise InvalidValueError.of("families", f"must be of {', '.join(FAMILIES)} (got {text_of(unknown[0])})")
    return [family for family in FAMILIES if not families or family in families]


def _limits(quick: bool, longest: float | None) -> Limits:
    limits = _QUICK if quick else _FULL
    if longest is None:
        return limits
    problem = LONGEST.problem(longest)
    if problem is not None:
        raise InvalidValueError.of("longest", problem)
    return Limits(longest, min(limits.method, longest), limits.repeats)


def _parts(family: str, scenes: Sequence[Scenario], limits: Limits, quick: bool) -> Iterator[_Part]:
    """Problems and their rows; a scene that cannot be run is a problem with one row that says why."""
    for scene in scenes or _named(family, quick):
        try:
            if family == "quadratures":
                areas = scene if isinstance(scene, Areas) else quadratures.of_scenario(scene)
                yield areas.problem, quadratures.rows(areas, limits, quick)
                continue
            case = scene if isinstance(scene, Case) else chains.of_scenario(scene, limits)
            if family == "predictors":
                yield predictors.rows(case, limits, quick)
            else:
                yield integrators.problem(case), integrators.rows(case, limits, quick)
        except ShockwaveError as error:
            yield _failed(family, scene.name, str(error))


def _named(family: str, quick: bool) -> Sequence[Any]:
    if family == "quadratures":
        return quadratures.NAMED
    names = (_QUICK_CASES if quick else _CASES)[family]
    return [case for name in names for case in chains.NAMED if case.name == name]


def _distinct(scenarios: Sequence[Scenario]) -> list[Scenario]:
    """With names of their own: rows are told apart by them."""
    given = {scenario.name for scenario in scenarios}
    used: set[str] = set()
    found = []
    for scenario in scenarios:
        name = scenario.name
        if name in used:
            others = (f"{name} ({number})" for number in count(2))
            name = next(other for other in others if other not in given and other not in used)
        used.add(name)
        found.append(scenario if name == scenario.name else evolve(scenario, name=name))
    return found


def _failed(family: str, name: str, why: str) -> _Part:
    about = Problem(
        family=family,
        name=name,
        description="there is no reference",
        quantities=("peak force",),
        reference="none",
        reference_error=1.0,
    )
    row = Row(family=family, case=name, method="reference", setting="-", value=None, problem=why)
    return about, iter([row])


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


def _writable(output: str | os.PathLike[str]) -> Path:
    path = Path(output)
    if path.suffix.lower() not in _SUFFIXES:
        raise UsageError(f"output must end in .html or .svg (got {path.name!r})")
    # A round takes long: what it needs at its end is looked for at its beginning.
    from shockwave.benchmark.figure import need_matplotlib

    need_matplotlib()
    try:
        problem = _hindrance(path)
    except OSError as error:
        problem = error.strerror or type(error).__name__
    if problem:
        raise FileAccessError(f"{path}: cannot be written ({problem})")
    return path


def _hindrance(path: Path) -> str:
    """Why a file cannot be written; "" if nothing is seen that hinders. Nothing is made or changed."""
    if path.is_dir():
        return "it is a folder"
    if path.exists():
        return "" if os.access(path, os.W_OK) else "permission denied"
    if not path.parent.is_dir():
        return f"there is no folder {path.parent}"
    return "" if os.access(path.parent, os.W_OK | os.X_OK) else "permission denied"


def _write(result: WorkPrecision, path: Path) -> None:
    try:
        write_file(path, _drawn(result, path))
    # Whatever is wrong with a page, what was found is not lost with it.
    except Exception as error:
        own = isinstance(error, FileAccessError)
        late = NotWrittenError(str(error) if own else f"{path}: cannot be written ({type(error).__name__}: {error})")
        late.result = result
        raise late from error


def _drawn(result: WorkPrecision, path: Path) -> str:
    if path.suffix.lower() == ".svg":
        from shockwave.benchmark.figure import column

        return '<?xml version="1.0" encoding="utf-8"?>\n' + column(result)
    from shockwave.benchmark.page import page

    return page(result)
