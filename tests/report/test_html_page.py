"""Page of a scenario: complete, escaped, self-contained and reproducible."""

import json
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from functools import cache
from html import escape
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import shockwave as sw
from shockwave import cli, pictures
from shockwave.registry.registry import load
from shockwave.report import compute_results, page, render_page
from shockwave.report.html_page import _parameters, choose_pictures, draw_pictures, list_parts
from shockwave.report.number_text import formula, percent, quantity, typeset
from shockwave.scenario.scene_hash import scene_hash
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation.result_parts import Train
from support.scenario_texts import scenario_in_python as scenario
from support.scenes import CHAIN, power, triangle
from support.slow_cases import keeping

ROOT = Path(__file__).parents[2]
ROW1 = ROOT / "profiles" / "paper" / "table2-row1.yaml"
EVIL = "</title></pre><script>alert(1)</script>\" onload='x' <b>&amp; \u202eevil"
DAMPED = sw.Segment(count=5, damping=sw.Dashpot(coefficient=1e-6))
# Two peaks, and a rise that is too slow for the second of the conditions (3).
PEAKS = sw.Tabulated(times=[0, 2e-5, 3e-5, 5e-5, 7e-5, 9e-5], forces=[0, 10, 100, 20, 60, 0])
#: Both regimes, a shock outside (3), finite chains, and an integrator with a fixed step.
SCENES = {
    "ejection": sw.load_scenario(ROW1),
    "several peaks": scenario(sw.Shock(profile=PEAKS)),
    "two granules": scenario(power(0.5), evolve(CHAIN, granules=2), integrator="verlet", step=0.05, waves="primary"),
    "twelve granules": scenario(triangle(9.0), evolve(CHAIN, granules=12), contacts=[3, 8]),
}
#: Chains before a wall, the second of two materials and with a limit.
HALVES = (sw.Segment(count=15), sw.Segment(count=15, material=sw.material("ptfe")))
WALLED = evolve(scenario(triangle(0.5)), chain=evolve(CHAIN, granules=30, end=sw.Wall()))
LAYERED = evolve(WALLED, chain=evolve(WALLED.chain, granules=HALVES), limit=sw.Limit(force=1e3))


@cache
def made(name: str) -> str:
    return page({"wall": WALLED, "layers": LAYERED}.get(name) or SCENES[name])


