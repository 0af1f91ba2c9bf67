"""The header of a sweep: everything about it but its results, and the hash of that."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any

from attrs import asdict

from shockwave import OWN_DISTRIBUTION
from shockwave.errors import InvalidValueError, ShockwaveError
from shockwave.fields import text_of
from shockwave.registry import entries, find
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_hash import normalised
from shockwave.sweep.journal import header_in, written
from shockwave.sweep.points import Points
from shockwave.sweep.stored import FORMAT, HEADER

__all__ = ["EARLIER", "header_of", "plugins_of", "settle", "settled"]

#: The key of versions that a sweep was gone on with before.
EARLIER = "earlier_versions"
# So many differences are told.
_MOST_TOLD = 4


def plugins_of(scenario: Scenario) -> list[str]:
    """Distributions, other than shockwave, that scenes of the sweep come from."""
    names: dict[str, set[Any]] = {
        "profiles": {_profile(scenario)},
        "models": {scenario.predictor.model},
        "quadratures": {scenario.predictor.quadrature},
        "integrators": {scenario.simulate.integrator},
        "materials": {scenario.chain.material.name},
    }
    blocks = {"shock.profile": "profiles", "chain.material": "materials", "simulate.integrator": "integrators"}
    blocks |= {"predict.model": "models", "predict.quadrature": "quadratures"}
    for axis in scenario.sweep.axes if scenario.sweep else ():
        for at, name in enumerate(axis.names):
            if name in blocks:
                # a material may be described, not called by its name
                names[blocks[name]] |= {values[at] for values in axis.values if isinstance(values[at], str)}
    found = set()
    for kind, given in names.items():
        for name in given:
            try:
                found.add(find(kind, name).distribution if isinstance(name, str) and name else OWN_DISTRIBUTION)
            except ShockwaveError:  # a material of the scenario's own may be called anything
                continue
    return sorted(found - {OWN_DISTRIBUTION})


def _profile(scenario: Scenario) -> str:
    """The name of the profile; none for a class that is not registered."""
    document = scenario.document.data if scenario.document is not None else {}
    if document:
        return str(document["shock"]["profile"])
    cls = type(scenario.shock.profile)
    if cls.__module__.startswith("shockwave."):
        return ""
    address = f"{cls.__module__}:{cls.__qualname__}"
    return next((entry.name for entry in entries("profiles") if entry.address == address), "")


def header_of(points: Points) -> dict[str, Any]:
    """The header, as JSON reads it again."""
    scenario, sweep = points.scenario, points.sweep
    axes = [
        {"names": axis.names, "units": [variable.unit for variable in axis.variables], "values": axis.values}
        for axis in sweep.axes
    ]
    header = {
        "format": FORMAT,
        "name": scenario.name,
        "run": sweep.run,
        "axes": axes,
        "shape": sweep.shape,
        "points": len(sweep),
        "columns": [asdict(read.column) for read in points.columns],
        "scenario": json.loads(normalised(scenario)),
        # what a name or a file stands for may change without a change of the scenario
        "named": dict(points.named),
        "versions": dict(points.versions),
    }
    text = json.dumps(header, sort_keys=True)
    found: dict[str, Any] = json.loads(text)
    # whatever it is called, it is the same sweep
    same = {name: value for name, value in found.items() if name != "name"}
    return {**found, "key": hashlib.sha256(json.dumps(same, sort_keys=True).encode()).hexdigest()}


def settle(folder: Path, header: Mapping[str, Any], accept_versions: bool) -> Mapping[str, Any]:
    """Write the header, or hold it against the one that is there; the one that is there then.

    Raises
    ------
    InvalidValueError
        When the folder holds another sweep, or one by other versions that are not to be accepted.
    FileAccessError
        When the file cannot be read or written.
    """
    there = header_in(folder)
    found = settled(there, header, folder, accept_versions)
    if found is not there:
        written(folder / HEADER, (json.dumps(found, indent=1) + "\n").encode())
    return found


def settled(
    there: Mapping[str, Any] | None, header: Mapping[str, Any], folder: Path, accept_versions: bool
) -> Mapping[str, Any]:
    """The header that ``folder`` is to have, where one is ``there``; see `settle`, which writes it."""
    if there is None:
        return header
    if there.get("key") == header["key"]:
        return there
    different = {name: change for name, change in _differences(there, header) if name not in ("key", "name", EARLIER)}
    told = "; ".join(f"{name} {was}, now {now}" for name, (was, now) in islice(different.items(), _MOST_TOLD))
    told += f"; and {len(different) - _MOST_TOLD} more" if len(different) > _MOST_TOLD else ""
    if not all(name.startswith("versions.") for name in different):
        problem = f"must be of the sweep that is asked for (got {told or 'another key'}; choose another folder)"
        raise InvalidValueError.of(str(folder / HEADER), problem)
    if not accept_versions:
        remedy = "--accept-versions goes on with these, a new folder begins anew"
        raise InvalidValueError.of(str(folder / HEADER), f"must be of the versions in use (got {told}; {remedy})")
    return {**header, EARLIER: [*there.get(EARLIER, []), there["versions"]]}


def _differences(there: Any, here: Any, name: str = "") -> Iterator[tuple[str, tuple[str, str]]]:
    """Dotted names of what differs, with what it was and what it is."""
    if isinstance(there, dict) and isinstance(here, dict):
        for key in sorted(there.keys() | here.keys()):
            yield from _differences(there.get(key), here.get(key), f"{name}.{key}" if name else key)
    elif there != here:
        yield name, (text_of(there), text_of(here))
