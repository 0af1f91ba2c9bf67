"""Registry of profiles, integrators, quadratures, materials, contact laws and commands, built in or from plugins.

A registry holds addresses (``package.module:attribute``): listing names imports nothing, and a scene imports only the
objects that it names. Addresses are imported in this module only.

A plugin is a distribution with an entry point in the group ``shockwave``. Its module of hooks is imported here, in the
same process; an exception that it raises affects this plugin only.
"""

from __future__ import annotations

import importlib
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from functools import cache
from itertools import chain
from operator import itemgetter
from typing import Any

from attrs import evolve, frozen

from shockwave import OWN_DISTRIBUTION
from shockwave.base.errors import MOST_NAMES, PluginError, ShockwaveError, UnknownNameError, nearest
from shockwave.registry import built_ins
from shockwave.registry.built_ins import Entry

#: Kind of an entry -> its name in messages.
KINDS = {f"{name}s": name for name in ("profile", "integrator", "quadrature", "material", "contact", "command")}
#: Environment variable with the distributions to ignore, separated by commas.
DISABLE = "SHOCKWAVE_DISABLE_PLUGINS"
#: Value of this variable that stands for all distributions.
EVERY = "*"
#: Exceptions from a plugin's code, which may even exit the interpreter; only the user's interrupt passes.
PLUGIN_FAULTS = (Exception, SystemExit)
#: Kind -> base class of the objects registered under it.
_BASES = {
    "profiles": "shockwave.profiles.shock_profile:ShockProfile",
    "integrators": "shockwave.engine.integrator:Integrator",
    "quadratures": "shockwave.profiles.quadrature.base:Quadrature",
    "contacts": "shockwave.scene.contact_law:ContactLaw",
}


@frozen
class Plugin:
    """Entry point of an installed distribution, with its problem if it has one.

    Attributes
    ----------
    distribution, version : str
        Name and version in the metadata.
    module : str
        Its module of hooks.
    entries : tuple of (str, Entry)
        Kind and entry of everything that it registers; empty if it cannot be read.
    problem : str
        Description of the problem, or an empty string.
    disabled : bool
        Whether SHOCKWAVE_DISABLE_PLUGINS excludes it; it is then not read.
    """

    distribution: str
    version: str
    module: str
    entries: tuple[tuple[str, Entry], ...] = ()
    problem: str = ""
    disabled: bool = False


# ---------------------------------------------------------------- names


def find(kind: str, name: str) -> Entry:
    """Entry of ``name``, regardless of case; plugins are searched only if no built-in entry has the name.

    Raises
    ------
    UnknownNameError
        When the name is unknown; the message gives the known names and the nearest one.
    PluginError
        When two plugins register it, or when it is unknown but may belong to a plugin that cannot be read.
    """
    built_in = _built_in_entries(kind).get(name) or _built_in_entries(kind).get(str(name).lower())
    if built_in is not None:
        return built_in
    owners = [entry for entry in _plugin_entries(kind) if entry.name == name]
    owners = owners or [entry for entry in _plugin_entries(kind) if entry.name.lower() == str(name).lower()]
    if not owners:
        raise _unknown_name(kind, name)
    if len(owners) > 1:
        homes = " and ".join(entry.distribution for entry in owners)
        problem = f"{KINDS[kind]} {name!r} is registered twice, by {homes}"
        raise PluginError(f"{problem} (uninstall one of them or rename the entry)")
    return owners[0]


def _unknown_name(kind: str, name: str) -> ShockwaveError:
    names = [entry.name for entry in entries(kind)]
    likely = "-".join(built_ins.SYNONYMS.get(word, word) for word in str(name).lower().split("-"))
    faulty = [f"plugin {plugin.distribution} is faulty: {plugin.problem}" for plugin in plugins() if plugin.problem]
    if faulty and not nearest(likely, names):
        return PluginError(f"unknown {KINDS[kind]} (got {name!r}; {'; '.join(faulty)})")
    disabled = ", ".join(plugin.distribution for plugin in plugins() if plugin.disabled)
    hints = [f"`shockwave list {kind}` shows all"] if len(names) > MOST_NAMES else []
    others = "others by values such as youngs_modulus" if kind == "materials" else "others need a plugin"
    hints += [] if nearest(likely, names) else [others]
    hints += [f"disabled plugins: {disabled}"] if disabled else []
    return UnknownNameError.of(KINDS[kind], name, names, "; ".join(hints), likely)


