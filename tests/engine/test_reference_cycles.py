"""What calls leave behind: no reference cycles, which hold arrays until the garbage collector runs."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import shockwave as sw
from shockwave import cli
from support.pages import ROOT
from support.scenes import CASE_B, CHAIN, STEEL

WALLED = sw.Chain(material=STEEL, radius=4.75e-3, granules=12, end=sw.Wall())
HISTORIES: dict[str, Any] = {"record": ["forces", "field", "energies"], "contacts": [5]}
FILE = ROOT / "profiles" / "examples" / "triangular.yaml"
TINY = sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=1e-300, rise_time=1e-5)
CALLS: dict[str, Callable[[], Any]] = {
    "scenario": lambda: sw.load_scenario(FILE),
    "prediction": lambda: sw.predict(FILE, **HISTORIES).to_dict(),
    "prediction of a chain": lambda: sw.predict(CASE_B, WALLED, **HISTORIES).to_dict(),
    "section 4": lambda: sw.predict(FILE, model="section-4").to_dict(),
    "simulation": lambda: sw.simulate(CASE_B, CHAIN, **HISTORIES).to_dict(),
    "simulation of a chain": lambda: sw.simulate(CASE_B, WALLED, **HISTORIES).to_dict(),
    "comparison": lambda: sw.compare(CASE_B, CHAIN, **HISTORIES).to_dict(),
    "comparison of a chain": lambda: sw.compare(CASE_B, WALLED, **HISTORIES).to_dict(),
    "simulations": lambda: sw.simulate_many([CASE_B, TINY], [CHAIN, WALLED], 1e-4),
    "curve": lambda: sw.UniversalCurve(sw.Triangular(duration_ratio=3), rtol=1e-2, longest=1.0),
    "design": lambda: sw.design(
        FILE, vary="shock.peak_force", between=("50 N", "200 N"), target="peak_force = 60 N", points=3, rtol=1e-2
    ),
    "uncertainty": lambda: sw.uncertainty(CASE_B, CHAIN, {"chain.radius": "5 %"}, draws=64, rtol=1e-2),
}


@pytest.fixture
def garbage() -> Iterator[list[Any]]:
    """What only the collector finds; it does not run by itself."""
    gc.disable()
    gc.collect()
    gc.set_debug(gc.DEBUG_SAVEALL)
    yield gc.garbage
    gc.set_debug(0)
    gc.garbage.clear()
    gc.enable()


@pytest.mark.usefixtures("frozen", "few_draws")
@pytest.mark.parametrize("kind", CALLS)
def test_a_result_is_freed_without_the_garbage_collector(kind: str, garbage: list[Any]) -> None:
    call = CALLS[kind]
    call()  # fills caches and imports modules
    gc.collect()
    garbage.clear()
    text = str(call())
    gc.collect()
    assert text
    # SciPy's distributions and matplotlib's figures are cycles of their own
    assert [each for each in garbage if type(each).__module__.startswith("shockwave")] == []
    assert [each for each in garbage if isinstance(each, np.ndarray)] == []


@pytest.mark.parametrize(
    ("address", "arguments"),
    [("plugin_commands.run", ["explore"]), ("sweep_command.sweep", ["sweep", "map.yaml"])],
    ids=["explore", "sweep"],
)
def test_a_command_that_may_stay_running_collects_garbage_as_usual(
    address: str, arguments: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    usual = gc.get_threshold()
    thresholds = []
    monkeypatch.setattr(f"shockwave.cli.{address}", lambda _: thresholds.append(gc.get_threshold()) or 0)
    monkeypatch.setattr("atexit.register", lambda _: None)
    monkeypatch.setattr("sys.argv", ["shockwave", *arguments])
    try:
        assert cli.command() == 0
    finally:
        gc.set_threshold(*usual)
    assert thresholds == [usual]
