"""Names and where they live: profiles, integrators, quadratures, materials and models.

A registry holds addresses (``package.module:attribute``), so listing names imports nothing and a scene
imports only what it names. Built-ins and plugins come through the same hooks. This room is the only
place from which such an address is imported.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from functools import cache
from typing import Any

from attrs import evolve

from shockwave import OWN_DISTRIBUTION
from shockwave.errors import PluginError, ShockwaveError, UnknownNameError
from shockwave.hooks import Entry
from shockwave.registration import KINDS, at, registered
from shockwave.registry.elsewhere import ELSEWHERE
from shockwave.registry.installed import DISABLE, EVERY, Plugin, checked, plugins, same_distribution, twice

__all__ = [
    "DISABLE",
    "EVERY",
    "KINDS",
    "Plugin",
    "blame",
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
        raise PluginError(twice(kind, name, (entry.distribution for entry in owners)))
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
    return UnknownNameError(
        KINDS[kind], name, dict.fromkeys(entry.name for entry in entries(kind)), hints, faulty=bool(faulty)
    )


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
    own = _own(kind, name)
    return own if own is not None else _of_plugin(kind, find(kind, name))


@cache
def _own(kind: str, name: str) -> Any:
    return next((at(entry.address) for entry in own_entries(kind) if entry.name == name), None)


@cache
def _of_plugin(kind: str, entry: Entry) -> Any:
    plugin = next(plugin for plugin in plugins() if (kind, entry) in plugin.entries)
    problem = checked(evolve(plugin, entries=((kind, entry),), problem=""), anew=False).problem
    if not problem:
        try:
            with redirect_stdout(sys.stderr):  # what it prints is no part of a result
                return at(entry.address)
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


def owner_of(kind: str, noun: Any) -> str:
    """Name and distribution under which a class or function is registered, in words; else its address."""
    for entry in entries(kind):
        module, _, attribute = entry.address.partition(":")
        if getattr(sys.modules.get(module), attribute, None) is noun:
            return f"{entry.name!r} of {entry.distribution}"
    return f"{noun.__module__}:{noun.__qualname__}"


@contextmanager
def blame(kind: str, noun: Any) -> Iterator[None]:
    """Whatever the code of another than shockwave raises, and did not mean for the user, is that plugin's fault."""
    try:
        yield
    except ShockwaveError:
        raise
    except _PLUGIN_FAULTS as error:
        if noun.__module__.startswith("shockwave."):
            raise
        got = f"got {type(error).__name__}: {' '.join(str(error).split())[:200]}"
        raise PluginError(f"{KINDS[kind]} {owner_of(kind, noun)}: must not raise ({got})") from error


def _plugin_entries(kind: str) -> list[Entry]:
    return [entry for plugin in plugins() for of_kind, entry in plugin.entries if of_kind == kind]


def own_entries(kind: str) -> list[Entry]:
    """What shockwave itself registers."""
    return [entry for of_kind, entry in _built_in() if of_kind == kind]


@cache
def _built_in() -> tuple[tuple[str, Entry], ...]:
    own = registered(importlib.import_module("shockwave.built_ins"))
    return tuple((kind, entry._replace(distribution=OWN_DISTRIBUTION)) for kind, entry in own)
