"""The compiled code and NumPy: the same answers, the choice between them, and buffers that do not fit."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path
from types import ModuleType

import attrs
import numpy as np
import pytest

import shockwave as sw
from scenes import CASE_A, CASE_B, CHAIN, FORCE, UNITS, power, random_pulses, triangle
from selection import keeping
from shockwave.cli import main
from shockwave.simulation import backend
from shockwave.simulation.nystroem import Rkn86, Tableau
from shockwave.simulation.primary import find_primaries
from shockwave.simulation.primary_request import KNOWN, Primary
from shockwave.simulation.primary_request import Request as Asked
from shockwave.simulation.problem import ChainProblem

compiled_alone = pytest.mark.skipif(backend.compiled is None, reason=backend.lack())


def record(samples: int) -> sw.Shock:
    """Several peaks, finely sampled."""
    times = np.linspace(0, 6, samples)
    forces = np.abs(np.sin(1.7 * times)) * np.exp(-times / 4) + 0.02
    forces[[0, -1]] = 0.0
    return sw.Shock(profile=sw.Tabulated(times=times * UNITS.time, forces=FORCE * forces / forces.max()))


def shaped(profile: sw.ShockProfile, rise_time: float = 1.0) -> sw.Shock:
    return sw.Shock(profile=profile, peak_force=FORCE, rise_time=rise_time * UNITS.time)


SCENES: dict[str, tuple[sw.Shock, int | None]] = {
    "A": (CASE_A, None),
    "B": (CASE_B, None),
    "vanishing": (triangle(1e-9), None),
    "long": (triangle(60), None),
    "rectangle": (shaped(sw.PowerLaw(rise_exponent=0, decay_exponent=0, duration_ratio=2)), None),
    "jump": (shaped(sw.PowerLaw(rise_exponent=1e-8, decay_exponent=50, duration_ratio=3)), None),
    "singular": (shaped(sw.PowerLaw(rise_exponent=0.1, decay_exponent=0.2, duration_ratio=2)), None),
    "exponential": (shaped(sw.Exponential(rise_rate=3, decay_rate=-4, duration_ratio=5)), None),
    "record": (record(2000), None),
    "two-peaks": (
        sw.Shock(profile=sw.Tabulated(times=np.array([0, 1, 2, 8, 9, 10]) * UNITS.time, forces=[0, 50, 0, 0, 100, 0])),
        None,
    ),
    "two-granules": (power(0.5), 2),
    "nine-granules": (power(0.5), 9),
    "33-granules": (power(0.5), 33),
    "300-granules": (CASE_A, 300),
}
each_scene = pytest.mark.parametrize("scene", SCENES)


@cache
def run(scene: str, name: str, integrator: str, rtol: float = 1e-5) -> sw.SimulationResult:
    shock, granules = SCENES[scene]
    chain = attrs.evolve(CHAIN, granules=granules)
    return sw.simulate(shock, chain, rtol=rtol, integrator=integrator, backend=name, waves="primary")  # type: ignore


def numbers(found: Primary) -> np.ndarray:
    return np.array(found[: Primary._fields.index("passages")])


# ---------------------------------------------------------------- the same answers


@compiled_alone
@each_scene
@pytest.mark.parametrize("integrator", keeping(["rkn86", "rkn64", "rkn1210"], "rkn86"))
def test_backends_agree(scene: str, integrator: str) -> None:
    one, other = (numbers(run(scene, name, integrator).found) for name in ("compiled", "numpy"))
    # sums of momenta, energies and, with 17 stages, accelerations are rounded in another order
    assert one == pytest.approx(other, rel=1e-12, abs=1e-12)


@compiled_alone
@each_scene
@pytest.mark.parametrize("integrator", keeping(["rkn86", "rkn64"], "rkn86"))
def test_backends_find_the_same_bits(scene: str, integrator: str) -> None:
    one, other = (run(scene, name, integrator).found for name in ("compiled", "numpy"))
    assert (one.peak, one.time, one.doubt, one.steps) == (other.peak, other.time, other.doubt, other.steps)


@compiled_alone
def test_backends_find_the_same_bits_for_random_pulses_on_chains_of_any_length() -> None:
    pulses = random_pulses(seed=11, count=30)
    chains = [attrs.evolve(CHAIN, granules=None if index % 2 else 4 * index + 20) for index in range(30)]
    one, other = (
        [result.found for result in sw.simulate_many(pulses, chains, rtol=1e-4, backend=name, waves="primary")]
        for name in ("compiled", "numpy")
    )
    assert [found.peak for found in one] == [found.peak for found in other]
    assert [found.steps for found in one] == [found.steps for found in other]


@compiled_alone
@pytest.mark.parametrize("scene", ["A", "record", "rectangle", "two-peaks"])
def test_backends_agree_on_passages(scene: str) -> None:
    shock, _ = SCENES[scene]
    contacts = (1, 3, 8, 20)
    one, other = (sw.simulate(shock, CHAIN, backend=name, contacts=contacts).passages for name in ("compiled", "numpy"))
    for here, there in zip(one, other, strict=True):
        assert attrs.astuple(here) == pytest.approx(attrs.astuple(there), rel=1e-12)


@compiled_alone
def test_backends_agree_on_the_loaded_contact_while_the_force_acts() -> None:
    # both tell the time to 1e-4 by a parabola, which is off by its cube
    profile = sw.PowerLaw(rise_exponent=2, decay_exponent=2, duration_ratio=2.5)
    one, other = (sw.simulate(shaped(profile, 9.5), CHAIN, backend=name).passage(0) for name in ("compiled", "numpy"))
    assert one.arrival_time == pytest.approx(other.arrival_time, rel=1e-10)


@compiled_alone
def test_backends_agree_on_the_train() -> None:
    one, other = (sw.simulate(CASE_A, CHAIN, backend=name, rtol=1e-4) for name in ("compiled", "numpy"))
    assert [wave.peak_force for wave in one.waves] == pytest.approx(
        [wave.peak_force for wave in other.waves], rel=1e-12
    )


# ---------------------------------------------------------------- the choice


NAMES = ["numpy", pytest.param("compiled", marks=compiled_alone)]
SCENARIO = """
chain: {material: copper, radius: 1 mm}
shock: {profile: triangular, peak_force: 10 N, rise_time: 10 us, duration_ratio: 3}
"""


def json_of(capsys: pytest.CaptureFixture[str], *arguments: str) -> object:
    assert main(["simulate", "--json", *arguments]) == 0
    return json.loads(capsys.readouterr().out)["backend"]


@pytest.mark.parametrize("name", NAMES)
def test_backend_is_chosen_from_python(name: str) -> None:
    assert sw.simulate(CASE_A, CHAIN, backend=name).backend == name  # type: ignore[arg-type]


@pytest.mark.parametrize("name", NAMES)
def test_backend_is_chosen_in_a_scenario(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(f"{SCENARIO}simulate: {{backend: {name}}}\n")
    assert json_of(capsys, str(path)) == name


@pytest.mark.parametrize("name", NAMES)
def test_backend_of_the_command_line_stands_in_place_of_the_scenario_s(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(f"{SCENARIO}simulate: {{backend: auto}}\n")
    assert json_of(capsys, "--backend", name, str(path)) == name


@pytest.mark.parametrize("name", NAMES)
def test_print_tells_the_backend(name: str) -> None:
    first, *_ = str(sw.simulate(CASE_A, CHAIN, backend=name, waves="primary")).splitlines()  # type: ignore[arg-type]
    assert "rkn86" in first
    assert name in first


def test_a_method_of_another_kind_runs_in_numpy() -> None:
    short = attrs.evolve(CHAIN, granules=10)
    assert sw.simulate(CASE_A, short, integrator="rk4", step=0.1, waves="primary").backend == "numpy"


@pytest.fixture
def without(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if shockwave had been installed without a compiler."""
    from shockwave.measurement.simulate import plan_of

    monkeypatch.setattr(backend, "compiled", None)
    plan_of.cache_clear()
    yield
    plan_of.cache_clear()


