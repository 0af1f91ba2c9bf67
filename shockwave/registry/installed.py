"""Installed plugins: distributions with an entry point in the group ``shockwave``, the faulty ones too."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING

from attrs import evolve, frozen

import shockwave
from shockwave.hooks import Entry
from shockwave.registration import KINDS
from shockwave.registry.isolation import Isolated

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

__all__ = ["DISABLE", "EVERY", "Plugin", "checked", "plugins", "same_distribution"]

#: The variable that names, with commas between them, distributions not to be used.
DISABLE = "SHOCKWAVE_DISABLE_PLUGINS"
#: Its value that means all of them.
EVERY = "*"
_GROUP = "shockwave"
_REQUIREMENT = re.compile(r"shockwave\s*(?:\[[^]]*\]\s*)?\(?([<>=!~][^;)]*)\)?\s*(?:;(.*))?\Z", re.IGNORECASE)


@frozen
class Plugin:
    """An installed distribution that registers nouns, and what is wrong with it, if anything is.

    Attributes
    ----------
    distribution, version : str
        As its metadata tell.
    entries : tuple of (str, Entry)
        Kind and entry of what it registers and what can be used; none where it cannot be read.
    problem : str
        What is wrong with it, in words.
    disabled : bool
        Left out by SHOCKWAVE_DISABLE_PLUGINS, and therefore not read.
    """

    distribution: str
    version: str
    entries: tuple[tuple[str, Entry], ...]
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
    return re.sub(r"[-_.]+", "-", name).lower()


@cache
def plugins() -> tuple[Plugin, ...]:
    """Every installed plugin; its hooks are read in a process of their own, and nothing of it is imported here."""
    from importlib.metadata import entry_points

    points = sorted(entry_points(group=_GROUP), key=lambda point: (point.name, point.value))
    disabled = {_plain(name.strip()) for name in os.environ.get(DISABLE, "").split(",") if name.strip()}
    disabled = {_plain(name.strip()) for name in os.environ.get(DISABLE, "").split(",") if name.strip()}
    read = [point for point in points if not disabled & {EVERY, _plain(_name(point))}] if disabled else points
    reading = Isolated([("read", point.value) for point in read])
    # While the other process reads the hooks, this one reads the metadata.
    found = {point: _described(point) for point in points}
    for point, answer in zip(read, reading.answers(), strict=True):
        plugin = found[point]
        read_entries = ((kind, Entry(*entry)) for kind, *entry in answer.get("entries", ()))
        entries = [(kind, entry._replace(distribution=plugin.distribution)) for kind, entry in read_entries]
        problem = plugin.problem or answer.get("problem", "")
        found[point] = evolve(plugin, entries=() if problem else tuple(entries), problem=problem, disabled=False)
    return _without_clashes(found.values())


def _name(point: EntryPoint) -> str:
    return (point.dist.name if point.dist else None) or point.name


def _described(point: EntryPoint) -> Plugin:
    """What the metadata of its distribution tell; ``disabled`` as long as it is not read."""
    text = (point.dist.read_text("METADATA") or point.dist.read_text("PKG-INFO") or "") if point.dist else ""
    fields: dict[str, list[str]] = {}
    # Only the head is read: a parser of messages takes longer for many plugins than all else together.
    for line in text.partition("\n\n")[0].splitlines():
        name, _, value = line.partition(":")
        fields.setdefault(name.lower(), []).append(value.strip())
    (name, *_), (version, *_) = fields.get("name", [point.name]), fields.get("version", [""])
    return Plugin(name, version, (), _unmet(fields.get("requires-dist", ())), disabled=True)


def _unmet(requirements: Iterable[str]) -> str:
    """What is wrong, if the plugin asks for another version of shockwave."""
    for requirement in requirements:
        match = _REQUIREMENT.match(requirement)
        if match and not (match[2] and "extra" in match[2]):
            from packaging.specifiers import InvalidSpecifier, SpecifierSet

            try:
                fits = SpecifierSet(match[1]).contains(shockwave.__version__, prereleases=True)
            except InvalidSpecifier:
                fits = True  # not ours to judge
            if not fits:
                this = f"this is {shockwave.__version__}; install a version that fits"
                return f"needs shockwave {match[1].strip()} ({this})"
    return ""


def _without_clashes(found: Iterable[Plugin]) -> tuple[Plugin, ...]:
    """Plugins as they are found, those that claim a name of another told so.

    A name of shockwave's own is refused; one that two plugins claim stays with both, for `find` to refuse.
    """
    from shockwave.registry import own_entries

    plugins = list(found)
    own = {(kind, entry.name) for kind in KINDS for entry in own_entries(kind)}
    claims = Counter((kind, entry.name) for plugin in plugins for kind, entry in plugin.entries)
    for index, plugin in enumerate(plugins):
        problems = []
        for kind, entry in plugin.entries:
            if (kind, entry.name) in own:
                problems.append(f"{KINDS[kind]} {entry.name!r} is one of shockwave itself, and stays so")
            elif claims[kind, entry.name] > 1:
                owners = _owners(plugins, kind, entry.name)
                problems.append(f"{KINDS[kind]} {entry.name!r} is registered twice, by {owners}: uninstall one of them")
        kept = tuple((kind, entry) for kind, entry in plugin.entries if (kind, entry.name) not in own)
        problem = "; ".join([*filter(None, [plugin.problem]), *dict.fromkeys(problems)])
        plugins[index] = evolve(plugin, entries=kept, problem=problem)
    return tuple(plugins)


def _owners(plugins: Iterable[Plugin], kind: str, name: str) -> str:
    owners = (plugin.distribution for plugin in plugins for claimed in plugin.entries if _is(claimed, kind, name))
    return " and ".join(dict.fromkeys(owners))


def _is(claimed: tuple[str, Entry], kind: str, name: str) -> bool:
    return claimed[0] == kind and claimed[1].name == name


def checked(plugin: Plugin, anew: bool = True) -> Plugin:
    """``plugin``, each of whose nouns was imported in a process of its own, to tell those that cannot be.

    ``anew``, even those that could be before.
    """
    answers = Isolated([("load", kind, entry.address) for kind, entry in plugin.entries], anew).answers()
    problems = [
        f"{KINDS[kind]} {entry.name!r}: {entry.address}: {answer['problem']}"
        for (kind, entry), answer in zip(plugin.entries, answers, strict=True)
        if "problem" in answer
    ]
    return evolve(plugin, problem="; ".join([*filter(None, [plugin.problem]), *problems]))
