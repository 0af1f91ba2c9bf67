"""The distribution as shockwave sees it: found once installed, imported only when named."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from shockwave import load_scenario
from shockwave.base.errors import ShockwaveError
from shockwave.registry.registry import entries, find, load

from shockwave_composition.hooks import shockwave_integrators

NAMES = ["blanes-moan-4", "blanes-moan-6", "blanes-moan-6-long", "verlet-richardson"]

SCENE = """
chain: {{material: paper-steel, diameter: 9.5 mm}}
shock: {{profile: triangular, peak_force: 100 N, rise_time: 10 us, duration_ratio: 3}}
simulate: {{integrator: {name}, {setting}: 1e-3}}
"""


def _output(*arguments: str, cwd: Path) -> str:
    command = [sys.executable, "-W", "error", *arguments]
    return subprocess.run(command, cwd=cwd, check=True, capture_output=True, text=True, timeout=60).stdout


def _listed(kind: str, folder: Path) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = json.loads(_output("-m", "shockwave", "list", kind, "--json", cwd=folder))
    return rows


def test_integrators_are_listed_by_name(tmp_path: Path) -> None:
    rows = _listed("integrators", tmp_path)
    assert [row["name"] for row in rows if row["distribution"] == "shockwave-composition"] == NAMES


def test_the_distribution_is_listed_without_a_problem(tmp_path: Path) -> None:
    own = [row for row in _listed("plugins", tmp_path) if row["name"] == "shockwave-composition"]
    assert [row["problem"] for row in own] == [None]


def test_listing_imports_no_method_and_no_numpy(tmp_path: Path) -> None:
    script = (
        "import sys; from shockwave.registry.registry import entries; print(len(entries('integrators')));"
        " print(*(name for name in sys.modules if name.startswith(('numpy.', 'shockwave_composition'))))"
    )
    _, *found = _output("-c", script, cwd=tmp_path).split()
    assert set(found) <= {"shockwave_composition", "shockwave_composition.hooks"}


@pytest.mark.parametrize("name", NAMES)
def test_the_registry_loads_the_class_of_the_name(name: str) -> None:
    assert load("integrators", name).name == name


@pytest.mark.parametrize("name", NAMES)
def test_summary_and_setting_state_order_and_properties(name: str) -> None:
    method, entry = load("integrators", name), find("integrators", name)
    order = re.search(r"order (\d+)", entry.summary)
    assert order is not None
    assert int(order[1]) == method.order
    assert ("fixed" in entry.summary) == (not method.adaptive)
    assert ("symplectic" in entry.summary) == name.startswith("blanes-moan")
    assert entry.takes == ("rtol" if method.adaptive else "step")


def test_nothing_else_is_registered() -> None:
    own = [entry for entry in entries("integrators") if entry.distribution == "shockwave-composition"]
    assert [entry.name for entry in own] == [entry.name for entry in shockwave_integrators()] == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_a_scenario_may_give_the_setting_of_the_method_alone(name: str, tmp_path: Path) -> None:
    taken, other = ("rtol", "step") if name == "verlet-richardson" else ("step", "rtol")
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE.format(name=name, setting=taken), encoding="utf-8")
    load_scenario(file)
    file.write_text(SCENE.format(name=name, setting=other), encoding="utf-8")
    with pytest.raises(ShockwaveError, match=rf"{other}: must be left out: {name}"):
        load_scenario(file)
