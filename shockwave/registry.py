"""Names and where they live: profiles, integrators, quadratures, materials and models, built in or from plugins.

A registry holds addresses (``package.module:attribute``), so listing names imports nothing and a scene imports what it
names. Built-ins and plugins come through the same hooks. Such an address is imported from this module only.

A plugin is a distribution with an entry point in the group ``shockwave``. Its module of hooks is imported here, in this
process; whatever it raises is a problem of that plugin alone.
"""

from __future__ import annotations

import importlib
import os
import re
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, redirect_stdout
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import pluggy
from attrs import evolve, frozen

from shockwave import OWN_DISTRIBUTION, __version__, built_ins, hooks
from shockwave.errors import PluginError, ShockwaveError, UnknownNameError
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

Claims = tuple[tuple[str, Entry], ...]


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
    entries: Claims = ()
    problem: str = ""
    disabled: bool = False


def same_distribution(one: str, other: str) -> bool:
    """Whether two names are those of one distribution: case, and which of - _ . is used, make no difference."""
    return _plain(one) == _plain(other)


def _plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name.strip()).lower()


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
        raise PluginError(_twice(kind, name, (entry.distribution for entry in owners)))
    return owners[0]


def _unknown(kind: str, name: str) -> UnknownNameError:
    disabled = [plugin.distribution for plugin in plugins() if plugin.disabled]
    unread = [plugin for plugin in plugins() if plugin.problem and not plugin.entries]
    faulty = [f"{plugin.distribution} ({plugin.problem})" for plugin in unread]
    hints = []
    for home, (of_kind, names) in SAMPLES.items():
        if kind == of_kind and name in names and home not in disabled:
            hints.append(f"it comes with the sample plugin {home}: `pip install ./plugins/{home}` in the source tree")
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
    if entry.distribution == OWN_DISTRIBUTION:
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
    return own_entries(kind) + sorted(_plugin_entries(kind))


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


# ---------------------------------------------------------------- what is installed


@cache
def plugins() -> tuple[Plugin, ...]:
    """Every installed plugin; only the modules of hooks are imported."""
    return without_clashes(map(_read, installed()))


def _read(plugin: Plugin) -> Plugin:
    if not plugin.module:
        return plugin
    try:
        return evolve(plugin, entries=registered(plugin.module))
    except PLUGIN_FAULTS as error:
        return evolve(plugin, problem=described(error))


def installed() -> list[Plugin]:
    """Every plugin as its metadata describe it, by name; of two copies on the path, the first."""
    from importlib.metadata import distributions

    disabled = {_plain(name) for name in os.environ.get(DISABLE, "").split(",")}
    found: dict[tuple[str, str], Plugin] = {}
    for distribution in distributions():
        for plugin in _plugins_of(distribution):
            name = _plain(plugin.distribution)
            if disabled & {EVERY, name}:
                plugin = Plugin(plugin.distribution, plugin.version, disabled=True)
            found.setdefault((name, plugin.module), plugin)
    return [found[key] for key in sorted(found)]


def _plugins_of(distribution: Distribution) -> list[Plugin]:
    """A plugin for each entry point in the group; one that is at fault where the metadata cannot be read."""
    try:
        points = distribution.entry_points.select(group="shockwave")
        if not points:
            return []
        unmet = _unmet(distribution)
        name, version = distribution.metadata["Name"], distribution.version
        if not name:
            raise ValueError("METADATA gives no name")
        return [Plugin(name, version, "" if unmet else point.value, problem=unmet) for point in points]
    except Exception as error:
        folder = Path(str(getattr(distribution, "_path", distribution)))
        name = folder.stem.partition("-")[0]
        return [Plugin(name, "", problem=f"its metadata cannot be read: {described(error)}")]


def _unmet(distribution: Distribution) -> str:
    """What is wrong, if the plugin asks for another version of shockwave."""
    from packaging.requirements import Requirement

    for needed in map(Requirement, distribution.requires or ()):
        ours = same_distribution(needed.name, OWN_DISTRIBUTION)
        applies = needed.marker is None or needed.marker.evaluate({"extra": ""})
        if ours and applies and not needed.specifier.contains(__version__, prereleases=True):
            return f"needs {needed.name} {needed.specifier} (this is {__version__}; install a version that fits)"
    return ""


