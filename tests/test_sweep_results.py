"""Results of sweeps: tables say what the journal says, arrays have their axes, pictures their borders."""

from __future__ import annotations

import csv
import json
import random
import re
import resource
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import shockwave as sw
from shockwave import cli
from shockwave.errors import FileAccessError, InvalidValueError, UnknownNameError, UsageError
from shockwave.scenario.scene_family import Family
from shockwave.sweep.plot import plot
from shockwave.sweep.regimes import regimes
from shockwave.sweep.results import SweepResults, load_sweep
from shockwave.sweep.tables import write_tables

COLUMNS = [
    {"name": "regime", "unit": None, "kind": "text", "meaning": "predicted"},
    {"name": "peak_force", "unit": "N", "kind": "number", "meaning": "of the primary"},
    {"name": "amplification", "unit": "", "kind": "number", "meaning": "over the shock's"},
    {"name": "waves", "unit": "", "kind": "whole", "meaning": "how many"},
]
N, TIME, FORCE = ("shock.duration_ratio", ""), ("shock.rise_time", "s"), ("shock.peak_force", "N")
MATERIAL = ("chain.material", None)
#: Two by three points, of which one failed and one crashed.
AXES = [([N], [[2.0], [4.0]]), ([TIME], [[1e-6], [0.1 + 0.2], [3e-5]])]
PROBLEM = 'no "root",\nhere'


def line(index: int, *values: Any, status: str = "done", error: str = "") -> str:
    told = {"values": list(values)} if status == "done" else {"error": error}
    return json.dumps({"index": index, "key": f"{index:064x}", "status": status, **told}) + "\n"


LINES = [
    line(0, "train", 1 / 3, 0.1, 2),
    line(1, "single", 2.5e-300, None, None),
    line(2, status="failed", error=PROBLEM),
    line(3, "train", 1e16, -0.0, 12),
    line(4, status="crashed", error="ended its process"),
    line(5, None, 7.0, 0.7, 1),
]


def folder_of(folder: Path, axes: Any = AXES, lines: Any = LINES, columns: Any = COLUMNS, run: str = "predict") -> Path:
    folder.mkdir(exist_ok=True)
    parts = [
        {"names": [name for name, _ in variables], "units": [unit for _, unit in variables], "values": values}
        for variables, values in axes
    ]
    shape = [len(values) for _, values in axes]
    header = {"format": 1, "name": "a test", "run": run, "axes": parts, "shape": shape, "points": int(np.prod(shape))}
    header |= {"columns": columns, "scenario": {"chain": {"radius": 1}}, "key": "f" * 64}
    header |= {"versions": {"shockwave": "0.1", "python": "3"}}
    (folder / "sweep.json").write_text(json.dumps(header), encoding="utf-8")
    (folder / "journal.jsonl").write_text("".join(lines), encoding="utf-8")
    return folder


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return folder_of(tmp_path / "out")


# ---------------------------------------------------------------- CSV and JSON Lines


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "results.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_csv_has_a_row_for_each_point_with_units_in_its_head_and_all_digits(folder: Path) -> None:
    write_tables(folder)
    head = (folder / "results.csv").read_text(encoding="utf-8").splitlines()[0]
    names = "shock.duration_ratio,shock.rise_time [s],regime,peak_force [N],amplification,waves,status,problem"
    assert head == names
    found = rows(folder)
    assert [row["shock.duration_ratio"] for row in found] == ["2.0"] * 3 + ["4.0"] * 3
    assert [row["status"] for row in found] == ["done", "done", "failed", "done", "crashed", "done"]
    assert float(found[1]["shock.rise_time [s]"]) == 0.1 + 0.2
    assert [found[i]["peak_force [N]"] for i in (0, 1, 2, 3)] == [repr(1 / 3), "2.5e-300", "", "1e+16"]
    assert (found[1]["amplification"], found[3]["waves"], found[5]["regime"]) == ("", "12", "")
    assert (found[2]["problem"], found[0]["problem"]) == (PROBLEM, "")


FORMULAS = ("=1+1", "+1", "-1", "@sum(1)", "\t=1", "\r=1")


@pytest.mark.parametrize("text", FORMULAS, ids=repr)
def test_text_that_a_spreadsheet_would_run_has_an_apostrophe_in_csv(tmp_path: Path, text: str) -> None:
    lines = [line(0, text, 1.0, 1.0, 1), line(1, status="failed", error=text)]
    place = folder_of(tmp_path / "out", [([MATERIAL], [[text], ["a"]])], lines)
    write_tables(place)
    first, second = rows(place)
    assert (first["chain.material"], first["regime"], second["problem"]) == (f"'{text}",) * 3
    objects = [json.loads(one) for one in (place / "results.jsonl").read_text(encoding="utf-8").splitlines()]
    assert (objects[0]["regime"], objects[1]["problem"]) == (text, text)


def test_a_carriage_return_does_not_end_a_csv_row(tmp_path: Path) -> None:
    place = folder_of(tmp_path / "out", [([N], [[1.0]])], [line(0, "a\r=1+1", 1.0, 1.0, 1)])
    write_tables(place)
    assert [row["regime"] for row in rows(place)] == ["a\r=1+1"]
    assert (place / "results.csv").read_bytes().count(b"\r") == 1


