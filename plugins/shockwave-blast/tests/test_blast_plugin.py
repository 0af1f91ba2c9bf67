"""The distribution as shockwave sees it: found once installed, imported only when named."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from shockwave.registry.registry import load, plugins

from shockwave_blast.friedlander import Friedlander
from shockwave_blast.kingery_bulmash import KingeryBulmash

NAMES = ["friedlander", "kingery-bulmash"]


def _output(*arguments: str, cwd: Path) -> str:
    command = [sys.executable, "-W", "error", *arguments]
    return subprocess.run(command, cwd=cwd, check=True, capture_output=True, text=True, timeout=60).stdout


def test_profiles_are_listed_with_the_distribution(tmp_path: Path) -> None:
    rows = [
        line.split() for line in _output("-m", "shockwave", "list", "profiles", cwd=tmp_path).splitlines()
    ]
    listed = {row[0]: row[-1] for row in rows if row}
    assert {name: listed.get(name) for name in NAMES} == dict.fromkeys(NAMES, "shockwave-blast")


@pytest.mark.parametrize(("name", "kind"), [(NAMES[0], Friedlander), (NAMES[1], KingeryBulmash)], ids=NAMES)
def test_the_registry_loads_the_class_of_the_name(name: str, kind: type) -> None:
    assert load("profiles", name) is kind


def test_nothing_but_the_two_profiles_is_registered() -> None:
    own = [plugin for plugin in plugins() if plugin.distribution == "shockwave-blast"]
    assert [[(kind, entry.name) for kind, entry in plugin.entries] for plugin in own] == [
        [("profiles", name) for name in NAMES]
    ]


def test_listing_imports_no_profile_and_no_numpy(tmp_path: Path) -> None:
    script = (
        "import sys; from shockwave.registry.registry import entries; entries('profiles');"
        " print(*sorted(name for name in sys.modules if name.startswith(('numpy.', 'shockwave_blast'))))"
    )
    assert set(_output("-c", script, cwd=tmp_path).split()) <= {"shockwave_blast", "shockwave_blast.hooks"}


@pytest.mark.parametrize("name", NAMES)
def test_a_template_of_the_profile_is_a_scenario(name: str, tmp_path: Path) -> None:
    _output("-m", "shockwave", "new", "--profile", name, "-o", "new.yaml", cwd=tmp_path)
    assert "valid" in _output("-m", "shockwave", "validate", "new.yaml", cwd=tmp_path)