def without_pictures(found: Any) -> str:
    """The page without its pictures, which take most of the time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("shockwave.report.html_page.choose_pictures", lambda _: {})
        return render_page(found)


@cache
def undrawn(name: str) -> str:
    return without_pictures(compute_results(SCENES[name]))


def parsed(text: str) -> ET.Element:
    """The page as a tree; unbalanced tags are an error."""
    return ET.fromstring(re.sub("<meta[^>]*>|<!DOCTYPE html>", "", text))


def plain(text: str) -> str:
    """Text without markup and with plain blanks."""
    return " ".join(re.sub("<[^>]*>", "", text).replace("\N{NO-BREAK SPACE}", " ").split())


def test_the_widest_table_is_stacked_on_a_phone_with_a_name_for_each_cell() -> None:
    (table,) = parsed(undrawn("ejection")).iterfind(".//div[@class='spanning stacked']//table")
    for row in table.iterfind("tbody/tr"):
        names = [cell.get("data-name", "") for cell in row]
        assert len(set(names)) == len(names) == len(table.findall("thead/tr/th"))
    assert "prefers-color-scheme: dark" in undrawn("ejection")


@pytest.mark.parametrize("name", keeping(SCENES, "ejection"))
def test_every_page_is_complete_and_self_contained(name: str) -> None:
    text = made(name)
    root = parsed(text)
    assert text.startswith("<!DOCTYPE html>")
    assert "Not drawn" not in text
    # the correction area is drawn for ejections only
    ejection = compute_results(SCENES[name]).predicted.regime == "ejection"  # type: ignore[union-attr]
    assert len(root.findall(".//figure")) == text.count('<svg role="img"') == 7 + ejection
    assert "nan" not in plain(re.sub("<svg.*?</svg>", "", text, flags=re.DOTALL)).lower().split()
    assert not {"script", "link", "iframe", "object", "embed", "img", "form"} & {one.tag for one in root.iter()}
    targets = ["".join(found) for found in re.findall(r'(?:href|src)="(.*?)"|url\((.*?)\)', text)]
    assert all(target.startswith(("#", "data:image/png;base64,")) for target in targets)
    assert "@import" not in text
    assert "content=\"default-src 'none'; style-src 'unsafe-inline'; img-src data:;" in text
    given = [one.get("id") for one in root.iter() if one.get("id")]
    assert len(given) == len(set(given)) > 0
    assert {"#" + name for name in given} >= {target for target in targets if target.startswith("#")}


def test_the_command_writes_the_same_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["report", str(ROW1), "-o", str(tmp_path / "page.html")]) == 0
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == made("ejection")
    assert "Traceback" not in capsys.readouterr().err


def test_the_simulation_is_stated_first_and_section_4_with_its_actual_error() -> None:
    scene = SCENES["ejection"]
    compared = sw.compare(scene)
    paper, simulated = compared.predicted.section4, compared.simulated  # type: ignore[union-attr]
    head = plain(undrawn("ejection").partition("</header>")[0])
    # the first digits, without those that the error estimates do not support
    first = head.index(f"Simulation: peak force of the leading wave {str(simulated.peak_force)[:6]}")
    assert first < head.index(f"peak force of the leading wave {str(paper.peak_force)[:2]}")
    assert f"It is {compared.errors.peak_force:.1%}".replace("%", " % higher than the simulation.") in head
    printed = "Published in Hasan &amp; Nemat-Nasser, table 2 row 1: error +3.0 %, virtual rise time 14.4 µs."
    assert printed in plain(undrawn("ejection"))


def test_tables_have_simulated_values_before_those_of_section_4() -> None:
    cells = [
        [plain(cell) for cell in re.findall("<t[hd][^>]*>(.*?)</t[hd]>", row)]
        for row in re.findall("<tr>(.*?)</tr>", undrawn("ejection"), re.DOTALL)
    ]
    named = {row[0]: row[1:] for row in cells if len(row) == 3}
    assert named[""] == ["simulated", "section 4"]
    # 4 digits: the simulation has an error of 1e-6, section 4 is shown with 3
    simulated, paper = named["peak force of the leading wave"]
    assert (simulated[:5], paper) == ("50.88", "52.5 N")
    assert named["error relative to the simulation"] == ["\N{EN DASH}", "+3.2 %"]
    assert named["leading wave relative to the shock"] == ["weaker", "weaker"]
    (wave,) = (row for row in cells if row[0] == "1" and len(row) == 5)
    assert (wave[1], wave[3:]) == (simulated, ["52.5 N", "+3.2 %"])


def test_conditions_have_margins_and_failed_ones_are_marked() -> None:
    # a1 = 1/(1 + 0.5), a2 = (3 - 1)/(1 + 1); the third holds with equality
    cells = [plain(cell) for cell in re.findall("<td>(.*?)</td>", undrawn("ejection"))]
    assert cells[:6] == ["a2 ≥ a1", "+0.3333", "holds", "a1 ≥ 1/2", "+0.1667", "holds"]
    assert cells[6:9] == ["a2 ≤ (n\N{MINUS SIGN}1)/2", "0", "holds"]
    assert undrawn("several peaks").count('<tr class="fails">') == 1


def test_the_decision_is_explained_step_by_step() -> None:
    part = undrawn("ejection").partition("<h2>Decision")[2].partition("</ol>")[0]
    steps = [plain(step) for step in re.findall("<li>(.*?)</li>", part, re.DOTALL)]
    assert len(steps) == 4
    assert "By (5e), the shock ends before its first wave has passed, and only one wave forms." in steps[0]
    assert steps[2].startswith("Total impulse / F0")
    assert steps[2].endswith("and granules rebound.")
    assert steps[3].startswith("By (5h), the peak force of the leading wave is")


def test_passages_and_warnings_are_listed() -> None:
    rows = [plain(row) for row in re.findall("<tr>(.*?)</tr>", undrawn("twelve granules"))]
    assert [row for row in rows if row.startswith("3")][-1].endswith("simulation")
    warnings = compute_results(SCENES["twelve granules"]).warnings
    assert len(warnings) > 0
    for warning in warnings:
        assert f'<p class="problem">{escape(warning)}</p>' in undrawn("twelve granules")


@pytest.mark.parametrize("end", [None, sw.Wall()], ids=["equal granules", "before a wall"])
def test_the_head_of_a_page_has_the_warnings_of_the_simulation(end: Any) -> None:
    beads = sw.Chain(material="stainless-steel-302", diameter="9.5 mm", granules=8, end=end)
    case = scenario(triangle(0.5), beads)
    warnings = compute_results(case).warnings
    assert any(warning.startswith("With elastic-plastic contacts, the greatest force is") for warning in warnings)
    assert warnings == sw.simulate(case).warnings


def test_the_head_of_a_page_states_the_error_of_the_plastic_law() -> None:
    beads = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm", granules=3, contact=sw.ElasticPlastic())
    whole = without_pictures(compute_results(scenario(triangle(0.5), beads)))
    assert whole.partition("</header>")[0].count("elastic-plastic law") == whole.count("elastic-plastic law") == 1


def test_pictures_do_not_repeat_the_warnings_of_the_page(monkeypatch: pytest.MonkeyPatch) -> None:
    large = evolve(CHAIN, radius=4.75)  # metres for millimetres
    results = compute_results(scenario(triangle(9.0), large, rtol=1e-3))
    assert results.warnings
    drawn: list[Any] = []
    chosen = choose_pictures(results)
    monkeypatch.setattr("shockwave.report.html_page.choose_pictures", lambda _: {"train": chosen["train"]})
    monkeypatch.setattr(pictures, "svg", lambda figure, _: drawn.append(figure))
    assert len(list(draw_pictures(results))) == len(drawn) == 1
    assert not drawn[0].axes[0].texts


def test_warnings_of_section_4_stand_beside_its_decision() -> None:
    profile = sw.PowerLaw(rise_exponent=2, decay_exponent=7, duration_ratio=5)
    shock = sw.Shock(profile=profile, peak_force=100.0, rise_time=5e-5)
    literal = evolve(scenario(shock, waves="primary"), predictor=sw.Predictor(alpha="literal"))
    part = (
        without_pictures(compute_results(literal)).partition("<h2>Decision of section 4")[2].partition("</section>")[0]
    )
    warnings = sw.predict(literal).section4.warnings
    assert any("no root" in warning for warning in warnings)
    for warning in warnings:
        assert escape(warning) in part


@pytest.mark.parametrize(
    ("made", "shown"),
    [
        (quantity(-1.5e-4, "N s"), "~150 µN s"),
        (quantity(3e-20, "N"), "3 * 10<sup>~20</sup> N"),
        (percent(22770.0), "+2.3 * 10<sup>6</sup> %"),
        (percent(-4.9e-6), "~4.9 * 10<sup>~6</sup>"),
        (
            typeset("wall stainless-steel-302, -1.5 us, error 2e-07"),
            "wall stainless-steel-302, ~1.5 µs, error 2 * 10<sup>~7</sup>",
        ),
        (
            typeset("E 193 GPa, nu 0.3, rho 7958 kg/m^3, 48 us (n = 4), nut 3"),
            "<i>E</i> 193 GPa, <i>\u03bd</i> 0.3, <i>\u03c1</i> 7958 kg/m<sup>3</sup>, 48 µs (<i>n</i> = 4), nut 3",
        ),
        (
            formula("alphaF0 A F0^(-1/6) < n t0"),
            "alpha <i>A</i> <i>F</i><sub>0</sub><sup>~1/6</sup> &lt; <i>n</i> <i>t</i><sub>0</sub>",
        ),
    ],
)
def test_numbers_and_formulae_are_typeset(made: str, shown: str) -> None:
    plainer = {"\N{NO-BREAK SPACE}": " ", "\N{MINUS SIGN}": "~", "\N{MULTIPLICATION SIGN}": "*", "\u03b1": "alpha"}
    assert made.translate(str.maketrans(plainer)) == shown


def test_a_failed_prediction_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise sw.NumericalError("no <root> was found")

    monkeypatch.setattr(sw.Predictor, "predict_scene", fail)
    found = compute_results(SCENES["ejection"])
    assert found.failures == ("The prediction failed: no <root> was found.",)
    assert found.predicted is found.comparison is None
    text = without_pictures(found)
    assert "no &lt;root&gt; was found" in text
    assert "Simulation:" in text


def test_only_the_leading_wave_of_a_very_long_shock_is_simulated() -> None:
    text = plain(without_pictures(compute_results(scenario(triangle(600.0)))))
    assert "Simulation: peak force of the leading wave" in text
    assert "only the leading wave is simulated for such a long shock" in text


def test_a_page_on_a_finite_chain_leads_with_the_greatest_force() -> None:
    text = plain(without_pictures(compute_results(scenario(triangle(0.3), evolve(CHAIN, granules=100)))))
    lead = text.index("Simulation: greatest force")
    assert "at contact 0" in text[lead : lead + 80]
    assert lead < text.index("peak force of the leading wave")


def test_a_contact_beyond_the_chain_is_reported() -> None:
    found = compute_results(scenario(power(0.5), evolve(CHAIN, granules=12), contacts=[3, 40]))
    assert [passage.contact for passage in found.passages] == [3]
    assert found.failures[0].startswith("The passage of contact 40 could not be computed:")


def test_a_missing_matplotlib_is_reported_before_any_computation(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setattr("shockwave.report.html_page.compute_results", None)
    with pytest.raises(sw.UsageError, match=r'matplotlib must .*python -m pip install "granular-shockwave\[plot\]"'):
        page(SCENES["ejection"])


def test_markup_in_names_is_escaped(tmp_path: Path) -> None:
    file = tmp_path / "<b>&.yaml"
    # too long to be simulated, so that there are few pictures, which show no other text
    text = f"""\