def test_json_lines_hold_the_same(folder: Path) -> None:
    write_tables(folder)
    found = [json.loads(text) for text in (folder / "results.jsonl").read_text(encoding="utf-8").splitlines()]
    assert [row["index"] for row in found] == list(range(6))
    assert found[0] == {
        "index": 0,
        "shock.duration_ratio": 2.0,
        "shock.rise_time": 1e-6,
        "regime": "train",
        "peak_force": 1 / 3,
        "amplification": 0.1,
        "waves": 2,
        "status": "done",
        "problem": None,
    }
    assert (found[2]["peak_force"], found[2]["problem"]) == (None, PROBLEM)


def test_tables_do_not_depend_on_the_order_of_the_journal(tmp_path: Path) -> None:
    one = folder_of(tmp_path / "one")
    mixed = list(LINES)
    random.Random(3).shuffle(mixed)
    other = folder_of(tmp_path / "other", lines=mixed)
    write_tables(one)
    write_tables(other)
    for file in ("results.csv", "results.jsonl"):
        assert (one / file).read_bytes() == (other / file).read_bytes()


def test_of_two_lines_on_a_point_the_last_counts(tmp_path: Path) -> None:
    place = folder_of(tmp_path / "out", lines=[*LINES, line(2, "train", 8.0, 0.8, 3)])
    assert load_sweep(place).values("peak_force")[0, 2] == 8.0


# ---------------------------------------------------------------- when tables are written


def test_tables_are_written_once_for_a_state_of_the_journal(folder: Path) -> None:
    assert [file.name for file in write_tables(folder)] == ["results.csv", "results.jsonl"]
    assert write_tables(folder) == []
    (folder / "results.jsonl").unlink()
    assert len(write_tables(folder)) == 2
    with (folder / "journal.jsonl").open("a", encoding="utf-8") as journal:
        journal.write(line(2, "train", 8.0, 0.8, 3))
    assert len(write_tables(folder)) == 2
    assert rows(folder)[2]["status"] == "done"