@cache
def load(kind: str, name: str) -> Any:
    """Object registered as ``name``; its module is imported here.

    Raises
    ------
    UnknownNameError
        When the name is unknown.
    PluginError
        When a plugin's module cannot be imported or does not contain the registered object.
    """
    entry = find(kind, name)
    if entry.distribution == OWN_DISTRIBUTION:
        return _import_object(entry.address)
    try:
        return load_entry(kind, entry)
    except PLUGIN_FAULTS as error:
        problem = describe(error, kind, entry)
        raise PluginError(f"plugin {entry.distribution} is faulty: {problem}") from error


def entries(kind: str) -> list[Entry]:
    """All entries of ``kind``, built-in ones first; nothing of it is imported."""
    return [*_built_in_entries(kind).values(), *sorted(_plugin_entries(kind))]


def entry_of(kind: str, noun: Any) -> Entry | None:
    """Entry of a class or function, if it is registered."""
    for entry in entries(kind):
        module, _, attribute = entry.address.partition(":")
        if getattr(sys.modules.get(module), attribute, None) is noun:
            return entry
    return None


@cache
def _built_in_entries(kind: str) -> dict[str, Entry]:
    return {entry.name: entry._replace(distribution=OWN_DISTRIBUTION) for entry in built_ins.ENTRIES[kind]}


def _plugin_entries(kind: str) -> list[Entry]:
    return [entry for plugin in plugins() for of_kind, entry in plugin.entries if of_kind == kind]


def forget() -> None:
    """Search for plugins again, after installed or disabled distributions have changed."""
    plugins.cache_clear()
    load.cache_clear()


# ---------------------------------------------------------------- plugins


@cache
def plugins() -> tuple[Plugin, ...]:
    """All installed plugins; only their modules of hooks are imported."""
    return tuple(map(read, installed_plugins()))


def installed_plugins() -> list[Plugin]:
    """All plugins as described by their metadata, sorted by name; of two copies on the path, the first."""
    from importlib.metadata import Distribution, entry_points

    named_points: list[tuple[str, Distribution, str]] = []
    for point in entry_points(group="shockwave"):
        if point.dist is not None:
            named_points.append((_canonical(point.dist.name), point.dist, point.value))
    disabled = set(map(_canonical, os.environ.get(DISABLE, "").split(",")))
    return [
        Plugin(of_point.name, of_point.version, module, disabled=not disabled.isdisjoint((EVERY, name)))
        for name, of_point, module in sorted(named_points, key=itemgetter(0))
    ]


def _canonical(distribution: str) -> str:
    """Name of a distribution, in which case and the choice among - _ . do not matter."""
    return re.sub(r"[-_.]+", "-", distribution.strip()).lower()


def read(plugin: Plugin) -> Plugin:
    """``plugin`` with the entries of its module of hooks, or with its problem."""
    if plugin.disabled:
        return plugin
    try:
        with redirect_stdout(sys.stderr):
            return evolve(plugin, entries=tuple(_entries_of(plugin)))
    except PLUGIN_FAULTS as error:
        return evolve(plugin, problem=describe(error))


def check_plugin(plugin: Plugin) -> Plugin:
    """``plugin`` with the problems of everything that it registers, which is imported."""
    problems = [plugin.problem] if plugin.problem else []
    for kind, entry in plugin.entries:
        try:
            load_entry(kind, entry)
        except PLUGIN_FAULTS as error:
            problems.append(describe(error, kind, entry))
    return evolve(plugin, problem="; ".join(problems))


