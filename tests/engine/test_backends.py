"""The compiled and the NumPy backend: equal results, the choice between them, and invalid buffers."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import attrs
import pytest

import shockwave as sw
from shockwave.cli import main
from shockwave.engine import backend
from shockwave.engine.nystroem_integrators import Rkn86
from shockwave.engine.scaled_problem import ScaledProblem
from shockwave.engine.search_request import SearchRequest, SearchStatus
from shockwave.engine.stretch import free_granules
from shockwave.engine.wave_search import find_primaries
from shockwave.simulation.wave_setup import setup_of
from shockwave.simulation.whole_chain import WholeChain
from support.scenes import (
    CASE_A,
    CHAIN,
    POWER,
    lasting,
    power,
    power_law,
    random_pulses,
    record,
    triangle,
)
from support.slow_cases import keeping

pytestmark = pytest.mark.compiled

compiled_alone = pytest.mark.skipif(backend.compiled is None, reason=backend.lack())


NAMES = ["numpy", pytest.param("compiled", marks=compiled_alone)]


EXPONENTIAL = sw.Exponential(rise_rate=3, decay_rate=-4, duration_ratio=5)
# its precursor makes overlaps of 1e-3 to 2e-3, whose forces are too weak for the front
PRECURSOR = record([0, 0.5, 1, 41, 42, 43], [0, 6e-4, 0, 0, 1, 0])
TWO_PEAKS = record([0, 1, 2, 8, 9, 10], [0, 0.5, 0, 0, 1, 0])
SCENES: dict[str, tuple[sw.Shock, int | None]] = {
    "A": (CASE_A, None),
    "long": (triangle(60), None),
    "rectangle": (lasting(power_law(2, 0, 0), 2), None),
    "exponential": (lasting(EXPONENTIAL, 5), None),
    "record": (random_pulses(11, 3)[2], None),
    "two-peaks": (TWO_PEAKS, None),
    "precursor": (PRECURSOR, None),
    "loaded": (lasting(power_law(2.5, 2, 2), 23.75), None),
    "two-granules": (power(0.5), 2),
    "33-granules": (power(0.5), 33),
}


@compiled_alone
@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("integrator", keeping(["rkn86", "rkn64", "rkn1210"], "rkn86"))
def test_backends_agree(scene: str, integrator: str) -> None:
    shock, granules = SCENES[scene]
    chain = attrs.evolve(CHAIN, granules=granules)
    settings = {"rtol": 1e-5, "integrator": integrator, "waves": "primary"}
    one, other = (sw.simulate(shock, chain, backend=name, **settings).wave.scaled for name in ("compiled", "numpy"))
    # sums of momenta, energies and, with 17 stages, accelerations are rounded in a different order; where the whole
    # chain is measured, the evaluations that locate a peak at the loaded end are not the same
    assert one[:-2] == pytest.approx(other[:-2], rel=1e-12, abs=1e-12)
    if integrator != "rkn1210" and granules != 2:
        assert (one.peak, one.time, one.doubt, one.steps) == (other.peak, other.time, other.doubt, other.steps)


@compiled_alone
def test_backends_agree_to_the_last_bit_for_random_pulses_on_chains_of_any_length() -> None:
    chains = [attrs.evolve(CHAIN, granules=None if index % 2 else 4 * index + 20) for index in range(30)]
    settings = {"rtol": 1e-4, "waves": "primary"}
    runs = [sw.simulate_many(random_pulses(11, 30), chains, backend=name, **settings) for name in ("compiled", "numpy")]
    one, other = ([(run.wave.scaled.peak, run.wave.scaled.steps) for run in each] for each in runs)
    assert one == other


@compiled_alone
@pytest.mark.parametrize("scene", ["A", "record", "two-peaks", "precursor", "loaded"])
def test_backends_agree_on_passages(scene: str) -> None:
    shock, _ = SCENES[scene]
    contacts = (0,) if scene == "loaded" else (1, 3, 8, 20)
    one, other = (sw.simulate(shock, CHAIN, backend=name, contacts=contacts).passages for name in ("compiled", "numpy"))
    for here, there in zip(one, other, strict=True):
        # the estimate is the difference of two runs, which amplifies rounding
        assert here.error_estimate == pytest.approx(there.error_estimate, rel=1e-3)
        there = attrs.evolve(there, error_estimate=here.error_estimate)
        assert attrs.astuple(here) == pytest.approx(attrs.astuple(there), rel=1e-12)


@compiled_alone
def test_backends_agree_on_the_train() -> None:
    one, other = (sw.simulate(CASE_A, CHAIN, backend=name, rtol=1e-4) for name in ("compiled", "numpy"))
    for name in ("peak_force", "momentum", "energy", "width", "granule_velocity", "foot"):
        values = [getattr(wave, name) for wave in other.waves]
        # equal steps, except for the rounding of sums, which is relative to the leading wave
        assert [getattr(wave, name) for wave in one.waves] == pytest.approx(
            values, rel=1e-11, abs=1e-12 * max(values[0], 1.0)
        )


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("beyond", "status"), [(8, SearchStatus.AT_END), (9, SearchStatus.KNOWN)])
def test_a_free_end_within_eight_granules_of_the_front_ends_a_search(
    name: str, beyond: int, status: SearchStatus
) -> None:
    compiled = backend.compiled if name == "compiled" else None
    (endless,) = find_primaries([SearchRequest(PROBLEM, 1e-8, 1e-6)], Rkn86, compiled)
    problem = attrs.evolve(PROBLEM, granules=int(endless.contact) + beyond)
    (finite,) = find_primaries([SearchRequest(problem, 1e-8, 1e-6)], Rkn86, compiled)
    assert finite.status == status
    # a free end has no effect on what was read before
    assert (finite == endless) == (status is SearchStatus.KNOWN)


# ---------------------------------------------------------------- choice of the backend


SCENARIO = """
chain: {material: copper, radius: 1 mm}
shock: {profile: triangular, peak_force: 10 N, rise_time: 10 us, duration_ratio: 3}
simulate: {backend: %s}
"""


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("in_scenario", [True, False], ids=["scenario", "command-line"])
def test_backend_is_chosen_and_printed(
    name: str, in_scenario: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENARIO % (name if in_scenario else "auto"))
    options = [] if in_scenario else ["--backend", name]
    assert main(["simulate", "--verbose", *options, str(path)]) == 0
    assert f"rkn86 ({name})" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("integrator", "backend"),
    [("dop853", "numpy"), *(pytest.param(name, "compiled", marks=compiled_alone) for name in ("rk4", "rkn86"))],
)
def test_auto_selects_a_backend_with_the_method(integrator: str, backend: str) -> None:
    short = attrs.evolve(CHAIN, granules=10)
    assert sw.simulate(CASE_A, short, integrator=integrator, waves="primary").backend == backend


@pytest.fixture
def without(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """An installation without the compiled code."""
    monkeypatch.setattr(backend, "compiled", None)
    setup_of.cache_clear()
    yield
    setup_of.cache_clear()


@pytest.mark.usefixtures("without")
def test_without_compiled_code_auto_selects_numpy_and_compiled_is_an_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert sw.simulate(CASE_A, CHAIN) == sw.simulate(CASE_A, CHAIN, backend="numpy")
    with pytest.raises(sw.InvalidValueError, match=r"backend: must be auto or numpy here .* needs a C compiler"):
        sw.simulate(CASE_A, CHAIN, backend="compiled")
    assert main(["list", "backends", "--json"]) == 0
    found = {row["name"]: row["problem"] for row in json.loads(capsys.readouterr().out)}
    assert "needs a C compiler" in found["compiled"]
    assert found["numpy"] is None


PROBLEM = ScaledProblem(POWER, 2.0, 1.0)


@pytest.mark.parametrize("compiled", [None, pytest.param(backend.compiled, marks=compiled_alone)])
def test_a_chain_of_granules_in_free_flight_can_be_shortened(compiled: Any) -> None:
    problem = ScaledProblem(POWER, 0.1, 10.0)
    whole = WholeChain(problem, Rkn86(compiled=compiled))
    stretch = whole.advance_to(60.0, "", 60.0)
    flying = free_granules(stretch.x[-1], stretch.v[-1])
    assert flying > 10
    whole.shorten(flying)
    after = whole.advance_to(70.0, "", 70.0)
    # rounding of positions of order 10
    assert after.v[-1][:flying] == pytest.approx(stretch.v[-1][:flying], abs=1e-12)
