"""Installed plugins: distributions with an entry point in the group ``shockwave``, and the entries that they register.

A plugin's module of hooks is imported here, in this process; whatever it raises is a problem of that plugin alone.
"""

from __future__ import annotations

import importlib
import os
import re
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from contextlib import redirect_stdout
from functools import cache
from types import ModuleType
from typing import TYPE_CHECKING

import pluggy
from attrs import evolve, frozen

from shockwave import OWN_DISTRIBUTION, __version__, built_ins, hooks
from shockwave.hooks import Entry

if TYPE_CHECKING:
    from importlib.metadata import Distribution

#: Kind of an entry -> how one of them is called in a sentence.
KINDS = {
    "profiles": "profile",
    "integrators": "integrator",
    "quadratures": "quadrature",
    "materials": "material",
    "models": "model",
}
#: The variable that names, with commas between them, distributions not to be used.
DISABLE = "SHOCKWAVE_DISABLE_PLUGINS"
#: Its value that means all of them.
EVERY = "*"
#: A plugin's module may even exit the interpreter on import; only the user's interrupt passes.
PLUGIN_FAULTS = (Exception, SystemExit)
#: Most characters of a plugin's error that are shown.
_LONGEST = 300
_PACKAGING = "install it, and name it among the plugin's dependencies; if it is the plugin's own, it was not packaged"

_Claims = tuple[tuple[str, Entry], ...]


@frozen
class Plugin:
    """An installed distribution that registers entries, and what is wrong with it, if anything is.

    Attributes
    ----------
    distribution, version : str
        Name and version in the metadata.
    module : str
        Its module of hooks; empty if that must not be imported.
    entries : tuple of (str, Entry)
        Kind and entry of what it registers and what can be used; none where it cannot be read.
    problem : str
        What is wrong with it, in words.
    disabled : bool
        Left out by SHOCKWAVE_DISABLE_PLUGINS, and therefore not read.
    """

    distribution: str
    version: str
    module: str = ""
    entries: _Claims = ()
    problem: str = ""
    disabled: bool = False


def same_distribution(one: str, other: str) -> bool:
    """Whether two names are those of one distribution: case, and which of - _ . is used, make no difference."""
    return _plain(one) == _plain(other)


def _plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name.strip()).lower()


# ---------------------------------------------------------------- what is installed


@cache
def plugins() -> tuple[Plugin, ...]:
    """Every installed plugin; only the modules of hooks are imported."""
    return found(_read)


def _read(module: str) -> tuple[_Claims, str]:
    try:
        return registered(imported(module)), ""
    except PLUGIN_FAULTS as error:
        return (), described(error)


def found(
    read: Callable[[str], tuple[_Claims, str]], each: Callable[..., Iterable[tuple[_Claims, str]]] = map
) -> tuple[Plugin, ...]:
    """Every installed plugin.

    Parameters
    ----------
    read : callable
        Returns the entries and the problem of a module of hooks.
    each : callable
        `map`, or another that calls a function for each plugin.
    """
    listed = list(_installed())
    results = each(lambda plugin: read(plugin.module) if plugin.module else ((), plugin.problem), listed)
    claims: dict[tuple[str, str], list[str]] = defaultdict(list)
    answers = []
    for plugin, (entries, problem) in zip(listed, results, strict=True):
        answers.append(evolve(plugin, entries=entries, problem=problem))
        for kind, entry in entries:
            claims[kind, entry.name].append(plugin.distribution)
    return tuple(_without_clashes(plugin, claims) for plugin in answers)


def _installed() -> Iterator[Plugin]:
    """Each plugin as its metadata describe it."""
    from importlib.metadata import entry_points

    disabled = {_plain(name) for name in os.environ.get(DISABLE, "").split(",")}
    points = [(point.dist, point) for point in entry_points(group="shockwave") if point.dist is not None]
    for distribution, point in sorted(points, key=lambda pair: (pair[0].name, pair[1].value)):
        plugin = Plugin(distribution.name, distribution.version)
        if disabled & {EVERY, _plain(plugin.distribution)}:
            yield evolve(plugin, disabled=True)
        elif problem := _unmet(distribution):
            yield evolve(plugin, problem=problem)
        elif point.attr:
            yield evolve(plugin, problem=f"the entry point {point.name!r} must name a module (got {point.value})")
        else:
            yield evolve(plugin, module=point.module)