name: {json.dumps(EVIL)}
chain:
  material: {{youngs_modulus: 193 GPa, poisson_ratio: 0.3, density: 7958, name: "<script>2</script>"}}
  radius: 5 mm
shock: {{profile: triangular, peak_force: 1, rise_time: 1, duration_ratio: 3}} # </pre><script>3</script>
published: {{source: "<script>4</script>"}}
"""
    file.write_text(text, encoding="utf-8")
    root = parsed(page(sw.load_scenario(file)))
    assert str(root.findtext(".//p[@class='problem']")).startswith("The simulation failed: the shock lasts ")
    shown = EVIL.replace("\u202e", "\N{REPLACEMENT CHARACTER}")
    texts = {"".join(one.itertext()).strip() for one in root.iter()}
    expected = {f"{shown}: shock on a granular chain", shown, text.strip(), "<script>2</script>"}
    assert expected | {"Published in <script>4</script>:.", "Scenario file <b>&.yaml"} <= texts
    assert not root.findall(".//script")
    assert not [name for one in root.iter() for name in one.attrib if name.startswith("on")]


def test_provenance_has_versions_and_parts(sample_plugins: None) -> None:
    part = plain(undrawn("ejection").partition("<h2>Provenance")[2])
    assert f"NumPy{metadata.version('numpy')}" in part
    assert f"integratorrkn86granular-shockwave {sw.__version__}" in part
    assert scene_hash(sw.load_scenario(ROW1)) in part
    shock = sw.Shock(profile=load("profiles", "hertz-impact")(), peak_force=100.0, rise_time=1e-5)
    version = metadata.version("shockwave-pulses")
    assert ("profile", "hertz-impact", f"shockwave-pulses {version}") in list_parts(compute_results(scenario(shock)))


@pytest.mark.parametrize(
    ("excitation", "granules", "refused"),
    [
        ({"shock": triangle(0.5)}, 30, "a wall"),
        ({"shock": None, "impact": sw.Impact(velocity=1.0)}, 30, "a wall and a striker"),
        ({"shock": triangle(0.5)}, 2 * (DAMPED,), "damping and a wall"),
    ],
    ids=["shock", "striker", "each-feature-once"],
)
def test_a_page_on_a_wall_leads_with_the_simulated_force(
    excitation: dict[str, Any], granules: Any, refused: str
) -> None:
    walled = evolve(scenario(triangle(0.5)), chain=evolve(CHAIN, granules=granules, end=sw.Wall()), **excitation)
    text = without_pictures(compute_results(walled))
    parsed(text)
    lead = f"Simulation: greatest force {str(sw.simulate(walled).transmitted.peak_force)[:6]}"
    head = plain(text.partition("</header>")[0])
    assert lead in head
    assert f"Section 4 of the paper does not apply: it does not cover {refused}." in head


@pytest.mark.parametrize(("contacts", "last"), [((), True), ((0, 10), False), ((0, 29), True)], ids=str)
def test_the_caption_names_the_wall_if_its_contact_is_listed(contacts: tuple[int, ...], last: bool) -> None:
    text = without_pictures(compute_results(evolve(WALLED, simulate=SimulateOptions(contacts=contacts))))
    assert ("the last one is with the wall" in plain(text)) == last


@pytest.mark.parametrize("name", ["wall", "layers"])
def test_captions_name_the_lines_that_are_drawn_and_empty_columns_are_left_out(name: str) -> None:
    text, other = made(name), name == "layers"
    captions = [plain(each) for each in re.findall("<figcaption>(.*?)</figcaption>", text)]
    assert sum("dashed lines separate materials" in each for each in captions) == 2 * other
    assert sum("the dash-dotted line is the limit" in each for each in captions) == 2 * other
    assert "static force" not in text
    assert "Conditions (3)" not in text
    for title in ("Greatest forces", "Space-time diagram", "Force on the wall"):
        assert f"<h3>{title}</h3>" in text
    if other:
        head = plain(text.partition("</header>")[0])
        assert head.index("Verdict") < head.index("Simulation") < head.index("does not apply")
    assert not re.search(r"[0-9]e-|[0-9] us", plain(re.sub("<svg.*?</svg>|<pre>.*?</pre>", "", text, flags=re.DOTALL)))


def test_a_page_on_a_pulling_shock_shows_the_simulation_alone() -> None:
    pulling = sw.Tabulated(times=[0, 1e-5, 2e-5, 3e-5, 5e-5], forces=[0, 100, 0, -40, 0], negative="keep")
    found = compute_results(scenario(sw.Shock(profile=pulling)))
    text = plain(without_pictures(found))
    assert "does not apply: it does not cover pulling forces." in text
    assert "Conditions (3)" not in text
    assert "by section 4" not in text
    assert "conditions" not in choose_pictures(found)


def test_a_page_on_a_train_that_is_not_integrated_states_what_is_not_known() -> None:
    found = compute_results(SCENES["several peaks"])
    assert found.simulated is not None
    alone = Train(waves=found.simulated.waves[:1], recoil_error=1.0)
    cut = evolve(found, simulated=evolve(found.simulated, measured=alone))
    rows = [re.findall("<td>(.*?)</td>", row) for row in re.findall("<tr>(.*?)</tr>", without_pictures(cut))]
    for name, text in (("waves", "1+"), ("rebounding granules", "not known")):
        assert any(row[:2] == [name, text] for row in rows)


def test_parameters_that_are_not_set_are_left_out() -> None:
    record = sw.Tabulated(times=[0, 1, 2], forces=[0, 1, 0], negative="keep")
    shown = dict(_parameters(record))
    assert shown["negative"] == "keep"
    assert not any("None" in text for text in shown.values())


@pytest.mark.parametrize(("name", "title"), [("ejection", "Contact forces"), ("wall", "Force on the wall")])
def test_the_picture_of_the_answer_is_in_the_head(name: str, title: str) -> None:
    head, _, rest = made(name).partition("</header>")
    assert re.findall("<figure><h3>(.*?)</h3>", head) == [title]
    assert f"<h3>{title}</h3>" not in rest


def test_the_head_has_the_structure_behind_the_wall_and_the_spring_force() -> None:
    end = sw.Wall(mass=0.02, stiffness=1e5)
    case = evolve(scenario(triangle(0.5)), chain=evolve(CHAIN, granules=10, end=end), limit=sw.Limit(force=1e4))
    head = plain(without_pictures(compute_results(case)).partition("</header>")[0])
    assert re.search(r"Structure, simulated: displacement .* m/s2 \(.* g\); spring force .* N at", head)
    assert re.search(r"Verdict: below the limit of 10 kN: force on the wall .*; force of the spring", head)


def test_a_page_of_sensors_and_a_limit_of_the_spring_leads_with_the_force_of_the_spring() -> None:
    chain = evolve(CHAIN, granules=10, end=sw.Wall(mass=0.02, stiffness=1e5))
    case = evolve(scenario(triangle(0.5), sensors=[{"contact": 4}, "wall"]), chain=chain)
    whole = page(evolve(case, limit=sw.Limit(force=1e4, at="spring")))
    head, _, rest = whole.partition("</header>")
    assert re.findall("<figure><h3>(.*?)</h3>", head) == ["Forces at the sensors"]
    titles = re.findall("<figure><h3>(.*?)</h3>", rest)
    assert {"Force on the wall", "Acceleration of the structure", "Shock response spectrum"} <= set(titles)
    assert "the dash-dotted line is the limit" in head
    assert "the dash-dotted line" not in rest[rest.index("<h3>Force on the wall") :].partition("</figure>")[0]
    assert re.search(
        r"<td>contact 4</td><td>[\d.]+.N</td><td>[\d.]+.µs</td><td>[\d.]+.µs</td><td>\N{EN DASH}</td>", rest
    )
    assert rest.count("<td>wall</td>") == 2  # as a sensor, and with its energy


def test_an_end_that_its_spring_holds_still_has_no_pictures_of_its_motion() -> None:
    end = sw.Wall(material="steel-4340", mass=1.0, stiffness=1e16)
    case = evolve(scenario(triangle(0.5)), chain=evolve(CHAIN, granules=4, end=end))
    chosen = choose_pictures(compute_results(case))
    assert "sensors" in chosen
    assert not {"structure", "spectrum"} & set(chosen)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["paper/table2-row1", "examples/hammer", "validation/damped"])
@pytest.mark.parametrize("sheet", ["letter", "a4"])
def test_a_page_prints_on_two_sheets(name: str, sheet: str, tmp_path: Path) -> None:
    browser = shutil.which("chromium") or pytest.skip("there is no Chromium")
    text = page(sw.load_scenario(ROOT / "profiles" / f"{name}.yaml"))
    file = tmp_path / "page.html"
    file.write_text(text.replace("@page {", f"@page {{ size: {sheet};"), encoding="utf-8")
    printed = tmp_path / "page.pdf"
    options = ["--headless", "--no-sandbox", "--no-pdf-header-footer", f"--print-to-pdf={printed}"]
    subprocess.run([browser, *options, file.as_uri()], check=True, capture_output=True, timeout=60)
    assert len(re.findall(rb"/Type */Page(?!s)", printed.read_bytes())) <= 2
