"""Results of sweeps: tables and arrays agree with the journal."""

import csv
import errno
import json
import math
import os
import re
import sqlite3
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from shockwave.base.errors import FileAccessError, InvalidValueError, UnknownNameError
from shockwave.base.quantities import Quantity
from shockwave.sweep.columns import row
from shockwave.sweep.definition import SweepDefinition
from shockwave.sweep.journal import Entry, Journal, write_tables
from shockwave.sweep.results import load_sweep

COLUMNS = [
    {"name": "regime", "unit": None, "kind": "text", "meaning": "predicted", "quantity": ""},
    {"name": "peak_force", "unit": "N", "kind": "number", "meaning": "of the primary", "quantity": ""},
    {"name": "amplification", "unit": "", "kind": "number", "meaning": "over the shock's", "quantity": ""},
    {"name": "waves", "unit": "", "kind": "whole", "meaning": "how many", "quantity": ""},
]
N, TIME, FORCE = ("shock.duration_ratio", ""), ("shock.rise_time", "s"), ("shock.peak_force", "N")
MATERIAL = ("chain.material", None)
#: Two by three points; one failed and one crashed.
AXES = [([N], [[2.0], [4.0]]), ([TIME], [[1e-6], [0.1 + 0.2], [3e-5]])]
PROBLEM = 'no "root",\nhere'


def done(index: int, *values: Any) -> Entry:
    return index, "done", json.dumps(values), None


ENTRIES = [
    done(0, "train", 1 / 3, 0.1, 2),
    done(1, "single", 2.5e-300, None, None),
    (2, "failed", None, PROBLEM),
    done(3, "train", 1e16, -0.0, 12),
    (4, "crashed", None, "ended its process"),
    done(5, None, 7.0, 0.7, 1),
]


def folder_of(
    folder: Path, axes: Any = AXES, entries: Any = ENTRIES, columns: Any = COLUMNS, run: str = "predict"
) -> Path:
    folder.mkdir(exist_ok=True)
    parts = [
        {"names": [name for name, _ in variables], "units": [unit for _, unit in variables], "values": values}
        for variables, values in axes
    ]
    definition = {"format": 4, "name": "a test", "run": run, "axes": parts, "columns": columns}
    definition |= {"scenario": {"chain": {"radius": 1}}, "named": {}, "versions": {"shockwave": "0.1", "python": "3"}}
    (folder / "sweep.json").write_text(json.dumps(definition), encoding="utf-8")
    journal = Journal(folder, 0)
    journal.begin(retry_failed=False)
    journal.add(entries)
    return folder


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return folder_of(tmp_path / "out")


def written(folder: Path) -> Path:
    """The folder, after its tables have been written."""
    definition = SweepDefinition.read(folder)
    journal = Journal(folder, definition.points)
    journal.read()
    write_tables(definition, journal)
    return folder


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "results.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_csv_has_a_row_for_each_point_with_units_and_all_digits(folder: Path) -> None:
    found = rows(written(folder))
    head = (folder / "results.csv").read_text(encoding="utf-8").splitlines()[0]
    names = "shock.duration_ratio,shock.rise_time [s],regime,peak_force [N],amplification,waves,status,problem"
    assert head == names
    assert [row["shock.duration_ratio"] for row in found] == ["2.0"] * 3 + ["4.0"] * 3
    assert [row["status"] for row in found] == ["done", "done", "failed", "done", "crashed", "done"]
    assert float(found[1]["shock.rise_time [s]"]) == 0.1 + 0.2
    assert [found[i]["peak_force [N]"] for i in (0, 1, 2, 3)] == [repr(1 / 3), "2.5e-300", "", "1e+16"]
    assert (found[1]["amplification"], found[3]["waves"], found[5]["regime"]) == ("", "12", "")
    assert (found[2]["problem"], found[0]["problem"]) == (PROBLEM, "")


