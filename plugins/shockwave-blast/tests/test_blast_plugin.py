"""The distribution as shockwave sees it: found once installed, imported only when named."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from shockwave import load_scenario

from shockwave_blast.kingery_bulmash import KingeryBulmash

NAMES = ["kingery-bulmash"]


def _output(*arguments: str, cwd: Path) -> str:
    command = [sys.executable, "-W", "error", *arguments]
    return subprocess.run(command, cwd=cwd, check=True, capture_output=True, text=True, timeout=60).stdout


def test_profiles_are_listed_with_the_distribution(tmp_path: Path) -> None:
    rows = [
        line.split() for line in _output("-m", "shockwave", "list", "profiles", cwd=tmp_path).splitlines()
    ]
    listed = {row[0]: row[-1] for row in rows if row}
    assert {name: listed.get(name) for name in NAMES} == dict.fromkeys(NAMES, "shockwave-blast")


def test_a_scenario_gets_the_class_of_the_name() -> None:
    path = Path(__file__).parent.parent / "profiles" / "microcharge.yaml"
    assert type(load_scenario(path).shock.profile) is KingeryBulmash


def test_nothing_but_the_profile_is_registered(tmp_path: Path) -> None:
    rows = json.loads(_output("-m", "shockwave", "list", "plugins", "--check", "--json", cwd=tmp_path))
    (own,) = [row for row in rows if row["name"] == "shockwave-blast"]
    assert own["entries"] == [{"kind": "profiles", "name": name} for name in NAMES]
    assert own["checked"]
    assert own["problem"] is None


def test_listing_imports_no_profile_and_no_numpy(tmp_path: Path) -> None:
    command = [sys.executable, "-X", "importtime", "-m", "shockwave", "list", "profiles"]
    done = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True, timeout=60)
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert "shockwave.cli" in imported
    assert {name for name in imported if name.startswith(("numpy.", "shockwave_blast"))} <= {
        "shockwave_blast",
        "shockwave_blast.hooks",
    }


@pytest.mark.parametrize("name", NAMES)
def test_a_template_of_the_profile_is_a_scenario(name: str, tmp_path: Path) -> None:
    _output("-m", "shockwave", "new", "--profile", name, "-o", "new.yaml", cwd=tmp_path)
    assert "valid" in _output("-m", "shockwave", "validate", "new.yaml", cwd=tmp_path)
