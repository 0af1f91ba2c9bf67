"""Time limits and interrupts, and what remains of a result of which a part cannot be computed."""

from __future__ import annotations

import gc
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import attrs
import pytest

import shockwave as sw
from shockwave.scene.scene import Scene
from shockwave.scene.simulate_options import Backend
from shockwave.simulation import simulate
from support.scenes import CHAIN, FORCE, power_law, record

#: Takes far longer than any test waits.
SLOW = record([0, 4, 8, 10, 14, 18], [0, 1, 0, 0, 1, 0])
FLAT = record([0, 0.5, 199.5, 200], [0, 1, 1, 0])


@pytest.mark.parametrize("backend", ["compiled", "numpy"])
def test_a_time_limit_ends_a_simulation_with_an_error(backend: Backend) -> None:
    begin = time.monotonic()
    with pytest.raises(sw.NumericalError, match="the time limit was reached before the leading wave was known"):
        sw.simulate(SLOW, CHAIN, rtol=1e-9, backend=backend, timeout=0.01)
    assert time.monotonic() - begin < 15  # the computation looks at the clock every few tens of milliseconds


def test_a_time_limit_is_that_of_each_of_many(monkeypatch: pytest.MonkeyPatch) -> None:
    shocks = [record([0, 1, 3], [0, height, 0]) for height in (1.0, 2.0, 3.0)]
    search = simulate.search

    def slow(problems: Any, setup: Any) -> Any:
        found = search(problems, setup)
        if len(problems) == 1:
            return found
        time.sleep(0.6)  # the time of all together
        return {0: found[0], 1: found[1]._replace(error_estimate=0.1)}

    expected = sw.simulate_many(shocks, CHAIN)
    monkeypatch.setattr(simulate, "search", slow)
    assert sw.simulate_many(shocks, CHAIN, timeout=0.5) == [
        attrs.evolve(result, options=attrs.evolve(result.options, timeout=0.5))
        for result in expected
        if isinstance(result, sw.Simulation)
    ]


#: 4500 characteristic times.
LONG = sw.Shock(profile=power_law(15, 0.5, 2), peak_force=FORCE, rise_time=4.4e-3)


def test_a_shock_of_thousands_of_characteristic_times_ends_at_its_time_limit() -> None:
    begin = time.process_time()
    with pytest.raises(sw.NumericalError, match="the time limit was reached"):
        sw.simulate(LONG, CHAIN, timeout=0.2)
    assert time.process_time() - begin < 5  # without a limit 24 s


def test_a_train_that_takes_too_long_leaves_the_leading_wave() -> None:
    # the leading wave takes hundredths of a second, the train tens of seconds
    result = sw.simulate(record([0, 200, 600], [0, 1, 0]), CHAIN, timeout=0.8)
    assert len(result.waves) == 1
    assert any("the time limit was reached" in warning for warning in result.warnings)
    assert result.to_dict()["peak_force"] == result.peak_force
    assert "only the leading wave is known" in str(result)


def test_the_train_of_a_flat_top_is_not_integrated_and_its_cost_is_stated() -> None:
    from shockwave.simulation.wave_setup import immeasurable, scale_scene

    assert "about 10 s or more" in immeasurable(scale_scene(Scene(excitation=FLAT, chain=CHAIN))[0])
    assert immeasurable(scale_scene(Scene(excitation=record([0, 100, 300], [0, 1, 0]), chain=CHAIN))[0]) == ""


INTERRUPTED: dict[str, Callable[[], object]] = {
    "one": lambda: sw.simulate(SLOW, CHAIN, rtol=1e-9, waves="primary"),
    "many": lambda: sw.simulate_many([SLOW] * 40, CHAIN, rtol=1e-9, waves="primary", threads=2),
    "train": lambda: sw.simulate(record([0, 70, 210], [0, 1, 0]), CHAIN, rtol=1e-10).train,
}


@pytest.mark.skipif(sys.platform == "win32", reason="no signal can be sent to oneself there")
@pytest.mark.parametrize("name", INTERRUPTED)
def test_an_interrupt_ends_a_computation_soon(name: str) -> None:
    sent = []

    def interrupt() -> None:
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    sw.simulate(record([0, 1, 2], [0, 1, 0]), CHAIN, rtol=1e-2).train  # noqa: B018  an interrupted import leaves files open
    gc.collect()  # Python ignores an interrupt that arrives while it disposes of garbage, such as that of earlier tests
    # a process that was started in the background ignores the signal
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        threading.Timer(0.2, interrupt).start()
        with pytest.raises(KeyboardInterrupt):
            INTERRUPTED[name]()
    finally:
        signal.signal(signal.SIGINT, before)
    assert time.monotonic() - sent[0] < 10  # a tenth of a second on a machine that has nothing else to do


def test_a_contact_without_a_passage_leaves_the_others() -> None:
    result = sw.simulate(record([0, 30, 60], [0, 1, 0]), CHAIN, rtol=1e-4, waves="primary", contacts=(0, 60))
    with pytest.raises(sw.NumericalError, match="the force still rises there"):
        result.passage(0)
    assert [passage.contact for passage in result.passages] == [60]
    assert any(warning.startswith("No passage at contact 0") for warning in result.warnings)
