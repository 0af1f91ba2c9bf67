"""The command line: what it prints, where, and how it ends."""

import argparse
import atexit
import gc
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

import shockwave as sw
from shockwave.answers import settings_of
from shockwave.base.errors import Fault
from shockwave.cli import scenario_commands
from shockwave.cli.output import report_as_usage
from shockwave.engine.backend import lack
from shockwave.simulation import simulate
from support.command_line import shockwave, unwrapped

ROOT = Path(__file__).parents[2]
PAPER = ROOT / "profiles" / "paper"
SCENE = str(PAPER / "table2-row1.yaml")
TRAIN = str(PAPER / "table1-row1.yaml")
ALL_SCENES = [file for file in sorted((ROOT / "profiles").rglob("*.yaml")) if "\nsweep:" not in file.read_text()]

# Lines of the text on one scene, unless more is asked for.
MOST_LINES = 14
# A chain that section 4 does not cover.
LAYERS = str(ROOT / "profiles" / "validation" / "layers.yaml")

SOFT = """
chain: {material: {youngs_modulus: 1e9, poisson_ratio: 0.3, density: 1000}, radius: 1e-3}
shock: {profile: triangular, peak_force: 10, rise_time: 1e-5, duration_ratio: 3}
"""


@pytest.fixture
def bad(tmp_path: Path) -> str:
    """A file with two errors, of which the first is in line 2."""
    file = tmp_path / "bad.yaml"
    file.write_text(SOFT.replace("density: 1000", "density: 0").replace("rise_time: 1e-5", "rise_time: 3 kg"))
    return str(file)


def test_a_command_inside_a_program_leaves_its_garbage_collection_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    registered: list[object] = []
    monkeypatch.setattr(atexit, "register", registered.append)
    before = gc.get_threshold()
    assert shockwave("predict", SCENE).status == 0
    assert (registered, gc.get_threshold()) == ([], before)


def test_the_installed_command_is_that_of_the_module() -> None:
    scripts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["scripts"]
    module, _, name = scripts["shockwave"].partition(":")
    assert f"from {module} import {name}" in (ROOT / "shockwave" / "__main__.py").read_text(encoding="utf-8")


@pytest.mark.parametrize("command", ["predict", "simulate", "compare", "validate"])
def test_json_of_one_file_is_an_object_and_of_two_a_list(command: str) -> None:
    one = shockwave(command, "--json", SCENE).document
    two = shockwave(command, "--json", SCENE, SCENE).document
    assert list(one) == list(two[0]) == list(two[1])
    assert one.get("scenario", "table 2 row 1") == "table 2 row 1"


# ---------------------------------------------------------------- one scene on a few lines


@pytest.mark.parametrize("command", ["predict", "simulate", "compare"])
@pytest.mark.parametrize("scene", ALL_SCENES, ids=lambda scene: f"{scene.parent.stem}-{scene.stem}")
def test_one_scene_takes_few_lines(scene: Path, command: str) -> None:
    # a verdict is a line more
    limit = [] if str(scene) in (SCENE, LAYERS) else ["--limit", "60 N"]
    answer = shockwave(command, *limit, scene)
    assert (answer.status, answer.err) == (0, "")
    lines = answer.out.splitlines()
    assert 1 < len(lines) <= MOST_LINES
    assert lines[0].startswith(f"{sw.load_scenario(scene).name}: ")
    assert ("verdict  " in answer.out) == bool(limit)


@pytest.mark.parametrize("command", ["predict", "simulate", "compare"])
@pytest.mark.parametrize("scene", [SCENE, LAYERS], ids=["endless", "layers"])
def test_verbose_shows_more_than_the_few_lines(scene: str, command: str) -> None:
    shown = shockwave(command, "--verbose", scene).out
    assert "--verbose" not in shown
    assert f"\n  {'impact' if scene == LAYERS else 'shock'}  " in shown  # the scene
    assert len(shown.splitlines()) > MOST_LINES


