"""The distribution as shockwave sees it: found once installed, imported only when named."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from shockwave import ShockwaveError, load_scenario
from shockwave.hooks import Entry, OneStep

from shockwave_composition.blanes_moan import BlanesMoan4, BlanesMoan6, BlanesMoan6Long
from shockwave_composition.hooks import shockwave_integrators
from shockwave_composition.verlet_richardson import VerletRichardson

METHODS = [BlanesMoan4, BlanesMoan6, BlanesMoan6Long, VerletRichardson]
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
    command = [sys.executable, "-X", "importtime", "-m", "shockwave", "list", "integrators"]
    done = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True, timeout=60)
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert "shockwave.cli" in imported
    assert {name for name in imported if name.startswith(("numpy.", "shockwave_composition"))} <= {
        "shockwave_composition",
        "shockwave_composition.hooks",
    }


@pytest.mark.parametrize(
    ("method", "entry"), list(zip(METHODS, shockwave_integrators(), strict=True)), ids=NAMES
)
def test_summary_and_setting_state_order_and_properties(method: type[OneStep], entry: Entry) -> None:
    assert entry.address == f"{method.__module__}:{method.__name__}"
    order = re.search(r"order (\d+)", entry.summary)
    assert order is not None
    assert int(order[1]) == method.order
    assert ("fixed" in entry.summary) == (not method.adaptive)
    assert ("symplectic" in entry.summary) == entry.name.startswith("blanes-moan")
    assert entry.takes == ("rtol" if method.adaptive else "step")


def test_nothing_else_is_registered(tmp_path: Path) -> None:
    rows = json.loads(_output("-m", "shockwave", "list", "plugins", "--check", "--json", cwd=tmp_path))
    (own,) = [row for row in rows if row["name"] == "shockwave-composition"]
    assert own["entries"] == [{"kind": "integrators", "name": name} for name in NAMES]
    assert own["checked"]


@pytest.mark.parametrize("name", NAMES)
def test_a_scenario_may_give_the_setting_of_the_method_alone(name: str, tmp_path: Path) -> None:
    taken, other = ("rtol", "step") if name == "verlet-richardson" else ("step", "rtol")
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE.format(name=name, setting=taken), encoding="utf-8")
    load_scenario(file)
    file.write_text(SCENE.format(name=name, setting=other), encoding="utf-8")
    with pytest.raises(ShockwaveError, match=rf"{other}: must be left out: {name}"):
        load_scenario(file)