def test_json_lines_have_the_same_values(folder: Path) -> None:
    text = (written(folder) / "results.jsonl").read_text(encoding="utf-8")
    found = [json.loads(one) for one in text.splitlines()]
    assert [row["index"] for row in found] == list(range(6))
    values = {"regime": "train", "peak_force": 1 / 3, "amplification": 0.1, "waves": 2}
    point = {"shock.duration_ratio": 2.0, "shock.rise_time": 1e-6}
    assert found[0] == {"index": 0, **point, **values, "status": "done", "problem": None}
    assert (found[2]["peak_force"], found[2]["problem"]) == (None, PROBLEM)


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_number_that_is_not_finite_is_no_value(value: float) -> None:
    assert row((Quantity("low", "N", source=""),), SimpleNamespace(low=value)) == [None]


def test_tables_do_not_depend_on_the_order_of_the_journal(tmp_path: Path) -> None:
    mixed = [*reversed(ENTRIES)]
    one, other = written(folder_of(tmp_path / "one")), written(folder_of(tmp_path / "other", entries=mixed))
    for file in ("results.csv", "results.jsonl"):
        assert (one / file).read_bytes() == (other / file).read_bytes()


FORMULAS = {
    "=1+1": "'=1+1",
    "+x": "'+x",
    "@SUM(A1)": "'@SUM(A1)",
    "\t=1": "'\t=1",
    "\r=1": "'\n=1",
    "-x": "'-x",
    "\x1b[1m": "\ufffd[1m",
}


@pytest.mark.parametrize("text", FORMULAS, ids=repr)
def test_text_that_a_spreadsheet_would_run_begins_with_an_apostrophe(tmp_path: Path, text: str) -> None:
    axes = [([MATERIAL], [[text], ["-1.5e3"]])]
    entries = [done(0, text, -1.5, 0.1, -2), (1, "failed", None, text)]
    place = written(folder_of(tmp_path / "out", axes, entries))
    first, second = rows(place)
    assert first["chain.material"] == first["regime"] == second["problem"] == FORMULAS[text]
    assert (second["chain.material"], first["peak_force [N]"], first["waves"]) == ("-1.5e3", "-1.5", "-2")
    objects = [json.loads(one) for one in (place / "results.jsonl").read_text(encoding="utf-8").splitlines()]
    assert objects[0]["regime"] == objects[1]["problem"] == text


