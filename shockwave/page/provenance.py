"""Where the figures of a page come from: versions, and the registered parts in use."""

from __future__ import annotations

import platform
import re
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version

from shockwave import OWN_DISTRIBUTION, __version__
from shockwave.errors import UnknownNameError
from shockwave.hooks import Entry
from shockwave.page.results import Findings
from shockwave.profiles.base import ShockProfile
from shockwave.registry import entries, find, load, own_entries


def versions(found: Findings) -> list[tuple[str, str]]:
    """Names and versions of the software, and the code that steps the chain."""
    named = [("shockwave", __version__), ("Python", platform.python_version())]
    named += [(name, _version(name.lower())) for name in ("NumPy", "SciPy", "matplotlib")]
    if found.simulated is not None:
        named.append(("code that steps the chain", found.simulated.backend))
    return named


def parts_in_use(found: Findings) -> Iterator[tuple[str, str, str]]:
    """Kind, name and distribution of each registered part that the results were made with."""
    used = []
    profile = _entry_of(found.scenario.shock.profile)
    if profile is not None:
        used.append(("profile", profile))
    if found.predicted is not None:
        used.append(("model", find("models", found.predicted.model)))
    if found.scenario.predictor.quadrature is not None:
        used.append(("quadrature", find("quadratures", found.scenario.predictor.quadrature)))
    if found.simulated is not None:
        used.append(("integrator", find("integrators", found.simulated.integrator)))
    material = found.scenario.chain.material
    try:
        if material.name and load("materials", material.name) == material:
            used.append(("material", find("materials", material.name)))
    except UnknownNameError:
        pass  # a material of the scenario's own may have any name
    for kind, entry in used:
        yield kind, entry.name, f"{entry.distribution} {_version(entry.distribution)}"


def profile_name(profile: ShockProfile) -> str:
    """The name under which the class of a profile is registered; else the name of the class."""
    entry = _entry_of(profile)
    return type(profile).__name__ if entry is None else entry.name


def _entry_of(profile: ShockProfile) -> Entry | None:
    """The entry of the profile's class, which was imported with its package: no other package is."""
    cls = type(profile)
    package = cls.__module__.partition(".")[0]
    for entry in own_entries("profiles") if package == "shockwave" else entries("profiles"):
        if re.split("[.:]", entry.address)[0] == package and load("profiles", entry.name) is cls:
            return entry
    return None


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return __version__ if distribution == OWN_DISTRIBUTION else "unknown"
