"""Installed plugins: distributions with an entry point in the group ``shockwave``, including those at fault."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from typing import TYPE_CHECKING

from attrs import evolve, frozen

import shockwave
from shockwave.hooks import Entry
from shockwave.registry.nouns import KINDS, PLUGIN_FAULTS, imported, named, own_entries, registered

if TYPE_CHECKING:
    from importlib.metadata import Distribution

__all__ = ["DISABLE", "EVERY", "Plugin", "found", "plugins", "same_distribution", "twice"]

#: The variable that names, with commas between them, distributions not to be used.
DISABLE = "SHOCKWAVE_DISABLE_PLUGINS"
#: Its value that means all of them.
EVERY = "*"

_Claims = tuple[tuple[str, Entry], ...]


@frozen
class Plugin:
    """An installed distribution that registers nouns, and what is wrong with it, if anything is.

    Attributes
    ----------
    distribution, version : str
        Name and version in the metadata.
    entries : tuple of (str, Entry)
        Kind and entry of what it registers and what can be used; none where it cannot be read.
    problem : str
        What is wrong with it, in words.
    disabled : bool
        Left out by SHOCKWAVE_DISABLE_PLUGINS, and therefore not read.
    """

    distribution: str
    version: str = ""
    entries: _Claims = ()
    problem: str = ""
    disabled: bool = False

    @property
    def readable(self) -> bool:
        """Whether it is known what it registers."""
        return bool(self.entries) or self.disabled


def same_distribution(one: str, other: str) -> bool:
    """Whether two names are those of one distribution: case, and which of - _ . is used, make no difference."""
    return _plain(one) == _plain(other)


def _plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name.strip()).lower()


@cache
def plugins() -> tuple[Plugin, ...]:
    """Every installed plugin; only the modules of hooks are imported."""
    return found(lambda modules: map(_read, modules))


def _read(module: str) -> tuple[_Claims, str]:
    try:
        return tuple(registered(imported(module))), ""
    except PLUGIN_FAULTS as error:
        return (), named(error)


def found(read: Callable[[list[str]], Iterable[tuple[_Claims, str]]]) -> tuple[Plugin, ...]:
    """Every installed plugin; ``read`` returns the entries and the problem of each module of hooks."""
    pairs = sorted(_described(), key=lambda pair: (pair[0].distribution, pair[1]))
    answers = iter(read([module for _, module in pairs if module]))
    listed = []
    for plugin, module in pairs:
        entries, problem = next(answers) if module else ((), plugin.problem)
        owned = tuple((kind, entry._replace(distribution=plugin.distribution)) for kind, entry in entries)
        listed.append(evolve(plugin, entries=owned, problem=problem))
    return _without_clashes(listed)


def _described() -> Iterator[tuple[Plugin, str]]:
    """Each plugin as its metadata describe it, and its module of hooks, empty if it must not be imported."""
    from importlib import metadata

    disabled = {_plain(name) for name in os.environ.get(DISABLE, "").split(",")}
    seen = set()
    for distribution in metadata.distributions():
        # if the metadata cannot be read, the folder serves as the name
        name, version = getattr(getattr(distribution, "_path", None), "name", "unknown"), ""
        what = "entry points"
        try:
            points = distribution.entry_points.select(group="shockwave")
            if not points:
                continue
            what = "metadata"
            name, version = distribution.metadata["Name"], distribution.metadata["Version"] or ""
            unmet = _unmet(distribution)
        except Exception as error:  # of one distribution: the others are well
            yield Plugin(name, version, problem=f"its {what} cannot be read ({type(error).__name__}: {error})"), ""
            continue
        if _plain(name) in seen:  # hidden by one of the same name earlier on the path
            continue
        seen.add(_plain(name))
        out = not disabled.isdisjoint({EVERY, _plain(name)})
        for point in points:
            wrong = f"the entry point {point.name!r} must name a module (got {point.value})" if point.attr else ""
            problem = "" if out else unmet or wrong
            yield Plugin(name, version, problem=problem, disabled=out), "" if out or problem else point.module


def _unmet(distribution: Distribution) -> str:
    """What is wrong, if the plugin asks for another version of shockwave."""
    from packaging.requirements import InvalidRequirement, Requirement

    for text in distribution.requires or ():
        try:
            needed = Requirement(text)
        except InvalidRequirement:
            continue  # not ours to judge
        ours = same_distribution(needed.name, shockwave.OWN_DISTRIBUTION)
        applies = ours and (needed.marker is None or needed.marker.evaluate({"extra": ""}))
        if applies and not needed.specifier.contains(shockwave.__version__, prereleases=True):
            this = f"this is {shockwave.__version__}; install a version that fits"
            return f"needs {shockwave.OWN_DISTRIBUTION} {needed.specifier} ({this})"
    return ""


def _without_clashes(listed: Iterable[Plugin]) -> tuple[Plugin, ...]:
    """The plugins, with a problem where one claims a name of another.

    A name of shockwave's own is refused; one that two plugins claim stays with both, for `find` to refuse.
    """
    listed = list(listed)
    own = {(kind, entry.name) for kind in KINDS for entry in own_entries(kind)}
    owners: dict[tuple[str, str], list[str]] = {}
    for plugin in listed:
        for kind, entry in plugin.entries:
            owners.setdefault((kind, entry.name), []).append(plugin.distribution)
    return tuple(_settled(plugin, own, owners) for plugin in listed)


def _settled(plugin: Plugin, own: set[tuple[str, str]], owners: dict[tuple[str, str], list[str]]) -> Plugin:
    problems = [plugin.problem]
    for kind, entry in plugin.entries:
        if (kind, entry.name) in own:
            problems.append(f"{KINDS[kind]} {entry.name!r} is a name of shockwave itself: choose another")
        elif len(owners[kind, entry.name]) > 1:
            problems.append(twice(kind, entry.name, owners[kind, entry.name]))
    kept = tuple((kind, entry) for kind, entry in plugin.entries if (kind, entry.name) not in own)
    return evolve(plugin, entries=kept, problem="; ".join(filter(None, dict.fromkeys(problems))))


def twice(kind: str, name: str, distributions: Iterable[str]) -> str:
    """Message for a name that several ``distributions`` register, or that one registers twice."""
    owners = " and ".join(dict.fromkeys(distributions))
    return f"{KINDS[kind]} {name!r} is registered twice, by {owners}: uninstall one, or give it another name there"
