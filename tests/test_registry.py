"""The registry: built-ins found without plugins, plugins found as installed, unknown names answered with hints."""

from __future__ import annotations

import importlib.metadata
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from distributions import PLUGINS
from shockwave import registry
from shockwave.errors import PluginError, UnknownNameError
from shockwave.hooks import Entry
from test_architecture import loaded

BUILT_IN = {
    "profiles": "power-law",
    "integrators": "dop853",
    "quadratures": "gauss-legendre",
    "materials": "paper-steel",
    "models": "section-4",
}

if TYPE_CHECKING:
    from conftest import Install

EVERY_KIND = pytest.mark.parametrize("kind", BUILT_IN)


def _plugin(distribution: str) -> registry.Plugin:
    (found,) = [plugin for plugin in registry.plugins() if plugin.distribution == distribution]
    return found


# ---------------------------------------------------------------- built-ins


@EVERY_KIND
def test_a_built_in_is_found_without_looking_for_plugins(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.metadata, "distributions", lambda **_: pytest.fail("plugins were looked for"))
    registry.forget()
    assert registry.find(kind, BUILT_IN[kind]).name == BUILT_IN[kind]


@EVERY_KIND
def test_every_built_in_has_a_summary_and_can_be_loaded(kind: str) -> None:
    for entry in registry.own_entries(kind):
        assert entry.summary
        assert registry.load(kind, entry.name) is not None


def test_finding_a_name_imports_nothing_that_it_names() -> None:
    modules = loaded("from shockwave.registry import find; find('profiles', 'tabulated')")
    assert {"numpy", "scipy", "shockwave.profiles.tabulated"} & modules == set()


@EVERY_KIND
def test_an_unknown_name_is_answered_with_the_known_and_the_nearest(kind: str) -> None:
    near = BUILT_IN[kind] + "x"
    with pytest.raises(UnknownNameError) as caught:
        registry.find(kind, near)
    message = str(caught.value)
    assert message.startswith(f"unknown {registry.KINDS[kind]} (got {near!r}; did you mean {BUILT_IN[kind]!r}? known: ")
    assert all(entry.name in message for entry in registry.entries(kind))


# ---------------------------------------------------------------- plugins


def test_a_plugin_is_found_as_installed(install: Install) -> None:
    module = install("test-pulses", name="test-pulse", version="3.4.5")
    entry = registry.find("profiles", "test-pulse")
    assert entry == Entry("test-pulse", f"{module}_pulse:Pulse", "a pulse", distribution="test-pulses")
    assert (_plugin("test-pulses").version, _plugin("test-pulses").problem) == ("3.4.5", "")
    # the module of hooks alone is imported before the name is used
    assert {module, f"{module}_pulse"} & set(sys.modules) == {module}
    assert registry.load("profiles", "test-pulse") is sys.modules[f"{module}_pulse"].Pulse


def test_plugins_are_listed_after_built_ins_by_name(install: Install) -> None:
    install("test-a", name="z-pulse")
    install("test-b", name="a-pulse")
    names = [entry.name for entry in registry.entries("profiles")]
    assert names.index("tabulated") < names.index("a-pulse") < names.index("z-pulse")


#: File of the metadata, its content, and what is reported of it.
METADATA = {
    "names no module": ("entry_points.txt", b"[shockwave]\na = a_pulses:hook\n", "No module named 'a_pulses:hook'"),
    "no entry points": ("entry_points.txt", b"[shockwave]\nno equals sign\n", "its metadata cannot be read: "),
    "no text": ("entry_points.txt", b"[shockwave]\n\xff = a\n", "its metadata cannot be read: UnicodeDecodeError"),
    "no name": ("METADATA", b"Version: 1\n", "its metadata cannot be read: "),
    "no requirement": ("METADATA", b"Name: a\nVersion: 1\nRequires-Dist: >> 1\n", "its metadata cannot be read: "),
}


@pytest.mark.parametrize("fault", METADATA)
def test_broken_metadata_are_a_fault_of_their_distribution_alone(install: Install, site: Path, fault: str) -> None:
    install("a-pulses")
    install("other", name="other-pulse")
    file, content, problem = METADATA[fault]
    (site / "a_pulses-1.2.dist-info" / file).write_bytes(content)
    registry.forget()
    with pytest.raises(UnknownNameError, match=r"plugins that cannot be read: a[-_]pulses") as caught:
        registry.find("profiles", "foreign-thing")
    assert problem in str(caught.value)
    assert caught.value.exit_code == PluginError.exit_code
    assert registry.find("profiles", "other-pulse").distribution == "other"


def test_a_plugin_cannot_take_the_name_of_a_built_in(install: Install) -> None:
    install("test-usurper", name="triangular")
    assert registry.load("profiles", "triangular").__module__ == "shockwave.profiles.triangular"
    assert "triangular" in _plugin("test-usurper").problem


def test_names_of_the_sample_plugins_are_known(monkeypatch: pytest.MonkeyPatch) -> None:
    found = set()
    for file in sorted(PLUGINS.glob("*/src/*/hooks.py")):
        monkeypatch.syspath_prepend(file.parents[1])
        entries = registry.registered(f"{file.parent.name}.hooks")
        found |= {(file.parents[2].name, kind, entry.name) for kind, entry in entries}
    listed = registry.SAMPLES.items()
    assert found == {(home, kind, name) for home, (kind, names) in listed for name in names}


def test_the_error_for_a_name_of_a_sample_plugin_names_the_plugin(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.metadata, "distributions", lambda: ())
    registry.forget()
    hint = r"comes with the sample plugin shockwave-blast: `pip install \./plugins/shockwave-blast`"
    with pytest.raises(UnknownNameError, match=hint):
        registry.find("profiles", "friedlander")
    registry.forget()
