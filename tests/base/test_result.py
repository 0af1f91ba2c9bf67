"""Every result: a short repr, HTML for notebooks, and tables for pandas and xarray."""

import json
import math
import sys
import xml.etree.ElementTree as ET
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from attrs import evolve
from markupsafe import escape

import shockwave as sw
from shockwave import cli
from shockwave.base.errors import UnknownNameError, UsageError
from shockwave.scenario.sweep_block import SweepAxis
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.sweep.progress_text import SweepReport
from support.pages import ROOT
from support.scenes import CASE_B, CHAIN, STEEL

pytest.importorskip("pandas")
pytest.importorskip("xarray")

pytestmark = pytest.mark.usefixtures("few_draws")

WALLED = sw.Chain(material=STEEL, radius=4.75e-3, granules=8, end=sw.Wall())
TINY = sw.Chain(material=STEEL, radius=4.75e-3, granules=2, end=sw.Wall())
SHORT = sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=100.0, rise_time=1e-6)
SPREADS = {"shock.peak_force": "5 %", "chain.radius": "2 %"}
#: Kind of result -> the computation.
MAKERS: dict[str, Any] = {
    "outcome": lambda: sw.predict(CASE_B, CHAIN),
    "striker": lambda: sw.predict(ROOT / "profiles" / "chains" / "striker.yaml"),
    "section 4": lambda: sw.predict(CASE_B, CHAIN, model="section-4").section4,
    "simulation": lambda: sw.simulate(CASE_B, CHAIN, rtol=1e-4, contacts=[5, 9], record=["forces", "field"]),
    "chain": lambda: sw.simulate(CASE_B, WALLED, rtol=1e-4),
    "comparison": lambda: sw.compare(CASE_B, CHAIN, rtol=1e-4),
    "recording": lambda: result_of("simulation").recording,
    "curve": lambda: sw.UniversalCurve(sw.Triangular(duration_ratio=3), rtol=1e-2, longest=1.0),
    "uncertainty": lambda: sw.uncertainty(SHORT, CHAIN, SPREADS, draws=64),
    "simulated uncertainty": lambda: sw.uncertainty(SHORT, TINY, {"shock.peak_force": "5 %"}, draws=64),
    "design": lambda: sw.design(
        sw.load_scenario(ROOT / "profiles" / "examples" / "triangular.yaml"),
        vary="shock.peak_force",
        between=("50 N", "200 N"),
        target={"peak_force": "60 N"},
        rtol=1e-2,
    ),
}


@cache
def result_of(kind: str) -> Any:
    return MAKERS[kind]()


@pytest.fixture(scope="module")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> sw.SweepResults:
    folder = tmp_path_factory.mktemp("sweep")
    text = (ROOT / "profiles" / "examples" / "triangular.yaml").read_text(encoding="utf-8")
    file = folder / "two.yaml"
    file.write_text(f"{text}\nsweep: {{grid: {{shock.peak_force: [50 N, 100 N]}}}}\n", encoding="utf-8")
    assert cli.main(["sweep", str(file), "--output", str(folder / "out"), "--workers", "1"]) == 0
    return sw.load_sweep(folder / "out")


def has_a_table(html: str) -> bool:
    """Whether a document, whose tags must be balanced, has a table."""
    return ET.fromstring(f"<div>{html.replace('&nbsp;', ' ')}</div>").find(".//table") is not None


@pytest.mark.parametrize("kind", MAKERS)
def test_the_repr_is_one_short_line(kind: str) -> None:
    shown = repr(result_of(kind))
    assert "\n" not in shown
    assert len(shown) < 220


#: Large objects whose display is bounded -> the computation, with the folder of a sweep of records.
LARGE: dict[str, Any] = {
    "scenario": lambda folder: sw.load_scenario(folder / "large.yaml"),
    "sweep": lambda folder: sw.load_sweep(folder / "out"),
    "axes": lambda folder: sw.load_sweep(folder / "out").axes,
    "many values": lambda _: SweepAxis(("shock.peak_force",), ("N",), tuple((float(n),) for n in range(20_000))),
    "chain": lambda _: sw.Chain(material=STEEL, radius=1e-3, granules=[sw.Segment(count=1)] * 5000),
    "cell": lambda _: sw.Cell(repeat=2, cell=[sw.Segment(count=1)] * 5000),
    "options": lambda _: SimulateOptions(contacts=range(20_000)),
    "recording": lambda _: sw.simulate(CASE_B, CHAIN, rtol=1e-3, record=["field"], contacts=range(300)).recording,
    "passages": lambda _: sw.simulate(CASE_B, CHAIN, rtol=1e-3, contacts=range(300)),
}