@pytest.mark.usefixtures("without")
def test_a_backend_that_is_not_there_is_refused_with_the_reason() -> None:
    with pytest.raises(sw.InvalidValueError, match=r"backend: must be auto or numpy here .* needs a C compiler"):
        sw.simulate(CASE_A, CHAIN, backend="compiled")


@pytest.mark.usefixtures("without")
def test_what_is_left_to_choose_falls_back_to_numpy_with_the_same_answer() -> None:
    result = sw.simulate(CASE_A, CHAIN)
    assert result.backend == "numpy"
    assert result.peak_force == run("A", "numpy", "rkn86", 1e-6).peak_force


@compiled_alone
def test_what_is_left_to_choose_is_the_compiled_code() -> None:
    assert sw.simulate(CASE_A, CHAIN).backend == "compiled"


@pytest.mark.usefixtures("without")
def test_list_tells_what_is_not_there(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "backends", "--json"]) == 0
    rows = {row["name"]: row["problem"] for row in json.loads(capsys.readouterr().out)}
    assert "needs a C compiler" in rows["compiled"]
    assert rows["numpy"] is None


@compiled_alone
def test_list_tells_both_backends(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "backends", "--json"]) == 0
    rows = {row["name"]: row["problem"] for row in json.loads(capsys.readouterr().out)}
    assert rows == {"compiled": None, "numpy": None}


