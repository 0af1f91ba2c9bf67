"""Nouns: entries that a module of hooks registers, and the objects at their addresses, checked against their kind."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from contextlib import redirect_stdout
from functools import cache
from types import ModuleType
from typing import Any

import pluggy

from shockwave import OWN_DISTRIBUTION, hooks
from shockwave.hooks import Entry

__all__ = ["KINDS", "PLUGIN_FAULTS", "at", "imported", "named", "noun_at", "own_entries", "registered"]

#: Kind of a noun -> how one of them is called in a sentence.
KINDS = {
    "profiles": "profile",
    "integrators": "integrator",
    "quadratures": "quadrature",
    "materials": "material",
    "models": "model",
}
#: A plugin's module may even exit the interpreter on import; only the user's interrupt passes.
PLUGIN_FAULTS = (Exception, SystemExit)
#: What an address must lead to: a subclass of this, or an instance.
_EXPECTED = {
    "profiles": "shockwave.profiles.base:ShockProfile",
    "integrators": "shockwave.simulation.integrator:Integrator",
    "quadratures": "shockwave.quadrature.base:Quadrature",
    "materials": "shockwave.chain.material:Material",
}
# most characters of a plugin's error that are shown
_LONGEST = 300


def own_entries(kind: str) -> list[Entry]:
    """What shockwave itself registers."""
    return [entry for of_kind, entry in _built_in() if of_kind == kind]


@cache
def _built_in() -> tuple[tuple[str, Entry], ...]:
    own = registered(importlib.import_module("shockwave.built_ins"))
    return tuple((kind, entry._replace(distribution=OWN_DISTRIBUTION)) for kind, entry in own)


def imported(module: str) -> ModuleType:
    """Import a module of a plugin; its printed output goes to stderr."""
    with redirect_stdout(sys.stderr):
        return importlib.import_module(module)


def registered(module: ModuleType) -> list[tuple[str, Entry]]:
    """(kind, entry) of everything that ``module`` registers.

    Raises
    ------
    TypeError, ValueError
        When a hook returns no list of entries, or when there is nothing.
    pluggy.PluginValidationError
        When a hook is unknown or takes arguments.
    """
    manager = pluggy.PluginManager("shockwave")
    manager.add_hookspecs(hooks)
    manager.register(module)
    manager.check_pending()
    with redirect_stdout(sys.stderr):
        found = [(kind, entry) for kind in KINDS for entry in _entries(manager, kind)]
    if not found:
        raise ValueError("registers nothing (a hook without @hookimpl, or one that returns nothing?)")
    return found


def _entries(manager: pluggy.PluginManager, kind: str) -> Iterator[Entry]:
    hook = f"shockwave_{kind}"
    for returned in getattr(manager.hook, hook)():
        if not isinstance(returned, list | tuple):
            raise TypeError(f"{hook} must return a list of entries (got {returned!r:.80})")
        for entry in returned:
            if not (isinstance(entry, Entry) and all(isinstance(text, str) for text in entry)):
                raise TypeError(f"{hook} must return entries of strings (got {entry!r:.80})")
            module, _, attribute = entry.address.partition(":")
            well_named = entry.name.isprintable() and entry.name.strip() == entry.name != ""
            if not (well_named and all(part.isidentifier() for part in (*module.split("."), attribute))):
                raise ValueError(f"{hook} must give names, and addresses package.module:Class (got {entry!r:.160})")
            yield entry


def at(address: str) -> Any:
    """Object at ``address``; its module is imported now."""
    module, _, attribute = address.partition(":")
    return getattr(importlib.import_module(module), attribute)


def noun_at(kind: str, entry: Entry) -> Any:
    """Object that a plugin registers, checked against its kind and, for an integrator, the options of its entry.

    Raises
    ------
    TypeError
        When it is not. Anything else comes from the module itself.
    """
    module, _, attribute = entry.address.partition(":")
    found = getattr(imported(module), attribute)
    if kind == "materials":
        fits, wanted = isinstance(found, at(_EXPECTED[kind])), "a Material, made"
    elif kind in _EXPECTED:
        fits = isinstance(found, type) and issubclass(found, at(_EXPECTED[kind]))
        wanted = f"a subclass of {_EXPECTED[kind].partition(':')[2]}"
    else:
        fits, wanted = callable(found), "a function of a scaled shock"
    if not fits:
        raise TypeError(f"must be {wanted} (got {found!r:.80})")
    abstract = sorted(getattr(found, "__abstractmethods__", ()))
    if abstract:
        raise TypeError(f"must write {' and '.join(abstract)} too (got {found!r:.80})")
    if kind == "profiles":
        at("shockwave.scenario.declared_fields:check_declared")(found)
        _check_ratio(found)
    if kind == "integrators":
        _check_takes(found, entry.takes)
    return found


def _check_ratio(profile: Any) -> None:
    """Refuse a class without a duration ratio; a class with its own constructor may set it there."""
    fields = {field.name for field in getattr(profile, "__attrs_attrs__", ())}
    plain = "__init__" in vars(profile) and not fields
    if "duration_ratio" not in fields and not hasattr(profile, "duration_ratio") and not plain:
        raise TypeError("must have duration_ratio, n: a field for the user to give, or a property")


def _check_takes(method: Any, takes: str) -> None:
    right, wrong = ("rtol", "step") if method.adaptive else ("step", "rtol")
    if right not in takes.split() or wrong in takes.split():
        trait = "adaptive" if method.adaptive else "of fixed step"
        raise TypeError(f"is {trait}, so its entry must say takes={right!r} (got {takes!r})")


def named(error: BaseException) -> str:
    """Error of a plugin in one line, with the usual remedy, if any."""
    remedy = ""
    if isinstance(error, ModuleNotFoundError):
        remedy = (
            "install it, and name it among the plugin's dependencies; if it is the plugin's own, it was not packaged"
        )
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}{f' ({remedy})' if remedy else ''}"[:_LONGEST]