@pytest.fixture
def small_disk() -> Iterator[None]:
    """Files can have 200 bytes at most."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (200, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_names_the_file_and_leaves_the_table_that_was_there(
    tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    place = folder_of(tmp_path / "out", lines=LINES[:1])
    (place / "results.csv").write_text("old", encoding="utf-8")
    request.getfixturevalue("small_disk")
    with pytest.raises(FileAccessError, match=r"results\.\w+: cannot be written \(got File too large"):
        write_tables(place)
    assert (place / "results.csv").read_text(encoding="utf-8") == "old"
    assert [file.name for file in place.iterdir() if file.suffix == ".part"] == []


# ---------------------------------------------------------------- other libraries

CLASHES = {
    "zip": ([([N, TIME], [[2.0, 1e-6], [4.0, 2e-6]])], {"duration_ratio": "point", "rise_time": "point"}),
    "words": ([([MATERIAL], [["lead"], ["brass-260"]])], {"material": "material"}),
    "column": ([([FORCE], [[1.0], [2.0]])], {"shock_peak_force": "shock_peak_force"}),
    "two-zips": (
        [([N, FORCE], [[2.0, 1.0]]), ([TIME, MATERIAL], [[1e-6, "lead"], [2e-6, {"density": 1}]])],
        {"duration_ratio": "point", "shock_peak_force": "point", "rise_time": "point_2", "material": "point_2"},
    ),
    "nothing": ([([("chain.granules", "")], [[None], [50]])], {"granules": "granules"}),
}


@pytest.mark.parametrize("name", CLASHES)
def test_axes_of_every_kind_become_dimensions_of_xarray(tmp_path: Path, name: str) -> None:
    xarray = pytest.importorskip("xarray")
    axes, coordinates = CLASHES[name]
    found = load_sweep(folder_of(tmp_path / "out", axes, LINES[:2])).to_xarray()
    assert {one: found[one].dims[0] for one in coordinates} == coordinates
    assert found.peak_force.values.ravel().tolist() == [1 / 3, 2.5e-300]
    # as a file of arrays, too
    found.to_netcdf(tmp_path / "results.nc", engine="scipy")
    with xarray.open_dataset(tmp_path / "results.nc", engine="scipy") as again:
        assert {one: again[one].dims[0] for one in coordinates} == coordinates


def test_xarray_gets_named_axes_units_and_where_they_come_from(folder: Path) -> None:
    pytest.importorskip("xarray")
    found = load_sweep(folder).to_xarray()
    assert found.sizes == {"duration_ratio": 2, "rise_time": 3}
    assert (found.peak_force.units, found.rise_time.units, found.duration_ratio.units) == ("N", "s", "1")
    assert (found.rise_time.long_name, found.peak_force.long_name) == ("shock.rise_time", "of the primary")
    assert float(found.peak_force.sel(duration_ratio=4, rise_time=1e-6)) == 1e16
    assert found.regime.values.tolist() == [["train", "single", ""], ["train", "", ""]]
    assert (found.title, found.sweep_key, found.source) == ("a test", "f" * 64, "shockwave 0.1, python 3")
    assert json.loads(found.scenario) == {"chain": {"radius": 1}}


# ---------------------------------------------------------------- load_sweep


def test_values_have_an_axis_for_each_axis_of_the_sweep(folder: Path) -> None:
    found = load_sweep(folder)
    assert (found.shape, found.complete, found.warnings) == ((2, 3), True, ())
    np.testing.assert_array_equal(found.values("amplification"), [[0.1, np.nan, np.nan], [0.0, np.nan, 0.7]])
    assert found.values("regime").tolist() == [["train", "single", ""], ["train", "", ""]]
    assert found.values("shock.rise_time")[1].tolist() == [1e-6, 0.1 + 0.2, 3e-5]
    assert found.coordinate("shock.duration_ratio").tolist() == [2.0, 4.0]
    assert found.units["peak_force"] == "N"
    assert (found.units["regime"], found.units["shock.rise_time"]) == (None, "s")


def test_points_that_failed_are_told_with_their_values(folder: Path) -> None:
    first, second = load_sweep(folder).failed
    assert (first.index, first.status, first.problem) == (2, "failed", PROBLEM)
    assert second.point == {"shock.duration_ratio": 4.0, "shock.rise_time": 0.1 + 0.2}
    assert second.status == "crashed"


def test_results_are_frozen_and_equal_by_value(folder: Path) -> None:
    found = load_sweep(folder)
    assert found == load_sweep(folder)
    with pytest.raises(ValueError, match="read-only"):
        found.values("peak_force")[0, 0] = 1.0


def test_results_print_what_they_hold(folder: Path) -> None:
    told = str(load_sweep(folder))
    assert "points  6: 4 done, 2 failed" in told
    assert re.search(r"shock.rise_time +1 us +300 ms +3", told)
    assert re.search(r"regime +1 single, 2 train", told)
    assert "note: shock.duration_ratio 2, shock.rise_time 3e-05: no" in told


UNFINISHED = {
    "torn": (["".join(LINES)[:-9]], "the last line of journal.jsonl is torn"),
    "unfinished": (LINES[:4], "2 of 6 points are not done"),
    "garbage": (
        [*LINES[:5], "{}\n", '{"index": 77, }\n', LINES[5].replace('"done"', '"lost"'), LINES[5]],
        "lines of journal.jsonl that are of no point, and were left out: 3",
    ),
    "unreadable": (
        [*LINES[:5], LINES[5].replace("7.0,", "7.0")],
        "lines of the journal that cannot be read: 1 (delete them",
    ),
    "text-for-number": (
        [*LINES[:5], line(5, "train", "7", 0.7, 1)],
        "lines of the journal that cannot be read: 1 (delete them",
    ),
}


@pytest.mark.parametrize("name", UNFINISHED)
def test_a_journal_that_is_not_whole_is_read_as_far_as_it_goes(tmp_path: Path, name: str) -> None:
    lines, warning = UNFINISHED[name]
    found = load_sweep(folder_of(tmp_path / "out", lines=lines))
    assert warning in "; ".join(found.warnings)
    assert found.values("peak_force")[0, 0] == 1 / 3
    assert found.complete is (name == "garbage")
    assert (found.values("status")[1, 2] == "not run") is (name != "garbage")


def test_a_sweep_that_has_just_begun_is_empty(folder: Path) -> None:
    (folder / "journal.jsonl").unlink()
    found = load_sweep(folder)
    assert (found.complete, bool(np.isnan(found.values("peak_force")).all())) == (False, True)
    assert "6 of 6 points are not done" in str(found)


@pytest.mark.parametrize("name", ["peak_forc", "shock.rise_tim"])
def test_an_unknown_quantity_is_answered_with_the_known(folder: Path, name: str) -> None:
    with pytest.raises(UnknownNameError, match="did you mean"):
        load_sweep(folder).values(name)
    with pytest.raises(UnknownNameError, match="unknown variable of the sweep"):
        load_sweep(folder).coordinate("peak_force")


def test_a_folder_that_is_none_says_how_to_make_one(tmp_path: Path) -> None:
    with pytest.raises(FileAccessError, match=r"sweep\.json: cannot be read .*; give a folder that `shockwave sweep"):
        load_sweep(tmp_path)


def test_other_versions_that_a_sweep_was_begun_with_are_told(folder: Path) -> None:
    header = json.loads((folder / "sweep.json").read_text(encoding="utf-8"))
    header["earlier_versions"] = [{"shockwave": "0.0.9", "numpy": "1.26"}]
    (folder / "sweep.json").write_text(json.dumps(header), encoding="utf-8")
    told = "points may have been run with other versions (shockwave 0.0.9, numpy 1.26)"
    assert load_sweep(folder).warnings == (told,)


def test_pandas_gets_a_table_indexed_by_the_variables(folder: Path) -> None:
    pytest.importorskip("pandas")
    found = load_sweep(folder).to_pandas()
    assert found.loc[(4.0, 1e-6), "peak_force"] == 1e16
    assert (found.attrs["units"]["peak_force"], found.attrs["units"]["shock.rise_time"]) == ("N", "s")


@pytest.mark.parametrize("library", ["pandas", "xarray"])
def test_what_is_not_installed_is_named(folder: Path, library: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(UsageError, match=f"needs {library}: pip install {library}"):
        getattr(load_sweep(folder), f"to_{library}")()


# ---------------------------------------------------------------- pictures

MAP = """\
chain: {material: paper-steel, diameter: 9.5 mm}
shock: {profile: power-law, peak_force: 100 N, parameters: {rise_exponent: 0.5, decay_exponent: 1}}
sweep:
  run: predict
  grid:
    shock.rise_time: {logspace: [1 us, 100 us, 15]}
    shock.duration_ratio: {logspace: [1.5, 15, 12]}
