"""Names and where they live: profiles, integrators, quadratures, materials and models.

A registry holds addresses (``package.module:attribute``), so listing names imports nothing and a scene
imports only what it names. Built-ins and plugins come through the same hooks. This is the only
module from which such an address is imported.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, Final

from shockwave.errors import PluginError, ShockwaveError, UnknownNameError
from shockwave.hooks import Entry
from shockwave.installed_plugins import (
    DISABLE,
    EVERY,
    KINDS,
    PLUGIN_FAULTS,
    Plugin,
    built_in,
    described,
    imported,
    plugins,
    same_distribution,
    twice,
)

__all__ = [
    "DISABLE",
    "EVERY",
    "KINDS",
    "SAMPLES",
    "Plugin",
    "blame",
    "entries",
    "find",
    "forget",
    "load",
    "loaded_entry",
    "own_entries",
    "owner_of",
    "plugins",
    "same_distribution",
]

_PULSES = "half-sine haversine trapezoid initial-peak-sawtooth final-peak-sawtooth rectangular hertz-impact"
#: Names that the sample plugins of the source tree register, for the installation hint.
SAMPLES: Final = {
    "shockwave-pulses": ("profiles", _PULSES.split()),
    "shockwave-blast": ("profiles", ["friedlander", "kingery-bulmash"]),
    "shockwave-composition": (
        "integrators",
        ["blanes-moan-4", "blanes-moan-6", "blanes-moan-6-long", "verlet-richardson"],
    ),
}
#: Base class that an address of a kind must lead to.
_BASES = {
    "profiles": "shockwave.profiles.base:ShockProfile",
    "integrators": "shockwave.simulation.integrator:Integrator",
    "quadratures": "shockwave.quadrature.base:Quadrature",
}


def find(kind: str, name: str) -> Entry:
    """The entry of ``name``; plugins are looked for only when no built-in has the name.

    Raises
    ------
    UnknownNameError
        When the name is unknown; the message gives the known names and the nearest.
    PluginError
        When two distributions claim it.
    """
    own = built_in(kind).get(name)
    if own is not None:
        return own
    owners = [entry for entry in _plugin_entries(kind) if entry.name == name]
    if not owners:
        raise _unknown(kind, name)
    if len(owners) > 1:
        raise PluginError(twice(kind, name, (entry.distribution for entry in owners)))
    return owners[0]


def _unknown(kind: str, name: str) -> UnknownNameError:
    disabled = [plugin.distribution for plugin in plugins() if plugin.disabled]
    faulty = [
        f"{plugin.distribution} ({plugin.problem})" for plugin in plugins() if plugin.problem and not plugin.entries
    ]
    hints = [
        f"it comes with the sample plugin {home}: `pip install ./plugins/{home}` in the source tree"
        for home, (of_kind, names) in SAMPLES.items()
        if kind == of_kind and name in names and home not in disabled
    ]
    if disabled:
        hints.append(f"plugins that are disabled: {', '.join(disabled)}")
    if faulty:
        hints.append(f"plugins that cannot be read: {', '.join(faulty)}")
    known = dict.fromkeys(entry.name for entry in entries(kind))
    return UnknownNameError(KINDS[kind], name, known, hints, faulty=bool(faulty))


@cache
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
    if name in built_in(kind):
        return _at(entry.address)
    try:
        return loaded_entry(kind, entry)
    except PLUGIN_FAULTS as error:
        version = next(plugin.version for plugin in plugins() if plugin.distribution == entry.distribution)
        problem = f"{KINDS[kind]} {entry.name!r}: {entry.address}: {described(error)}"
        raise PluginError(f"plugin {entry.distribution} {version} is at fault: {problem}") from error


def forget() -> None:
    """Look for plugins anew: what is installed, or disabled, has changed."""
    plugins.cache_clear()
    load.cache_clear()


def own_entries(kind: str) -> list[Entry]:
    """What shockwave itself registers."""
    return list(built_in(kind).values())


def entries(kind: str) -> list[Entry]:
    """Everything registered under ``kind``, built-ins first; imports none of it."""
    return [*own_entries(kind), *sorted(_plugin_entries(kind), key=lambda entry: entry.name)]


def _plugin_entries(kind: str) -> list[Entry]:
    return [entry for plugin in plugins() for of_kind, entry in plugin.entries if of_kind == kind]


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


# ---------------------------------------------------------------- what stands at an address


def _at(address: str) -> Any:
    module, _, attribute = address.partition(":")
    return getattr(importlib.import_module(module), attribute)


def loaded_entry(kind: str, entry: Entry) -> Any:
    """Object that a plugin registers, checked against its kind.

    Raises
    ------
    TypeError
        When it does not fit. Anything else comes from the module itself.
    """
    module, _, attribute = entry.address.partition(":")
    found = getattr(imported(module), attribute)
    rule = _rule_broken(kind, found)
    if rule:
        raise TypeError(f"{rule} (got {found!r:.80})")
    if kind == "profiles":
        _at("shockwave.scenario.declared_fields:check_declared")(found)
        _check_ratio(found)
    if kind == "integrators":
        _check_takes(found, entry.takes)
    return found


def _rule_broken(kind: str, found: Any) -> str:
    if kind == "materials":
        return "" if isinstance(found, _at("shockwave.chain.material:Material")) else "must be a Material, made"
    if kind == "models":
        return "" if callable(found) else "must be a function of a scaled shock"
    base = _at(_BASES[kind])
    if not (isinstance(found, type) and issubclass(found, base)):
        return f"must be a subclass of {base.__name__}"
    missing = sorted(getattr(found, "__abstractmethods__", ()))
    return f"must write {' and '.join(missing)} too" if missing else ""


def _check_ratio(profile: Any) -> None:
    """Refuse a class without a duration ratio; a class with its own constructor may set it there."""
    fields = {field.name for field in getattr(profile, "__attrs_attrs__", ())}
    sets_it = "__init__" in vars(profile) and not fields
    if "duration_ratio" not in fields and not hasattr(profile, "duration_ratio") and not sets_it:
        raise TypeError("must have duration_ratio, n: a field for the user to give, or a property")


def _check_takes(method: Any, takes: str) -> None:
    right, wrong = ("rtol", "step") if method.adaptive else ("step", "rtol")
    if right not in takes.split() or wrong in takes.split():
        trait = "adaptive" if method.adaptive else "of fixed step"
        raise TypeError(f"is {trait}, so its entry must say takes={right!r} (got {takes!r})")
