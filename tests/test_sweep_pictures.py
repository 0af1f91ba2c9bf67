"""Pictures of sweeps: lines over one axis, maps over two, with the borders of the regimes."""

from __future__ import annotations

import json
import re
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import shockwave as sw
from shockwave import cli
from shockwave.errors import UsageError
from shockwave.scenario.scene_family import Family
from shockwave.sweep.plot import plot
from shockwave.sweep.regimes import regimes
from shockwave.sweep.results import SweepResults, load_sweep

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
