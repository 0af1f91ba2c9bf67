"""What all tests share: nothing is kept between runs, or in the user's own folders."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from shockwave import registry

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

# fmt: off
#: Files whose numbers could depend on the processor: the tests that are marked ``numerical``.
NUMERICAL = {
    "auto", "backends", "chain", "conditions", "curve", "curve_train", "docs", "extremes", "finite_chains",
    "free_path", "impulse_limit", "integrators", "many", "measurement", "moments", "numerics",
    "outcome", "pages", "paper_tables", "predictor", "primary", "profiles", "profiles_digits", "quadratures",
    "recording", "records", "section4", "simulation", "solitary_wave", "tabulated", "train",
    "trust", "truth", "uncertainty",
}
# fmt: on

Install = Callable[..., str]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the numerical tests."""
    for item in items:
        if item.path.stem.removeprefix("test_") in NUMERICAL:
            item.add_marker(pytest.mark.numerical)


@pytest.fixture(autouse=True, scope="session")
def cache_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Where shockwave keeps what it has read of plugins."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("platformdirs.user_cache_path", lambda *_, **__: folder)
        patch.setenv("XDG_CACHE_HOME", str(folder))
        yield folder


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder on the path, here and in other processes, where distributions are put."""
    place = tmp_path / "site"
    place.mkdir()
    monkeypatch.syspath_prepend(place)
    monkeypatch.setenv("PYTHONPATH", str(place), prepend=":")
    before = set(sys.modules)
    registry.forget()
    yield place
    registry.forget()
    for module in set(sys.modules) - before:
        if getattr(sys.modules[module], "__file__", None) and str(place) in str(sys.modules[module].__file__):
            del sys.modules[module]


@pytest.fixture
def install(site: Path) -> Install:
    """Put a distribution with a hooks module into the site; gives the name of its module."""

    def installed(
        distribution: str,
        hooks: str = HOOKS,
        pulse: str = PULSE,
        name: str = "",
        version: str = "1.2",
        requires: str = "",
    ) -> str:
        module = distribution.replace("-", "_")
        (site / f"{module}.py").write_text(hooks.format(name=name or distribution, module=module))
        (site / f"{module}_pulse.py").write_text(pulse)
        info = site / f"{module}-{version}.dist-info"
        info.mkdir()
        needs = f"Requires-Dist: {requires}\n" if requires else ""
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: {version}\n{needs}")
        (info / "entry_points.txt").write_text(f"[shockwave]\n{distribution} = {module}\n")
        registry.forget()
        importlib.invalidate_caches()
        return module

    return installed
