"""The registry: built-ins found without plugins, plugins found as installed, faults contained and named."""

from __future__ import annotations

import importlib
import importlib.metadata
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from distributions import PLUGINS
from shockwave import registry
from shockwave.errors import PluginError, UnknownNameError
from shockwave.hooks import Entry
from shockwave.registry.nouns import registered
from shockwave.registry.samples import SAMPLES

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
    def scanned(**_: str) -> None:
        raise AssertionError("entry points were scanned")

    monkeypatch.setattr(importlib.metadata, "distributions", scanned)
    registry.forget()
    assert registry.find(kind, BUILT_IN[kind]).name == BUILT_IN[kind]


@EVERY_KIND
def test_every_built_in_can_be_loaded(kind: str) -> None:
    own = [entry for entry in registry.entries(kind) if entry.distribution == "granular-shockwave"]
    assert all(registry.load(kind, entry.name) is not None for entry in own)


@EVERY_KIND
def test_names_of_a_kind_are_distinct(kind: str) -> None:
    names = [entry.name for entry in registry.entries(kind)]
    assert len(set(names)) == len(names)


@EVERY_KIND
def test_every_entry_says_what_it_is(kind: str) -> None:
    assert all(entry.summary for entry in registry.entries(kind))


def test_every_kind_has_a_word() -> None:
    assert set(registry.KINDS) == set(BUILT_IN)


def test_finding_a_name_imports_nothing_that_it_names() -> None:
    code = (
        "import sys; from shockwave.registry import find; find('profiles', 'tabulated');"
        "sys.exit(any(m in sys.modules for m in ('numpy', 'scipy', 'shockwave.profiles.tabulated')))"
    )
    # In a fresh interpreter, from the directory of the package under test.
    place = Path(registry.__file__).parents[1]
    assert subprocess.run([sys.executable, "-c", code], cwd=place, check=False).returncode == 0


@EVERY_KIND
def test_an_unknown_name_is_answered_with_the_known_and_the_nearest(kind: str) -> None:
    near = BUILT_IN[kind] + "x"
    with pytest.raises(UnknownNameError) as caught:
        registry.find(kind, near)
    message = str(caught.value)
    assert message.startswith(f"unknown {registry.KINDS[kind]} (got {near!r}; did you mean {BUILT_IN[kind]!r}? known: ")
    assert all(entry.name in message for entry in registry.entries(kind))


def test_a_name_like_no_other_has_no_nearest() -> None:
    with pytest.raises(UnknownNameError) as caught:
        registry.find("profiles", "@@@")
    assert "did you mean" not in str(caught.value)


def test_an_unknown_name_carries_what_is_known() -> None:
    with pytest.raises(UnknownNameError) as caught:
        registry.load("models", "nonesuch")
    assert (caught.value.kind, caught.value.name) == ("model", "nonesuch")
    assert "section-4" in caught.value.known


def test_an_entry_is_frozen() -> None:
    with pytest.raises(AttributeError):
        registry.find("profiles", "tabulated").address = "elsewhere:Thing"  # type: ignore[misc]


# ---------------------------------------------------------------- plugins


def test_a_plugin_is_found_as_installed(install: Install) -> None:
    module = install("test-pulses", name="test-pulse")
    entry = registry.find("profiles", "test-pulse")
    assert entry == Entry("test-pulse", f"{module}_pulse:Pulse", "a pulse", distribution="test-pulses")


def test_a_plugin_tells_its_version(install: Install) -> None:
    install("test-pulses", version="3.4.5")
    assert (_plugin("test-pulses").version, _plugin("test-pulses").problem) == ("3.4.5", "")


def test_what_a_plugin_registers_can_be_loaded(install: Install) -> None:
    module = install("test-pulses", name="test-pulse")
    assert registry.load("profiles", "test-pulse") is sys.modules[f"{module}_pulse"].Pulse


def test_the_module_of_hooks_alone_is_imported_before_a_noun_is_loaded(install: Install) -> None:
    module = install("test-pulses", name="test-pulse")
    registry.find("profiles", "test-pulse")
    assert {module, f"{module}_pulse"} & set(sys.modules) == {module}


def test_plugins_are_listed_after_built_ins_by_name(install: Install) -> None:
    install("test-a", name="z-pulse")
    install("test-b", name="a-pulse")
    names = [entry.name for entry in registry.entries("profiles")]
    assert names.index("tabulated") < names.index("a-pulse") < names.index("z-pulse")


def test_plugins_are_looked_for_once(install: Install, monkeypatch: pytest.MonkeyPatch) -> None:
    install("test-pulses")
    found = registry.plugins()
    monkeypatch.setattr(importlib.metadata, "distributions", lambda: pytest.fail("looked for again"))
    assert registry.plugins() is found


def test_two_plugins_with_one_name_are_both_named(install: Install) -> None:
    install("test-first", name="same-pulse")
    install("test-second", name="same-pulse")
    with pytest.raises(PluginError, match=r"'same-pulse' is registered twice, by test-first and test-second"):
        registry.find("profiles", "same-pulse")


def test_a_clash_leaves_other_names_alone(install: Install) -> None:
    install("test-first", name="same-pulse")
    install("test-second", name="same-pulse")
    assert registry.find("profiles", "triangular").distribution == "granular-shockwave"


def test_a_plugin_cannot_take_the_name_of_a_built_in(install: Install) -> None:
    install("test-usurper", name="triangular")
    assert registry.load("profiles", "triangular").__module__ == "shockwave.profiles.triangular"
    assert "triangular" in _plugin("test-usurper").problem


def test_names_of_the_sample_plugins_are_known(monkeypatch: pytest.MonkeyPatch) -> None:
    found = {}
    for file in sorted(PLUGINS.glob("*/src/*/hooks.py")):
        monkeypatch.syspath_prepend(file.parents[1])
        entries = registered(importlib.import_module(f"{file.parent.name}.hooks"))
        found |= {(kind, entry.name): file.parents[2].name for kind, entry in entries}
    assert found == SAMPLES


def test_an_unknown_name_that_a_sample_has_tells_which(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.metadata, "distributions", lambda: ())
    registry.forget()
    with pytest.raises(
        UnknownNameError,
        match=r"comes with the sample plugin shockwave-blast: `pip install \./plugins/shockwave-blast`",
    ):
        registry.find("profiles", "friedlander")
    registry.forget()


def test_what_cannot_be_loaded_is_the_plugin_s_fault(install: Install) -> None:
    module = install("test-pulses", name="test-pulse", pulse="raise RuntimeError('out of order')")
    with pytest.raises(PluginError) as caught:
        registry.load("profiles", "test-pulse")
    at_fault = f"plugin test-pulses 1.2 is at fault: profile 'test-pulse': {module}_pulse:Pulse: "
    assert str(caught.value) == f"{at_fault}RuntimeError: out of order"
    assert caught.value.exit_code == 4