@pytest.fixture(scope="module")
def records(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a sweep over records of many samples, which fail at half of the points."""
    folder = tmp_path_factory.mktemp("records")
    samples = [[sign * round(math.sin(math.pi * n / 1500), 4) for n in range(1501)] for sign in (1, -1, 2, -2)]
    points = [{"shock.parameters.forces": forces} for forces in samples]
    file = folder / "large.yaml"
    parameters = {"times": [f"{n} us" for n in range(1501)], "forces": samples[0]}
    shock = {"profile": "tabulated", "parameters": parameters}
    text = {"chain": {"material": "ptfe", "radius": 5e-3}, "shock": shock, "sweep": {"points": points}}
    file.write_text(json.dumps(text), encoding="utf-8")
    assert cli.main(["sweep", str(file), "--output", str(folder / "out"), "--workers", "1"]) == 1
    return folder


@pytest.mark.parametrize("kind", LARGE)
def test_the_display_of_a_large_object_is_bounded(kind: str, records: Path) -> None:
    value = LARGE[kind](records)
    # a screen or two
    assert len(repr(value)) < 5_000
    assert len(str(value)) < 5_000
    assert len(value._repr_html_() if hasattr(value, "_repr_html_") else "") < 40_000


def test_a_repr_does_not_integrate_the_train() -> None:
    for result in (sw.simulate(CASE_B, CHAIN, rtol=1e-4), sw.compare(CASE_B, CHAIN, rtol=1e-4)):
        assert "peak_force=" in repr(result)
        assert "train" not in vars(getattr(result, "simulated", result))
        assert "exponents" not in vars(result)


def test_the_repr_of_a_prediction_does_not_run_the_engine() -> None:
    outcome = sw.predict(CASE_B, CHAIN, limit="60 N")
    assert repr(outcome) == "<Outcome model='best', limit.force=60 N>"
    assert outcome.simulation is not None
    assert outcome.simulation._engine.results is None  # type: ignore[attr-defined]


@pytest.mark.parametrize("kind", MAKERS)
def test_the_html_has_a_table(kind: str) -> None:
    assert has_a_table(result_of(kind)._repr_html_())


def test_the_html_of_a_sweep_has_a_table(sweep: sw.SweepResults) -> None:
    assert has_a_table(sweep._repr_html_())


@pytest.mark.parametrize(("rise_exponent", "holds"), [(1, True), (2, False)])
def test_the_table_of_conditions_states_whether_they_hold(rise_exponent: float, holds: bool) -> None:
    # a1 = 1/(rise_exponent + 1) is at least 1/2 in the first case alone
    profile = sw.PowerLaw(rise_exponent=rise_exponent, decay_exponent=5, duration_ratio=10)
    both = sw.compare(evolve(CASE_B, profile=profile), CHAIN, rtol=1e-3)
    assert both.predicted is not None
    assert both.predicted.to_pandas("conditions").set_index("name")["holds"]["steep-rise"] == holds


def test_the_tables_of_a_prediction_are_those_of_the_engine() -> None:
    leading = result_of("outcome").to_pandas()
    assert leading["peak_force"].tolist() == [result_of("outcome").peak_force]
    struck = sw.predict(sw.Impact(velocity=0.3), WALLED)
    assert struck.to_pandas().equals(sw.simulate(sw.Impact(velocity=0.3), WALLED).to_pandas("contacts"))


#: A record with notes.
RECORD = sw.Shock(profile=sw.Tabulated([0.0, 1e-5, 2e-5, 4e-5], [0.0, 0.0, 5.0, 0.0]))
OF_RECORDS: dict[str, Any] = {
    "simulation": lambda: sw.simulate(RECORD, CHAIN, rtol=1e-3),
    "chain": lambda: sw.simulate(RECORD, WALLED, rtol=1e-3),
    "prediction": lambda: sw.Predictor().predict_many([RECORD], CHAIN)[0],
    "comparison": lambda: sw.compare(RECORD, CHAIN, rtol=1e-3),
    "curve": lambda: sw.UniversalCurve(RECORD.profile, rtol=1e-2, longest=1.0),
}


@pytest.mark.parametrize("kind", OF_RECORDS)
def test_notes_on_a_record_are_notes_everywhere(kind: str) -> None:
    result = OF_RECORDS[kind]()
    assert result.notes == RECORD.profile.notes != ()
    document, frame = result.to_dict(), result.to_pandas()
    for note in result.notes:
        assert note not in [*document["warnings"], *frame.attrs["warnings"], *result.warnings]
        assert f"Note: {escape(note)}" in result._repr_html_()
        assert f"note: {note[:20]}" in result.text()
        assert f"! {note[:20]}" not in result.text()
    assert frame.attrs["notes"] == list(result.notes)


def test_tables_have_the_warnings_of_their_result() -> None:
    both = sw.compare(CASE_B, evolve(CHAIN, radius=4.75), rtol=1e-3)
    assert both.to_pandas().attrs["warnings"] == list(both.warnings) != []
    assert both.to_xarray().attrs["warnings"] == "\n".join(both.warnings)


def test_names_in_the_html_are_escaped() -> None:
    evil = sw.load_scenario(ROOT / "profiles" / "examples" / "triangular.yaml")
    shown = sw.predict(evolve(evil, name="<script>alert(1)</script>"))._repr_html_()
    assert "<script>" not in shown


@pytest.mark.parametrize("kind", MAKERS)
def test_both_libraries_get_the_same_units(kind: str) -> None:
    frame, data = result_of(kind).to_pandas(), result_of(kind).to_xarray()
    for name, unit in frame.attrs["units"].items():
        variable = data[name.partition("[")[0]]
        assert variable.attrs.get("units") == (None if unit is None else unit or "1")


def test_a_table_holds_the_values_of_the_result() -> None:
    result = result_of("simulation")
    frame = result.to_pandas("waves")
    assert frame["peak_force"].tolist() == [wave.peak_force for wave in result.waves]
    assert frame.attrs["units"]["momentum"] == "N s"
    assert result.to_pandas("passages").index.tolist() == [5, 9]


def test_histories_have_axes_of_time_contacts_and_granules() -> None:
    recording = result_of("recording")
    data = recording.to_xarray()
    assert data.forces.dims == ("time", "contact")
    assert data.contact.values.tolist() == [5, 9]
    assert data.velocities.dims == ("time", "granule")
    assert np.array_equal(data.forces.sel(contact=9), recording.forces[:, 1])
    assert np.array_equal(recording.to_pandas()["forces[9]"], recording.forces[:, 1])


def test_a_comparison_has_both_columns_and_nan_for_a_missing_wave() -> None:
    both = result_of("comparison")
    forces = both.to_xarray().peak_force
    assert forces.sel(wave=0, source="section4") == both.predicted.peak_force
    assert forces.sel(wave=0, source="simulated") == both.waves[0].peak_force
    counts = (len(both.predicted.waves), len(both.waves))
    assert int(np.isnan(forces).sum()) == max(counts) * 2 - sum(counts)
    assert not math.isnan(forces.sel(wave=0, source="simulated"))


def test_a_missing_table_is_refused_with_the_known_names() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown table of this result \(got 'recording'; known: contacts"):
        result_of("chain").to_pandas("recording")


@pytest.mark.parametrize("method", ["to_pandas", "to_xarray"])
def test_the_results_of_a_sweep_refuse_an_unknown_table(method: str, sweep: sw.SweepResults) -> None:
    with pytest.raises(UnknownNameError, match=r"\(got 'nope'; known: points\)"):
        getattr(sweep, method)("nope")
    assert len(getattr(sweep, method)("points").peak_force) == 2


def test_a_result_without_tables_says_so() -> None:
    report = SweepReport(folder=Path("out"), points=2, done=2, failed=0, crashed=0, before=0, seconds=1.0)
    with pytest.raises(UsageError, match="SweepReport has no table"):
        report.to_pandas()


@pytest.mark.parametrize("library", ["pandas", "xarray"])
def test_a_missing_library_is_named_with_its_installation(
    library: str, sweep: sw.SweepResults, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    for result in (result_of("chain"), sweep):
        with pytest.raises(UsageError, match=rf"{library} must be installed .*\"granular-shockwave\[tables\]\""):
            getattr(result, f"to_{library}")()
