"""Names and where they live: profiles, integrators, quadratures, materials and models.

A registry holds addresses (``package.module:attribute``), so listing names imports nothing and a scene
imports only what it names. Built-ins and plugins come through the same hooks. This module is the only
place from which such an address is imported.
"""

from __future__ import annotations

import importlib
from functools import cache
from types import ModuleType
from typing import Any

import attrs
from attrs import frozen

from shockwave.errors import PluginError, UnknownNameError
from shockwave.hooks import Entry

__all__ = ["KINDS", "Plugin", "entries", "find", "load", "plugins"]

#: Kind of a noun -> how one of them is called in a sentence.
KINDS = {
    "profiles": "profile",
    "integrators": "integrator",
    "quadratures": "quadrature",
    "materials": "material",
    "models": "model",
}
_OWN = "shockwave"


@frozen
class Plugin:
    """An installed distribution that registers nouns, and what is wrong with it, if anything is."""

    distribution: str
    version: str
    entries: tuple[tuple[str, Entry], ...]
    problem: str = ""


def find(kind: str, name: str) -> Entry:
    """The entry of ``name``; plugins are looked for only when no built-in has the name.

    Raises
    ------
    UnknownNameError
        When nothing has the name; the message tells the known names and the nearest.
    PluginError
        When two distributions claim it.
    """
    own = [entry for entry in _own_entries(kind) if entry.name == name]
    if own:
        return own[0]
    owners = [entry for entry in _plugin_entries(kind) if entry.name == name]
    if not owners:
        known = [entry.name for entry in entries(kind)]
        raise UnknownNameError(KINDS[kind], name, known)
    if len(owners) > 1:
        both = " and ".join(sorted({entry.distribution for entry in owners}))
        raise PluginError(f"{KINDS[kind]} {name!r} is registered twice, by {both}: uninstall one of them")
    return owners[0]


def load(kind: str, name: str) -> Any:
    """The object registered as ``name``: its module is imported now, and not before.

    Raises
    ------
    UnknownNameError
        When nothing has the name.
    PluginError
        When a plugin's module cannot be imported or does not hold what it registered.
    """
    entry = find(kind, name)
    module, _, attribute = entry.address.partition(":")
    try:
        return getattr(importlib.import_module(module), attribute)
    except Exception as error:
        if entry.distribution == _OWN:
            raise
        raise PluginError(
            f"{KINDS[kind]} {name!r} of {entry.distribution}: {entry.address} cannot be imported"
            f" (got {type(error).__name__}: {error})"
        ) from error


def entries(kind: str) -> list[Entry]:
    """Everything registered under ``kind``, built-ins first; imports none of it."""
    return [*_own_entries(kind), *sorted(_plugin_entries(kind), key=lambda entry: entry.name)]


@cache
def plugins() -> tuple[Plugin, ...]:
    """Every installed distribution with an entry point in the group ``shockwave``, the faulty ones too."""
    from importlib.metadata import entry_points

    found = []
    for point in sorted(entry_points(group=_OWN), key=lambda point: (point.name, point.value)):
        name, version = (point.dist.name, point.dist.version) if point.dist else (point.name, "")
        try:
            module = point.load()
            found.append(Plugin(name, version, _registered(module, name)))
        except Exception as error:
            found.append(Plugin(name, version, (), f"{type(error).__name__}: {error}"))
    return tuple(found)


def _plugin_entries(kind: str) -> list[Entry]:
    return [entry for plugin in plugins() for of_kind, entry in plugin.entries if of_kind == kind]


def _own_entries(kind: str) -> list[Entry]:
    return [entry for of_kind, entry in _built_in() if of_kind == kind]


@cache
def _built_in() -> tuple[tuple[str, Entry], ...]:
    return _registered(importlib.import_module("shockwave.built_ins"), _OWN)


def _registered(module: ModuleType, distribution: str) -> tuple[tuple[str, Entry], ...]:
    """(kind, entry) of everything that ``module`` registers."""
    import pluggy

    manager = pluggy.PluginManager(_OWN)
    manager.add_hookspecs(importlib.import_module("shockwave.hooks"))
    manager.register(module)
    manager.check_pending()  # a misspelt hook is an error, not silence
    registered = []
    for kind in KINDS:
        for returned in getattr(manager.hook, f"shockwave_{kind}")():
            for entry in returned:
                if not isinstance(entry, Entry):
                    raise TypeError(f"shockwave_{kind} must return entries (got {entry!r})")
                registered.append((kind, attrs.evolve(entry, distribution=distribution)))
    return tuple(registered)
