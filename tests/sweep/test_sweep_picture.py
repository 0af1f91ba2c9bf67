"""Pictures of sweeps: lines over one axis, maps over two, with the borders of the regimes."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.contour import ContourSet
from test_results import FORCE, MATERIAL, TIME, done, folder_of

from shockwave import cli
from shockwave.base.errors import UsageError
from shockwave.sweep.results import SweepResults, load_sweep
from shockwave.sweep.sweep_picture import Plot, plot
from support.figures import inside, key_of


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    """Figures of pyplot live until they are closed."""
    yield
    pyplot.close("all")


RATIO = ("shock.duration_ratio", "")
UNITS = {
    "section4_regime": None,
    "notes": None,
    "peak_force": "N",
    "recoil_momentum": "N s",
    "recoil_error": "N s",
    "width": "s",
}


def swept(folder: Path, axes: Any, columns: dict[str, Any], failed: tuple[int, ...] = ()) -> SweepResults:
    """A sweep over axes of variables and values, with a list of values for each column."""
    described = []
    for name in columns:
        unit = UNITS.get(name, "")
        described.append({"name": name, "unit": unit, "kind": "number" if unit is not None else "text", "meaning": "a"})
    rows = enumerate(zip(*columns.values(), strict=True))
    lines = [(at, "failed", None, "no") if at in failed else done(at, *values) for at, values in rows]
    return load_sweep(folder_of(folder, axes, lines, described))


def numbered(folder: Path, axes: Any) -> SweepResults:
    """A sweep in which the amplification of a point is its number, counted from 0."""
    count = int(np.prod([len(values) for _, values in axes]))
    return swept(folder / "out", axes, {"amplification": list(range(count))})


TIMES = np.geomspace(1e-6, 1e-4, 15)
RATIOS = np.geomspace(1.5, 15, 12)
#: A train for long n t0, an ejection for short n t0.
PLANE = np.outer(TIMES, RATIOS)
NAMES = np.where(PLANE > 5e-5, "train", "ejection")


def a_map(folder: Path, failed: tuple[int, ...] = ()) -> SweepResults:
    axes = [([TIME], TIMES[:, None].tolist()), ([RATIO], RATIOS[:, None].tolist())]
    columns = {"section4_regime": NAMES.ravel().tolist(), "amplification": PLANE.ravel().tolist()}
    return swept(folder / "map", axes, columns, failed)


def along(variable: tuple[str, str], *values: Any) -> Any:
    return [variable], [[value] for value in values]


def lines_of(found: Plot) -> list[list[list[float]]]:
    return [one.get_xydata().tolist() for one in found.ax.get_lines()]  # type: ignore[union-attr]


def test_two_axes_give_a_map_with_units_and_regime_borders(tmp_path: Path) -> None:
    found = plot(a_map(tmp_path))
    (ax,) = found.ax.figure.axes
    assert (found.column, ax.get_xlabel(), ax.get_ylabel()) == ("amplification", "rise time (µs)", "duration ratio")
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    assert {text.get_text() for text in ax.texts} == {"ejection", "train"}
    mesh, *rest = ax.collections
    # halfway between factors of 100^(1/14) from 1 us
    edges = mesh.get_coordinates()[0, :, 0]
    np.testing.assert_allclose(edges, 1e-6 * 100 ** ((np.arange(16) - 0.5) / 14), rtol=1e-12)
    np.testing.assert_array_equal(mesh.get_array().reshape(12, 15).T, PLANE)
    across, upwards = rest[-2:]
    places = {float(segment[0, 0]) for segment in across.get_segments()}
    assert sorted(places) == pytest.approx(edges[1:-1][(NAMES[1:] != NAMES[:-1]).any(axis=1)])
    assert len(upwards.get_segments()) == np.count_nonzero(NAMES[:, 1:] != NAMES[:, :-1])


def test_a_map_of_amplifications_has_a_line_at_one(tmp_path: Path) -> None:
    assert not any(isinstance(each, ContourSet) for each in plot(a_map(tmp_path)).ax.collections)
    axes = [([TIME], TIMES[:, None].tolist()), ([RATIO], RATIOS[:, None].tolist())]
    doubled = np.outer(TIMES / TIMES[7], np.ones(len(RATIOS)))
    (line,) = (
        each
        for each in plot(swept(tmp_path / "one", axes, {"amplification": doubled.ravel().tolist()})).ax.collections
        if isinstance(each, ContourSet)
    )
    np.testing.assert_allclose(line.get_paths()[0].vertices[:, 0], TIMES[7])


def test_values_that_crowd_at_one_end_have_half_of_the_colours(tmp_path: Path) -> None:
    axes = [([TIME], TIMES[:, None].tolist()), ([RATIO], RATIOS[:, None].tolist())]
    crowded = np.linspace(0.97, 1.0, PLANE.size)
    crowded[:5] = 0.0
    mesh = plot(swept(tmp_path / "crowd", axes, {"amplification": crowded.tolist()})).ax.collections[0]
    assert mesh.norm(0.99) - mesh.norm(0.98) > 0.1
    assert mesh.norm(0.0) == 0
    ticks = mesh.colorbar.ax.get_yticks()
    assert min(np.count_nonzero(ticks > 0.98), np.count_nonzero(ticks < 0.98)) >= 2


def test_points_without_a_value_are_masked_and_counted(tmp_path: Path) -> None:
    results = a_map(tmp_path, failed=(3, 77))
    found = plot(results)
    assert np.ma.asarray(found.ax.collections[0].get_array()).mask.sum() == 2
    assert "2 of the 180 drawn points failed" in found.notes
    # only drawn points are counted
    assert "1 of the 12 drawn points failed" in plot(results, at={TIME[0]: TIMES[6]}).notes


@pytest.mark.parametrize("held", [{}, {RATIO[0]: 1.5}], ids=["map", "line"])
def test_a_sweep_without_results_is_drawn_empty(tmp_path: Path, held: dict[str, float]) -> None:
    assert inside(plot(a_map(tmp_path, failed=tuple(range(180))), at=held).ax.figure)


def test_the_amplification_is_drawn_and_without_it_the_first_number(tmp_path: Path) -> None:
    axes = [([TIME], [[1e-6], [2e-6]])]
    numbers = {"peak_force": [3.0, 4.0], "section4_peak_force": [5.0, 6.0]}
    both = {"amplification": [0.3, 0.4], "section4_amplification": [0.5, 0.6]}
    # points without an answer of the engine
    unknown = both | {"amplification": [None, None]}
    cases = (numbers | both, "amplification"), (numbers, "peak_force"), (numbers | unknown, "section4_amplification")
    for columns, name in cases:
        found = plot(swept(tmp_path / name, axes, columns))
        assert found.column == name
        assert lines_of(found) == [[[1e-6, columns[name][0]], [2e-6, columns[name][1]]]]


def test_one_axis_gives_a_line(tmp_path: Path) -> None:
    found = plot(a_map(tmp_path), at={RATIO[0]: repr(float(RATIOS[4]))})
    assert lines_of(found) == [np.column_stack([TIMES, PLANE[:, 4]]).tolist()]
    assert found.ax.get_xlabel() == f"rise time (µs)\nduration ratio {RATIOS[4]:.6g}"
    assert inside(found.ax.figure)


def test_a_few_values_of_a_second_axis_give_lines(tmp_path: Path) -> None:
    found = plot(numbered(tmp_path, [along(TIME, 1.0, 2.0, 3.0), along(RATIO, 2.0, 4.0)]))
    assert key_of(found.ax) == ["duration ratio 2", "duration ratio 4"]
    assert lines_of(found) == [[[1, 0], [2, 2], [3, 4]], [[1, 1], [2, 3], [3, 5]]]


ERRORS: dict[str, tuple[dict[str, Any], str]] = {
    "relative": (
        {"amplification": [2.0, 4.0], "error_estimate": [0.1, 0.25]},
        "amplification: relative error at most 2.5e-01",
    ),
    "of-momentum": (
        {"recoil_momentum": [2.0, 3.0], "recoil_error": [0.5, 1.0]},
        "recoil_momentum: error at most 1 N s",
    ),
    "of-forces": (
        {"greatest_force": [2.0, 4.0], "error_estimate": [0.1, 0.25]},
        "greatest_force: relative error at most 2.5e-01",
    ),
    # the ends of a range are those of the peak force, of which the amplification is a multiple
    "of-range": (
        {"amplification": [2.0, 4.0], "peak_force": [20.0, 40.0], "low": [18.0, 39.0], "high": [22.0, 41.0]},
        "amplification: relative error at most 1.0e-01",
    ),
    "section-4": (
        {"peak_force": [20.0, 40.0], "low": [None, None], "high": [None, None]},
        "peak_force: by section 4, error not known",
    ),
}


@pytest.mark.parametrize("case", ERRORS)
def test_the_accuracy_of_the_drawn_values_is_stated(tmp_path: Path, case: str) -> None:
    columns, note = ERRORS[case]
    found = plot(swept(tmp_path / "out", [along(RATIO, 2.0, 3.0)], columns), next(iter(columns)))
    assert found.notes[0] == note


def test_a_picture_of_points_with_warnings_is_marked(tmp_path: Path) -> None:
    columns = {
        "amplification": [2.0, 4.0],
        "notes": ["Beyond validity. Note: The end was cut.", "Note: The end was cut."],
    }
    drawing = plot(swept(tmp_path / "out", [along(RATIO, 2.0, 3.0)], columns))
    assert "! 1 of 2 points with warnings" in [text.get_text() for text in drawing.ax.texts]
    assert drawing.notes[1:] == ("In 1 of 2 points (0): Beyond validity.",)


def test_each_sentence_of_the_warnings_is_listed_once_with_its_points(tmp_path: Path) -> None:
    yielding = "Beyond validity: the force is {} N. No yield."
    notes = [yielding.format(3.5), yielding.format(2.5) + " A wave is cut.", "A wave is cut.", "A wave is cut."]
    columns = {"amplification": [1.0, 2.0, 3.0, 4.0], "notes": notes}
    drawing = plot(swept(tmp_path / "out", [along(RATIO, 2.0, 3.0, 4.0, 5.0)], columns))
    assert drawing.notes[1:] == (
        "In 3 of 4 points (1, 2, 3): A wave is cut.",
        "In 2 of 4 points (0, 1), greatest at point 0: Beyond validity: the force is 3.5 N. No yield.",
    )


def test_warnings_of_points_that_are_not_drawn_are_left_out(tmp_path: Path) -> None:
    columns = {"amplification": [1.0, 2.0, 3.0, 4.0], "notes": ["A.", "B.", "", "B."]}
    results = swept(tmp_path / "out", [along(RATIO, 2.0, 3.0), along(TIME, 1.0, 2.0)], columns)
    assert plot(results, at={RATIO[0]: 3.0}).notes[1:] == ("In 1 of 2 points (3): B.",)


def test_an_axis_of_several_variables_is_drawn_as_markers(tmp_path: Path) -> None:
    axis = ([TIME, FORCE], [[1.0, 5.0], [10.0, 5.0], [1.0, 6.0], [10.0, 6.0], [100.0, 6.0]])
    results = numbered(tmp_path, [axis])
    found = plot(results)
    assert lines_of(found) == [[[1, 0], [1, 2], [10, 1], [10, 3], [100, 4]]]
    assert found.ax.get_lines()[0].get_linestyle() == "None"
    held = plot(results, at={FORCE[0]: 5})
    assert lines_of(held)[0] == [[1, 0], [10, 1]]
    assert held.ax.get_lines()[0].get_linestyle() == "-"
    assert held.ax.get_xlabel().endswith("\npeak force 5 N")


def test_coinciding_points_of_a_map_are_refused(tmp_path: Path) -> None:
    axis = ([TIME, FORCE], [[1.0 + at // 2, 5.0 + at % 2] for at in range(8)])
    with pytest.raises(UsageError, match=r"different coordinates \(got shock.rise_time, which repeats"):
        plot(numbered(tmp_path, [axis, along(RATIO, *range(2, 12))]))


@pytest.mark.parametrize(
    ("end", "label"),
    [("", "diameter"), (".from", "first diameter"), (".to", "last diameter")],
    ids=["all", "from", "to"],
)
def test_variables_that_end_alike_are_labelled_with_all_of_their_names_in_words(
    tmp_path: Path, end: str, label: str
) -> None:
    axes = [([(f"chain.granules[{part}].diameter{end}", "m")], [[1e-3], [2e-3], [3e-3]]) for part in (0, 1)]
    ax = plot(numbered(tmp_path, axes), at={f"chain.granules[1].diameter{end}": "1 mm"}).ax
    assert ax.get_xlabel() == f"segment 0 {label} (mm)\nsegment 1 {label} 1 mm"


def test_materials_are_labelled_with_their_name_or_number(tmp_path: Path) -> None:
    materials = along(MATERIAL, {"name": "mine", "density": 1}, "lead", {"density": 2}, r"$\foo$", None)
    results = numbered(tmp_path, [materials, along(RATIO, 2, 3, 4)])
    found = plot(results, x=MATERIAL[0])
    names = ["mine", "lead", "#3", r"$\foo$", "none"]
    assert [label.get_text().replace("\\$", "$") for label in found.ax.get_xticklabels()] == names
    # an unknown symbol must not be parsed as a formula
    assert inside(found.ax.figure)
    for at, name in enumerate(names):
        assert lines_of(plot(results, at={MATERIAL[0]: name}))[0][0] == [2, 3 * at]
    assert plot(results, at={MATERIAL[0]: "mine"}).ax.get_xlabel().endswith("\nmaterial mine")


def test_three_axes_are_refused_unless_one_is_fixed(tmp_path: Path) -> None:
    found = numbered(tmp_path, [along(RATIO, 2, 4), along(TIME, 1e-6, 0.3, 3e-5), along(FORCE, 1, 2)])
    listed = "fix 1 of them with --at NAME=VALUE: shock.duration_ratio=2, 4; shock.rise_time=1 µs, 300 ms, "
    with pytest.raises(UsageError, match=re.escape(listed)):
        plot(found)
    assert plot(found, at={FORCE[0]: 2.0}).column == "amplification"


WRONG: dict[str, tuple[list[str], int, str]] = {
    "column": (["--column", "amplificatio"], 2, "did you mean 'amplification'"),
    "text": (["--column", "section4_regime"], 2, "numeric column (got 'section4_regime'; known: amplification)"),
    "variable": (["--x", "shock.rise_tim"], 2, "unknown variable of the sweep"),
    "held": (["--at", "shock.duration_ratio=3"], 2, "must be one of its values (got 3; they are 1.5, "),
    "held-unit": (["--at", "shock.duration_ratio=3 s"], 2, "shock.duration_ratio: must be a number"),
    "held-form": (["--at", "shock.duration_ratio"], 2, "--at: must be NAME=VALUE"),
    "held-both": (["--at", "shock.duration_ratio=1.5", "--at", "shock.rise_time=1 us"], 2, "(got one point; see"),
    "held-x": (["--at", "shock.rise_time=1 us", "--x", "shock.rise_time"], 2, "must be a variable with several values"),
    "ending": (["-o", "map.gif"], 2, "--output: must end in .svg, .png or .pdf"),
    "place": (["-o", "nowhere/map.svg"], 5, "cannot be written"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_wrong_options_are_refused_with_a_hint(
    tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    a_map(tmp_path)
    monkeypatch.chdir(tmp_path)
    arguments, status, part = WRONG[name]
    assert cli.main(["plot", "map", *arguments]) == status
    assert part in capsys.readouterr().err


def test_pictures_with_other_options_get_other_names(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    numbered(tmp_path, [along(TIME, 1e-6, 2e-6), along(RATIO, 2, 3)])
    for options in ([], ["--at", "shock.rise_time=1 us"], ["--x", "shock.duration_ratio"], []):
        assert cli.main(["plot", str(tmp_path / "out"), *options]) == 0
    names = {"", "-shock.rise_time=1_us", "-over-shock.duration_ratio"}
    assert {file.name for file in (tmp_path / "out").glob("*.svg")} == {f"amplification{name}.svg" for name in names}
    states = [text.rpartition(" ")[2] for text in capsys.readouterr().err.splitlines() if ".svg: " in text]
    assert states == ["written", "written", "written", "replaced"]


def test_results_draw_their_main_quantity(tmp_path: Path) -> None:
    results = numbered(tmp_path, [along(TIME, 1.0, 2.0, 3.0)])
    ax = results.plot()
    assert ax.get_ylabel() == "amplification"
    assert ax.get_lines()[0].get_ydata().tolist() == [0, 1, 2]  # type: ignore[union-attr]
