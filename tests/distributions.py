"""Distributions that count as installed, without an installer: their source on the path, and metadata beside it."""

from __future__ import annotations

import importlib
import os
import tomllib
from collections.abc import Mapping
from pathlib import Path

import pytest

from shockwave import registry

__all__ = ["PLUGINS", "describe", "install", "on_path"]

#: The folder of the sample plugins.
PLUGINS = Path(__file__).parent.parent / "plugins"


def describe(folder: Path, name: str, version: str, modules: Mapping[str, str], requires: str = "") -> Path:
    """Write the metadata of a plugin: ``modules`` holds the module of hooks of each entry point."""
    info = folder / f"{name.replace('-', '_')}-{version}.dist-info"
    info.mkdir()
    needs = f"Requires-Dist: {requires}\n" if requires else ""
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n{needs}")
    points = [f"{point} = {module}" for point, module in modules.items()]
    (info / "entry_points.txt").write_text("\n".join(["[shockwave]", *points, ""]))
    registry.forget()
    importlib.invalidate_caches()
    return info


def on_path(folder: Path, patch: pytest.MonkeyPatch) -> None:
    """Put a folder on the path, here and in processes that are started."""
    patch.syspath_prepend(folder)
    patch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)


def install(folder: Path, project: Path, patch: pytest.MonkeyPatch) -> None:
    """Make the distribution of a project file count as installed; its metadata go to ``folder``."""
    about = tomllib.loads(project.read_text(encoding="utf-8"))["project"]
    describe(folder, about["name"], about["version"], about["entry-points"]["shockwave"])
    on_path(project.parent / "src", patch)