# ---------------------------------------------------------------- buffers

PROBLEM = ChainProblem(sw.PowerLaw(rise_exponent=0.5, decay_exponent=1, duration_ratio=3), 2.0, 1.0)
TABLEAU: Tableau = Rkn86.tableau


class Buffers(ModuleType):
    """Stands in for the compiled code and keeps what it is given."""

    def primary(self, *arguments: object) -> None:
        self.kept = list(arguments)


def primary_buffers() -> list[object]:
    """What `primary` takes for case A: method, jobs, rows, coefficients, stops, wanted, found, lanes."""
    buffers = Buffers("buffers")
    find_primaries([Asked(PROBLEM, 1e-6, 1e-6, (9,))], Rkn86, buffers)
    return [each.copy() if isinstance(each, np.ndarray) else each for each in buffers.kept]


def attempt_buffers() -> list[object]:
    """What `attempt` takes for ten granules: method, rows, coefficients, state, after, and four numbers."""
    path = PROBLEM.path
    packed, rows, coefficients = (array.copy() for array in (TABLEAU.packed, path.rows, path.coefficients))
    return [packed, rows, coefficients, np.zeros(30), np.zeros(30), 0.0, 0.1, 2.0, 1.0]


def read_only(array: np.ndarray) -> np.ndarray:
    array.flags.writeable = False
    return array


MISFITS = {
    "short-method": (0, lambda a: a[:-1].copy(), ValueError),
    "empty-method": (0, lambda a: a[:0], ValueError),
    "method-of-100-stages": (0, lambda a: np.append(100.0, a[1:]), ValueError),
    "short-found": (6, lambda a: a[:, :-1].copy(), ValueError),
    "read-only-found": (6, read_only, (ValueError, BufferError)),
    "read-only-passages": (5, read_only, (ValueError, BufferError)),
    "strided-found": (6, lambda a: np.zeros((1, 2 * a.size))[:, ::2], (ValueError, BufferError)),
    "two-jobs": (1, lambda a: np.append(a, a), ValueError),
    "half-a-job": (1, lambda a: np.append(a, a[:7]), ValueError),
    "list": (1, lambda a: a.tolist(), TypeError),
    "none": (4, lambda a: None, TypeError),
    "three-lanes": (7, lambda a: 3, ValueError),
    "no-lanes": (7, lambda a: 0, ValueError),
    "lanes-of-text": (7, lambda a: "8", TypeError),
}


@compiled_alone
@pytest.mark.parametrize("name", MISFITS)
def test_buffers_that_do_not_fit_a_search_are_refused(name: str) -> None:
    index, change, error = MISFITS[name]
    arguments = primary_buffers()
    arguments[index] = change(arguments[index])
    with pytest.raises(error):
        backend.compiled.primary(*arguments)  # type: ignore[union-attr]


@compiled_alone
def test_buffers_that_fit_are_filled() -> None:
    arguments = primary_buffers()
    backend.compiled.primary(*arguments)  # type: ignore[union-attr]
    assert arguments[6].flat[0] == KNOWN  # type: ignore[index]
    # the peak of case A at contact 9
    assert arguments[5][2] == pytest.approx(1.490253931405876, rel=1e-6)  # type: ignore[index]


ATTEMPT_MISFITS = {
    "short-method": (0, lambda a: a[:-1].copy(), ValueError),
    "no-state": (3, lambda a: a[:0], ValueError),
    "short-state": (3, lambda a: a[:-3].copy(), ValueError),
    "short-after": (4, lambda a: a[:-3].copy(), ValueError),
    "read-only-after": (4, read_only, (ValueError, BufferError)),
    "time-of-text": (5, lambda a: "now", TypeError),
}


@compiled_alone
@pytest.mark.parametrize("name", ATTEMPT_MISFITS)
def test_buffers_that_do_not_fit_a_step_are_refused(name: str) -> None:
    index, change, error = ATTEMPT_MISFITS[name]
    arguments = attempt_buffers()
    arguments[index] = change(arguments[index])
    with pytest.raises(error):
        backend.compiled.attempt(*arguments)  # type: ignore[union-attr]


