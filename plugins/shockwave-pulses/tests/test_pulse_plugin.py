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
from shockwave import load_scenario

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
LIST = (
    "import runpy; sys.argv[1:] = ['list', 'profiles', '--json'];"
    " runpy.run_module('shockwave', run_name='__main__')"
)


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
    command = [sys.executable, "-X", "importtime", "-m", "shockwave", "list", "profiles"]
    done = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True, timeout=60)
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert "shockwave.cli" in imported
    assert {name for name in imported if name.startswith(("numpy.", "shockwave_pulses"))} <= {
        "shockwave_pulses",
        "shockwave_pulses.hooks",
    }


@pytest.mark.parametrize("name", NAMES)
def test_a_scenario_gets_the_class_of_the_name(name: str) -> None:
    profile = load_scenario(Path(__file__).parent.parent / "profiles" / f"{name}.yaml").shock.profile
    assert (type(profile).__name__, type(profile).__module__) == (
        CLASSES[name],
        f"shockwave_pulses.{name.replace('-', '_')}",
    )


def test_nothing_but_the_pulses_is_registered(tmp_path: Path) -> None:
    rows = json.loads(_output("-m", "shockwave", "list", "plugins", "--check", "--json", cwd=tmp_path))
    (own,) = [row for row in rows if row["name"] == "shockwave-pulses"]
    assert own["entries"] == [{"kind": "profiles", "name": name} for name in NAMES]
    assert own["checked"]


def test_no_name_is_taken_from_another(tmp_path: Path) -> None:
    rows = json.loads(_output("-m", "shockwave", "list", "profiles", "--json", cwd=tmp_path))
    names = [row["name"] for row in rows]
    assert sorted(names) == sorted(set(names))
