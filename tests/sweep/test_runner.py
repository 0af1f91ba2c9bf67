"""Sweeps: every point once, with the result of its own scene; resumption, refusal and repair."""

import json
import os
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import shockwave as sw
from conftest import Install
from shockwave.scenario.scenario import load_scenario
from shockwave.scenario.variations import Family
from shockwave.scene.scene import Scene
from shockwave.simulation import simulate
from shockwave.sweep import definition, point_evaluation
from shockwave.sweep.progress_text import SweepInterrupt, SweepReport
from shockwave.sweep.runner import dry_run, points_of, run_sweep
from support.command_line import shockwave, unwrapped

CHAIN = "chain: {material: paper-steel, diameter: 9.5 mm}\n"
SHOCK = (
    "shock: {profile: power-law, peak_force: 100 N, rise_time: 5 us, duration_ratio: 3,"
    " parameters: {rise_exponent: 1, decay_exponent: 1}}\n"
)
GRID = "sweep: {grid: {shock.duration_ratio: [2, 4], shock.rise_time: {linspace: [2 us, 6 us, 20]}}}\n"
SIMULATE = "simulate: {rtol: 1e-4}\n"
# With the second value, the mass of a granule exceeds the range of a float.
BROKEN = "sweep: {grid: {chain.diameter: [1 mm, 1e200]}}\n"
MATERIALS = (
    "sweep: {run: predict, grid: "
    "{chain.material: [ptfe, {youngs_modulus: 203 GPa, poisson_ratio: 0.3, density: 7810}]}}\n"
)


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    return written(tmp_path, SIMULATE + GRID)


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the finished sweep of ``scenario``."""
    folder = tmp_path_factory.mktemp("whole")
    swept(written(folder, SIMULATE + GRID), folder / "out")
    return folder / "out"


@pytest.fixture
def finished(whole: Path, out: Path) -> Path:
    """The finished sweep of ``scenario`` in ``out``."""
    shutil.copytree(whole, out)
    return out


def written(folder: Path, text: str) -> Path:
    file = folder / "scene.yaml"
    file.write_text(CHAIN + SHOCK + text)
    return file


def swept(file: Path, folder: Path, **settings: Any) -> SweepReport:
    """Run in this process, without workers."""
    with ThreadPoolExecutor(1) as executor:
        return run_sweep(file, folder, executor, **settings)


def journal(folder: Path) -> list[dict[str, Any]]:
    """The finished points."""
    finished = change(folder, "SELECT number, status, results, problem FROM points")
    return [
        {"index": number, "status": status, "values": json.loads(results or "null"), "error": problem}
        for number, status, results, problem in finished
    ]


def change(folder: Path, statement: str) -> list[Any]:
    """Run a statement of SQL in the journal; if there is none, in an empty one."""
    with closing(sqlite3.connect(folder / "journal.sqlite")) as database, database:
        return database.execute(statement).fetchall()


def rows(folder: Path) -> dict[int, dict[str, Any]]:
    """Values by name for each point."""
    names = [column["name"] for column in json.loads((folder / "sweep.json").read_text())["columns"]]
    return {line["index"]: dict(zip(names, line["values"], strict=True)) for line in journal(folder)}


def scene_of(file: Path, point: dict[str, Any]) -> sw.Scenario:
    """The scenario of a point."""
    return evolve(Family(load_scenario(file)).scenario(point), sweep=None)


def tables(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.glob("results.*")}


# ---------------------------------------------------------------- points


def test_every_point_is_finished_once_with_the_result_of_its_own_scene(scenario: Path, out: Path) -> None:
    report = swept(scenario, out)
    assert (report.points, report.done, report.exit_code) == (40, 40, 0)
    assert sorted(line["index"] for line in journal(out)) == list(range(40))
    found = rows(out)[27]  # second duration ratio, eighth rise time
    shock = sw.Shock(
        profile=sw.PowerLaw(rise_exponent=1, decay_exponent=1, duration_ratio=4),
        peak_force=100.0,
        rise_time=load_scenario(scenario).sweep.point(27)["shock.rise_time"],  # type: ignore[union-attr]
    )
    alone = sw.simulate(shock, load_scenario(scenario).chain, rtol=1e-4, waves="primary")
    # equal to the last bit: results do not depend on the other shocks of the batch
    assert found["peak_force"] == alone.peak_force
    assert found["error_estimate"] == alone.error_estimate
    assert (found["momentum"], found["speed"]) == (alone.primary.momentum, alone.primary.speed)


SECTION4 = ["section4_regime", "section4_relation", "section4_peak_force", "section4_amplification", "section4_waves"]
SCALED = ["scaled_rise_time", "scaled_duration", "notes"]
SIMULATED = ["peak_force", "amplification", "error_estimate", "momentum", "speed", "width", "foot"]
ANSWER = ["relation", "peak_force", "low", "high", "amplification"]
#: Columns of each kind of sweep, which are part of the public interface.
COLUMNS = {
    "predict": [*ANSWER, *SECTION4, "section4_error", "applied_momentum", "virtual_rise_time", "added_momentum"],
    "simulate": SIMULATED,
    "compare": [*SIMULATED, "relation", *SECTION4, "error"],
}
#: The same in a chain before a wall, which section 4 does not cover.
WALLED = ["greatest_force", "greatest_contact", "greatest_time", "transmitted_force", "transmitted_impulse"]
WALLED += ["error_estimate", "dissipated_energy", "notes"]
WALL = CHAIN.replace("}", ", granules: 6, end: {wall: same}}")


@pytest.mark.parametrize("run", COLUMNS)
def test_columns_of_each_kind_of_sweep(tmp_path: Path, run: str) -> None:
    sweep = f"sweep: {{run: {run}, grid: {{shock.rise_time: [4 us, 20 us]}}}}\n"
    file = written(tmp_path, sweep)
    assert [column.name for column in points_of(file).definition.columns] == COLUMNS[run] + SCALED
    (tmp_path / "wall.yaml").write_text(WALL + SHOCK + sweep)
    assert [column.name for column in points_of(tmp_path / "wall.yaml").definition.columns] == WALLED


@pytest.mark.parametrize("model", ["best", "section-4"])
def test_a_prediction_has_the_values_of_its_document(tmp_path: Path, out: Path, model: str) -> None:
    settings = f"predict: {{model: {model}}}\n{SIMULATE}"
    file = written(tmp_path, settings + "sweep: {run: predict, grid: {shock.rise_time: [4 us, 1 ms]}}\n")
    swept(file, out)
    found = rows(out)
    regimes = []
    for index, rise_time in enumerate((4e-6, 1e-3)):
        scene = scene_of(file, {"shock.rise_time": rise_time})
        document, row = sw.predict(scene, waves="primary").to_dict(), found[index]
        paper, ejection = document["section4"], document["ejection"] or {}
        expected = {name: document[name] for name in (*ANSWER, "applied_momentum")}
        expected |= {f"section4_{name}": paper[name] for name in ("relation", "peak_force", "amplification", "error")}
        expected |= {"section4_regime": document["regime"], "section4_waves": len(paper["waves"])}
        expected |= {name: ejection.get(name) for name in ("virtual_rise_time", "added_momentum")}
        assert {name: row[name] for name in expected} == expected
        assert row.keys() - expected.keys() == set(SCALED)
        assert (row["low"] is None, row["section4_error"] is None) == (model == "section-4",) * 2
        regimes.append(row["section4_regime"])
    assert regimes == ["ejection", "train"]


@pytest.mark.parametrize("excitation", [SHOCK, "impact: {velocity: 0.5 m/s}\n"], ids=["shock", "striker"])
@pytest.mark.parametrize("run", COLUMNS)
def test_a_chain_with_a_wall_has_the_values_of_its_simulation(
    tmp_path: Path, out: Path, run: str, excitation: str
) -> None:
    file = tmp_path / "scene.yaml"
    sweep = f"sweep: {{run: {run}, grid: {{chain.end.wall: [same, rigid], 'chain.granules[0].count': [3, 4]}}}}\n"
    chain = WALL.replace("granules: 6", "granules: [{count: 4}]")
    file.write_text(f"{chain}{excitation}simulate: {{contacts: [1], rtol: 1e-4}}\n{sweep}")
    report = swept(file, out)
    assert (report.done, report.failed) == (4, 0)
    for index, row in rows(out).items():
        point = load_scenario(file).sweep.point(index)  # type: ignore[union-attr]
        alone = sw.simulate(scene_of(file, point))
        forces = (alone.greatest_force, alone.contacts[0], alone.transmitted)
        names = ("greatest_force", "force_1", "transmitted_force")
        # together with others the rounding of a step may differ
        expected = pytest.approx([force.peak_force for force in forces], rel=1e-12)
        assert [row[name] for name in names] == expected
        assert row.get("section4_peak_force") is None


@pytest.mark.parametrize("chain", [CHAIN, WALL], ids=["endless", "wall"])
def test_a_point_without_an_answer_is_done_and_its_reason_is_in_the_notes(
    tmp_path: Path, out: Path, chain: str
) -> None:
    file = tmp_path / "scene.yaml"
    sweep = "simulate: {timeout: 1e-6}\nsweep: {run: predict, grid: {shock.rise_time: [4 us, 20 us]}}\n"
    file.write_text(chain + SHOCK + sweep)
    report = swept(file, out)
    assert (report.done, report.failed, report.exit_code) == (2, 0, 0)
    for row in rows(out).values():
        assert re.search(r"^No answer: the time limit was reached.*\.$", row["notes"])
        known = {name for name, value in row.items() if value is not None}
        by_section4 = (
            {"applied_momentum", "scaled_rise_time", "scaled_duration", *SECTION4} if chain == CHAIN else set()
        )
        assert known - {"virtual_rise_time", "added_momentum"} == {"notes"} | by_section4


def test_a_comparison_has_the_values_of_section_4_and_of_the_simulation(tmp_path: Path, out: Path) -> None:
    file = written(tmp_path, "sweep: {zip: {shock.rise_time: [4 us, 20 us], chain.diameter: [8 mm, 10 mm]}}\n")
    swept(file, out)
    alone = sw.compare(scene_of(file, {"shock.rise_time": 2e-5, "chain.diameter": 1e-2}))
    found = rows(out)[1]
    assert found["section4_peak_force"] == alone.predicted.section4.peak_force  # type: ignore[union-attr]
    assert found["peak_force"] == alone.simulated.peak_force
    assert (found["error"], found["relation"]) == (alone.errors.peak_force, alone.relation)


def test_a_comparison_simulates_each_point_once(tmp_path: Path, out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = written(tmp_path, "limit: {force: 60 N}\nsweep: {run: compare, grid: {shock.rise_time: [4 us, 20 us]}}\n")
    run, counts = simulate.run_jobs, []
    monkeypatch.setattr(simulate, "run_jobs", lambda jobs, *rest: counts.append(len(jobs)) or run(jobs, *rest))
    assert swept(file, out).done == 2
    assert sum(counts) == 2


STEEL = {"youngs_modulus": 203e9, "poisson_ratio": 0.3, "density": 7810.0}
CROPS = (
    f"{CHAIN}shock: {{profile: tabulated, parameters: {{file: blow.csv}}}}\n"
    "sweep: {run: predict, grid: {shock.parameters.crop: [[0, 1.5 ms], [0, 1.6 ms]]}}\n"
)
#: A scenario, its variable, and the values of that.
NO_NUMBERS: dict[str, tuple[str, str, list[Any]]] = {
    "lists": (CROPS, "shock.parameters.crop", [[0.0, 0.0015], [0.0, 0.0016]]),
    "mappings": (CHAIN + SHOCK + MATERIALS, "chain.material", ["ptfe", STEEL]),
}


@pytest.mark.parametrize("case", NO_NUMBERS)
def test_mappings_and_lists_are_values_of_the_tables(tmp_path: Path, out: Path, case: str) -> None:
    pytest.importorskip("xarray")  # which needs pandas
    (tmp_path / "blow.csv").write_text("time [ms],force [N]\n0,0\n0.5,40\n1,20\n1.5,5\n1.6,0\n")
    text, name, values = NO_NUMBERS[case]
    (tmp_path / "scene.yaml").write_text(text)
    assert swept(tmp_path / "scene.yaml", out).done == 2
    lines = (out / "results.jsonl").read_text().splitlines()
    assert [json.loads(line)[name] for line in lines] == values
    results = sw.load_sweep(out)
    texts = [value if isinstance(value, str) else json.dumps(value) for value in values]
    assert results.coordinate(name).tolist() == texts
    assert [value for (value,) in results.to_dict()["axes"][0]["values"]] == values
    assert results.to_pandas().index.tolist() == texts
    assert results.to_xarray()[name.rpartition(".")[2]].values.tolist() == texts


@pytest.mark.parametrize("run", COLUMNS)
def test_warnings_of_a_point_are_in_its_notes(tmp_path: Path, out: Path, run: str) -> None:
    file = written(tmp_path, f"sweep: {{run: {run}, grid: {{chain.granules: [3, 100]}}}}\n")
    report = swept(file, out)
    assert (report.warned, str(report).count("! 1 point with warnings")) == (1, 1)
    notes = [json.loads(line)["notes"] for line in (out / "results.jsonl").read_text().splitlines()]
    assert notes[0].count("A longer chain shows the settled waves") == 1
    assert notes[1] is None
    assert sw.load_sweep(out).warnings == (f"In 1 of 2 points (0): {notes[0]}",)


def test_notes_on_a_record_are_no_warnings_of_a_sweep(tmp_path: Path, out: Path) -> None:
    (tmp_path / "blow.csv").write_text("time [ms],force [N]\n0,0\n0.5,40\n1,20\n1.5,5\n1.6,0\n")
    (tmp_path / "scene.yaml").write_text(CROPS.replace("1.5 ms", "1.6 ms").replace("predict", "simulate"))
    report = swept(tmp_path / "scene.yaml", out)
    results = sw.load_sweep(out)
    assert all("Note: The record was cropped" in notes for notes in results.values("notes"))
    assert (report.warned, results.warnings) == (0, ())


@pytest.mark.parametrize(("waves", "measured"), [("", False), (", waves: train", True)], ids=["default", "train"])
def test_the_train_is_measured_if_the_scenario_requests_it(
    tmp_path: Path, out: Path, waves: str, measured: bool
) -> None:
    block = f"simulate: {{rtol: 1e-3{waves}}}\nsweep: {{grid: {{shock.rise_time: [10 us]}}}}\n"
    swept(written(tmp_path, block), out)
    found = rows(out)[0]
    assert ("recoil_momentum" in found) == measured
    assert found.get("recoil_momentum", -1.0) < 0
    # the momentum of the leading wave as a single run measures it
    scene = scene_of(tmp_path / "scene.yaml", {"shock.rise_time": 1e-5})
    leading = sw.simulate(scene, waves="train" if measured else "primary").waves[0]
    assert (found["momentum"], found["foot"]) == (leading.momentum, leading.foot)


# ---------------------------------------------------------------- workers and resumption


def test_one_executor_runs_several_sweeps(tmp_path: Path) -> None:
    with ThreadPoolExecutor(1) as executor:
        for size in (8, 10):
            sweep = f"sweep: {{run: simulate, grid: {{chain.diameter: [{size} mm, 12 mm]}}}}\n"
            file, folder = written(tmp_path, SIMULATE + sweep), tmp_path / str(size)
            run_sweep(file, folder, executor)
            alone = sw.simulate(scene_of(file, {"chain.diameter": size / 1000}), waves="primary")
            assert rows(folder)[0]["peak_force"] == alone.peak_force


def test_results_do_not_depend_on_workers_or_interrupts(scenario: Path, whole: Path, out: Path) -> None:
    run_sweep(scenario, out, workers=2)
    assert tables(out) == tables(whole)
    # interrupted, and resumed
    change(out, "DELETE FROM points WHERE number % 3 == 0")
    assert swept(scenario, out).before == 26
    assert tables(out) == tables(whole)


def test_a_finished_sweep_has_nothing_to_do(scenario: Path, finished: Path, whole: Path) -> None:
    assert "nothing to do" in shockwave("sweep", scenario, "--output", finished, "--resume").out
    assert tables(finished) == tables(whole)


def test_units_and_names_do_not_change_the_sweep(scenario: Path, finished: Path) -> None:
    text = scenario.read_text().replace("9.5 mm", "0.95 cm").replace("[2 us, 6 us", "[2000 ns, 6e-6")
    scenario.write_text(f"name: another name\n{text}")
    assert swept(scenario, finished).before == 40


def test_records_are_found_from_any_folder_and_changed_records_are_refused(
    tmp_path: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, last in (("a", 20), ("b", 30)):
        (tmp_path / f"{name}.csv").write_text(f"time [us],force [N]\n0,0\n10,100\n{last},0\n")
    file = tmp_path / "scene.yaml"
    file.write_text(
        f"{CHAIN}{SIMULATE}shock: {{profile: tabulated, parameters: {{file: a.csv}}}}\n"
        "sweep: {grid: {shock.parameters.file: [a.csv, b.csv]}}\n"
    )
    monkeypatch.chdir(tmp_path)
    # the workers may run in another folder
    assert run_sweep(file.name, "out", workers=1).done == 2
    assert rows(out)[1]["peak_force"] > rows(out)[0]["peak_force"]
    content = point_evaluation.content_of(points_of(file.name))
    (tmp_path / "b.csv").write_text("time [us],force [N]\n0,0\n10,100\n40,0\n")
    # as on a worker with its own disk
    with pytest.raises(sw.UsageError, match=r"got a worker with named\.file b\.csv '\w+.*, now '\w+.*; install"):
        point_evaluation.run_batch(content, [0, 1])
    with pytest.raises(sw.InvalidValueError, match=r"got named\.file b\.csv"):
        swept(file, out)


# ---------------------------------------------------------------- refusals


CHANGED = {
    "setting": ("model: best", "model: section-4", r"scenario\.predict\.model 'best', now 'section-4'"),
    "value": ("7810", "7900", r"got axes\.chain\.material\.value\.2\.density 7810\.0, now 7900\.0; choose"),
    "number": ("[ptfe, ", "[ptfe, lead, ", r"got axes\.chain\.material\.number of values 2, now 3; axes"),
    "name": (
        "chain.material: ",
        "shock.peak_force: [1 N], chain.material: ",
        r"got axes\.shock\.peak_force None, now \{.*; order of axes 'chain\.material', now 'shock\.peak_force; ",
    ),
}


@pytest.mark.parametrize("case", CHANGED)
def test_another_sweep_is_refused_and_what_differs_is_named(tmp_path: Path, out: Path, case: str) -> None:
    old, new, message = CHANGED[case]
    text = "predict: {model: best}\n" + MATERIALS
    swept(written(tmp_path, text), out)
    with pytest.raises(sw.InvalidValueError, match=message):
        swept(written(tmp_path, text.replace(old, new)), out)


def test_another_version_must_be_accepted(scenario: Path, finished: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    change(finished, "DELETE FROM points WHERE number >= 30")
    monkeypatch.setattr(sw, "__version__", "99.0")
    with pytest.raises(sw.InvalidValueError, match=r"versions\.shockwave '0.*', now '99\.0'; use --accept-versions"):
        swept(scenario, finished)
    report = swept(scenario, finished, accept_versions=True)
    assert (report.before, report.done) == (30, 40)
    assert any("other versions" in note for note in report.notes)
    # accepted from then on
    assert swept(scenario, finished).before == 40
    monkeypatch.setattr(sw, "__version__", "100.0")
    swept(scenario, finished, accept_versions=True)
    earlier = definition.SweepDefinition.read(finished).earlier_versions
    assert [versions["shockwave"] for versions in earlier[1:]] == ["99.0"]


def test_a_sweep_depends_only_on_the_plugins_of_its_points(tmp_path: Path, install: Install) -> None:
    file = tmp_path / "scene.yaml"
    triangle = CHAIN + "shock: {profile: triangular, peak_force: 100 N, rise_time: 5 us, duration_ratio: 3}\n" + GRID
    for name in ("mine", "other"):
        install(name)
    found = []
    swept_profile = triangle.replace("grid: {", "grid: {shock.profile: [other, triangular], ")
    for text in (triangle, triangle.replace("triangular", "mine"), swept_profile):
        file.write_text(text)
        found.append(points_of(file).definition.versions.keys() & {"mine", "other"})
    assert found == [set(), {"mine"}, {"other"}]


def test_the_lock_of_a_killed_client_is_released(scenario: Path, out: Path) -> None:
    program = (
        "import sys, time; from pathlib import Path; from shockwave.sweep.journal import Journal\n"
        "with Journal(Path(sys.argv[1]), 1).lock(): print('held', flush=True); time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", program, out], stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        other.stdout.readline()
        with pytest.raises(sw.FileAccessError, match="used by one client at a time"):
            swept(scenario, out)
        other.send_signal(signal.SIGKILL)
    assert swept(scenario, out).done == 40


def test_a_folder_with_other_files_is_refused(scenario: Path, tmp_path: Path) -> None:
    with pytest.raises(
        sw.FileAccessError, match=r"must be a new folder or hold a sweep \(got a folder with scene.yaml"
    ):
        swept(scenario, tmp_path)


@pytest.mark.parametrize("name", ["sweep.lock", "scenario.yaml", "journal.sqlite"])
def test_links_in_a_folder_lead_to_no_other_file(scenario: Path, finished: Path, tmp_path: Path, name: str) -> None:
    place = finished / name
    for target, content in ((tmp_path / "dangling", None), (tmp_path / "other", place.read_bytes())):
        if content is not None:
            target.write_bytes(content)
        place.unlink()
        place.symlink_to(target)
        refused = pytest.raises(sw.FileAccessError, match=rf"{name}: is not a file \(got a link; delete it\)")
        with refused if name == "sweep.lock" else suppress(sw.FileAccessError):
            swept(scenario, finished, retry_failed=True)
        assert (target.read_bytes() if target.exists() else None) == content


#: What may happen to the folder of a sweep.
CHANGES: dict[str, Callable[[Path], object]] = {
    "deleted": lambda folder: (folder / "journal.sqlite").unlink(),
    "cut": lambda folder: os.truncate(folder / "journal.sqlite", 500),
    "folder deleted": shutil.rmtree,
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_journal_that_others_change_ends_the_sweep(
    scenario: Path, out: Path, monkeypatch: pytest.MonkeyPatch, change: str
) -> None:
    monkeypatch.setattr(point_evaluation, "SLICE", 1e-9)  # one point in a batch
    with pytest.raises(sw.FileAccessError, match=r"journal\.sqlite: cannot be read"):
        swept(scenario, out, progress=lambda report: CHANGES[change](out) if report.done == 15 else None)


@pytest.mark.parametrize("file", ["sweep.json", "scenario.yaml"])
def test_a_file_that_others_delete_meanwhile_is_written_again(scenario: Path, out: Path, file: str) -> None:
    swept(scenario, out, progress=lambda _: (out / file).unlink(missing_ok=True))
    assert (out / file).exists()
    assert sw.load_sweep(out) is not None


USAGE = {
    "no sweep": (SIMULATE, [], 3, "sweep: must be given"),
    "nothing to resume": (GRID, ["--resume"], 2, "must hold a sweep to resume"),
    "long name": (GRID, ["--output", "long" * 100], 5, ": cannot be written (File name too long)"),
    "folder is a file": (GRID, ["--output", "scene.yaml"], 5, "scene.yaml: cannot be"),
}


@pytest.mark.parametrize("case", USAGE)
def test_a_wrong_call_gives_a_short_error_message(case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text, options, status, part = USAGE[case]
    monkeypatch.chdir(tmp_path)
    answer = shockwave("sweep", written(tmp_path, text).name, *options)
    assert (answer.status, part in answer.err, "Traceback" in answer.err) == (status, True, False)
    assert not (tmp_path / "scene-sweep").exists()


# ---------------------------------------------------------------- points that fail


def test_a_failed_point_does_not_stop_the_others(tmp_path: Path, out: Path) -> None:
    report = swept(written(tmp_path, SIMULATE + BROKEN.replace("1e200", "1e200, 2 mm")), out)
    assert (report.done, report.failed, report.exit_code) == (2, 1, 1)
    (failed,) = (line for line in journal(out) if line["status"] == "failed")
    assert failed["index"] == 1
    assert "must give granules a mass that a floating-point number can hold" in failed["error"]


def test_a_sweep_of_which_section_4_covers_no_point_is_refused(tmp_path: Path) -> None:
    model = "predict: {model: section-4}\nsweep: {run: predict, grid: {%s}}\n"
    file = tmp_path / "scene.yaml"
    file.write_text(WALL + SHOCK + model % "shock.rise_time: [4 us, 20 us]")
    with pytest.raises(sw.NotCoveredError, match=r"chain\.end: must be left out for section 4"):
        swept(file, tmp_path / "none")
    # some points may be covered
    report = swept(written(tmp_path, model % "chain.precompression: [1 N, 0 N]"), tmp_path / "some")
    assert (report.done, report.failed) == (1, 1)


@pytest.mark.parametrize("status", ["failed", "crashed"])
def test_unfinished_points_run_again_on_request(scenario: Path, finished: Path, whole: Path, status: str) -> None:
    change(finished, f"UPDATE points SET status = '{status}', results = NULL, problem = 'an error' WHERE number == 7")
    report = swept(scenario, finished)
    assert (report.before, report.done, report.failed + report.crashed) == (40, 39, 1)
    report = swept(scenario, finished, retry_failed=True)
    assert (report.before, report.done, report.failed + report.crashed) == (39, 40, 0)
    assert tables(finished) == tables(whole)


def test_only_the_point_that_raises_fails(scenario: Path, out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    many = point_evaluation.simulate_scenes

    def picky(scenes: list[Scene], *rest: Any, **settings: Any) -> Any:
        shocks = [scene.shock for scene in scenes if scene.shock is not None]
        if any(abs(shock.rise_time - 4.526e-6) < 1e-8 and shock.profile.duration_ratio == 2 for shock in shocks):
            raise SystemExit(3)  # a plugin may do that
        return many(scenes, *rest, **settings)

    monkeypatch.setattr(point_evaluation, "simulate_scenes", picky)
    report = swept(scenario, out)
    assert (report.done, report.failed) == (39, 1)
    assert [line["error"] for line in journal(out) if line["error"]] == ["SystemExit: 3"]


def test_the_rest_of_a_batch_is_sent_again_after_the_time_slice(
    scenario: Path, whole: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(point_evaluation, "SLICE", 1e-9)
    reports: list[SweepReport] = []
    assert swept(scenario, out, progress=reports.append).done == 40
    assert [report.done for report in reports] == list(range(1, 41))
    assert tables(out) == tables(whole)


# ---------------------------------------------------------------- interrupts and disks


def test_an_interrupt_keeps_finished_points(scenario: Path, out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(report: SweepReport) -> None:
        if report.done == 3:
            raise KeyboardInterrupt

    monkeypatch.setattr(point_evaluation, "SLICE", 1e-9)  # one point in a batch
    with pytest.raises(SweepInterrupt) as interrupted:
        swept(scenario, out, progress=interrupt)
    finished = interrupted.value.report.done
    assert 3 <= finished == len(journal(out)) < 40
    assert swept(scenario, out).before == finished


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on the size of files")
def test_a_full_disk_is_reported_and_finished_points_are_kept(scenario: Path, out: Path) -> None:
    # a limit on the file size acts like a full disk
    program = (
        "import resource, sys; from concurrent.futures import ThreadPoolExecutor\n"
        "from shockwave.sweep.runner import run_sweep; from shockwave import FileAccessError\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (12000, 12000))\n"
        "try: run_sweep(sys.argv[1], sys.argv[2], ThreadPoolExecutor(1))\n"
        "except FileAccessError as error: print(error)"
    )
    command = [sys.executable, "-c", program, str(scenario), str(out)]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert "journal.sqlite: cannot be read or written as a journal (disk I/O error)" in printed
    kept = journal(out)
    assert 0 < len(kept) < 40
    assert swept(scenario, out).before == len(kept)


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGHUP")
def test_a_sweep_inside_a_program_leaves_its_signals_alone(scenario: Path) -> None:
    numbers = signal.SIGTERM, signal.SIGHUP
    before = [signal.signal(number, signal.SIG_DFL) for number in numbers]
    try:
        assert shockwave("sweep", scenario, "--dry-run").status == 0
        assert [signal.getsignal(number) for number in numbers] == [signal.SIG_DFL] * 2
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)


# ---------------------------------------------------------------- dry runs


def test_a_dry_run_writes_nothing_and_reports_the_work(
    scenario: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    lead, *_ = shockwave("sweep", scenario.name, "--dry-run", "--workers", "2").out.splitlines()
    assert re.fullmatch(r"40 of 40 points to run, about 0:00:\d\d on 2 workers", lead)
    assert [file.name for file in tmp_path.iterdir()] == ["scene.yaml"]


def test_a_dry_run_reports_finished_and_failed_points(tmp_path: Path, out: Path) -> None:
    file = written(tmp_path, SIMULATE + BROKEN)
    swept(file, out)
    assert dry_run(file, out).startswith("0 of 2 points to run\n")
    again = dry_run(file, out, workers=1, retry_failed=True)
    assert again.startswith("1 of 2 points to run, about ")
    assert "a measured point failed: chain.radius: must give granules a mass" in unwrapped(again)
    with pytest.raises(sw.InvalidValueError, match=r"scenario\.simulate\.rtol 0\.0001, now 1e-05"):
        dry_run(written(tmp_path, SIMULATE.replace("-4", "-5") + BROKEN), out)


THREADS = """
import os
from concurrent.futures import ProcessPoolExecutor
from shockwave.sweep.fork_server import start_server

before = dict(os.environ)
with ProcessPoolExecutor(1, mp_context=start_server()) as executor:
    print(executor.submit(os.getenv, "OMP_NUM_THREADS").result(), os.environ == before)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no server")
def test_workers_have_one_thread_and_the_environment_of_the_client_is_unchanged() -> None:
    environment = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    run = subprocess.run([sys.executable, "-c", THREADS], env=environment, capture_output=True, text=True)
    assert run.stdout == "1 True\n", run.stderr


def test_a_sweep_logs_its_begin_and_end_and_batches_only_in_detail(
    scenario: Path, out: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("DEBUG", "shockwave")
    swept(scenario, out)
    told = [record.getMessage() for record in caplog.records if record.levelname == "INFO"]
    assert len(told) == 2
    assert "40 of 40 points to run" in told[0]
    assert "40 of 40 points done, 0 failed" in told[1]
    assert {record.levelname for record in caplog.records if "recorded" in record.message} == {"DEBUG"}
