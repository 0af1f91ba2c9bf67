"""Names and where they live: profiles, integrators, quadratures, materials and models.

A registry holds addresses (``package.module:attribute``), so listing names imports nothing and a scene
imports only what it names. Built-ins and plugins come through the same hooks. This room is the only
place from which such an address is imported.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from shockwave.errors import PluginError, ShockwaveError, UnknownNameError
from shockwave.hooks import Entry
from shockwave.registry.installed import DISABLE, EVERY, Plugin, plugins, same_distribution, twice
from shockwave.registry.nouns import KINDS, PLUGIN_FAULTS, at, named, noun_at, own_entries
from shockwave.registry.samples import SAMPLES

__all__ = [
    "DISABLE",
    "EVERY",
    "KINDS",
    "Plugin",
    "blame",
    "entries",
    "find",
    "forget",
    "load",
    "own_entries",
    "owner_of",
    "plugins",
    "same_distribution",
]


def find(kind: str, name: str) -> Entry:
    """The entry of ``name``; plugins are looked for only when no built-in has the name.

    Raises
    ------
    UnknownNameError
        When the name is unknown; the message gives the known names and the nearest.
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
    home = SAMPLES.get((kind, name), "")
    disabled = [plugin.distribution for plugin in plugins() if plugin.disabled]
    faulty = [f"{plugin.distribution} ({plugin.problem})" for plugin in plugins() if not plugin.readable]
    if home and not any(home == distribution for distribution in disabled):
        hints.append(f"it comes with the sample plugin {home}: `pip install ./plugins/{home}` in the source tree")
    if disabled:
        hints.append(f"plugins that are disabled: {', '.join(disabled)}")
    if faulty:
        hints.append(f"plugins that cannot be read: {', '.join(faulty)}")
    return UnknownNameError(
        KINDS[kind], name, dict.fromkeys(entry.name for entry in entries(kind)), hints, faulty=bool(faulty)
    )


def load(kind: str, name: str) -> Any:
    """The object registered as ``name``: its module is imported now, and not before.

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
    try:
        return noun_at(kind, entry)
    except PLUGIN_FAULTS as error:
        version = next(plugin.version for plugin in plugins() if plugin.distribution == entry.distribution)
        problem = f"{KINDS[kind]} {entry.name!r}: {entry.address}: {named(error)}"
        raise PluginError(f"plugin {entry.distribution} {version} is at fault: {problem}") from error


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
    except PLUGIN_FAULTS as error:
        if noun.__module__.startswith("shockwave."):
            raise
        got = f"got {type(error).__name__}: {' '.join(str(error).split())[:200]}"
        raise PluginError(f"{KINDS[kind]} {owner_of(kind, noun)}: must not raise ({got})") from error


def _plugin_entries(kind: str) -> list[Entry]:
    return [entry for plugin in plugins() for of_kind, entry in plugin.entries if of_kind == kind]
