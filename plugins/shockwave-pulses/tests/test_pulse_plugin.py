"""The distribution as shockwave sees it: found once installed, imported only when named."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib.metadata import distribution
from pathlib import Path
from typing import Any

import pytest
from shockwave.registry.registry import entries, load, plugins

CLASSES = {
    "half-sine": "HalfSine",
    "haversine": "Haversine",
    "trapezoid": "Trapezoid",
    "initial-peak-sawtooth": "InitialPeakSawtooth",
    "final-peak-sawtooth": "FinalPeakSawtooth",
    "rectangular": "Rectangular",
    "hertz-impact": "HertzImpact",
}
NAMES = list(CLASSES)

# Runs a script against the given site directory in place of the interpreter's own.
IN_SITE = "import site, sys; site.addsitedir(sys.argv.pop(1)); exec(sys.argv.pop(1))"
LIST = "from shockwave.cli import main; sys.exit(main(['list', 'profiles', '--json']))"


def _output(*arguments: str, cwd: Path) -> str:
    command = [sys.executable, "-W", "error", *arguments]
    return subprocess.run(command, cwd=cwd, check=True, capture_output=True, text=True, timeout=60).stdout


def _site(place: Path, *, plugin: bool) -> Path:
    """A site directory with all that is installed beside the plugin, and the plugin itself or not."""
    place.mkdir()
    for item in Path(str(distribution("shockwave-pulses").locate_file(""))).iterdir():
        if plugin or "shockwave_pulses" not in item.name:
            os.symlink(item, place / item.name)
    return place


def _listed(site: Path, cwd: Path) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = json.loads(_output("-I", "-S", "-c", IN_SITE, str(site), LIST, cwd=cwd))
    return rows


def test_profiles_are_listed_by_name(tmp_path: Path) -> None:
    text = _output("-m", "shockwave", "list", "profiles", cwd=tmp_path)
    rows = [line.split() for line in text.splitlines() if line.strip()]
    listed = {row[0]: row[-1] for row in rows}
    assert {name: listed.get(name) for name in NAMES} == dict.fromkeys(NAMES, "shockwave-pulses")


def test_the_distribution_is_listed_without_a_problem(tmp_path: Path) -> None:
    rows = json.loads(_output("-m", "shockwave", "list", "plugins", "--json", cwd=tmp_path))
    own = [row for row in rows if row["name"] == "shockwave-pulses"]
    assert [row["problem"] for row in own] == [None]
    assert own[0]["summary"] == ", ".join(NAMES)


def test_profiles_are_listed_only_after_install(tmp_path: Path) -> None:
    with_plugin = _listed(_site(tmp_path / "with", plugin=True), tmp_path)
    without = _listed(_site(tmp_path / "without", plugin=False), tmp_path)
    added = [row for row in with_plugin if row not in without]
    assert [row for row in without if row not in with_plugin] == []
    assert [(row["name"], row["distribution"]) for row in added] == [
        (name, "shockwave-pulses") for name in sorted(NAMES)
    ]


def test_listing_imports_no_profile_and_no_numpy(tmp_path: Path) -> None:
    script = (
        "import sys; from shockwave.registry.registry import entries;"
        " print(*[entry.name for entry in entries('profiles')]);"
        " print(*sorted(name for name in sys.modules if name.startswith(('numpy.', 'shockwave_pulses.'))))"
    )
    listed, imported = _output("-c", script, cwd=tmp_path).splitlines()
    assert set(NAMES) <= set(listed.split())
    # The module of hooks is read here, or in a process of its own.
    assert imported in ("", "shockwave_pulses.hooks")


@pytest.mark.parametrize("name", NAMES)
def test_the_registry_loads_the_class_of_the_name(name: str) -> None:
    kind = load("profiles", name)
    assert (kind.__name__, kind.__module__) == (
        CLASSES[name],
        f"shockwave_pulses.{name.replace('-', '_')}",
    )


@pytest.mark.parametrize("name", NAMES)
def test_no_parameter_need_be_given(name: str) -> None:
    assert load("profiles", name)().duration_ratio > 1


def test_nothing_but_the_pulses_is_registered() -> None:
    own = [plugin for plugin in plugins() if plugin.distribution == "shockwave-pulses"]
    assert [[(kind, entry.name) for kind, entry in plugin.entries] for plugin in own] == [
        [("profiles", name) for name in NAMES]
    ]


def test_no_name_is_taken_from_another() -> None:
    names = [entry.name for entry in entries("profiles")]
    assert sorted(names) == sorted(set(names))
