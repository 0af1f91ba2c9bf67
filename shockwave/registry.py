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
#: What an address must lead to: a subclass of this, or an instance.
_EXPECTED = {
    "profiles": "shockwave.profiles.base:ShockProfile",
    "integrators": "shockwave.simulation.integrator:Integrator",
    "quadratures": "shockwave.quadrature.base:Quadrature",
    "materials": "shockwave.chain.material:Material",
}
# A plugin's module may do anything on import, even leave the interpreter; only the user's own interrupt passes.
_PLUGIN_FAULTS = (Exception, SystemExit)


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
        faulty = [plugin.distribution for plugin in plugins() if plugin.problem]
        raise UnknownNameError(KINDS[kind], name, known, faulty)
    if len(owners) > 1:
        both = " and ".join(entry.distribution for entry in owners)
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
    if entry.distribution == _OWN:
        return _at(entry.address)
    what = f"{KINDS[kind]} {name!r} of {entry.distribution}: {entry.address}"
    try:
        loaded = _at(entry.address)
    except _PLUGIN_FAULTS as error:
        raise PluginError(f"{what} cannot be imported (got {type(error).__name__}: {error})") from error
    expected = _at(_EXPECTED[kind]) if kind in _EXPECTED else object
    if not ((isinstance(loaded, type) and issubclass(loaded, expected)) or isinstance(loaded, expected)):
        raise PluginError(f"{what} must be a {expected.__name__} (got {loaded!r})")
    return loaded


def _at(address: str) -> Any:
    module, _, attribute = address.partition(":")
    return getattr(importlib.import_module(module), attribute)


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
            found.append(Plugin(name, version, _of_plugin(module, name)))
        except _PLUGIN_FAULTS as error:
            found.append(Plugin(name, version, (), f"{type(error).__name__}: {error}"))
    return tuple(found)


def _of_plugin(module: ModuleType, distribution: str) -> tuple[tuple[str, Entry], ...]:
    registered = _registered(module, distribution)
    if not registered:
        raise ValueError("registers nothing (a hook without @hookimpl, or without its return?)")
    own = {(kind, entry.name) for kind, entry in _built_in()}
    taken = [f"{KINDS[kind]} {entry.name!r}" for kind, entry in registered if (kind, entry.name) in own]
    if taken:
        raise ValueError(f"registers names that shockwave has itself: {', '.join(taken)}")
    return registered


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
                if not (isinstance(entry, Entry) and all(isinstance(t, str) for t in attrs.astuple(entry))):
                    raise TypeError(f"shockwave_{kind} must return entries of strings (got {entry!r})")
                registered.append((kind, attrs.evolve(entry, distribution=distribution)))
    return tuple(registered)
