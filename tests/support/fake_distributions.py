"""Distributions that count as installed, without an installer: their source on the path, and metadata beside it."""

import importlib
import os
import sys
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pytest

from shockwave.registry import registry

#: The folder of the sample plugins.
PLUGINS = Path(__file__).parents[2] / "plugins"


def describe(folder: Path, name: str, version: str, modules: Mapping[str, str]) -> Path:
    """Write the metadata of a plugin: ``modules`` holds the module of hooks of each entry point."""
    info = folder / f"{name.replace('-', '_')}-{version}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    points = [f"{point} = {module}" for point, module in modules.items()]
    (info / "entry_points.txt").write_text("\n".join(["[shockwave]", *points, ""]))
    registry.forget()
    importlib.invalidate_caches()
    return info


@contextmanager
def forgetting(*folders: Path) -> Iterator[None]:
    """Forget afterwards which plugins were found, and which modules were imported from the folders."""
    before = set(sys.modules)
    registry.forget()
    yield
    registry.forget()
    for name in set(sys.modules) - before:
        file = Path(getattr(sys.modules[name], "__file__", None) or "")
        if any(file.is_relative_to(folder) for folder in folders):
            del sys.modules[name]


def on_path(folder: Path, patch: pytest.MonkeyPatch) -> None:
    """Put a folder on the path, here and in processes that are started."""
    patch.syspath_prepend(folder)
    patch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)


def install(folder: Path, project: Path, patch: pytest.MonkeyPatch) -> None:
    """Make the distribution of a project file count as installed; its metadata go to ``folder``."""
    about = tomllib.loads(project.read_text(encoding="utf-8"))["project"]
    describe(folder, about["name"], about["version"], about["entry-points"]["shockwave"])
    on_path(project.parent / "src", patch)