def test_a_full_disk_leaves_the_old_table_unchanged(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    (folder / "results.csv").write_text("old", encoding="utf-8")
    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(FileAccessError, match=r"results\.\w+: cannot be written \(No space left on device"):
        written(folder)
    assert (folder / "results.csv").read_text(encoding="utf-8") == "old"
    assert [file.name for file in folder.iterdir() if file.suffix == ".part"] == []


CLASHES = {
    "zip": ([([N, TIME], [[2.0, 1e-6], [4.0, 2e-6]])], {"duration_ratio": "point", "rise_time": "point"}),
    "words": ([([MATERIAL], [["lead"], ["brass-260"]])], {"material": "material"}),
    "column": ([([FORCE], [[1.0], [2.0]])], {"shock_peak_force": "shock_peak_force"}),
    "two-zips": (
        [([N, FORCE], [[2.0, 1.0]]), ([TIME, MATERIAL], [[1e-6, "lead"], [2e-6, {"density": 1}]])],
        {"duration_ratio": "point", "shock_peak_force": "point", "rise_time": "point_2", "material": "point_2"},
    ),
    "equal last names": (
        [([("chain.radius", "m")], [[1.0], [2.0]]), ([("impact.radius", "m")], [[3.0]])],
        {"chain_radius": "chain_radius", "impact_radius": "impact_radius"},
    ),
    "nothing": ([([("chain.granules", "")], [[None], [50]])], {"granules": "granules"}),
}


@pytest.mark.parametrize("name", CLASHES)
def test_axes_of_every_kind_become_dimensions_of_xarray(tmp_path: Path, name: str) -> None:
    xarray = pytest.importorskip("xarray")
    axes, coordinates = CLASHES[name]
    found = load_sweep(folder_of(tmp_path / "out", axes, ENTRIES[:2])).to_xarray()
    assert {one: found[one].dims[0] for one in coordinates} == coordinates
    assert found.peak_force.values.ravel().tolist() == [1 / 3, 2.5e-300]
    # also in a file
    found.to_netcdf(tmp_path / "results.nc", engine="scipy")
    with xarray.open_dataset(tmp_path / "results.nc", engine="scipy") as again:
        assert {one: again[one].dims[0] for one in coordinates} == coordinates


def test_xarray_has_named_axes_units_and_provenance(folder: Path) -> None:
    pytest.importorskip("xarray")
    found = load_sweep(folder).to_xarray()
    assert found.sizes == {"duration_ratio": 2, "rise_time": 3}
    assert (found.peak_force.units, found.rise_time.units, found.duration_ratio.units) == ("N", "s", "1")
    assert (found.rise_time.long_name, found.peak_force.long_name) == ("shock.rise_time", "of the primary")
    assert float(found.peak_force.sel(duration_ratio=4, rise_time=1e-6)) == 1e16
    assert found.regime.values.tolist() == [["train", "single", ""], ["train", "", ""]]
    assert found.title == "a test"
    assert found.source == "shockwave 0.1, python 3"
    assert json.loads(found.scenario) == {"chain": {"radius": 1}}


def test_the_document_has_the_values_in_the_shape_of_the_sweep(folder: Path) -> None:
    found = load_sweep(folder).to_dict()
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert found["values"]["amplification"] == [[0.1, None, None], [-0.0, None, 0.7]]
    assert found["values"]["regime"] == [["train", "single", None], ["train", None, None]]
    assert found["values"]["status"][0] == ["done", "done", "failed"]
    assert found["axes"][1] == {"names": ["shock.rise_time"], "units": ["s"], "values": [[1e-6], [0.1 + 0.2], [3e-5]]}
    assert (found["columns"], found["failed"][0]["problem"]) == (COLUMNS, PROBLEM)


def test_values_have_an_axis_for_each_axis_of_the_sweep(folder: Path) -> None:
    found = load_sweep(folder)
    assert (found.shape, found.complete, found.warnings) == ((2, 3), True, ())
    np.testing.assert_array_equal(found.values("amplification"), [[0.1, np.nan, np.nan], [0.0, np.nan, 0.7]])
    assert found.values("regime").tolist() == [["train", "single", ""], ["train", "", ""]]
    assert found.values("shock.rise_time")[1].tolist() == [1e-6, 0.1 + 0.2, 3e-5]
    assert found.coordinate("shock.duration_ratio").tolist() == [2.0, 4.0]
    assert found.units["peak_force"] == "N"
    assert (found.units["regime"], found.units["shock.rise_time"]) == (None, "s")


def test_results_are_frozen_and_equal_by_value(folder: Path) -> None:
    found = load_sweep(folder)
    assert found == load_sweep(folder)
    with pytest.raises(ValueError, match="read-only"):
        found.values("peak_force")[0, 0] = 1.0


def test_results_print_ranges_counts_and_failures(folder: Path) -> None:
    text = str(load_sweep(folder))
    assert text.startswith("4 of 6 points done; amplification 0 to 0.7\n")
    assert max(map(len, text.splitlines())) <= 80
    assert re.search(r"shock.rise_time +1 us +300 ms +3", text)
    assert re.search(r"regime +2 train, 1 single", text)
    assert "! shock.duration_ratio 2, shock.rise_time 3e-05: no" in text


def test_an_unfinished_sweep_is_read_as_far_as_possible(tmp_path: Path) -> None:
    found = load_sweep(folder_of(tmp_path / "out", entries=ENTRIES[:4]))
    assert "2 of 6 points have not been run" in "; ".join(found.warnings)
    assert found.values("peak_force")[0, 0] == 1 / 3
    assert (found.complete, found.values("status")[1, 2]) == (False, "not run")


def test_a_file_that_is_no_journal_is_refused(folder: Path) -> None:
    with closing(sqlite3.connect(folder / "journal.sqlite")) as database, database:
        database.execute("CREATE VIEW more AS SELECT * FROM points")
    with pytest.raises(FileAccessError, match=r"journal\.sqlite: cannot be read .*the table of points alone"):
        load_sweep(folder)
    (folder / "journal.sqlite").write_text("of another program\n" * 100)
    with pytest.raises(FileAccessError, match=r"journal\.sqlite: cannot be read .*file is not a database"):
        load_sweep(folder)


#: A key of the definition, and its wrong value.
WRONG_DEFINITIONS: dict[str, tuple[str, Any]] = {
    "text-for-axes": ("axes", "abc"),
    "no-axes": ("axes", []),
    "many-points": ("axes", [{"names": [], "units": [], "values": [[]] * 1000}] * 3),
    "words-for-numbers": ("axes", [{"names": ["a"], "units": ["s"], "values": [["two"]]}]),
    "a-value-too-many": ("axes", [{"names": ["a"], "units": ["s"], "values": [[1.0, 2.0]]}]),
    "versions": ("versions", [1]),
    "not-a-number": ("scenario", float("nan")),
    "later-format": ("format", 5),
}


@pytest.mark.parametrize("name", WRONG_DEFINITIONS)
def test_an_invalid_definition_is_refused(folder: Path, name: str) -> None:
    key, value = WRONG_DEFINITIONS[name]
    document = json.loads((folder / "sweep.json").read_text())
    (folder / "sweep.json").write_text(json.dumps(document | {key: value}))
    with pytest.raises(InvalidValueError, match=r"sweep\.json: must be "):
        load_sweep(folder)


@pytest.mark.parametrize("name", ["sweep.json", "journal.sqlite"])
def test_only_regular_files_are_read(folder: Path, name: str) -> None:
    (folder / name).unlink()
    os.mkfifo(folder / name)
    with pytest.raises(FileAccessError, match=f"{name}: is not a file"):
        load_sweep(folder)


def test_a_sweep_that_has_just_begun_is_empty(folder: Path) -> None:
    (folder / "journal.sqlite").unlink()
    found = load_sweep(folder)
    assert (found.complete, bool(np.isnan(found.values("peak_force")).all())) == (False, True)
    assert "6 of 6 points have not been run" in str(found)


@pytest.mark.parametrize("name", ["peak_forc", "shock.rise_tim"])
def test_an_unknown_quantity_is_refused_with_a_suggestion(folder: Path, name: str) -> None:
    with pytest.raises(UnknownNameError, match="did you mean"):
        load_sweep(folder).values(name)
    with pytest.raises(UnknownNameError, match="unknown variable of the sweep"):
        load_sweep(folder).coordinate("peak_force")


def test_a_folder_without_a_sweep_is_refused_with_a_hint(tmp_path: Path) -> None:
    with pytest.raises(FileAccessError, match=r"sweep\.json: cannot be read .*; choose a folder that `shockwave sweep"):
        load_sweep(tmp_path)
    with pytest.raises(InvalidValueError, match=r"^folder: must be the path of a folder, such as 'results' \(got None"):
        load_sweep(None)  # type: ignore[arg-type]


def test_earlier_versions_are_reported(folder: Path) -> None:
    header = json.loads((folder / "sweep.json").read_text(encoding="utf-8"))
    header["earlier_versions"] = [{"shockwave": "0.0.9", "numpy": "1.26"}]
    (folder / "sweep.json").write_text(json.dumps(header), encoding="utf-8")
    warning = "points may have been run with other versions (shockwave 0.0.9, numpy 1.26)"
    assert load_sweep(folder).warnings == (warning,)


def test_a_data_frame_is_indexed_by_the_variables(folder: Path) -> None:
    pytest.importorskip("pandas")
    found = load_sweep(folder).to_pandas()
    assert found.loc[(4.0, 1e-6), "peak_force"] == 1e16
    assert (found.attrs["units"]["peak_force"], found.attrs["units"]["shock.rise_time"]) == ("N", "s")