@pytest.mark.parametrize("arguments", [["predict"], ["predict", "--model", "section-4"], ["compare"]], ids=" ".join)
def test_the_decision_of_section_4_is_shown_on_request(arguments: list[str]) -> None:
    shown = [shockwave(*arguments, "--wide", *more, SCENE).out for more in ([], ["--explain"], ["--verbose"])]
    trace = sw.predict(SCENE).trace
    assert trace is not None
    decision = [*(inequality.statement for inequality in trace), "a2 >= a1", "alphaF0 A F0^(-1/6) its passage time"]
    assert [[part in unwrapped(text) for part in decision] for text in shown] == [
        [False] * len(decision),
        [True] * len(decision),
        [True] * len(decision),
    ]
    assert len(shown[2]) > len(shown[1])


# ---------------------------------------------------------------- predictions without an answer, and those for walls


@pytest.fixture
def slow(tmp_path: Path) -> str:
    """A shock that is too long for the engine, whatever its time limit."""
    file = tmp_path / "slow.yaml"
    file.write_text(f"name: slow\n{SOFT.replace('rise_time: 1e-5', 'rise_time: 10')}")
    return str(file)


def test_a_prediction_without_an_answer_ends_with_1_and_prints_its_reason(slow: str) -> None:
    answer = shockwave("predict", slow)
    assert answer.status == 1
    assert answer.out.startswith("slow: no answer: the shock lasts ")
    # section 4 alone has an answer
    assert shockwave("predict", "--model", "section-4", slow).status == 0


def test_a_prediction_without_an_answer_keeps_those_of_other_files(slow: str) -> None:
    answer = shockwave("predict", "--json", slow, SCENE)
    assert answer.status == 1
    first, second = answer.document
    assert first["reason"].startswith("the shock lasts ")
    assert (second["reason"], second["peak_force"]) == (None, sw.predict(SCENE).peak_force)
    assert first["peak_force"] is None
    answer = shockwave("predict", slow, SCENE)
    assert answer.status == 1
    rows = table_of(answer.out)
    assert rows["slow"]["peak force"] == "no answer"
    assert rows["table 2 row 1"]["peak force"].endswith(" N")


def test_a_table_of_predictions_has_the_forces_on_walls(tmp_path: Path) -> None:
    files = []
    for name, more in (("three", ", granules: 3, end: {wall: same}"), ("six", ", granules: 6, end: {wall: rigid}")):
        files.append(tmp_path / f"{name}.yaml")
        files[-1].write_text(f"name: {name}\n{SOFT.replace('radius: 1e-3', f'radius: 1e-3{more}')}")
    rows = table_of(shockwave("predict", *files, SCENE).out)
    for file in files:
        force, unit = rows[file.stem]["wall force"].split()
        # the digits that are printed
        assert float(force) == pytest.approx(sw.predict(file).transmitted.peak_force, rel=1e-6)
        assert unit == "N"
    assert rows["table 2 row 1"]["wall force"] == "-"


def table_of(text: str) -> dict[str, dict[str, str]]:
    """Cells of a printed table by scenario and column."""
    header, _, *rows = (re.split(r"  +", line.strip()) for line in text.partition("\n\n")[0].splitlines())
    return {row[0]: dict(zip(header, row, strict=True)) for row in rows if len(row) == len(header)}


# ---------------------------------------------------------------- settings of a prediction


def test_section_4_alone_is_asked_for_by_name() -> None:
    paper = sw.predict(SCENE, model="section-4")
    assert shockwave("predict", "--model", "section-4", "--json", SCENE).document == paper.to_dict()
    assert (paper.method, paper.low, paper.high) == ("section-4", None, None)
    shown = shockwave("predict", "--model", "section-4", "--limit", "60 N", SCENE).out
    assert shown.startswith("table 2 row 1: leading wave 52.5 N by section 4, error not known\n")
    assert "verdict           undecided for the limit of 60 N" in shown


def test_section_4_is_refused_for_other_chains_in_their_place() -> None:
    answer = shockwave("predict", "--model", "section-4", "--json", LAYERS, SCENE)
    assert answer.status == 3
    refused, answered = answer.document
    features = ("8:7: chain.granules[1]", "14:3: chain.end", "15:3: chain.damping", "16:1: impact")
    assert [line.rpartition(": must be left out")[0] for line in answer.err.splitlines()] == [
        f"{LAYERS}:{feature}" for feature in features
    ]
    assert refused["error"] + "\n" == answer.err
    assert answered["method"] == "section-4"


