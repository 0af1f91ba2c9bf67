"""Opening a scenario whose points may do anything: a profile of a plugin is first built in a process of its own."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from concurrent.futures import Future
from pathlib import Path
from typing import Any

from shockwave import OWN_DISTRIBUTION
from shockwave.errors import Fault, PluginError, ShockwaveError
from shockwave.registry import find
from shockwave.scenario.loader import scenario_of
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.yaml_document import read_document
from shockwave.sweep.executors import Processes
from shockwave.sweep.points import let_through

__all__ = ["opened"]

# So many points may end the process that builds their scene before it is given up.
_MOST = 8


def opened(path: str | os.PathLike[str], apart: bool) -> Scenario:
    """The scenario in a file, as `load_scenario` gives it; begun with a point that ends no process if ``apart``.

    Raises
    ------
    PluginError
        When each of the first points ends its process.
    """
    faults: list[Fault] = []
    document = read_document(path, faults)
    foreign = next(_foreign(document.data), None) if apart else None
    begin = 0 if foreign is None else _begin(Path(path), foreign)
    return scenario_of(document, Path(path), faults, slice(begin, None))


def _foreign(data: Mapping[str, Any]) -> Iterator[str]:
    """The profiles of plugins among those of the scenario."""
    sweep = data.get("sweep")
    for word in _words([data.get("shock"), sweep if isinstance(sweep, dict) else None]):
        try:
            if find("profiles", word).distribution != OWN_DISTRIBUTION:
                yield word
        except ShockwaveError:  # told where the scene is built
            continue


def _words(value: Any, here: bool = False) -> Iterator[str]:
    """All texts that stand under a key that says profile."""
    if isinstance(value, str) and here:
        yield value
    elif isinstance(value, list):
        for one in value:
            yield from _words(one, here)
    elif isinstance(value, dict):
        for name, one in value.items():
            yield from _words(one, here or name in ("profile", "shock.profile"))


def _begin(path: Path, profile: str) -> int:
    """The number of the first try at a scene that does not end its process."""
    crew = Processes(1)
    try:
        for attempt in range(_MOST):
            future: Future[None] = crew.call(_build, path.absolute(), attempt)
            if crew.wait([future]) and future.exception() is None:
                return attempt
            crew.renew(1)
    finally:
        crew.close()
    got = f"got {_MOST} points that end the process that builds their scene"
    raise PluginError(f"profile {profile!r}: must take some values of the sweep ({got}; mend it)")


def _build(path: Path, attempt: int) -> None:
    """Build a scene, whatever becomes of it, short of the end of this process."""
    faults: list[Fault] = []
    try:
        scenario_of(read_document(path, faults), path, faults, slice(attempt, attempt + 1))
    except BaseException as error:
        let_through(error)
