"""Plugins as they are installed: damaged metadata, archives, two distributions of one entry point."""

from __future__ import annotations

import importlib
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from conftest import HOOKS
from shockwave import registry
from shockwave.errors import PluginError

if TYPE_CHECKING:
    from conftest import Install


@pytest.mark.parametrize(
    ("file", "text", "problem"),
    [
        ("entry_points.txt", b"[shockwave]\nno equals sign\n", "entry points cannot be read"),
        ("entry_points.txt", b"[shockwave]\na = \xff\n", "entry points cannot be read"),
        ("METADATA", b"Name: a-\xff\n", "metadata cannot be read"),
        ("METADATA", b"", "metadata cannot be read"),
        ("entry_points.txt", b"[shockwave]\na = a_damaged:hook\n", "must name a module (got a_damaged:hook)"),
    ],
    ids=["no-value", "no-text", "metadata", "empty", "attribute"],
)
def test_damaged_metadata_are_the_fault_of_their_distribution(
    install: Install, site: Path, file: str, text: bytes, problem: str
) -> None:
    install("a-damaged")
    install("b-sound")
    (site / "a_damaged-1.2.dist-info" / file).write_bytes(text)
    registry.forget()
    problems = {plugin.distribution: plugin.problem for plugin in registry.plugins()}
    assert problems.pop("b-sound") == ""
    assert any(problem in found for found in problems.values())


def test_a_plugin_in_an_archive_can_be_used(site: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    archive = site / "plugins.zip"
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("zipped.py", HOOKS.format(name="zipped-pulse", module="zipped"))
        file.writestr("zipped_pulse.py", "from shockwave import Triangular as Pulse\n")
        file.writestr("zipped-1.0.dist-info/METADATA", "Metadata-Version: 2.1\nName: zipped\nVersion: 1.0\n")
        file.writestr("zipped-1.0.dist-info/entry_points.txt", "[shockwave]\nz = zipped\n")
    monkeypatch.syspath_prepend(archive)
    registry.forget()
    importlib.invalidate_caches()
    assert registry.load("profiles", "zipped-pulse").__name__ == "Triangular"


def test_two_distributions_with_the_same_entry_point_are_both_read(install: Install, site: Path) -> None:
    install("a-one", name="one-pulse")
    install("b-two", name="two-pulse")
    (site / "b_two-1.2.dist-info" / "entry_points.txt").write_text("[shockwave]\na-one = a_one\n")
    registry.forget()
    with pytest.raises(PluginError, match="registered twice, by a-one and b-two"):
        registry.find("profiles", "one-pulse")
