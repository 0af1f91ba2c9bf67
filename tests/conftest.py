"""Plugins that a test brings along, and what all tests share."""

import gc
import importlib.util
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from attrs import evolve

# Workers side by side take all cores already. It is read when NumPy is imported, here and in child processes.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# What is tested is the shockwave that is installed, and it may lie elsewhere: `python -m pytest` puts the source tree,
# which has no compiled part then, before it on the path; so does a child process that runs there.
ROOT = Path(__file__).parent.parent
IMPORT_PATH = sys.path[:]
sys.path[:] = [entry for entry in IMPORT_PATH if Path(entry).resolve() != ROOT.resolve()]
if not (INSTALLED := importlib.util.find_spec("shockwave")):
    sys.path[:] = IMPORT_PATH
elif not Path(str(INSTALLED.origin)).is_relative_to(ROOT / "shockwave"):
    os.environ["PYTHONSAFEPATH"] = "1"

from support.fake_distributions import PLUGINS, describe, forgetting, on_path  # noqa: E402 (after the path is set)
from support.fake_distributions import install as install_project  # noqa: E402
from support.pages import workplace  # noqa: E402

#: A hooks module that registers one profile and imports nothing heavy.
HOOKS = """
from shockwave.hooks import Entry, hookimpl

@hookimpl
def shockwave_profiles():
    return [Entry("{name}", "{module}_pulse:Pulse", "a pulse")]
"""
PULSE = """
from shockwave.profiles.triangular import Triangular

class Pulse(Triangular):
    pass
"""

#: Folders with tests of texts, commands, files and processes; the numbers in all others depend on the processor.
NOT_NUMERICAL = {"cli", "pictures", "project", "registry", "report", "scenario", "sweep"}

Install = Callable[..., str]


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.parent.name not in NOT_NUMERICAL:
            item.add_marker(pytest.mark.numerical)


@pytest.fixture(scope="module")
def frozen() -> Iterator[None]:
    """Nothing that exists already is garbage: a collection before each timed run need not look at all tests."""
    gc.freeze()
    yield
    gc.unfreeze()


@pytest.fixture
def few_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    """An uncertainty takes 64 draws too, a quarter of the least number: enough where no test judges their scatter."""
    from shockwave.studies import uncertainty_study

    monkeypatch.setattr(uncertainty_study, "_DRAWS", evolve(uncertainty_study._DRAWS, at_least=64))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def patch(tmp_path: Path) -> Iterator[pytest.MonkeyPatch]:
    """A working folder, which is the current one, and where alone plugins are."""
    with workplace(tmp_path) as patch:
        yield patch


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder on the path, here and in other processes, where distributions are put."""
    place = tmp_path / "site"
    place.mkdir()
    on_path(place, monkeypatch)
    with forgetting(place):
        yield place


@pytest.fixture
def install(site: Path) -> Install:
    """Put a distribution with a hooks module into the site; gives the name of its module."""

    def installed(project: str, hooks: str = HOOKS, pulse: str = PULSE, name: str = "", version: str = "1.2") -> str:
        module = project.replace("-", "_")
        (site / f"{module}.py").write_text(hooks.format(name=name or project, module=module))
        (site / f"{module}_pulse.py").write_text(pulse)
        describe(site, project, version, {project: module})
        return module

    return installed


@pytest.fixture
def sample_plugins(site: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The sample plugins of the source tree count as installed."""
    for project in sorted(PLUGINS.glob("*/pyproject.toml")):
        install_project(site, project, monkeypatch)