def _entries_of(plugin: Plugin) -> list[tuple[str, Entry]]:
    """Kind and entry of everything that ``plugin`` registers; pluggy checks names and arguments of the hooks."""
    import pluggy

    from shockwave.registry import hook_specifications

    manager = pluggy.PluginManager("shockwave")
    manager.add_hookspecs(hook_specifications)
    manager.register(importlib.import_module(plugin.module))
    manager.check_pending()
    claims = []
    for kind in KINDS:
        hook = f"shockwave_{kind}"
        for entry in chain.from_iterable(getattr(manager.hook, hook)()):
            if not (isinstance(entry, Entry) and all(isinstance(text, str) for text in entry)):
                raise TypeError(f"{hook} must return a list of entries with text in all fields (got {entry!r:.80})")
            if entry.name.lower() in _built_in_entries(kind):
                remedy = f"uninstall {plugin.distribution}, or install a version without this name"
                raise ValueError(f"{KINDS[kind]} {entry.name!r} is a built-in name ({remedy})")
            claims.append((kind, entry._replace(distribution=plugin.distribution)))
    if not claims:
        raise ValueError("registers nothing (is @hookimpl missing, or does a hook return nothing?)")
    return claims


def describe(error: BaseException, kind: str = "", entry: Entry | None = None) -> str:
    """Error of a plugin in one line, with the entry that it concerns."""
    place = f"{KINDS[kind]} {entry.name!r}: {entry.address}: " if entry else ""
    return f"{place}{type(error).__name__}: {' '.join(str(error).split())}"


# ---------------------------------------------------------------- objects at addresses


def _import_object(address: str) -> Any:
    module, _, attribute = address.partition(":")
    return getattr(importlib.import_module(module), attribute)


def load_entry(kind: str, entry: Entry) -> Any:
    """Object that a plugin registers, checked against the rules of its kind.

    Raises
    ------
    TypeError
        When it breaks a rule. Other exceptions come from the module itself.
    """
    with redirect_stdout(sys.stderr):
        noun = _import_object(entry.address)
    if rule := _broken_rule(kind, entry, noun):
        raise TypeError(f"{rule} (got {noun!r:.80})")
    return noun


def _broken_rule(kind: str, entry: Entry, noun: Any) -> str:
    if kind == "materials":
        return "" if isinstance(noun, _import_object("shockwave.scene.material:Material")) else "must be a Material"
    if kind == "commands":
        return "" if callable(noun) else "must be a function of a list of arguments"
    base = _import_object(_BASES[kind])
    if not (isinstance(noun, type) and issubclass(noun, base)):
        return f"must be a subclass of {base.__name__}"
    if missing := sorted(getattr(noun, "__abstractmethods__", ())):
        return f"must also define {' and '.join(missing)}"
    if kind == "integrators":
        setting = "rtol" if getattr(noun, "adaptive", False) else "step"
        if entry.takes != setting:
            return f"must be registered with takes={setting!r}"
    return UNDECORATED if lacks_decorator(noun) else ""


#: Rule violated by a class for which `lacks_decorator` is true.
UNDECORATED = "must be decorated with attrs.frozen, because it declares fields"


def lacks_decorator(cls: type) -> bool:
    """Whether a class declares fields of attrs without the decorator that generates its constructor."""
    return any(type(value).__name__ == "_CountingAttr" for value in vars(cls).values())


# ---------------------------------------------------------------- errors of plugins in use


@contextmanager
def blame(kind: str, noun: Any) -> Iterator[None]:
    """Turn unexpected exceptions from a plugin's code into a `PluginError` that names the plugin."""
    try:
        yield
    except ShockwaveError:
        raise
    except PLUGIN_FAULTS as error:
        if noun.__module__.startswith("shockwave."):
            raise
        got = f"got {describe(error):.200}"
        raise PluginError(f"{KINDS[kind]} {owner_of(kind, noun)}: must not raise ({got})") from error


def owner_of(kind: str, noun: Any) -> str:
    """Name and distribution of a registered class or function, or its address if it is not registered."""
    entry = entry_of(kind, noun)
    return f"{entry.name!r} of {entry.distribution}" if entry else f"{noun.__module__}:{noun.__qualname__}"