def _unmet(distribution: Distribution) -> str:
    """What is wrong, if the plugin asks for another version of shockwave."""
    from packaging.requirements import Requirement

    for needed in map(Requirement, distribution.requires or ()):
        ours = same_distribution(needed.name, OWN_DISTRIBUTION)
        applies = ours and (needed.marker is None or needed.marker.evaluate({"extra": ""}))
        if applies and not needed.specifier.contains(__version__, prereleases=True):
            this = f"this is {__version__}; install a version that fits"
            return f"needs {OWN_DISTRIBUTION} {needed.specifier} ({this})"
    return ""


def _without_clashes(plugin: Plugin, claims: dict[tuple[str, str], list[str]]) -> Plugin:
    """The plugin with a problem where it claims a name of another.

    A name of shockwave's own is refused; one that two plugins claim stays with both, for the registry to refuse.
    """
    problems, kept = [plugin.problem], []
    for kind, entry in plugin.entries:
        if entry.name in built_in(kind):
            problems.append(f"{KINDS[kind]} {entry.name!r} is a name of shockwave itself: choose another")
            continue
        if len(claims[kind, entry.name]) > 1:
            problems.append(twice(kind, entry.name, claims[kind, entry.name]))
        kept.append((kind, entry._replace(distribution=plugin.distribution)))
    return evolve(plugin, entries=tuple(kept), problem="; ".join(filter(None, dict.fromkeys(problems))))


def twice(kind: str, name: str, distributions: Iterable[str]) -> str:
    """Message for a name that several ``distributions`` register, or that one registers twice."""
    owners = " and ".join(dict.fromkeys(distributions))
    return f"{KINDS[kind]} {name!r} is registered twice, by {owners}: uninstall one, or give it another name there"


# ---------------------------------------------------------------- what a module of hooks registers


@cache
def built_in(kind: str) -> dict[str, Entry]:
    """Name -> entry, of what shockwave itself registers under ``kind``."""
    own: list[Entry] = getattr(built_ins, f"shockwave_{kind}")()
    return {entry.name: entry._replace(distribution=OWN_DISTRIBUTION) for entry in own}


def imported(module: str) -> ModuleType:
    """Import a module of a plugin; its printed output goes to stderr."""
    with redirect_stdout(sys.stderr):
        return importlib.import_module(module)


def registered(module: ModuleType) -> _Claims:
    """Kind and entry of everything that ``module`` registers.

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
        claims = tuple((kind, entry) for kind in KINDS for entry in _entries(manager, f"shockwave_{kind}"))
    if not claims:
        raise ValueError("registers nothing (a hook without @hookimpl, or one that returns nothing?)")
    return claims


def _entries(manager: pluggy.PluginManager, hook: str) -> Iterator[Entry]:
    for returned in getattr(manager.hook, hook)():
        if not isinstance(returned, list | tuple):
            raise TypeError(f"{hook} must return a list of entries (got {returned!r:.80})")
        for entry in returned:
            if not (isinstance(entry, Entry) and all(isinstance(text, str) for text in entry)):
                raise TypeError(f"{hook} must return entries of strings (got {entry!r:.80})")
            if not (entry.name.strip() and re.fullmatch(r"\w+(\.\w+)*:\w+", entry.address)):
                raise ValueError(f"{hook} must give names, and addresses package.module:Class (got {entry!r:.160})")
            yield entry


def described(error: BaseException) -> str:
    """Error of a plugin in one line, with the usual remedy, if any."""
    remedy = f" ({_PACKAGING})" if isinstance(error, ModuleNotFoundError) else ""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}{remedy}"[:_LONGEST]
