"""Trials in a process of its own, which a point may end: whether a scene can be built, and how long points take."""

from __future__ import annotations

import math
import os
import random
import statistics
import time
from collections.abc import Mapping
from concurrent.futures import BrokenExecutor
from pathlib import Path
from typing import Any

from attrs import frozen

from shockwave import OWN_DISTRIBUTION
from shockwave.errors import PluginError, ShockwaveError
from shockwave.registry import find
from shockwave.scenario.loader import scenario_of
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.yaml_document import read_document
from shockwave.sweep.batch import Order, understood
from shockwave.sweep.points import Points, error_text
from shockwave.sweep.workers import processes

# Points whose scene may end the process that builds it, before the sweep is refused.
_MOST_ENDED = 8
# Points whose scene is built.
_MOST_BUILT = 20_000
# Groups that are run, points of a group of simulations and of others, and seconds for all groups.
_GROUPS = 8
_SIMULATIONS = 16
_OTHERS = 2
_LIMIT = 4.0
# Seconds that start, journal and tables add, and add for each point.
_START = 0.7
_EACH = 1e-4


def loaded_apart(path: str | os.PathLike[str], timeout: float | None = None) -> Scenario:
    """The scenario in a file, as `load_scenario` gives it, begun with a point whose scene ends no process.

    Raises
    ------
    PluginError
        When each of the first points ends its process, or takes longer than ``timeout`` [s].
    """
    document = read_document(path)
    begin = _first_sound(Path(path).absolute(), timeout) if _has_plugin(document.data) else 0
    return scenario_of(document, Path(path), slice(begin, None))


def _has_plugin(data: Mapping[str, Any]) -> bool:
    """Whether the profile may be that of a plugin."""
    if "'shock.profile'" in repr(data.get("sweep")):
        return True
    try:
        return find("profiles", data["shock"]["profile"]).distribution != OWN_DISTRIBUTION
    except (ShockwaveError, KeyError, TypeError):  # reported where the scene is built
        return False


def _first_sound(path: Path, timeout: float | None) -> int:
    with processes(1) as own:
        for attempt in range(_MOST_ENDED):
            try:
                own.schedule(_build, (path, attempt), timeout).result()
                return attempt
            except (*own.deaths, BrokenExecutor):
                continue
    got = f"got {_MOST_ENDED} points that end the process that builds their scene; mend the plugin"
    raise PluginError(f"{path}: the profile must take some values of the sweep ({got})")


def _build(path: Path, attempt: int) -> None:
    try:
        scenario_of(read_document(path), path, slice(attempt, attempt + 1))
    except (Exception, SystemExit):  # reported by the client
        return


@frozen
class Trial:
    """The outcome of a trial of some points.

    Attributes
    ----------
    tried, unbuilt : int
        Points whose scene was to be built, and of which none can be.
    problem : str or None
        What is wrong with the first of these.
    measured : int
        Points that were run.
    mean, error : float
        Seconds a point, and the standard error of that.
    """

    tried: int = 0
    unbuilt: int = 0
    problem: str | None = None
    measured: int = 0
    mean: float = 0.0
    error: float = 0.0

    def range_of(self, count: int, workers: int) -> tuple[float, float] | None:
        """Wall times between which ``count`` points will take: two standard errors each way, and what is added."""
        if not (count and self.measured):
            return None
        low, high = (max(self.mean + side * self.error, 0.0) * count / workers for side in (-2, 2))
        return low + _START, high + _START + _EACH * count


def timed_apart(points: Points) -> Trial | None:
    """Try points in a process of their own; None if one of them ends it."""
    with processes(1) as own:
        try:
            trial: Trial = own.schedule(_timed, (Order.of(points).content,)).result()
        except (*own.deaths, BrokenExecutor):
            return None
    return trial


def _timed(content: bytes) -> Trial:
    """Build scenes of points spread over the sweep, the same each time, and run some of them."""
    points = understood(content)
    assert isinstance(points, Points)
    indices = random.Random(0).sample(range(len(points.sweep)), min(len(points.sweep), _MOST_BUILT))
    sound, problem = [], None
    for index in indices:
        try:
            points.scene(index)
            sound.append(index)
        except (Exception, SystemExit) as error:
            problem = problem or error_text(error)
    unbuilt = len(indices) - len(sound)
    size = _SIMULATIONS if points.sweep.run == "simulate" and not points.train else _OTHERS
    times = _times(points, sound, size)
    if not times:
        return Trial(len(indices), unbuilt, problem)
    spread = statistics.stdev(times) / math.sqrt(len(times)) if len(times) > 1 else times[0] / 2
    measured = min(len(sound), size * len(times))
    return Trial(len(indices), unbuilt, problem, measured, statistics.fmean(times), spread)


def _times(points: Points, sound: list[int], size: int) -> list[float]:
    """Seconds a point, of groups of ``size`` points."""
    points.lines(sound[:size])  # the first group also loads the code
    times: list[float] = []
    begin = time.perf_counter()
    for at in range(0, min(len(sound), _GROUPS * size), size):
        if len(times) > 1 and time.perf_counter() - begin > _LIMIT:
            break
        group = sound[at : at + size]
        before = time.perf_counter()
        points.lines(group)
        times.append((time.perf_counter() - before) / len(group))
    return times
