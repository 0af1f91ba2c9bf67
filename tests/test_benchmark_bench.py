"""The bench as it is called: families, scenarios, what cannot be run, the page."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Sequence
from functools import cache
from html.parser import HTMLParser
from pathlib import Path

import pytest
from attrs import evolve

import shockwave as sw
from selection import keeping
from shockwave.benchmark import bench, outside, quadratures, smooth
from shockwave.benchmark.rows import Order, Problem, Row, WorkPrecision
from shockwave.errors import FileAccessError, InvalidValueError, UsageError
from shockwave.quadrature import Integral, Integrand
from shockwave.registry import entries, load

pytestmark = pytest.mark.usefixtures("frozen")

ROOT = Path(__file__).parent.parent
LITTLE = 0.02


def scenario() -> sw.Scenario:
    return sw.load_scenario(ROOT / "profiles" / "examples" / "triangular.yaml")


@cache
def predictors() -> WorkPrecision:
    return bench.run([scenario()], ["predictors"], quick=True)


def of_method(result: WorkPrecision, begin: str) -> list[Row]:
    return [row for row in result.rows if row.method.startswith(begin)]


# ---------------------------------------------------------------- families


def test_every_quadrature_has_rows_on_every_problem() -> None:
    result = bench.run(families=["quadratures"], quick=True, longest=LITTLE)
    pairs = {(row.case, row.method) for row in result.rows}
    names = {entry.name for entry in entries("quadratures")}
    assert pairs == {(problem.name, name) for problem in result.problems for name in names}


def test_formulae_simulation_and_scipy_are_on_the_same_problem() -> None:
    (problem,) = predictors().problems
    methods = {row.method for row in predictors().of(problem) if row.error is not None}
    assert {"section-4, constant", "section-4, literal", "simulate", "scipy DOP853"} <= methods


def test_section_4_is_there_in_every_reading() -> None:
    settings = [row.setting for row in of_method(predictors(), "section-4")]
    assert settings == [f"alpha {alpha}, {a} A" for alpha in ("constant", "literal") for a in ("exact", "paper")]


def test_error_of_a_formula_is_that_of_the_comparison() -> None:
    scene = scenario()
    compared = sw.compare(scene.shock, scene.chain, rtol=1e-9, waves="primary")
    row = of_method(predictors(), "section-4, constant")[0]
    assert row.error == pytest.approx(abs(compared.error), abs=1e-8)


def test_simulation_errs_by_less_than_it_was_asked_for() -> None:
    rows = of_method(predictors(), "simulate")
    assert len(rows) >= 3
    assert all(row.error is not None and row.value is not None and row.error <= row.value for row in rows)


@pytest.fixture
def only_scipy(monkeypatch: pytest.MonkeyPatch) -> None:
    """Compiling takes longer than all that is looked at."""
    monkeypatch.setattr(outside, "CODES", (outside.SCIPY,))


@pytest.mark.usefixtures("only_scipy")
def test_every_integrator_has_rows() -> None:
    result = bench.run([scenario()], ["integrators"], quick=True, longest=LITTLE)
    methods = {row.method for row in result.rows}
    assert {entry.name for entry in entries("integrators")} | {"simulate", "scipy DOP853"} <= methods


@pytest.mark.usefixtures("only_scipy")
def test_a_chain_that_ends_is_read_before_its_end() -> None:
    scene = scenario()
    short = evolve(scene, chain=evolve(scene.chain, granules=30))
    result = bench.run([short], ["integrators"], quick=True, longest=LITTLE)
    assert "contact 20" in result.problems[0].description
    first = of_method(result, "simulate")[0]
    assert first.error is not None, first.problem
    assert first.error < 1e-2


def test_a_scene_that_cannot_be_simulated_is_a_row_that_says_why() -> None:
    scene = scenario()
    slow = evolve(scene, shock=evolve(scene.shock, rise_time=10.0))
    (row,) = bench.run([slow], ["predictors"], quick=True).rows
    assert "a matter of statics" in row.problem


def test_scenes_of_one_name_are_told_apart() -> None:
    result = bench.run([scenario()] * 2, ["quadratures"], quick=True, longest=LITTLE)
    assert [problem.name for problem in result.problems] == [scenario().name, f"{scenario().name} (2)"]
    assert len(result.of(result.problems[0])) == len(result.of(result.problems[1])) > 0


def test_names_made_for_scenes_are_those_of_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(quadratures, "rows", lambda *_: iter(()))
    scenes = [evolve(scenario(), name=name) for name in ("x", "x", "x (2)", "x")]
    names = [problem.name for problem in bench.run(scenes, ["quadratures"], True, longest=LITTLE).problems]
    assert names == ["x", "x (3)", "x (2)", "x (4)"]


@pytest.mark.usefixtures("only_scipy")
def test_a_scene_may_be_called_as_the_problem_of_the_orders() -> None:
    scene = evolve(scenario(), name=smooth.NAME)
    result = bench.run([scene], ["integrators"], quick=True, longest=LITTLE)
    assert (result.problems[0].name, result.orders) == (smooth.NAME, ())


def test_a_quadrature_that_finds_no_number_is_a_row_that_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    class Nan(load("quadratures", "tanh-sinh")):  # type: ignore[misc]
        def integrate(self, integrand: Integrand, points: Sequence[float], tolerance: float = 1e-14) -> Integral:
            found: Integral = super().integrate(integrand, points, tolerance)
            # in the second place, which a greatest that is taken one by one passes over
            return found if points[0] < 1 else evolve(found, value=float("nan"))

    monkeypatch.setattr(quadratures, "load", lambda _, name: Nan)
    monkeypatch.setattr(quadratures, "NAMED", quadratures.NAMED[:1])
    result = bench.run(families=["quadratures"], quick=True, longest=60)
    assert {row.problem for row in result.rows} == {"not finite"}
    json.dumps(result.to_dict(), allow_nan=False)


# ---------------------------------------------------------------- what is refused


def test_an_unknown_family_is_refused() -> None:
    with pytest.raises(InvalidValueError, match=r"families: must be of quadratures, predictors, integrators \(got 'a'"):
        bench.run(families=["a"])


@pytest.mark.parametrize("longest", [0.0, -1.0, float("nan"), 1e9])
def test_a_time_out_of_range_is_refused(longest: float) -> None:
    with pytest.raises(InvalidValueError, match="longest: must be"):
        bench.run(families=["quadratures"], quick=True, longest=longest)


def test_another_ending_of_the_page_is_refused() -> None:
    with pytest.raises(UsageError, match=r"output must end in .html or .svg \(got 'page.pdf'\)"):
        bench.run(output="page.pdf")


def test_without_matplotlib_one_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(UsageError, match=r"^pictures need matplotlib: pip install 'granular-shockwave\[plot\]'$"):
        bench.run(output=tmp_path / "page.html")


# ---------------------------------------------------------------- the page


def made(name: str = "<b>&", note: str = "no <script>") -> WorkPrecision:
    """A small result whose texts are not HTML."""
    problem = Problem(
        family="predictors",
        name=name,
        description="a <pulse>",
        quantities=("peak force",),
        reference="r",
        reference_error=1e-9,
    )
    common = {"family": "predictors", "case": name, "reference_error": 1e-9}
    rows = [
        Row(**common, method=method, setting=f"rtol {error:g}", value=error, errors={"peak force": error}, seconds=s)  # type: ignore[arg-type]
        for method, error, s in (("simulate", 1e-4, 1e-4), ("simulate", 1e-7, 2e-4), ("section-4", 1e-2, 1e-4))
    ]
    rows.append(Row(**common, method="<absent>", setting="-", value=None, problem=note))  # type: ignore[arg-type]
    other = evolve(problem, family="integrators", quantities=("peak force", "arrival time", "energy"))
    rows += [
        evolve(row, family="integrators", errors={"peak force": 1e-3, "arrival time": 1e-4, "energy": None})
        for row in rows[:2]
    ]
    orders = (Order(method="<m>", declared=2, fitted=2.01),)
    return WorkPrecision(problems=(problem, other), rows=tuple(rows), orders=orders, provenance={"os": "<x>"})


class _Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.names: list[str] = []
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.names += [value or "" for key, value in attrs if key == "id"]
        self.links += [value or "" for key, value in attrs if key in ("src", "href", "xlink:href")]


@cache
def parsed() -> tuple[str, _Tags]:
    pytest.importorskip("matplotlib")
    from shockwave.benchmark.page import page

    text, tags = page(made()), _Tags()
    tags.feed(text)
    return text, tags


def test_page_loads_nothing_from_elsewhere() -> None:
    assert all(link.startswith("#") for link in parsed()[1].links)


def test_the_page_may_not_load_or_send_anything() -> None:
    policy = re.search('<meta http-equiv="Content-Security-Policy" content="([^"]*)">', parsed()[0])
    assert policy is not None
    assert {"default-src 'none'", "base-uri 'none'", "form-action 'none'"} <= set(policy[1].split("; "))


def test_characters_that_reverse_text_direction_are_replaced_in_the_page() -> None:
    from shockwave.benchmark.page import page

    result = made(name="a\u202eb")
    assert "\u202e" not in page(evolve(result, problems=result.problems[:1]))


def test_texts_of_the_page_are_escaped() -> None:
    text, tags = parsed()
    assert {"b", "script", "pulse", "absent", "m", "x"} & set(tags.tags) == set()
    assert "no &lt;script&gt;" in text


def test_names_within_the_page_are_unique() -> None:
    names = parsed()[1].names
    assert len(names) == len(set(names)) > 0


def test_page_has_a_figure_for_each_error_that_is_drawn() -> None:
    assert parsed()[1].tags.count("figure") == 3


def test_page_says_why_a_method_is_not_drawn() -> None:
    assert "<li>&lt;absent&gt;: no &lt;script&gt;</li>" in parsed()[0]


def test_page_is_the_same_whenever_it_is_made() -> None:
    from shockwave.benchmark.page import page

    assert page(made()) == parsed()[0]


@pytest.mark.parametrize("ending", keeping(["html", "svg"], "html"))
def test_output_is_written(ending: str, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    file = tmp_path / f"page.{ending}"
    bench.run([scenario()], ["quadratures"], quick=True, longest=LITTLE, output=file)
    assert re.search(r"</(html|svg)>\s*$", file.read_text(encoding="utf-8"))


@pytest.mark.parametrize("place", ["missing/page.svg", "folder.html"])
def test_output_that_cannot_be_written_is_told_before_anything_is_run(place: str, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    (tmp_path / "folder.html").mkdir()
    run: list[str] = []
    with pytest.raises(FileAccessError, match="cannot be written"):
        bench.run([scenario()], ["quadratures"], True, tmp_path / place, LITTLE, run.append)
    assert run == []


def test_what_was_found_is_not_lost_with_the_page(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    folder = tmp_path / "folder"
    folder.mkdir()
    with pytest.raises(FileAccessError, match="cannot be written") as caught:
        bench.run([scenario()], ["quadratures"], True, folder / "page.svg", LITTLE, lambda _: folder.rmdir())
    assert isinstance(caught.value, bench.NotWrittenError)
    assert "tanh-sinh" in caught.value.result.table()


def test_dollars_in_names_begin_no_formula() -> None:
    pytest.importorskip("matplotlib")
    from shockwave.benchmark.page import page

    result = made(name=r"$\frac{a}{$")
    rows = tuple(evolve(row, method="$x^{$") for row in result.rows)
    assert "<figure>" in page(evolve(result, problems=result.problems[:1], rows=rows))


def test_page_names_the_problem_of_the_orders() -> None:
    assert f"<em>{smooth.NAME}</em>" in parsed()[0]


# ---------------------------------------------------------------- what it costs others


@pytest.mark.parametrize("command", ["predict", "simulate"])
def test_other_commands_load_neither_bench_nor_page_nor_pictures(command: str) -> None:
    file = str(ROOT / "profiles" / "examples" / "triangular.yaml")
    program = (
        f"import sys\nfrom shockwave.cli import main\nmain({[command, file]!r})\nprint(*sys.modules, file=sys.stderr)"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    loaded = set(run.stderr.split())
    assert "shockwave.cli" in loaded
    drawing = ("shockwave.benchmark", "shockwave.page", "shockwave.pictures", "matplotlib")
    assert not [name for name in loaded if name.startswith(drawing)]
