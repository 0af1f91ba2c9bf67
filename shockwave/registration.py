"""Registration: what a module of hooks registers, by the rules of pluggy, and what stands at an address.

It is also the program of the process in which a plugin's code is first run; so it imports next to nothing.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
from collections.abc import Iterator
from functools import cache
from types import ModuleType
from typing import Any

import pluggy

from shockwave import hooks
from shockwave.hooks import Entry

__all__ = ["KINDS", "answer_all", "at", "noun_at", "registered", "stamp"]

_GROUP = "shockwave"
_LONGEST = 300
#: Kind of a noun -> how one of them is called in a sentence.
KINDS = {
    "profiles": "profile",
    "integrators": "integrator",
    "quadratures": "quadrature",
    "materials": "material",
    "models": "model",
}
#: What an address must lead to: a subclass of this, or an instance.
_EXPECTED = {
    "profiles": "shockwave.profiles.base:ShockProfile",
    "integrators": "shockwave.simulation.integrator:Integrator",
    "quadratures": "shockwave.quadrature.base:Quadrature",
    "materials": "shockwave.chain.material:Material",
}


def at(address: str) -> Any:
    """What stands at ``address``; its module is imported now."""
    module, _, attribute = address.partition(":")
    return getattr(importlib.import_module(module), attribute)


def noun_at(kind: str, address: str) -> Any:
    """What stands at ``address``, if it is of its kind.

    Raises
    ------
    TypeError
        When it is not. Anything else comes from the module itself.
    """
    found = at(address)
    if kind == "materials":
        fits = isinstance(found, at(_EXPECTED[kind]))
    elif kind in _EXPECTED:
        fits = isinstance(found, type) and issubclass(found, at(_EXPECTED[kind]))
    else:
        fits = callable(found)
    if not fits:
        wanted = _EXPECTED[kind].partition(":")[2] if kind in _EXPECTED else "function of a scaled shock"
        raise TypeError(f"must be a {wanted if kind != 'materials' else 'Material object'} (got {found!r:.80})")
    abstract = sorted(getattr(found, "__abstractmethods__", ()))
    if abstract:
        raise TypeError(f"must write {' and '.join(abstract)} too (got {found!r:.80})")
    return found


def registered(module: ModuleType) -> list[tuple[str, Entry]]:
    """(kind, entry) of everything that ``module`` registers.

    Raises
    ------
    pluggy.PluginValidationError
        When a hook is misspelt or takes arguments.
    TypeError, ValueError
        When what a hook returns is no list of entries, or when there is nothing.
    """
    manager = _manager()
    manager.register(module)
    try:
        manager.check_pending()  # a misspelt hook is an error, not silence
        found = [claimed for kind in KINDS for claimed in _entries(manager, kind)]
    finally:
        manager.unregister(module)
    if not found:
        raise ValueError("registers nothing (a hook without @hookimpl, or one that returns nothing?)")
    return found


@cache
def _manager() -> pluggy.PluginManager:
    manager = pluggy.PluginManager(_GROUP)
    manager.add_hookspecs(hooks)
    return manager


def _entries(manager: pluggy.PluginManager, kind: str) -> Iterator[tuple[str, Entry]]:
    hook = f"{_GROUP}_{kind}"
    for returned in getattr(manager.hook, hook)():
        if not isinstance(returned, list | tuple):
            raise TypeError(f"{hook} must return a list of entries (got {returned!r:.80})")
        yield from ((kind, _checked(kind, entry)) for entry in returned)


def _checked(kind: str, entry: object) -> Entry:
    if not (isinstance(entry, Entry) and all(isinstance(text, str) for text in entry)):
        raise TypeError(f"{_GROUP}_{kind} must return entries of strings (got {entry!r:.80})")
    module, _, attribute = entry.address.partition(":")
    if not entry.name or not all(part.isidentifier() for part in (*module.split("."), attribute)):
        raise ValueError(f"{_GROUP}_{kind} must give names, and addresses package.module:Class (got {entry!r:.160})")
    return entry


# ---------------------------------------------------------------- in the other process


def answer_all() -> None:
    """Answer the tasks of stdin on stdout, a line for each; what a plugin prints goes nowhere."""
    tasks = json.load(sys.stdin)
    out = os.fdopen(os.dup(1), "w", encoding="ascii")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nowhere, stream)
    for task in tasks:
        print(json.dumps(_answer(*task)), file=out, flush=True)
    # threads that a plugin has begun must not keep this process
    os._exit(0)


def _answer(verb: str, *about: str) -> dict[str, Any]:
    try:
        if verb == "read":
            module = importlib.import_module(about[0])
            return {"entries": [(kind, *entry) for kind, entry in registered(module)], "files": _files(about[0])}
        noun_at(*about)
        return {"files": _files(about[1].partition(":")[0])}
    except BaseException as error:
        text = " ".join(str(error).split())
        return {"problem": f"{type(error).__name__}: {text}"[:_LONGEST]}


def _files(module: str) -> dict[str, list[int]]:
    """Files of ``module`` and of the packages around it, with what tells whether they have changed."""
    parts = module.split(".")
    modules = (sys.modules.get(".".join(parts[:end])) for end in range(1, len(parts) + 1))
    files = [file for file in (getattr(module, "__file__", None) for module in modules) if file]
    return {file: stamp(file) for file in files}


def stamp(file: str) -> list[int]:
    """What tells one state of a file from another."""
    state = os.stat(file)
    return [state.st_mtime_ns, state.st_size]
