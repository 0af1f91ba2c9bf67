"""Where the figures of a page come from: versions, parts in use, and the hash of what was asked."""

from __future__ import annotations

import platform
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version

from shockwave import OWN_DISTRIBUTION, __version__
from shockwave.errors import ShockwaveError
from shockwave.hooks import Entry
from shockwave.markup import Html, facts, joined, table, tag
from shockwave.page.findings import Findings
from shockwave.profiles.base import ShockProfile
from shockwave.registry import entries, find, load, own_entries
from shockwave.scenario.scene_hash import scene_hash

__all__ = ["profile_name", "provenance"]

_OTHERS = {"NumPy": "numpy", "SciPy": "scipy", "matplotlib": "matplotlib"}


def provenance(found: Findings) -> Html:
    """Versions, hash, and the parts in use with the distributions that they come from."""
    told = [("shockwave", __version__), ("Python", platform.python_version())]
    told += [(name, _version(distribution)) for name, distribution in _OTHERS.items()]
    if found.simulated is not None:
        told.append(("code that steps the chain", found.simulated.backend))
    told.append(("SHA-256 of what was asked", tag("code", scene_hash(found.scenario))))
    parts = [(kind, name, f"{owner} {_version(owner)}") for kind, name, owner in _parts(found)]
    return joined((facts(told), table(("part in use", "name", "from"), parts, "Parts in use", words=True)))


def _parts(found: Findings) -> Iterator[tuple[str, str, str]]:
    """Kind, name and distribution of all that the answers were made with."""
    scenario = found.scenario
    entry = _entry_of(scenario.shock.profile)
    if entry is not None:
        yield "profile", entry.name, entry.distribution
    if found.predicted is not None:
        yield "model", found.predicted.model, find("models", found.predicted.model).distribution
    if scenario.predictor.quadrature is not None:
        yield (
            "quadrature",
            scenario.predictor.quadrature,
            find("quadratures", scenario.predictor.quadrature).distribution,
        )
    if found.simulated is not None:
        yield "integrator", found.simulated.integrator, find("integrators", found.simulated.integrator).distribution
    name = scenario.chain.material.name
    try:
        if name and load("materials", name) == scenario.chain.material:
            yield "material", name, find("materials", name).distribution
    except ShockwaveError:
        # a material of the scenario's own may be called anything
        return


def profile_name(profile: ShockProfile) -> str:
    """The name under which the class of a profile is registered; else the name of the class."""
    entry = _entry_of(profile)
    return type(profile).__name__ if entry is None else entry.name


def _entry_of(profile: ShockProfile) -> Entry | None:
    cls = type(profile)
    own = cls.__module__.startswith("shockwave.")
    # plugins are looked for only where they are needed
    for entry in own_entries("profiles") if own else entries("profiles"):
        if own and entry.address == f"{cls.__module__}:{cls.__qualname__}":
            return entry
        if not own and _is_class(entry, cls):
            return entry
    return None


def _is_class(entry: Entry, cls: type) -> bool:
    # what is not imported cannot be the class of an object
    if entry.address.partition(":")[0].partition(".")[0] != cls.__module__.partition(".")[0]:
        return False
    try:
        return load("profiles", entry.name) is cls
    except ShockwaveError:
        return False


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return __version__ if distribution == OWN_DISTRIBUTION else "unknown"
