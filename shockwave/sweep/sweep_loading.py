"""Loading of a scenario with a sweep, whose profile may end the process that builds a scene."""

from __future__ import annotations

import os
from collections.abc import Mapping
from concurrent.futures import BrokenExecutor
from pathlib import Path
from typing import Any

from attrs import evolve

from shockwave import OWN_DISTRIBUTION
from shockwave.errors import Fault, InvalidValueError, PluginError, ShockwaveError
from shockwave.registry import find
from shockwave.scenario.loader import load_scenario, scenario_of
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.yaml_document import read_document
from shockwave.sweep.points import Points
from shockwave.sweep.workers import processes

# Points whose scene may end the process that builds it, before the sweep is refused.
_MOST_ENDED = 8


def points_of(scenario: Scenario | str | os.PathLike[str], apart: bool = False, timeout: float | None = None) -> Points:
    """The points of a scenario with a sweep, or of one in a file.

    Parameters
    ----------
    scenario : Scenario or path-like
        The scenario.
    apart : bool
        Whether a scene of a file whose profile may be a plugin's is tried in a process of its own.
    timeout : float, optional
        Longest time of that [s].

    Raises
    ------
    InvalidValueError
        When it has no sweep.
    PluginError
        When each of the first points ends its process, or takes longer than ``timeout``.
    """
    if isinstance(scenario, Scenario):
        found = scenario
    else:
        found = _loaded_apart(Path(scenario), timeout) if apart else load_scenario(scenario)
    if found.sweep is None:
        problem = "must be given (got nothing; a mapping of grid, zip or points)"
        raise InvalidValueError.of(f"{found.path}: sweep" if found.path else "sweep", problem)
    if found.path is not None:  # workers have folders of their own
        found = evolve(found, path=found.path.absolute())
    return Points(found)


def _loaded_apart(path: Path, timeout: float | None) -> Scenario:
    """The scenario in a file, as `load_scenario` gives it, begun with a point whose scene ends no process."""
    faults: list[Fault] = []
    document = read_document(path, faults)
    begin = _first_sound(path.absolute(), timeout) if _has_plugin(document.data) else 0
    return scenario_of(document, path, faults, slice(begin, None))


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
    faults: list[Fault] = []
    try:
        scenario_of(read_document(path, faults), path, faults, slice(attempt, attempt + 1))
    except (Exception, SystemExit):  # reported by the client
        return
