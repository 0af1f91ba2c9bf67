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

__all__ = ["KINDS", "READY", "answer_all", "at", "noun_at", "registered", "stamp"]

_GROUP = "shockwave"
_LONGEST = 300
#: The first line of a process that can answer.
READY = "shockwave reads plugins"
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


def noun_at(kind: str, address: str, takes: str = "") -> Any:
    """What stands at ``address``, if it is of its kind; of an integrator, if it has a use for what its entry ``takes``.

    Raises
    ------
    TypeError
        When it is not. Anything else comes from the module itself.
    """
    found = at(address)
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
        at("shockwave.document.declared:check_declared")(found)
        _check_ratio(found)
    if kind == "integrators":
        _check_takes(found, takes)
    return found


def _check_ratio(profile: Any) -> None:
    """A class of which nothing gives a duration ratio; one with a constructor of its own may set it there."""
    fields = {field.name for field in getattr(profile, "__attrs_attrs__", ())}
    plain = "__init__" in vars(profile) and not fields
    if "duration_ratio" not in fields and not hasattr(profile, "duration_ratio") and not plain:
        raise TypeError("must have duration_ratio, n: a field for the user to give, or a property")


def _check_takes(method: Any, takes: str) -> None:
    right, wrong = ("rtol", "step") if method.adaptive else ("step", "rtol")
    if right not in takes.split() or wrong in takes.split():
        trait = "adaptive" if method.adaptive else "of fixed step"
        raise TypeError(f"is {trait}, so its entry must say takes={right!r} (got {takes!r})")


def registered(module: ModuleType) -> list[tuple[str, Entry]]:
    """(kind, entry) of everything that ``module`` registers.

    Raises
    ------
    TypeError, ValueError
        When a hook is misspelt or takes arguments, when it returns no list of entries, or when there is nothing.
    """
    # pluggy looks long at whatever a module holds, so it is shown the hooks alone.
    shown = ModuleType(module.__name__)
    for name, function in vars(module).items():
        if hasattr(function, f"{_GROUP}_impl"):
            _check_hook(name, function)
            setattr(shown, name, function)
    manager = _manager()
    manager.register(shown)
    try:
        found = [claimed for kind in KINDS for claimed in _entries(manager, kind)]
    finally:
        manager.unregister(shown)
    if not found:
        raise ValueError("registers nothing (a hook without @hookimpl, or one that returns nothing?)")
    return found


def _check_hook(name: str, function: Any) -> None:
    known = [f"{_GROUP}_{kind}" for kind in KINDS]
    if name not in known:
        raise ValueError(f"unknown hook {name} (known: {', '.join(known)})")
    code = function.__code__
    if code.co_argcount or code.co_kwonlyargcount:
        raise TypeError(f"{name} must take no arguments (got {', '.join(code.co_varnames[: code.co_argcount])})")


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
    if not (entry.name.isprintable() and entry.name.strip() == entry.name != "") or not all(
        part.isidentifier() for part in (*module.split("."), attribute)
    ):
        raise ValueError(f"{_GROUP}_{kind} must give names, and addresses package.module:Class (got {entry!r:.160})")
    return entry


# ---------------------------------------------------------------- in the other process


def answer_all() -> None:
    """Answer the tasks of stdin on stdout, a line for each; what a plugin prints goes nowhere."""
    tasks = json.load(sys.stdin)
    # what a plugin may do to modules that are shared must not reach the answers
    out, dumps, process, get_process = os.fdopen(os.dup(1), "w", encoding="ascii"), json.dumps, os.getpid(), os.getpid
    leave = os._exit
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nowhere, stream)
    print(dumps(READY), file=out, flush=True)
    for task in tasks:
        answer = _answer(*task)
        if get_process() != process:  # a fork of the plugin's own
            leave(0)
        print(dumps(answer), file=out, flush=True)
    # threads that a plugin has begun must not keep this process
    leave(0)


def _answer(verb: str, *about: str) -> dict[str, Any]:
    before = set(sys.modules)
    try:
        if verb == "read":
            module = importlib.import_module(about[0])
            return {
                "entries": [(kind, *entry) for kind, entry in registered(module)],
                "files": _files(about[0], before),
            }
        noun_at(*about)
        return {"files": _files(about[1].partition(":")[0], before)}
    except BaseException as error:
        return {"problem": f"{type(error).__name__}: {_text(error)}{_remedy(error)}"[:_LONGEST]}


def _text(error: BaseException) -> str:
    try:
        return " ".join(str(error).split())
    except Exception:
        return "with a text that cannot be made"


def _remedy(error: BaseException) -> str:
    if not isinstance(error, ModuleNotFoundError):
        return ""
    return " (install it, and name it among the plugin's dependencies; if it is the plugin's own, it was not packaged)"


def _files(module: str, before: set[str]) -> dict[str, list[int]]:
    """Files of ``module``, of the packages around it and of all that it has imported, to tell whether they change."""
    parts = module.split(".")
    names = {".".join(parts[:end]) for end in range(1, len(parts) + 1)} | (sys.modules.keys() - before)
    files = (getattr(sys.modules.get(name), "__file__", None) for name in sorted(names))
    try:
        return {file: stamp(file) for file in files if isinstance(file, str)}
    except OSError:  # in an archive
        return {}


def stamp(file: str) -> list[int]:
    """What tells one state of a file from another."""
    state = os.stat(file)
    return [state.st_mtime_ns, state.st_size]
