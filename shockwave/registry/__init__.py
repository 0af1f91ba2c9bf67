"""Names and where they live: profiles, integrators, quadratures, materials and models.

A registry holds addresses (``package.module:attribute``), so listing names imports nothing and a scene
imports only what it names. Built-ins and plugins come through the same hooks. This room is the only
place from which such an address is imported.
"""

from __future__ import annotations

import importlib
import sys
from functools import cache
from typing import Any

from attrs import evolve

from shockwave.errors import PluginError, UnknownNameError
from shockwave.hooks import Entry
from shockwave.registration import KINDS, at, noun_at, registered
from shockwave.registry.elsewhere import ELSEWHERE
from shockwave.registry.installed import DISABLE, EVERY, Plugin, checked, plugins, same_distribution

__all__ = [
    "DISABLE",
    "EVERY",
    "KINDS",
    "Plugin",
    "checked",
    "entries",
    "find",
    "forget",
    "load",
    "own_entries",
    "owner_of",
    "plugins",
    "same_distribution",
]

_OWN = "shockwave"
# A plugin's module may do anything on import, even leave the interpreter; only the user's own interrupt passes.
_PLUGIN_FAULTS = (Exception, SystemExit)


def find(kind: str, name: str) -> Entry:
    """The entry of ``name``; plugins are looked for only when no built-in has the name.

    Raises
    ------
    UnknownNameError
        When nothing has the name; the message tells the known names and the nearest.
    PluginError
        When two distributions claim it.
    """
    own = [entry for entry in own_entries(kind) if entry.name == name]
    if own:
        return own[0]
    owners = [entry for entry in _plugin_entries(kind) if entry.name == name]
    if not owners:
        raise _unknown(kind, name)
    if len(owners) > 1:
        both = " and ".join(dict.fromkeys(entry.distribution for entry in owners))
        raise PluginError(f"{KINDS[kind]} {name!r} is registered twice, by {both}: uninstall one of them")
    return owners[0]


def _unknown(kind: str, name: str) -> UnknownNameError:
    hints = []
    home = ELSEWHERE.get((kind, name), "")
    disabled = [plugin.distribution for plugin in plugins() if plugin.disabled]
    faulty = [f"{plugin.distribution} ({plugin.problem})" for plugin in plugins() if not plugin.readable]
    if home and not any(home == distribution for distribution in disabled):
        hints.append(f"it comes with the distribution {home}, which is to be installed")
    if disabled:
        hints.append(f"plugins that are disabled: {', '.join(disabled)}")
    if faulty:
        hints.append(f"plugins that cannot be read: {', '.join(faulty)}")
    return UnknownNameError(KINDS[kind], name, [entry.name for entry in entries(kind)], hints, faulty=bool(faulty))


def load(kind: str, name: str) -> Any:
    """The object registered as ``name``: its module is imported now, and not before.

    A plugin's module is first imported in a process of its own, where it may hang or crash.

    Raises
    ------
    UnknownNameError
        When nothing has the name.
    PluginError
        When a plugin's module cannot be imported or does not hold what it registered.
    """
    entry = find(kind, name)
    return at(entry.address) if entry.distribution == _OWN else _of_plugin(kind, entry)


@cache
def _of_plugin(kind: str, entry: Entry) -> Any:
    plugin = next(plugin for plugin in plugins() if (kind, entry) in plugin.entries)
    problem = checked(evolve(plugin, entries=((kind, entry),), problem=""), anew=False).problem
    if not problem:
        try:
            return noun_at(kind, entry.address)
        except _PLUGIN_FAULTS as error:
            problem = f"{KINDS[kind]} {entry.name!r}: {entry.address}: {type(error).__name__}: {error}"
    raise PluginError(f"plugin {plugin.distribution} {plugin.version} is at fault: {problem}")


def forget() -> None:
    """Look for plugins anew: what is installed, or disabled, has changed."""
    plugins.cache_clear()
    _of_plugin.cache_clear()


def entries(kind: str) -> list[Entry]:
    """Everything registered under ``kind``, built-ins first; imports none of it."""
    return [*own_entries(kind), *sorted(_plugin_entries(kind), key=lambda entry: entry.name)]


def owner_of(kind: str, cls: type) -> str:
    """Name and distribution under which a class is registered, in words; else its address."""
    for entry in entries(kind):
        module, _, attribute = entry.address.partition(":")
        if getattr(sys.modules.get(module), attribute, None) is cls:
            return f"{entry.name!r} of {entry.distribution}"
    return f"{cls.__module__}:{cls.__qualname__}"


def _plugin_entries(kind: str) -> list[Entry]:
    return [entry for plugin in plugins() for of_kind, entry in plugin.entries if of_kind == kind]


def own_entries(kind: str) -> list[Entry]:
    """What shockwave itself registers."""
    return [entry for of_kind, entry in _built_in() if of_kind == kind]


@cache
def _built_in() -> tuple[tuple[str, Entry], ...]:
    own = registered(importlib.import_module("shockwave.built_ins"))
    return tuple((kind, entry._replace(distribution=_OWN)) for kind, entry in own)