def without_clashes(found: Iterable[Plugin]) -> tuple[Plugin, ...]:
    """The plugins, each with a problem where it claims a name of another.

    A name of shockwave's own is refused; one that two plugins claim stays with both, for `find` to refuse.
    """
    listed = tuple(found)
    owners: dict[tuple[str, str], list[str]] = defaultdict(list)
    for plugin in listed:
        for kind, entry in plugin.entries:
            owners[kind, entry.name].append(plugin.distribution)
    return tuple(_without_clashes(plugin, owners) for plugin in listed)


def _without_clashes(plugin: Plugin, owners: dict[tuple[str, str], list[str]]) -> Plugin:
    problems = [plugin.problem] if plugin.problem else []
    kept = []
    for kind, entry in plugin.entries:
        if entry.name in built_in(kind):
            problems.append(f"{KINDS[kind]} {entry.name!r} is a name of shockwave itself: choose another")
            continue
        if len(owners[kind, entry.name]) > 1:
            problems.append(_twice(kind, entry.name, owners[kind, entry.name]))
        kept.append((kind, entry._replace(distribution=plugin.distribution)))
    return evolve(plugin, entries=tuple(kept), problem="; ".join(dict.fromkeys(problems)))


def _twice(kind: str, name: str, distributions: Iterable[str]) -> str:
    owners = " and ".join(dict.fromkeys(distributions))
    return f"{KINDS[kind]} {name!r} is registered twice, by {owners}: uninstall one, or give it another name there"


# ---------------------------------------------------------------- what a module of hooks registers


@cache
def built_in(kind: str) -> dict[str, Entry]:
    """Name -> entry, of what shockwave itself registers under ``kind``."""
    own: list[Entry] = getattr(built_ins, f"shockwave_{kind}")()
    return {entry.name: entry._replace(distribution=OWN_DISTRIBUTION) for entry in own}


def registered(module: str) -> Claims:
    """Kind and entry of everything that a plugin's module of hooks registers; its printed output goes to stderr.

    Raises
    ------
    TypeError, ValueError
        When a hook returns no list of entries, or when there is nothing.
    pluggy.PluginValidationError
        When a hook is unknown or takes arguments. Anything else comes from the module itself.
    """
    manager = pluggy.PluginManager("shockwave")
    manager.add_hookspecs(hooks)
    with redirect_stdout(sys.stderr):
        manager.register(importlib.import_module(module))
        manager.check_pending()
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
            if not re.fullmatch(r"\w+(\.\w+)*:\w+", entry.address) or not entry.name.strip():
                raise ValueError(f"{hook} must give names, and addresses package.module:Class (got {entry!r:.160})")
            yield entry


def described(error: BaseException) -> str:
    """Error of a plugin in one line, with the usual remedy, if any."""
    remedy = f" ({_PACKAGING})" if isinstance(error, ModuleNotFoundError) else ""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}{remedy}"[:_LONGEST]


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
    with redirect_stdout(sys.stderr):
        found = _at(entry.address)
    if rule := _rule_broken(kind, found):
        raise TypeError(f"{rule} (got {found!r:.80})")
    if kind == "integrators":
        right, wrong = ("rtol", "step") if found.adaptive else ("step", "rtol")
        takes = entry.takes.split()
        if right not in takes or wrong in takes:
            trait = "adaptive" if found.adaptive else "of fixed step"
            raise TypeError(f"is {trait}, so its entry must say takes={right!r} (got {entry.takes!r})")
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
    if missing:
        return f"must write {' and '.join(missing)} too"
    if kind != "profiles":
        return ""
    if any(type(value).__name__ == "_CountingAttr" for value in vars(found).values()):
        return "must be decorated with attrs.frozen, as it declares fields"
    # a class with a constructor of its own may set it there
    fields = {field.name for field in getattr(found, "__attrs_attrs__", ())}
    has_ratio = hasattr(found, "duration_ratio") or "duration_ratio" in fields
    own_constructor = "__init__" in vars(found) and not fields
    rule = "must have duration_ratio, n: a field for the user to give, or a property"
    return "" if has_ratio or own_constructor else rule
