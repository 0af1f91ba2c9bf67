"""Installed plugins: distributions with an entry point in the group ``shockwave``, the faulty ones too."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING, Any

from attrs import evolve, frozen

import shockwave
from shockwave.hooks import Entry
from shockwave.registration import KINDS
from shockwave.registry.isolation import Isolated

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

__all__ = ["DISABLE", "EVERY", "Plugin", "checked", "plugins", "same_distribution", "twice"]

#: The variable that names, with commas between them, distributions not to be used.
DISABLE = "SHOCKWAVE_DISABLE_PLUGINS"
#: Its value that means all of them.
EVERY = "*"
_GROUP = "shockwave"
_REQUIREMENT = re.compile(r"granular[-_.]+shockwave\s*(?:\[[^]]*\]\s*)?\(?[<>=!~]", re.IGNORECASE)


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
def plugins(anew: bool = False) -> tuple[Plugin, ...]:
    """Every installed plugin; its hooks are read in a process of their own, and nothing of it is imported here.

    ``anew``, even if they were read before.
    """
    disabled = {_plain(name.strip()) for name in os.environ.get(DISABLE, "").split(",") if name.strip()}
    points, unreadable = _points()
    read = [not disabled & {EVERY, _plain(_name(point))} if disabled else True for point in points]
    reading = Isolated([("read", point.module) for point, wanted in zip(points, read, strict=True) if wanted], anew)
    try:
        # While the other process reads the hooks, this one reads the metadata.
        found = [_described(point) for point in points]
        answers = iter(reading.answers())
    finally:
        reading.stop()
    for index, wanted in enumerate(read):
        if wanted:
            found[index] = _with_entries(found[index], next(answers), points[index])
    return _without_clashes([*found, *unreadable])


def _points() -> tuple[list[EntryPoint], list[Plugin]]:
    """The entry points of all distributions, and the distributions whose entry points cannot be read."""
    from importlib import metadata

    faulty: list[Plugin] = []
    try:
        points = list(metadata.entry_points(group=_GROUP))
    except Exception:  # of one distribution: the others are well
        points = []
        for distribution in metadata.distributions():
            try:
                points += distribution.entry_points.select(group=_GROUP)
            except Exception as error:
                name = getattr(distribution, "_path", None)
                problem = f"its entry points cannot be read ({type(error).__name__}: {error})"
                faulty.append(Plugin(str(getattr(name, "name", "unknown")), "", (), problem))
    return sorted(points, key=lambda point: (point.name, point.value)), faulty


def _with_entries(plugin: Plugin, answer: dict[str, Any], point: EntryPoint) -> Plugin:
    entries = [(kind, Entry(*entry)) for kind, *entry in answer.get("entries", ())]
    problem = plugin.problem or answer.get("problem", "")
    if point.attr:
        problem = problem or f"the entry point {point.name!r} must name a module (got {point.value})"
    owned = tuple((kind, entry._replace(distribution=plugin.distribution)) for kind, entry in entries)
    return evolve(plugin, entries=() if problem else owned, problem=problem, disabled=False)


def _name(point: EntryPoint) -> str:
    return (point.dist.name if point.dist else None) or point.name


def _described(point: EntryPoint) -> Plugin:
    """What the metadata of its distribution tell; ``disabled`` as long as it is not read."""
    try:
        text = (point.dist.read_text("METADATA") or point.dist.read_text("PKG-INFO") or "") if point.dist else ""
    except (OSError, ValueError) as error:
        return Plugin(point.name, "", (), f"its metadata cannot be read ({error})", disabled=True)
    fields: dict[str, list[str]] = {}
    # Only the head is read: a parser of messages takes longer for many plugins than all else together.
    for line in text.partition("\n\n")[0].splitlines():
        name, _, value = line.partition(":")
        fields.setdefault(name.lower(), []).append(value.strip())
    (name, *_), (version, *_) = fields.get("name", [point.name]), fields.get("version", [""])
    return Plugin(name, version, (), _unmet(fields.get("requires-dist", ())), disabled=True)


def _unmet(requirements: Iterable[str]) -> str:
    """What is wrong, if the plugin asks for another version of shockwave."""
    for text in requirements:
        if _REQUIREMENT.match(text) is None:
            continue
        from packaging.requirements import InvalidRequirement, Requirement

        try:
            needed = Requirement(text)
        except InvalidRequirement:
            continue  # not ours to judge
        applies = needed.marker is None or needed.marker.evaluate({"extra": ""})
        if applies and not needed.specifier.contains(shockwave.__version__, prereleases=True):
            this = f"this is {shockwave.__version__}; install a version that fits"
            return f"needs {shockwave.OWN_DISTRIBUTION} {needed.specifier} ({this})"
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
                problems.append(f"{KINDS[kind]} {entry.name!r} is a name of shockwave itself: choose another")
            elif claims[kind, entry.name] > 1:
                problems.append(twice(kind, entry.name, _owners(plugins, kind, entry.name)))
        kept = tuple((kind, entry) for kind, entry in plugin.entries if (kind, entry.name) not in own)
        problem = "; ".join([*filter(None, [plugin.problem]), *dict.fromkeys(problems)])
        plugins[index] = evolve(plugin, entries=kept, problem=problem)
    return tuple(plugins)


def twice(kind: str, name: str, distributions: Iterable[str]) -> str:
    """What is wrong with a name that several ``distributions`` claim, or one of them twice."""
    owners = " and ".join(dict.fromkeys(distributions))
    return f"{KINDS[kind]} {name!r} is registered twice, by {owners}: uninstall one, or give it another name there"


def _owners(plugins: Iterable[Plugin], kind: str, name: str) -> list[str]:
    return [plugin.distribution for plugin in plugins for claimed in plugin.entries if _is(claimed, kind, name)]


def _is(claimed: tuple[str, Entry], kind: str, name: str) -> bool:
    return claimed[0] == kind and claimed[1].name == name


def checked(plugin: Plugin, anew: bool = True) -> Plugin:
    """``plugin``, each of whose nouns was imported in a process of its own, to tell those that cannot be.

    ``anew``, even those that could be before.
    """
    answers = Isolated([("load", kind, entry.address, entry.takes) for kind, entry in plugin.entries], anew).answers()
    problems = [
        f"{KINDS[kind]} {entry.name!r}: {entry.address}: {answer['problem']}"
        for (kind, entry), answer in zip(plugin.entries, answers, strict=True)
        if "problem" in answer
    ]
    return evolve(plugin, problem="; ".join([*filter(None, [plugin.problem]), *problems]))