"""


@cache
def _predicted(text: str) -> tuple[Any, tuple[str, ...], tuple[sw.Outcome, ...]]:
    """Axes, lines of a journal and outcomes of a scenario, predicted."""
    import tempfile

    with tempfile.TemporaryDirectory() as name:
        file = Path(name) / "scenario.yaml"
        file.write_text(text, encoding="utf-8")
        scenario = sw.load_scenario(file)
    assert scenario.sweep is not None
    family, swept = Family(scenario), scenario.sweep
    scenes = [family.scenario(swept.point(index)) for index in range(len(swept))]
    outcomes = tuple(scene.predictor.predict(scene.shock, scene.chain) for scene in scenes)
    axes = [
        ([(one.name, one.unit) for one in axis.variables], [list(values) for values in axis.values])
        for axis in swept.axes
    ]
    lines = tuple(
        line(index, found.regime, found.peak_force, found.amplification, len(found.waves))
        for index, found in enumerate(outcomes)
    )
    return axes, lines, outcomes


def a_map(folder: Path, text: str = MAP, failed: tuple[int, ...] = ()) -> SweepResults:
    axes, lines, _ = _predicted(text)
    told = [line(at, status="failed", error="no") if at in failed else one for at, one in enumerate(lines)]
    place = folder_of(folder / "map", axes, told)
    (place / "scenario.yaml").write_text(text, encoding="utf-8")
    return load_sweep(place)


def inside(figure: Any) -> bool:
    """Whether nothing leaves the figure; a pixel of slack for the rounding of letters."""
    figure.draw_without_rendering()
    around = figure.axes[0].get_tightbbox()
    return bool(
        around.x0 > -1 and around.y0 > -1 and around.x1 < figure.bbox.width + 1 and around.y1 < figure.bbox.height + 1
    )


@pytest.mark.parametrize("decay", [1, 3], ids=["single-waves-too", "none"])
def test_borders_of_regimes_are_where_predictions_change(tmp_path: Path, decay: int) -> None:
    text = MAP.replace("decay_exponent: 1", f"decay_exponent: {decay}")
    found = a_map(tmp_path, text)
    numbers, told = regimes(found, np.arange(180))
    assert told == "borders of the regimes: (5d) and (5e) of section 4, for each point"
    for name, values in numbers.items():
        assert ((values < 0) == (found.values("regime").ravel() == name)).all()
    # ln of n t0 over alphaF0 A F0^(-1/6), by the inequality that the prediction tells
    split = _predicted(text)[2][40].trace[0]
    assert -numbers["train"][40] == pytest.approx(np.log(split.right / split.left), abs=1e-12)


def test_without_a_scenario_borders_are_those_of_the_column(tmp_path: Path) -> None:
    found = a_map(tmp_path)
    (tmp_path / "map" / "scenario.yaml").unlink()
    numbers, told = regimes(found, np.arange(180))
    assert told == "borders of the regimes: regime"
    assert set(numbers) == {"ejection", "single", "train"}
    assert ((numbers["train"] < 0) == (found.values("regime").ravel() == "train")).all()


def test_without_either_there_are_no_borders_and_a_sentence_says_why(tmp_path: Path) -> None:
    found = load_sweep(
        folder_of(tmp_path / "out", [([TIME], [[1.0], [2.0]])], [line(0, 1.0)], COLUMNS[1:2], "simulate")
    )
    numbers, told = regimes(found, np.arange(2))
    assert numbers == {}
    assert "no borders of regimes: " in told
    assert "scenario.yaml" in told


def test_a_record_that_is_not_in_the_folder_is_asked_for(tmp_path: Path) -> None:
    place = folder_of(
        tmp_path / "out", [([TIME], [[1.0], [2.0]])], [line(at, 1.0) for at in range(2)], COLUMNS[1:2], "simulate"
    )
    shock = "{profile: tabulated, parameters: {file: pulse.csv}}"
    (place / "scenario.yaml").write_text(f"chain: {{material: lead, radius: 1 mm}}\nshock: {shock}\n", encoding="utf-8")
    numbers, told = regimes(load_sweep(place), np.arange(2))
    assert numbers == {}
    assert "pulse.csv: cannot be read" in told
    assert told.endswith("(a folder of results holds no copies of records: put them beside its scenario.yaml)")


def test_two_axes_make_a_map_with_borders_and_units(tmp_path: Path) -> None:
    found = plot(a_map(tmp_path))
    (ax,) = found.figure.axes
    assert (found.column, ax.get_xlabel(), ax.get_ylabel()) == ("amplification", "rise time (µs)", "duration ratio")
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    assert {"ejection", "train"} <= {text.get_text() for text in ax.texts}
    # halfway between factors of 100^(1/14) from 1 us
    edges = ax.collections[0].get_coordinates()[0, :, 0]
    np.testing.assert_allclose(edges, 1e-6 * 100 ** ((np.arange(16) - 0.5) / 14), rtol=1e-12)
    values = ax.collections[0].get_array().reshape(12, 15).T
    np.testing.assert_array_equal(values, load_sweep(tmp_path / "map").values("amplification"))
    assert inside(found.figure)


def test_points_without_a_value_are_hatched_and_counted(tmp_path: Path) -> None:
    results = a_map(tmp_path, failed=(3, 77))
    found = plot(results)
    (ax,) = found.figure.axes
    assert legend(found) == ["no value (2 of 180)"]
    # four corners, and one that closes them
    assert [len(one.get_path().vertices) for one in ax.patches if one.get_hatch()] == [2 * 5]
    assert "2 of the 180 points drawn failed" in found.notes
    # notes are of what is drawn
    held = plot(results, at={"shock.rise_time": results.coordinate("shock.rise_time")[6]})
    assert "1 of the 12 points drawn failed" in held.notes


def test_one_axis_makes_a_line_with_its_regimes(tmp_path: Path) -> None:
    results = a_map(tmp_path)
    ratio = results.coordinate("shock.duration_ratio")[4]
    found = plot(results, "peak_force", at={"shock.duration_ratio": repr(float(ratio))})
    (ax,) = found.figure.axes
    drawn = ax.get_lines()[0]
    np.testing.assert_array_equal(drawn.get_ydata(), results.values("peak_force")[:, 4])
    assert ax.get_ylabel() == "peak force (N)"
    borders = [one.get_xdata()[0] for one in ax.get_lines() if one.get_linestyle() == "--"]
    times, names = results.coordinate("shock.rise_time"), results.values("regime")[:, 4]
    changes = [at for at in range(14) if names[at] != names[at + 1]]
    assert all(any(times[at] < border < times[at + 1] for border in borders) for at in changes)
    assert inside(found.figure)


def test_a_few_values_of_a_second_axis_make_lines(tmp_path: Path) -> None:
    text = MAP.replace("{logspace: [1.5, 15, 12]}", "[2, 4]")
    results = a_map(tmp_path, text, failed=(1,))
    found = plot(results)
    (ax,) = found.figure.axes
    assert legend(found) == ["duration ratio 2", "duration ratio 4", "no value (1 of 30)"]
    second = results.values("amplification")[:, 1]
    np.testing.assert_array_equal(ax.get_lines()[1].get_ydata(), second)
    np.testing.assert_array_equal(ax.get_lines()[0].get_ydata(), results.values("amplification")[:, 0])
    assert np.isnan(ax.get_lines()[1].get_ydata()).tolist() == [True] + [False] * 14


@pytest.mark.parametrize("held", [{}, {"shock.duration_ratio": 1.5}], ids=["map", "line"])
def test_a_sweep_of_which_all_failed_is_drawn_empty(tmp_path: Path, held: dict[str, float]) -> None:
    found = plot(a_map(tmp_path, failed=tuple(np.arange(180))), at=held)
    failed = 15 if held else 180
    assert f"{failed} of the {failed} points drawn failed" in found.notes
    assert "amplification: over the shock's; its error is not known" in found.notes
    assert inside(found.figure)


WRONG: dict[str, tuple[list[str], int, str]] = {
    "column": (["--column", "amplificatio"], 3, "did you mean 'amplification'"),
    "text": (["--column", "regime"], 3, "must be a column of numbers (got regime, which is text; known: peak_force"),
    "variable": (["--x", "shock.rise_tim"], 3, "unknown variable of the sweep"),
    "held": (["--at", "shock.duration_ratio=3"], 2, "must be one of its values (got 3; they are 1.5, "),
    "held-si": (["--at", "shock.rise_time=3"], 2, "(got 3; they are 1 µs, 1.3895 µs, "),
    "held-twice": (["--at", "shock.rise_time=1 us", "--at", "shock.rise_time=1 s"], 2, "must name a variable once"),
    "held-unit": (["--at", "shock.duration_ratio=3 s"], 2, "shock.duration_ratio: must be a number"),
    "held-form": (["--at", "shock.duration_ratio"], 2, "--at: must be NAME=VALUE"),
    "held-both": (["--at", "shock.duration_ratio=1.5", "--at", "shock.rise_time=1 us"], 2, "one axis or two"),
    "held-x": (["--at", "shock.rise_time=1 us", "--x", "shock.rise_time"], 2, "it cannot be drawn over it"),
    "ending": (["-o", "map.gif"], 3, "--output: must end in .svg, .png, .pdf"),
    "place": (["-o", "nowhere/map.svg"], 5, "cannot be written"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_wrong_orders_are_refused_with_a_remedy(
    tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    a_map(tmp_path)
    monkeypatch.chdir(tmp_path)
    arguments, status, part = WRONG[name]
    assert cli.main(["plot", "map", *arguments]) == status
    assert part in capsys.readouterr().err


def test_three_axes_are_too_many_until_one_is_held(tmp_path: Path) -> None:
    axes = [*AXES, ([FORCE], [[1.0], [2.0]])]
    found = load_sweep(folder_of(tmp_path / "out", axes, [line(at, "train", at, at, 1) for at in range(12)]))
    told = "hold 1 of them at a value by --at NAME=VALUE: shock.duration_ratio=2, 4; shock.rise_time=1 µs, 300 ms, "
    with pytest.raises(UsageError, match=re.escape(told)):
        plot(found)
    assert plot(found, at={"shock.peak_force": 2.0}).column == "amplification"


def numbers_of(folder: Path, axes: Any, regime: str = "") -> SweepResults:
    """Of which the amplification is the number of the point, counted from 0, and every other one has a regime."""
    count = int(np.prod([len(values) for _, values in axes]))
    return load_sweep(
        folder_of(
            folder / "out", axes, [line(at, regime if at % 2 else None, 1.0, float(at), 1) for at in range(count)]
        )
    )


def lines_of(found: Any) -> list[list[tuple[float, float]]]:
    (ax,) = found.figure.axes
    return [[(float(x), float(y)) for x, y in one.get_xydata()] for one in ax.get_lines()]


#: The force twice at one time.
PAIRS = ([TIME, FORCE], [[1.0, 5.0], [1.0, 6.0], [2.0, 5.0]])
RATIOS = ([N], [[2.0], [3.0], [4.0]])
LONG = ([N], [[float(at)] for at in range(2, 12)])


def test_points_that_share_a_place_are_all_drawn(tmp_path: Path) -> None:
    axis = ([TIME, FORCE], [[1.0, 5.0], [10.0, 5.0], [1.0, 6.0], [10.0, 6.0], [100.0, 6.0]])
    results = numbers_of(tmp_path, [axis], "train")
    found = plot(results)
    assert lines_of(found) == [[(1.0, 0.0), (1.0, 2.0), (10.0, 1.0), (10.0, 3.0), (100.0, 4.0)]]
    assert found.figure.axes[0].get_xscale() == "log"
    drawn = found.figure.axes[0].get_lines()[0]
    assert (drawn.get_linestyle(), drawn.get_marker()) == ("None", "o")
    assert "no borders of regimes: points share a value of shock.rise_time" in found.notes
    assert lines_of(plot(results, at={"shock.peak_force": 5}))[0] == [(1.0, 0.0), (10.0, 1.0)]


def test_values_that_are_held_together_leave_what_has_them_all(tmp_path: Path) -> None:
    results = numbers_of(tmp_path, [PAIRS, RATIOS])
    one = plot(results, at={"shock.peak_force": 6, "shock.rise_time": 1})
    assert lines_of(one) == [[(2.0, 3.0), (3.0, 4.0), (4.0, 5.0)]]
    pairs = ["rise time 1 s, peak force 5 N", "rise time 1 s, peak force 6 N", "rise time 2 s, peak force 5 N"]
    assert legend(plot(results, x=N[0])) == pairs
    two = plot(results, at={"shock.rise_time": 1})
    assert [values[0][1] for values in lines_of(two)] == [0.0, 3.0]
    assert legend(two) == ["peak force 5 N", "peak force 6 N"]
    with pytest.raises(UsageError, match=r"shock.rise_time: must be one of its values \(got 2; they are 1 s"):
        plot(results, at={"shock.peak_force": 6, "shock.rise_time": 2})


def test_an_axis_is_drawn_over_what_varies_most(tmp_path: Path) -> None:
    results = numbers_of(tmp_path, [([TIME, FORCE], [[1.0, 5.0 + at] for at in range(8)]), LONG])
    assert plot(results).figure.axes[0].get_ylabel() == "peak force (N)"
    with pytest.raises(UsageError, match=r"shock.rise_time has one value"):
        plot(results, x="shock.rise_time")


def test_a_value_that_is_given_twice_is_drawn_once(tmp_path: Path) -> None:
    results = numbers_of(tmp_path, [([TIME], [[1.0], [1.0], *([float(at)] for at in range(2, 8))]), LONG])
    values = plot(results).figure.axes[0].collections[0].get_array().reshape(7, 10)
    assert values[:, 0].tolist() == [0.0, *range(20, 80, 10)]


def test_points_of_a_map_that_would_hide_each_other_are_refused(tmp_path: Path) -> None:
    axis = ([TIME, FORCE], [[1.0 + at // 2, 5.0 + at % 2 + at // 4] for at in range(8)])
    with pytest.raises(UsageError, match=r"a place each \(got shock.rise_time, which repeats a value; hold a variable"):
        plot(numbers_of(tmp_path, [axis, LONG]))


@pytest.mark.parametrize(("values", "held"), [([2.0], {}), ([2.0, 2.0], {}), ([2.0, 3.0], {N[0]: 2})])
def test_a_single_point_is_no_picture(tmp_path: Path, values: list[float], held: dict[str, int]) -> None:
    results = numbers_of(tmp_path, [([N], [[value] for value in values])])
    with pytest.raises(UsageError, match=r"\(got one point; read it in results.csv, or leave out an --at\)"):
        plot(results, at=held)


def test_values_that_are_listed_can_be_held(tmp_path: Path) -> None:
    results = numbers_of(tmp_path, [([TIME], [[1 / 3], [1.0], [2e-6 / 3]]), RATIOS])
    listed = ["333.333 ms", "1 s", "666.667 ns"]
    for at, value in enumerate(listed):
        assert lines_of(plot(results, at={"shock.rise_time": value}))[0][0] == (2.0, 3.0 * at)
    told = f"must be one of its values (got 5; they are {', '.join(listed)})"
    with pytest.raises(UsageError, match=re.escape(told)):
        plot(results, at={"shock.rise_time": 5})


@pytest.mark.parametrize("axis", [([MATERIAL], [[None], ["lead"]]), ([("chain.granules", "")], [[None], [50]])])
def test_nothing_is_called_none(tmp_path: Path, axis: Any) -> None:
    results = numbers_of(tmp_path, [axis, RATIOS])
    name = axis[0][0][0]
    assert lines_of(plot(results, at={name: "none"})) == [[(2.0, 0.0), (3.0, 1.0), (4.0, 2.0)]]
    labels = [text.get_text() for text in plot(results, x=name).figure.axes[0].get_xticklabels()]
    assert labels[0] == "none"


def test_words_are_no_mathematics(tmp_path: Path) -> None:
    results = numbers_of(tmp_path, [([MATERIAL], [[r"$\foo$"], ["$"]]), LONG])
    # there is no such symbol
    assert inside(plot(results).figure)
    assert inside(plot(results, x="chain.material", at={N[0]: 2}).figure)


def trusted(folder: Path, names: dict[str, str], rows: list[list[float | None]], run: str = "simulate") -> SweepResults:
    """Columns with units, over duration ratios from 2 on."""
    columns = [{"name": name, "unit": unit, "kind": "number", "meaning": "what"} for name, unit in names.items()]
    axes = [([N], [[2.0 + at] for at in range(len(rows))])]
    return load_sweep(folder_of(folder / "out", axes, [line(at, *row) for at, row in enumerate(rows)], columns, run))


def band(found: Any) -> list[tuple[float, float]]:
    """Least and greatest of the shade, place by place."""
    (shade,) = (one for one in found.figure.axes[0].collections if one.get_label() in ("error estimate", BAND))
    corners = shade.get_paths()[0].vertices
    return [(corners[corners[:, 0] == x, 1].min(), corners[corners[:, 0] == x, 1].max()) for x in (2.0, 3.0)]


BAND = "expected of a simulation"


def test_the_shade_of_a_prediction_is_where_simulation_is_expected(tmp_path: Path) -> None:
    names = {"amplification": "", "expected_error_low": "", "expected_error_high": ""}
    results = trusted(tmp_path, names, [[2.0, -0.2, 0.25], [6.0, -0.25, 0.5], [1.0, None, None]], "predict")
    found = plot(results)
    # a prediction that errs by +25 % is of 1.6 where it says 2
    np.testing.assert_allclose(band(found), [(1.6, 2.5), (4.0, 8.0)], rtol=1e-14)
    told = "amplification: predicted, expected to err by -25.0% to +50.0%; known at 67% of the points"
    assert found.notes[0] == told


def predictions(folder: Path, axes: Any, known: set[int]) -> SweepResults:
    """An amplification of 2 at every point, which errs by -20 % to +25 % where that is known."""
    names = ("amplification", "expected_error_low", "expected_error_high")
    columns = [{"name": name, "unit": "", "kind": "number", "meaning": ""} for name in names]
    count = int(np.prod([len(values) for _, values in axes]))
    lines = [line(at, 2.0, *((-0.2, 0.25) if at in known else (None, None))) for at in range(count)]
    return load_sweep(folder_of(folder / "out", axes, lines, columns))


def legend(found: Any) -> list[str]:
    return [text.get_text() for text in found.figure.axes[0].get_legend().get_texts()]


def hollow(found: Any) -> list[list[float]]:
    """Places of hollow marks, line by line."""
    lines = found.figure.axes[0].get_lines()
    return [one.get_xdata().tolist() for one in lines if one.get_markerfacecolor() == "white"]


def test_marks_are_hollow_where_the_expected_error_is_not_known(tmp_path: Path) -> None:
    found = plot(predictions(tmp_path, [LONG], {0, 1, 5}))
    assert hollow(found) == [[4.0, 5.0, 6.0, 8.0, 9.0, 10.0, 11.0]]
    assert legend(found) == [BAND, "error not known"]
    assert inside(found.figure)


def test_a_map_is_dotted_where_the_expected_error_is_not_known(tmp_path: Path) -> None:
    axes = [([TIME], [[float(at)] for at in range(1, 9)]), LONG]
    found = plot(predictions(tmp_path, axes, set(range(3, 80))))
    assert legend(found) == ["error not known (3 of 80)"]
    (dotted,) = (one for one in found.figure.axes[0].patches if one.get_hatch())
    # of the first time, and the ratios 2, 3 and 4
    corners = [(1.5, 0.5), (2.5, 0.5), (2.5, 1.5), (1.5, 1.5)]
    # the fifth closes each
    cells = dotted.get_path().vertices.reshape(3, 5, 2)[:, :4].tolist()
    assert cells == [[[x + at, y] for x, y in corners] for at in range(3)]


#: The force goes up and down with time, or up alone.
CROSSED = ([TIME, FORCE], [[float(at), 5.0 + at * at % 7] for at in range(8)])
ALONG = ([TIME, FORCE], [[float(at), 5.0 + at] for at in range(8)])


def test_unrelated_variables_of_an_axis_are_not_drawn_through(tmp_path: Path) -> None:
    found = plot(numbers_of(tmp_path, [CROSSED], "train"), x=TIME[0])
    assert found.figure.axes[0].get_lines()[0].get_linestyle() == "None"
    assert "no line and no borders of regimes: shock.peak_force goes up and down between points" in found.notes
    assert found.figure.get_suptitle() == "peak force changes with rise time"
    with pytest.raises(UsageError, match=r"got shock.rise_time, with which shock.peak_force goes up and down; hold"):
        plot(numbers_of(tmp_path, [CROSSED, LONG]))


def test_variables_that_go_together_are_drawn_and_told(tmp_path: Path) -> None:
    results = numbers_of(tmp_path, [ALONG, LONG])
    assert plot(results).figure.get_suptitle() == "peak force changes with rise time"
    assert plot(results, at={N[0]: 2}).figure.axes[0].get_lines()[0].get_linestyle() == "-"


MATERIALS = [[{"name": "mine", "density": 1}], ["lead"], [{"density": 2}], [{"name": "lead", "density": 3}]]


def test_materials_of_their_own_are_called_by_what_tells_them_apart(tmp_path: Path) -> None:
    results = numbers_of(tmp_path, [([MATERIAL], MATERIALS), RATIOS])
    told = [label.get_text() for label in plot(results, x=MATERIAL[0]).figure.axes[0].get_xticklabels()]
    assert told == ["mine", "lead", "#3", "#4"]
    for at, name in enumerate(told):
        assert lines_of(plot(results, at={MATERIAL[0]: name}))[0][0] == (2.0, 3.0 * at)
    assert lines_of(plot(results, at={MATERIAL[0]: MATERIALS[2][0]}))[0][0] == (2.0, 6.0)
    assert plot(results, at={MATERIAL[0]: "mine"}).figure.get_suptitle() == "material mine"


@pytest.mark.parametrize("index", [-1, 6, 9999])
def test_there_are_no_points_beyond_the_last(folder: Path, index: int) -> None:
    with pytest.raises(InvalidValueError, match=rf"index: must be from 0 to 5 \(got {index}\)"):
        load_sweep(folder).point(index)


def test_a_picture_of_something_else_gets_another_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    a_map(tmp_path)
    orders = [[], ["--at", "shock.rise_time=1 us"], ["--x", "shock.duration_ratio"], []]
    for order in orders:
        assert cli.main(["plot", str(tmp_path / "map"), *order]) == 0
    names = ["", "-shock.rise_time=1_us", "-over-shock.duration_ratio"]
    found = {file.name for file in (tmp_path / "map").glob("*.svg")}
    assert found == {f"amplification{name}.svg" for name in names}
    told = [text.rpartition(" ")[2] for text in capsys.readouterr().err.splitlines() if ".svg: " in text]
    assert told == ["written", "written", "written", "replaced"]


def test_the_shade_of_a_simulated_quantity_is_its_own_error(tmp_path: Path) -> None:
    names = {"amplification": "", "error_estimate": "", "second_peak_force": "N", "second_error_estimate": ""}
    names |= {"recoil_momentum": "N s", "recoil_error": "N s", "width": "s", "momentum_defect": ""}
    rows = [[2.0, 0.1, 2.0, 0.1, 2.0, 0.5, 1.0, 1.0], [4.0, 0.25, 4.0, 0.25, 3.0, 1.0, 1.0, 1.0]]
    results = trusted(tmp_path, names, rows)
    # products of two roundings
    shades = {"amplification": [(1.8, 2.2), (3.0, 5.0)], "second_peak_force": [(1.8, 2.2), (3.0, 5.0)]}
    shades["recoil_momentum"] = [(1.5, 2.5), (2.0, 4.0)]
    known = {"amplification": "2.5e-01 relative", "second_peak_force": "2.5e-01 relative", "recoil_momentum": "1 N s"}
    for name, shade in shades.items():
        drawn = plot(results, name)
        np.testing.assert_allclose(band(drawn), shade, rtol=1e-14)
        assert drawn.notes[0] == f"{name}: simulated, known to {known[name]} or better"
    assert plot(results, "width").notes[0] == "width: what; its error is not known"


def test_without_matplotlib_a_sentence_says_what_to_install(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert cli.main(["plot", str(folder)]) == 2
    assert capsys.readouterr().err == "pictures need matplotlib: pip install 'granular-shockwave[plot]'\n"