#: Options of a prediction, and what they are in Python.
SETTINGS: dict[str, tuple[list[str], dict[str, Any]]] = {
    "rtol": (["--rtol", "1e-9"], {"rtol": 1e-9}),
    "minus-sign": (["--rtol", "1e\u22129"], {"rtol": 1e-9}),
    "integrator": (["--integrator", "rkn64"], {"integrator": "rkn64"}),
    "fixed step": (["--integrator", "verlet", "--step", "0.05"], {"integrator": "verlet", "step": 0.05}),
    "contacts": (["--contacts", "3,8"], {"contacts": (3, 8)}),
    "alpha": (["--set", "predict.alpha=literal"], {"alpha": "literal"}),
    "coefficient": (["--set", "predict.momentum_coefficient=4.2"], {"momentum_coefficient": 4.2}),
    "named coefficient": (["--set", "predict.momentum_coefficient=exact"], {"momentum_coefficient": "exact"}),
    "tolerance": (["--set", "predict.equal_tolerance=0.001"], {"equal_tolerance": 0.001}),
    "quadrature": (["--set", "predict.quadrature=tanh-sinh"], {"quadrature": "tanh-sinh"}),
}


@pytest.mark.parametrize("name", SETTINGS)
def test_predict_takes_settings_of_the_prediction_and_options_of_the_simulation(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    arguments, settings = SETTINGS[name]
    scenarios, real = [], sw.predict
    monkeypatch.setattr(scenario_commands.answers, "predict", lambda scene: scenarios.append(scene) or real(scene))
    shown = shockwave("predict", "--json", *arguments, TRAIN).document
    (scenario,) = scenarios
    expected = settings_of(sw.load_scenario(TRAIN), settings)
    assert (scenario.predictor, scenario.simulate) == expected != settings_of(sw.load_scenario(TRAIN), {})
    assert shown == real(TRAIN, **settings).to_dict()
    # forces at contacts are in the table of the result alone
    assert (shown == real(TRAIN).to_dict()) == (name == "contacts")


def test_compare_shows_the_eight_rows_of_the_paper_with_published_figures() -> None:
    text = shockwave("compare", "--wide", "--rtol", "1e-4", *sorted(PAPER.glob("*.yaml"))).out
    rows = [line.split("  ")[0] for line in text.splitlines() if line.startswith("table ")]
    assert rows == [f"table {table} row {row}" for table, last in ((1, 3), (2, 5)) for row in range(1, last + 1)]
    assert all(figure in text for figure in ("+3.2 %", "3 %", "14.4 us", "+1.5 %", "2.9 %"))
    text = shockwave("compare", "--wide", "--rtol", "1e-4", SCENE).out
    assert re.search("published +error 3 %, virtual rise time 14.4 us [(]Hasan & Nemat-Nasser,", text)


@pytest.mark.parametrize("scene", [*sorted(PAPER.glob("*.yaml")), Path(LAYERS)], ids=lambda scene: scene.stem)
def test_a_comparison_has_the_numbers_of_the_predictions(scene: Path) -> None:
    found = shockwave("compare", "--json", "--rtol", "1e-4", scene).document
    assert found["simulated"]["error_estimate"] < 1e-4
    if str(scene) == LAYERS:  # beyond equal spheres, without a limit of the leading wave
        assert (found["predicted"], found["errors"], found["agrees"]) == (None, None, None)
        assert found["reason"].startswith(f"{scene}:")
        return
    paper = shockwave("predict", "--json", "--model", "section-4", scene).document
    assert found["predicted"]["peak_force"] == paper["peak_force"]
    assert found["errors"]["peak_force"] == paper["peak_force"] / found["simulated"]["peak_force"] - 1
    predicted = shockwave("predict", "--json", "--rtol", "1e-4", scene).document
    assert predicted["peak_force"] == found["simulated"]["peak_force"]
    assert predicted["section4"]["error"] == found["errors"]["peak_force"]


def test_validate_reports_every_error_of_every_file_and_ends_with_the_greatest_status(bad: str) -> None:
    answer = shockwave("validate", bad, SCENE)
    assert answer.status == 3
    *lines, last = answer.out.splitlines()
    assert [line.split(": ")[1] for line in lines] == ["chain.material.density", "shock.rise_time"]
    assert last == f"{SCENE}: valid"
    answer = shockwave("validate", "--json", "nowhere.yaml", bad, SCENE)
    assert answer.status == 5
    first, second, third = answer.document
    assert (first["valid"], second["valid"], third["valid"]) == (False, False, True)
    assert "nowhere.yaml" in first["faults"][0]["problem"]


def test_validate_reports_an_unknown_quantity_of_a_sweep_with_its_place(tmp_path: Path) -> None:
    scene = tmp_path / "scene.yaml"
    grid = "sweep:\n  run: predict\n  grid: {shock.peak_force: [1 N, 2 N]}\n  quantities: [wall.peak]\n"
    scene.write_text(Path(SCENE).read_text(encoding="utf-8") + grid, encoding="utf-8")
    answer = shockwave("validate", str(scene))
    assert answer.status == 3
    assert re.search(r"scene\.yaml:\d+:16: sweep\.quantities\[0\]: .*known: relation, peak_force", answer.out)


def test_invalid_files_stop_the_others_and_end_with_the_greatest_of_their_statuses(bad: str) -> None:
    answer = shockwave("predict", "--json", SCENE, bad)
    assert (answer.status, answer.out, f"{bad}:2:" in answer.err) == (3, "", True)
    answer = shockwave("simulate", bad, "nowhere.yaml")
    assert (answer.status, f"{bad}:2:" in answer.err, "nowhere.yaml" in answer.err) == (5, True, True)


def test_an_error_of_an_argument_is_one_of_usage_and_an_error_of_the_scene_is_not() -> None:
    options = argparse.Namespace(rtol=1.0)
    wrong = [Fault("rtol", "must be smaller"), Fault("chain.radius", "must be larger")]
    with pytest.raises(sw.UsageError, match=r"^--rtol: must be smaller$"), report_as_usage(options):
        raise sw.InvalidValueError(*wrong[:1])
    with pytest.raises(sw.InvalidValueError), report_as_usage(options):
        raise sw.InvalidValueError(*wrong)


#: Arguments that are wrong, and what is printed of them.
WRONG = {
    "command": (["predct", SCENE], "unknown command (got 'predct'; did you mean 'predict'? known: predict, simulate"),
    "column-twice": (["plot", "x", "--column", "a", "--column=b"], "--column: must be given once (got it again; "),
    "output-twice": (["spectrum", SCENE, "-o", "a.png", "--output", "b.csv"], "--output: must be given once ("),
    "default-twice": (["design", SCENE, "--points", "9", "--points", "7"], "--points: must be given once (got it "),
    "limit-twice": (
        ["predict", SCENE, "--limit", "60 N", "--limit=5 N"],
        "--limit: must give limit.force only once (got '60 N'",
    ),
    "set-twice": (
        ["predict", SCENE, "--rtol=1e-4", "--set", "simulate.rtol=1e-5"],
        "--set: must give simulate.rtol only once",
    ),
    "option": (["predict", "--jsn", SCENE], "unknown option (got '--jsn'; did you mean '--json'? known: "),
    "abbreviation": (["predict", "--verb", SCENE], "unknown option (got '--verb'; did you mean '--verbose'? "),
    "option-of-all": (["--vrsion"], "unknown option (got '--vrsion'; did you mean '--version'? "),
    "short-option": (["predict", SCENE, "-x", "3"], "unknown option (got '-x'; known: --help, "),
    "option-of-a-key": (["predict", SCENE, "--until", "1"], "(got '--until'; use `--set simulate.until=VALUE`)"),
    "one-more": (["new", "foo"], "unrecognized arguments: foo (see `shockwave new --help`)"),
    "picture": (["uncertainty", SCENE, "-o", "x.csv"], "--output: must end in .svg, .png or .pdf (got x.csv)"),
    "file": (["predict"], "the following arguments are required: FILE (see `shockwave predict --help`)"),
    "kind": (["list", "profils"], "KIND: unknown name (got 'profils'; did you mean 'profiles'? "),
    "family": (["bench", "--family", "integrator"], "--family: unknown name (got 'integrator'; did you mean "),
    "word": (["simulate", "--rtol", "soon", SCENE], "--rtol: simulate.rtol: must be a number, such as "),
    "range": (
        ["simulate", "--rtol", "1e-20", SCENE],
        "--rtol: simulate.rtol: must be >= 1e-13 and <= 0.01 (got 1e-20)",
    ),
    "contacts": (
        ["simulate", "--contacts=-2,-1", SCENE],
        "--contacts: simulate.contacts[1]: must be a whole number >= 0 and <= 1e+12 (got -1)",
    ),
    "sweep-into-a-stream": (["sweep", SCENE, "-o", "-"], "--output: must be a folder, not standard input or output"),
    "plot-of-a-stream": (["plot", "-"], "FOLDER: must be a folder, not standard input or output (got '-')"),
    "no-worker": (["sweep", SCENE, "--workers", "0"], "--workers: must be >= 1 and <= 10000 (got 0)"),
    "integrator": (["predict", SCENE, "--integrator", "nope"], "--integrator: simulate.integrator: unknown integrator"),
    "quadrature": (["compare", SCENE, "--set", "predict.quadrature=tanh"], "(got 'tanh'; did you mean 'tanh-sinh'?"),
    "model": (["predict", SCENE, "--model", "section4"], "or 'section-4' (got 'section4'; did you mean 'section-4'?)"),
    "model-of-a-comparison": (["compare", SCENE, "--model", "best"], "unknown option (got '--model'; "),
    "limit": (
        ["uncertainty", "--limit", "60 kg", SCENE],
        "--limit: limit.force: must be a force, such as '100 N' (got '60 kg'",
    ),
    "check-of-profiles": (["list", "profiles", "--check"], "--check: can be used only with plugins"),
    "page-as-pdf": (["report", SCENE, "-o", "x.pdf"], "--output: must end in .html or .htm (got x.pdf; print this"),
}


def test_usual_spellings_of_help_and_version_are_accepted() -> None:
    assert shockwave("help", "new").out == shockwave("new", "--help").out
    assert shockwave("-V").out == shockwave("--version").out


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_call_is_a_usage_error(name: str) -> None:
    arguments, problem = WRONG[name]
    answer = shockwave(*arguments)
    assert answer.status == 2
    assert problem in answer.err


def test_the_version_states_the_back_end() -> None:
    state = re.escape(f"numpy; compiled code {lack()}" if lack() else "compiled")
    assert re.fullmatch(rf"shockwave {re.escape(sw.__version__)} \(back end: {state}\)\n", shockwave("--version").out)


def test_without_compiled_code_the_version_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shockwave.engine.backend.compiled", None)
    assert "(back end: numpy; compiled code not built: needs a C compiler" in shockwave("--version").out


@pytest.mark.parametrize("command", ["predict", "simulate"])
@pytest.mark.parametrize("new", ["peak_force: 1e-300", "peak_force: 1e300", "rise_time: 1e-300", "rise_time: 1e300"])
def test_a_scene_beyond_floating_point_numbers_fails_alone(command: str, new: str, tmp_path: Path) -> None:
    extreme = tmp_path / "extreme.yaml"
    name = new.partition(":")[0]
    extreme.write_text(re.sub(rf"{name}: [^,]+", new, SOFT))
    answer = shockwave(command, "--json", extreme, SCENE)
    assert answer.status == 3
    first, second = answer.document
    assert f"{name}: must" in first["error"]
    assert second["peak_force"] > 0


def strike(monkeypatch: pytest.MonkeyPatch, *errors: BaseException | None) -> list[object]:
    """Let the first calls of a simulation raise these errors, if they are not None; gives the calls."""
    real, calls = simulate.simulate_scene, []

    def struck(*arguments: Any) -> object:
        calls.append(arguments)
        error = errors[len(calls) - 1] if len(calls) <= len(errors) else None
        return real(*arguments) if error is None else raised(error)

    monkeypatch.setattr(simulate, "simulate_scene", struck)
    return calls


def test_runs_that_fail_keep_the_others_and_end_with_the_greatest_of_their_statuses(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    errors = sw.InvalidValueError.of("rtol", "must be larger"), sw.NumericalError("the step size vanished")
    strike(monkeypatch, *errors)
    answer = shockwave("simulate", "--json", "--rtol", "1e-2", SCENE, SCENE, SCENE)
    assert answer.status == 3
    _, second, third = answer.document
    assert second == {"version": 2, "scenario": "table 2 row 1", "error": "the step size vanished"}
    assert third["peak_force"] == pytest.approx(50.88311, rel=1e-2)
    assert answer.err.index("must be larger") < answer.err.index("the step size vanished")


def raised(error: BaseException) -> None:
    raise error


def test_an_interrupt_of_any_command_ends_with_130(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scenario_commands, "load_with_changes", lambda *_: raised(KeyboardInterrupt()))
    answer = shockwave("validate", SCENE)
    assert (answer.status, answer.err) == (130, "interrupted\n")


@pytest.mark.parametrize("form", [["--json"], []], ids=["json", "text"])
def test_an_interrupt_keeps_the_results_before_it(form: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    calls = strike(monkeypatch, None, KeyboardInterrupt())
    answer = shockwave("simulate", *form, "--rtol", "1e-2", SCENE, SCENE, SCENE)
    assert (answer.status, answer.out.count("table 2 row 1")) == (130, 1)
    assert ("ejected" in answer.out, len(calls)) == (True, 2)
    assert f"{SCENE}: interrupted" in answer.err


@pytest.mark.parametrize("form", [["--json"], []], ids=["json", "text"])
def test_a_result_that_fails_when_it_is_printed_fails_alone(form: list[str], tmp_path: Path) -> None:
    scene = tmp_path / "short.yaml"
    scene.write_text(f"{SOFT.replace('radius: 1e-3', 'radius: 1e-3, granules: 100')}simulate: {{until: 1 ps}}\n")
    answer = shockwave("simulate", *form, scene, SCENE)
    assert answer.status == 3
    assert "table 2 row 1" in answer.out
    assert f"{scene}:" in answer.err


def test_an_internal_error_is_one_line_without_a_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sw.Predictor, "predict_scene", lambda *_: 1 / 0)
    answer = shockwave("predict", SCENE)
    assert answer.status == 1
    assert "internal error: ZeroDivisionError" in answer.err


#: Redirections of a shell, a command, its status, and what is then written on stderr.
STREAMS = {
    "closed": (">&-", "list backends", 5, "error of the operating system: Bad file descriptor (SHOCKWAVE_DEBUG=1"),
    "full": (">/dev/full", "list backends", 5, "error of the operating system: No space left on device (SHOCK"),
    "all closed": ("<&- >&- 2>&-", "list backends", 5, ""),
    "no errors": ("2>&-", "list backends", 0, ""),
    "errors closed": ("2>&-", "predict nowhere.yaml", 5, ""),
    "errors on a full disk": ("2>/dev/full", "predict nowhere.yaml", 5, ""),
}


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
@pytest.mark.parametrize("case", STREAMS)
def test_streams_that_cannot_be_written_end_with_a_documented_status(case: str) -> None:
    redirection, command, status, lost = STREAMS[case]
    words = ["sh", "-c", f'"$0" -m shockwave {command} {redirection}', sys.executable]
    run = subprocess.run(words, capture_output=True, text=True, cwd=ROOT)
    assert (run.returncode, run.stderr[: len(lost) or None]) == (status, lost)


def test_workers_start_without_standard_streams(tmp_path: Path) -> None:
    scene = (ROOT / SCENE).read_text(encoding="utf-8")
    (tmp_path / "sweep.yaml").write_text(scene + "\nsweep: {grid: {shock.peak_force: [1 N, 2 N, 3 N]}}\n")
    words = ["sh", "-c", '"$0" -m shockwave sweep sweep.yaml -o results --workers 2 <&- 2>&-', sys.executable]
    run = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path)
    assert run.returncode == 0
    assert (tmp_path / "results" / "results.csv").exists()


def test_an_error_of_the_system_names_the_file(monkeypatch: pytest.MonkeyPatch) -> None:
    error = PermissionError(13, "Permission denied", "library.so")
    monkeypatch.setattr(scenario_commands, "load_with_changes", lambda *_: raised(error))
    answer = shockwave("validate", SCENE)
    assert answer.status == 5
    assert answer.err.startswith("library.so: error of the operating system: Permission denied (")