@compiled_alone
@pytest.mark.parametrize("function", ["primary", "attempt"])
@pytest.mark.parametrize("change", [-1, 1], ids=["one-too-few", "one-too-many"])
def test_a_wrong_number_of_arguments_is_refused(function: str, change: int) -> None:
    arguments = primary_buffers() if function == "primary" else attempt_buffers()
    arguments = arguments[:-1] if change < 0 else [*arguments, 0.0]
    with pytest.raises(TypeError, match="arguments"):
        getattr(backend.compiled, function)(*arguments)


# Numbers that lead beyond a buffer: tried in processes of their own, for they may end them. The last
# columns of a job are: first piece and number of pieces, first coefficient, first stop, first and number of wanted.
HUGE = {"granules": 3, "piece": -6, "pieces": -5, "coefficient": -4, "stop": -3, "wanted": -2, "number-wanted": -1}
LEADS = {
    "piece": ("primary", "a[1][-6] = 1e6"),
    "negative-piece": ("primary", "a[1][-6] = -1e6"),
    "pieces": ("primary", "a[1][-5] = 1e9"),
    "no-pieces": ("primary", "a[2] = np.empty(0)"),
    "coefficient": ("primary", "a[1][-4] = 1e7"),
    "no-coefficients": ("primary", "a[3] = np.empty(0)"),
    "begin-of-terms": ("primary", "a[2][0, 2] = 1e9"),
    "number-of-terms": ("primary", "a[2][0, 3] = 1e9"),
    "stop": ("primary", "a[1][-3] = 1e7"),
    "no-stops": ("primary", "a[4] = np.empty(0)"),
    "stops-before-the-end": ("primary", "a[4][-1] = 1.0"),
    "wanted": ("primary", "a[1][-2] = 1e7"),
    "number-wanted": ("primary", "a[1][-1] = 1e7"),
    # beyond every whole number, to which they are converted
    **{f"huge-{name}": ("primary", f"a[1][{column}] = 1e299") for name, column in HUGE.items()},
    "stages-that-are-no-number": ("primary", "a[0][0] = np.nan"),
    "step-without-coefficients": ("attempt", "a[2] = np.empty(0)"),
    "step-with-terms-beyond": ("attempt", "a[1][0, 3] = 1e9"),
    "step-with-part-of-a-row": ("attempt", "a[1] = np.zeros(3)"),
    "step-with-rows-of-nothing": ("attempt", "a[1] *= np.nan"),
}
TRIAL = """
import sys; sys.path.insert(0, 'tests')
import os, signal
from test_backends import *

for name, (function, change) in LEADS.items():
    child = os.fork()
    if not child:
        signal.alarm(600)  # what is accepted may run for ever
        a = primary_buffers() if function == 'primary' else attempt_buffers()
        exec(change)
        try:
            getattr(backend.compiled, function)(*a)
        except ValueError:
            os._exit(0)
        os._exit(1)
    _, status = os.waitpid(child, 0)
    print(name, 'accepted' if status > 255 else 'crashed' if status else 'refused')
"""


@cache
def outcomes() -> dict[str, str]:
    done = subprocess.run([sys.executable, "-c", TRIAL], capture_output=True, text=True, check=True, timeout=1200)
    return dict(line.split() for line in done.stdout.splitlines())


@compiled_alone
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a process for each")
@pytest.mark.parametrize("name", LEADS)
def test_numbers_that_lead_beyond_a_buffer_are_refused(name: str) -> None:
    assert outcomes()[name] == "refused"


@compiled_alone
@pytest.mark.parametrize("column", [3, 8], ids=["granules", "rear"])
def test_a_count_far_beyond_what_is_reached_changes_nothing(column: int) -> None:
    arguments = primary_buffers()
    arguments[1][column] = 1e18  # type: ignore[index]
    backend.compiled.primary(*arguments)  # type: ignore[union-attr]
    assert arguments[5][2] == pytest.approx(1.490253931405876, rel=1e-6)  # type: ignore[index]


# ---------------------------------------------------------------- no request at all


@pytest.mark.parametrize("name", NAMES)
def test_no_request_is_answered_with_nothing(name: str) -> None:
    assert find_primaries([], Rkn86, backend.chosen(name)) == []


@compiled_alone
def test_lanes_side_by_side_do_not_feel_one_another() -> None:
    requests = [Asked(attrs.evolve(PROBLEM, rise_time=float(time)), 1e-6, 1e-6) for time in np.linspace(0.1, 5, 19)]
    together = find_primaries(requests, Rkn86, backend.compiled)
    assert together == [find_primaries([request], Rkn86, backend.compiled)[0] for request in requests]
