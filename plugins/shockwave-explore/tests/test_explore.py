"""The explorer without a browser: scenario, parts of the page, links, and what the server admits."""

from __future__ import annotations

import gc
import io
import json
import re
import signal
import socket
import subprocess
import sys
import threading
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from html import unescape
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
import shockwave as sw
from shockwave import cli
from shockwave.registry.built_ins import ENTRIES
from shockwave.report.number_text import typeset
from shockwave.scenario.scenario import load_scenario
from werkzeug.test import EnvironBuilder, run_wsgi_app

from shockwave_explore import answer, scene, server
from shockwave_explore.answer import parts_of, predict_text
from shockwave_explore.controls import Control, list_controls
from shockwave_explore.scene import PRESETS, edit_text, load_text, text_of_file
from shockwave_explore.server import make_application

PROFILES = Path(__file__).parents[3] / "profiles"
WALL = text_of_file(PRESETS["wall"])
ENDLESS = text_of_file(PRESETS["power-law"])
PORT, TOKEN = 8042, "s3cret"
LOOPBACK = f"http://127.0.0.1:{PORT}"


@pytest.fixture(scope="module")
def client() -> Any:
    return make_application(WALL, PORT, TOKEN).test_client()


def posted(client: Any, path: str = "answer", origin: str | None = LOOPBACK, **request: Any) -> Any:
    headers = {} if origin is None else {"Origin": origin}
    return client.post(f"/{TOKEN}/{path}", base_url=LOOPBACK, headers=headers, **request)


def asked(client: Any, **request: Any) -> dict[str, str]:
    reply = posted(client, json=request)
    assert reply.status_code == 200, reply.text
    parts: dict[str, str] = reply.get_json()
    return parts


def refused(client: Any, path: str = "answer", status: int = 400, **request: Any) -> str:
    """The message of a request that is refused: in plain text, or errors of the scenario with their places."""
    reply = posted(client, path, **request)
    assert reply.status_code == status
    if reply.mimetype == "application/json":
        assert status == 400
        faults = reply.get_json()["faults"]
        return "\n".join(": ".join(filter(None, map(fault.get, ("location", "path", "problem")))) for fault in faults)
    assert reply.mimetype == "text/plain"
    message: str = reply.text
    return message


def pictures(parts: dict[str, str]) -> list[ET.Element]:
    return [ET.fromstring(f"<svg{part.partition('</svg>')[0]}</svg>") for part in parts["figures"].split("<svg")[1:]]


# ---------------------------------------------------------------- scenarios


@pytest.mark.parametrize("name", PRESETS)
def test_every_example_has_a_result_and_well_formed_pictures(name: str, client: Any) -> None:
    parts = asked(client, preset=name)
    assert "estimated relative error" in parts["headline"]
    assert "section 4" in parts["results"]
    assert len(pictures(parts)) >= 5


@pytest.mark.parametrize("name", PRESETS)
def test_the_text_of_every_example_is_a_scenario_file(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "copied.yaml"
    file.write_text(text_of_file(PRESETS[name]), encoding="utf-8")
    assert cli.main(["validate", str(file)]) == 0
    assert cli.main(["predict", str(file)]) == 0


def test_a_file_keeps_its_comments_and_a_record_becomes_part_of_the_text() -> None:
    assert PRESETS["wall"].read_text(encoding="utf-8") == WALL
    text = text_of_file(PROFILES / "examples" / "hammer.yaml")
    assert "hammer.csv" not in text
    original = load_scenario(PROFILES / "examples" / "hammer.yaml").shock
    assert load_text(text).shock.peak_force == pytest.approx(original.peak_force)
    assert load_text(text).shock.rise_time == pytest.approx(original.rise_time, rel=1e-6)


@pytest.mark.parametrize(
    "processing",
    ["crop: [0 us, 200 us]", "low_pass: 20 kHz, negative: zero", "baseline: [0 us, 20 us]", "negative: zero"],
)
def test_the_record_in_the_text_is_processed_as_that_of_the_file(processing: str, tmp_path: Path) -> None:
    rows = "".join(
        f"{5 * i},{force}\n" for i, force in enumerate([*[0.5] * 9, 5, 20, 9, 3, *[0.5] * 30, 4, 40, 6, 0.5])
    )
    (tmp_path / "blow.csv").write_text("time (us),force (N)\n" + rows, encoding="utf-8")
    file = tmp_path / "blow.yaml"
    shock = f"shock: {{profile: tabulated, parameters: {{file: blow.csv, {processing}}}}}"
    file.write_text(f"{CHAIN}\n{shock}\n", encoding="utf-8")
    known, found = load_scenario(file).shock, load_text(text_of_file(file)).shock
    assert (found.peak_force, found.duration) == (known.peak_force, known.duration)


def test_an_edit_changes_the_text_and_the_results(client: Any) -> None:
    before = asked(client, text=WALL)
    after = asked(client, text=WALL, edits={"shock.peak_force": "50 N", "chain.granules": 20})
    assert load_text(after["text"]).shock.peak_force == 50
    assert load_text(after["text"]).chain.count == 20
    for part in ("controls", "headline", "figures"):
        assert after[part] != before[part]


def test_the_first_number_is_that_of_the_simulation_with_section_4_beside_it(client: Any) -> None:
    outcome = sw.predict(load_text(ENDLESS))
    parts = asked(client, text=ENDLESS)
    assert f"<strong>simulated leading wave {outcome.peak_force:.2f}" in parts["headline"]
    assert (
        f"<dt>section 4</dt><dd>peak force {outcome.section4.peak_force:.1f} N, error \N{MINUS SIGN}"
        in parts["results"]
    )
    assert parts["figures"].count("section 4") == 1


def test_a_chain_that_section_4_does_not_cover_states_why(client: Any) -> None:
    parts = asked(client, preset="damped")
    assert "force on the wall" in parts["headline"]
    assert "does not apply, because of granules of another kind, a wall, damping" in parts["results"]


def test_an_endless_chain_under_precompression_is_drawn(client: Any) -> None:
    parts = asked(client, text=ENDLESS, edits={"chain.precompression": "2 N"})
    assert len(pictures(parts)) >= 3


def test_section_4_alone_is_shown_without_a_simulation(client: Any) -> None:
    parts = asked(client, text=f"{ENDLESS}predict: {{model: section-4}}\n")
    assert "error not known" in parts["headline"]
    assert len(pictures(parts)) == 2


def test_a_limit_is_decided_and_drawn(client: Any) -> None:
    parts = asked(client, text=f"{WALL}limit: {{force: 60 N}}\n")
    assert "above the limit of 60 N" in parts["results"]
    assert "limit" in parts["figures"]


def test_the_contacts_of_the_scenario_and_the_wall_are_drawn(client: Any) -> None:
    figures = asked(client, text=WALL)["figures"]
    assert re.findall(r"</tspan> (contact \d+)", figures) == [f"contact {contact}" for contact in (0, 10, 20, 38)]
    for picture in ("force against time and", "greatest force against"):
        assert re.search(f'"{picture}[^"]*, at most 88', figures)


def test_the_marks_of_the_colour_bar_are_round(client: Any) -> None:
    diagram = asked(client, text=WALL)["figures"].partition('aria-label="Space-time diagram"')[2]
    marks = re.findall(r">([0-9.]+)</text>", diagram.partition("</image>")[0].partition("force (N)")[0])
    assert marks[-5:] == ["0", "20", "40", "60", "80"]


def test_the_greatest_forces_reach_the_wall(client: Any) -> None:
    chart = asked(client, text=WALL)["figures"].partition('aria-label="Greatest forces"')[2]
    square = re.search(r'd="M([0-9.]+ [0-9.]+)m-3.5', chart)
    assert square
    assert f'L{square[1]}" fill' in chart
    assert float(square[1].split()[0]) < 408  # left of the end of the axis


def test_values_of_a_taper_have_names_in_words() -> None:
    controls = list_controls(load_scenario(PRESETS["taper"]))["Chain"]
    assert {"segment 1 first diameter", "segment 1 last diameter"} <= {control.label for control in controls}


def test_the_grid_lies_behind_the_map(client: Any) -> None:
    diagram = asked(client, text=WALL)["figures"].partition('aria-label="Space-time diagram"')[2]
    assert diagram.index("<path") < diagram.index("<image")


def test_the_text_of_an_answer_gives_the_same_answer(client: Any) -> None:
    once = asked(client, text=WALL, edits={"shock.duration": "20 us"})
    assert asked(client, text=once["text"]) == once


def test_the_page_answers_as_the_command_line_does(
    client: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "short.yaml"
    file.write_text(f"{WALL}  until: 0.5 ms\n", encoding="utf-8")
    parts = asked(client, text=file.read_text(encoding="utf-8"))
    assert cli.main(["predict", str(file)]) == 0
    headline, *rest = capsys.readouterr().out.splitlines()
    assert headline == "a chain in front of a wall: the wave does not reach the wall"
    assert "<strong>the wave does not reach the wall</strong>" in parts["headline"]
    shown = typeset(" ".join(rest).replace(" ! ", " ").replace("chain.end (a wall)", "a wall"))
    assert re.sub("<.*?>", " ", parts["results"]).split() == re.sub("<.*?>", " ", shown).split()


@pytest.mark.parametrize("name", PRESETS)
def test_the_examples_stay_elastic(name: str, client: Any) -> None:
    assert "Beyond elastic validity" not in asked(client, preset=name)["results"]


def test_the_examples_are_listed_by_title_and_recognised(client: Any) -> None:
    page = client.get(f"/{TOKEN}/", base_url=LOOPBACK).text
    for name, file in PRESETS.items():
        title = load_text(text_of_file(file)).name
        assert f'<option value="{name}">{title[0].upper()}{title[1:]}</option>' in page
        assert asked(client, preset=name)["preset"] == name
    assert asked(client, text=WALL)["preset"] == "wall"
    assert asked(client, text=WALL, edits={"chain.granules": 20})["preset"] == ""


def test_the_decision_of_section_4_is_that_of_the_report(client: Any) -> None:
    decision = asked(client, text=ENDLESS)["decision"]
    page = posted(client, "report", json={"text": ENDLESS}).text
    for tag in ("ol", "tbody"):
        shown = re.search(f"<{tag}>.*?</{tag}>", decision, re.DOTALL)
        assert shown is not None
        assert "".join(shown[0].split()) in "".join(page.split())
    assert asked(client, text=WALL)["decision"].strip() == ""


def test_every_picture_describes_itself(client: Any) -> None:
    for picture in pictures(asked(client, text=WALL)):
        assert picture.get("role") == "img"
        assert re.search(r"at most|granules during", str(picture.get("aria-label")))


# ---------------------------------------------------------------- controls


def control(text: str, name: str) -> Control:
    groups = list_controls(*predict_text(text)).values()
    return next(control for group in groups for control in group if control.name == name)


@pytest.mark.parametrize(
    ("times", "edit", "rise_time", "duration"),
    [
        ("rise_time: 10 us, duration_ratio: 4", {"duration": "60 us"}, 10, 60),
        ("rise_time: 10 us, duration_ratio: 4", {"rise_time": "20 us"}, 20, 80),
        ("rise_time: 10 us, duration: 40 us", {"rise_time": "20 us"}, 20, 40),
        ("rise_time: 10 us, duration: 40 us", {"duration_ratio": 5}, 10, 50),
        ("duration: 40 us, duration_ratio: 4", {"duration": "60 us"}, 15, 60),
        ("duration: 40 us, duration_ratio: 4", {"rise_time": "20 us"}, 20, 40),
        ("rise_time: 10 us, duration_ratio: 4", {"rise_time": "50 us", "duration": "60 us"}, 50, 60),
        ("rise_time: 10 us, duration_ratio: 4", {"duration": ""}, 10, 40),
    ],
    ids=lambda value: str(value).strip("{}"),
)
def test_a_time_of_the_shock_takes_the_place_of_another(
    times: str, edit: dict[str, Any], rise_time: float, duration: float
) -> None:
    text = f"{CHAIN}\nshock: {{profile: triangular, peak_force: 5 N, {times}}}"
    shock = load_text(edit_text(text, {f"shock.{name}": value for name, value in edit.items()})).shock
    assert (shock.rise_time, shock.duration) == (pytest.approx(1e-6 * rise_time), pytest.approx(1e-6 * duration))


def test_a_record_is_scaled_to_a_duration() -> None:
    text = text_of_file(PRESETS["record"])
    assert control(text, "shock.duration").text == "60 us"
    assert load_text(edit_text(text, {"shock.duration": "30 us"})).shock.rise_time == pytest.approx(7e-6)


def test_times_that_follow_from_others_have_controls() -> None:
    assert control(WALL, "shock.rise_time").text == "24 us"
    assert control(f"{WALL}  until: 0.5 ms\n", "simulate.until").text == "0.5 ms"
    end = control(WALL, "simulate.until").text
    assert sw.simulate(load_text(WALL)).end == pytest.approx(1e-3 * float(end.removesuffix(" ms")), rel=1e-4)


def test_an_empty_field_returns_to_the_default() -> None:
    text = edit_text(f"{WALL}  until: 0.5 ms\n", {"simulate.until": ""})
    assert load_text(text).simulate == load_text(WALL).simulate


@pytest.mark.parametrize(
    ("written", "unit", "value"),
    [("0.048 ms", "ms", 0.048), ("48us", "us", 48), ("4.8e-5", "us", 48), ("48000 ns", "ns", 48000)],
)
def test_a_slider_has_the_unit_that_its_field_shows(written: str, unit: str, value: float) -> None:
    shown = control(WALL.replace("duration: 48 us", f"duration: {written}"), "shock.duration")
    assert (shown.unit, shown.value) == (unit, pytest.approx(value))
    assert shown.text.endswith(unit)


def test_every_number_of_the_chain_has_a_control() -> None:
    assert control(text_of_file(PRESETS["damped"]), "chain.damping.time").text == "2 us"
    assert control(text_of_file(PRESETS["precompressed"]), "chain.end.stiffness").label == "end stiffness"
    assert control(text_of_file(PRESETS["taper"]), "chain.granules[1].diameter.to").text == "6 mm"


@pytest.mark.parametrize("profile", [entry.name for entry in ENTRIES["profiles"] if entry.name != "tabulated"])
def test_every_built_in_pulse_shape_can_be_chosen(profile: str) -> None:
    scenario = load_text(edit_text(WALL, {"shock.profile": profile}))
    assert scenario.shock.peak_force == 40
    assert scenario.shock.duration == pytest.approx(48e-6)


@pytest.mark.parametrize(("profile", "duration"), [("power-law", 20e-6), ("half-sine", 60e-6)])
def test_a_shape_in_place_of_a_record_has_a_time(profile: str, duration: float) -> None:
    text = f"{CHAIN}\nshock: {{profile: tabulated, parameters: {{times: [0, 1e-5, 2e-5], forces: [0, 5, 0]}}}}"
    assert load_text(edit_text(text, {"shock.profile": profile})).shock.duration == pytest.approx(duration)


@pytest.mark.parametrize("profile", ["triangular", "half-sine"])
@pytest.mark.parametrize("times", ["duration: 60 us, duration_ratio: 3", "rise_time: 20 us, duration: 60 us"])
def test_a_shape_keeps_the_duration_that_is_given(times: str, profile: str) -> None:
    text = f"{CHAIN}\nshock: {{profile: exponential, peak_force: 5 N, {times}}}"
    assert load_text(edit_text(text, {"shock.profile": profile})).shock.duration == pytest.approx(60e-6)


@pytest.mark.parametrize("times", ["duration: 60 us, duration_ratio: 3", "rise_time: 20 us, duration_ratio: 3"])
def test_a_shape_keeps_the_rise_time(times: str) -> None:
    changed = load_text(edit_text(WALL, {"shock.profile": "triangular"}))
    assert changed.document is not None
    assert changed.document.data["shock"].items() >= {"rise_time": "24 us", "duration": "48 us"}.items()
    text = f"{CHAIN}\nshock: {{profile: exponential, peak_force: 5 N, {times}}}"
    shock = load_text(edit_text(text, {"shock.profile": "triangular"})).shock
    assert (shock.rise_time, shock.duration) == (pytest.approx(20e-6), pytest.approx(60e-6))


@pytest.mark.parametrize("until", ["50 us", "20 ms"])
def test_any_end_of_the_simulated_time_is_drawn(until: str, client: Any) -> None:
    for text in (WALL, f"{ENDLESS}simulate:\n"):
        assert len(pictures(asked(client, text=f"{text}  until: {until}\n"))) >= 5


def test_the_end_of_the_chain_can_be_chosen() -> None:
    endless = edit_text(WALL, {"chain.end": "endless chain"})
    assert load_text(endless).chain.count is None
    walled = load_text(edit_text(endless, {"chain.end": "wall: ptfe"})).chain
    assert walled.count == 30
    assert walled.end is not None
    assert load_text(edit_text(WALL, {"chain.end": "free end"})).chain.end is None


def test_contacts_can_flow_plastically(client: Any) -> None:
    plastic = edit_text(WALL, {"chain.contact": "elastic-plastic"})
    assert load_text(plastic).chain.is_plastic
    assert (control(WALL, "chain.contact").text, control(plastic, "chain.contact").text) == (
        "elastic",
        "elastic-plastic",
    )
    assert "another contact law" in asked(client, text=plastic)["results"]
    assert edit_text(plastic, {"chain.contact": "elastic"}) == edit_text(WALL, {"chain.contact": "elastic"})
    assert load_text(edit_text(plastic, {"chain.end": "endless chain"})).chain.is_uniform
    assert "chain.contact" not in [each.name for group in list_controls(load_text(ENDLESS)).values() for each in group]


def test_a_shorter_chain_drops_contacts_that_it_does_not_have() -> None:
    assert "contacts" in WALL
    assert load_text(edit_text(WALL, {"chain.granules": 5})).simulate.contacts == ()


@pytest.mark.parametrize("name", PRESETS)
def test_both_ends_of_every_slider_are_admitted(name: str) -> None:
    text = text_of_file(PRESETS[name])
    for group in list_controls(load_text(text)).values():
        for control in group:
            for value in (control.low, control.high) if control.high else ():
                load_text(edit_text(text, {control.name: f"{value:.15g} {control.unit}".strip()}))


# ---------------------------------------------------------------- hostile values

SHOCK = "shock: {profile: triangular, peak_force: 1 N, rise_time: 1 us, duration_ratio: 2}"
CHAIN = "chain: {material: ptfe, diameter: 9 mm}"
HOSTILE = {
    "no scenario": ("alert(1)", "must be a mapping"),
    "object": ("a: !!python/object/apply:os.system ['true']", "a tag"),
    "expression": (f"{CHAIN}\n{SHOCK.replace('1 N', '__import__')}", "shock.peak_force: must be a force"),
    "out of range": (f"{CHAIN}\n{SHOCK.replace('ratio: 2', 'ratio: 0')}", "shock.duration_ratio: must be > 1"),
    "file": (f"{CHAIN}\nshock: {{profile: tabulated, parameters: {{file: /etc/passwd}}}}", "could name a file"),
    "sweep": (f"{CHAIN}\n{SHOCK}\nsweep: {{grid: {{shock.rise_time: [1 us, 2 us]}}}}", "a single case"),
    "file in a sweep": (
        f"{CHAIN}\nshock: {{profile: tabulated}}\nsweep: {{grid: {{shock.parameters.file: [/etc/passwd]}}}}",
        "a single case",
    ),
    "granules": (f"{CHAIN[:-1]}, granules: 100000, end: {{wall: same}}}}\n{SHOCK}", "must be at most 300 here"),
    "nested": ("[" * 5000, "at most 50 nested brackets"),
    "long": ("#" * 300_000, "at most 262144 characters"),
    "cells": (f"{CHAIN[:-1]}, granules: [{{repeat: 1000000, cell: [{{count: 1000000}}]}}]}}\n{SHOCK}", "in all"),
}


@pytest.mark.parametrize("kind", HOSTILE)
def test_hostile_text_is_refused_with_a_message(kind: str, client: Any) -> None:
    text, message = HOSTILE[kind]
    for path in ("answer", "report"):
        fault = refused(client, path, json={"text": text})
        assert message in fault
        assert "root:" not in fault


NAMED = "shock.parameters.file"
READING = {
    "block": {"text": f"{CHAIN}\nshock: {{profile: tabulated, parameters: {{file: secret.txt}}}}"},
    "edit": {"text": f"{CHAIN}\nshock: {{profile: tabulated}}", "edits": {NAMED: "secret.txt"}},
    "grid": {"text": f"{CHAIN}\nshock: {{profile: tabulated}}\nsweep: {{grid: {{{NAMED}: [secret.txt]}}}}"},
    "points": {"text": f"{CHAIN}\nshock: {{profile: tabulated}}\nsweep: {{points: [{{{NAMED}: secret.txt}}]}}"},
    "uncertainty": {"text": f"{CHAIN}\nshock: {{profile: tabulated}}\nuncertainty: {{{NAMED}: secret.txt}}"},
    "example": {"preset": "secret.txt"},
    "shape": {"text": WALL, "edits": {"shock.profile": "secret.txt"}},
    "end": {"text": WALL, "edits": {"chain.end": "wall: secret.txt"}},
}


@pytest.mark.parametrize("kind", READING)
def test_no_request_reads_a_file(kind: str, client: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "secret.txt").write_text("hunter2,hunter2\n1,hunter2\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert "hunter2" not in refused(client, json=READING[kind])
    assert "hunter2" not in posted(client, "report", json=READING[kind]).text


def test_a_wrong_value_of_a_control_is_refused_with_its_name(client: Any) -> None:
    request = {"text": WALL, "edits": {"shock.rise_time": "15 kg", "chain.granules": "many"}}
    faults = {fault["path"]: fault["problem"] for fault in posted(client, json=request).get_json()["faults"]}
    assert faults.keys() == request["edits"].keys()
    assert faults["shock.rise_time"].startswith("must be a time")


def test_a_rise_time_beyond_the_duration_is_refused_in_words(client: Any) -> None:
    text = f"{CHAIN}\nshock: {{profile: triangular, peak_force: 5 N, rise_time: 10 us, duration: 0.2 ms}}"
    message = refused(client, json={"text": text, "edits": {"shock.rise_time": "300 us"}})
    assert "shock.rise_time: must be shorter than the duration, 200 us (got 300 us)" in message


WRONG = {
    "nothing": "",
    "null": "null",
    "list": "[1]",
    "number": "5",
    "number as text": '{"text": 5}',
    "NaN": '{"text": NaN}',
    "deep": "[" * 100_000,
    "deep in the text": json.dumps({"text": "- " * 100_000}),
    "deep in an edit": '{"edits": {"chain": ' + "[" * 900 + "]" * 900 + "}}",
    "list as edits": '{"edits": []}',
    "edit without a name": '{"edits": {"": 1}}',
    "edit of nothing": '{"edits": {"...": 1}}',
    "nested edit": '{"edits": {"shock": {"parameters": {"file": "secret.txt"}}}}',
    "deep name": json.dumps({"edits": {"a." * 100_000: 1}}),
    "edit of a scalar": '{"text": "shock: 5", "edits": {"shock.profile": "triangular", "chain.end": "free end"}}',
    "surrogate": '{"text": "\\ud800", "edits": {"\\ud800": "\\ud800"}}',
    "not UTF-8": b"\xff{}",
}


@pytest.mark.parametrize("path", ["answer", "report"])
@pytest.mark.parametrize("kind", WRONG)
def test_a_wrong_request_is_refused(client: Any, path: str, kind: str) -> None:
    message = refused(client, path, data=WRONG[kind], content_type="application/json")
    assert "internal" not in message
    assert len(message) < 500


def test_markup_in_a_value_is_text(client: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    evil = "<img src=x onerror=alert(1)>"
    groups = {evil: [Control(evil, evil, evil, (evil,)), Control("b", evil, evil)]}
    monkeypatch.setattr(answer, "list_controls", lambda *_: groups)
    shown = asked(client, text=WALL)["controls"]
    assert "<img" not in shown
    assert unescape(shown).count(evil) >= 6
    page = make_application(f"</textarea>{evil}", PORT, TOKEN).test_client().get(f"/{TOKEN}/", base_url=LOOPBACK).text
    assert evil not in page
    assert evil in unescape(page)


def test_work_is_limited_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scene, "_LONGEST", 1e-3)
    text = WALL.replace("granules: 40", "granules: 300") + "  timeout: 1e9 s\n"
    assert load_text(text).simulate.timeout == 1e-3
    parts = parts_of(text)
    limit = "the limit of 0.001 s of this page; shorten the shock or set until"
    assert f"<strong>no answer: the simulation reached {limit}</strong>" in parts["headline"]
    assert 'id="simulate.until"' in parts["controls"]
    assert len(pictures(parts)) == 1


def test_an_internal_error_does_not_end_the_server(client: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError("nought")

    monkeypatch.setattr(server, "parts_of", fail)
    assert "internal error: ZeroDivisionError: nought" in refused(client, status=500, json={"text": WALL})


# ---------------------------------------------------------------- server


HOSTS = {
    "another site": ("evil.example:8042", 403),
    "another port": ("127.0.0.1:8043", 403),
    "no port": ("127.0.0.1", 403),
    "none": (None, 403),
    "two": ("127.0.0.1:8042,evil.example", 403),
    "loopback": ("127.0.0.1:8042", 200),
    "its name": ("localhost:8042", 200),
}


@pytest.mark.parametrize("kind", HOSTS)
def test_a_request_for_another_host_is_refused(client: Any, kind: str) -> None:
    host, status = HOSTS[kind]
    sender = EnvironBuilder(f"/{TOKEN}/").get_environ()
    sender.pop("HTTP_HOST")
    if host is not None:
        sender["HTTP_HOST"] = host
    assert run_wsgi_app(client.application, sender)[1].startswith(str(status))


@pytest.mark.parametrize(
    "origin",
    [None, "null", "", "http://evil.example", "http://127.0.0.1:80", "https://127.0.0.1:8042", "http://localhost:8042"],
)
def test_a_request_of_another_page_is_refused(client: Any, origin: str | None) -> None:
    for path in ("answer", "report"):
        assert "page of the explorer" in refused(client, path, 403, origin=origin, json={"text": WALL})
    status = 200 if origin is None else 403
    headers = {} if origin is None else {"Origin": origin}
    assert client.get(f"/{TOKEN}/", base_url=LOOPBACK, headers=headers).status_code == status


@pytest.mark.parametrize("path", ["", "explorer.js", "explorer.css", "answer", "report"])
@pytest.mark.parametrize("token", ["", "wrong/", f"{TOKEN}2/", f"{TOKEN[:-1]}/", "\xe4/"])
def test_a_request_without_the_token_is_refused(client: Any, path: str, token: str) -> None:
    headers = {"Origin": LOOPBACK}
    for method in (client.get, client.post):
        reply = method(f"/{token}{path}", base_url=LOOPBACK, headers=headers)
        assert (reply.status_code, reply.mimetype) == (403, "text/plain")
        assert TOKEN not in reply.text


def test_a_form_of_another_site_is_refused(client: Any) -> None:
    refused(client, status=415, data=f'{{"text": "{CHAIN}"}}')


def test_a_large_request_is_refused(client: Any) -> None:
    refused(client, status=413, data=b"0" * 2**22, content_type="application/json")


def test_a_short_request_does_not_wait_for_long_ones(client: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    done = threading.Event()
    monkeypatch.setattr(server, "parts_of", lambda text, *_: {"ended": str("long" in text and done.wait(60))})
    app = make_application(WALL, PORT, TOKEN)
    with ThreadPoolExecutor(11) as pool:
        texts = [f"name: long {number}" for number in range(10)]
        long = [pool.submit(asked, app.test_client(), text=text) for text in texts]
        try:
            short = pool.submit(asked, app.test_client(), text="name: short").result(timeout=30)
            assert not any(reply.done() for reply in long)
        finally:
            done.set()
    assert short["ended"] == "False"
    assert [reply.result()["ended"] for reply in long] == ["True"] * 10


def test_answers_do_not_keep_memory() -> None:
    parts_of(WALL)
    gc.collect()
    gc.set_debug(gc.DEBUG_SAVEALL)
    try:
        for force in (50, 51, 52):
            parts_of(edit_text(WALL, {"shock.peak_force": force}))
        gc.collect()
        kept = [type(each) for each in gc.garbage if type(each).__module__.startswith("shockwave")]
    finally:
        gc.set_debug(0)
        gc.garbage.clear()
    assert kept == []


def test_the_page_loads_nothing_from_elsewhere(client: Any) -> None:
    for path in ("", "explorer.js", "explorer.css"):
        reply = client.get(f"/{TOKEN}/{path}", base_url=LOOPBACK)
        assert reply.status_code == 200
        policy = reply.headers["Content-Security-Policy"]
        assert "unsafe" not in policy
        for rule in ("default-src 'self'", "frame-ancestors 'none'", "base-uri 'none'", "form-action 'none'"):
            assert rule in policy
        assert "http://" not in reply.text
        assert "https://" not in reply.text
        reply.close()


def test_the_report_is_saved_or_refused(client: Any) -> None:
    reply = posted(client, "report", json={"text": ENDLESS})
    assert (reply.status_code, reply.mimetype) == (200, "text/html")
    assert reply.text.startswith("<!DOCTYPE html>")
    assert "chain: must be given" in refused(client, "report", json={"text": "shock: {<b>: 1}"})


@contextmanager
def served(*arguments: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """The command in a process of its own, and its address."""
    command = [sys.executable, "-m", "shockwave", "explore", "--no-browser", "--port", "0", *arguments]
    # a process that was started in the background ignores the signal, and would pass this on
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    signal.signal(signal.SIGINT, before)
    assert process.stdout is not None
    try:
        # ends a process that prints nothing
        clock = threading.Timer(60, process.kill)
        clock.start()
        line = process.stdout.readline()
        clock.cancel()
        yield process, line.split()[0]
    finally:
        process.kill()
        process.communicate()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one process")
def test_it_listens_on_loopback_alone_and_ends_quietly() -> None:
    with served() as (process, address):
        assert address.startswith("http://127.0.0.1:")
        port = urlsplit(address).port
        socket.create_connection(("127.0.0.1", port), 5).close()
        # an address that a server for all of them would answer on
        with pytest.raises(OSError, match=r".*"):
            socket.create_connection(("127.0.0.2", port), 5)
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=30) == ("", "")
        assert process.returncode == 0


def test_a_port_in_use_is_an_error_of_usage(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        assert cli.main(["explore", "--no-browser", "--port", str(port)]) == 2
    assert f"--port: must be a free port (got {port}: " in capsys.readouterr().err


def test_the_scenario_may_be_standard_input_with_values_of_options(monkeypatch: pytest.MonkeyPatch) -> None:
    begun: list[tuple[str, int, bool]] = []
    monkeypatch.setattr(server, "serve", lambda *arguments: begun.append(arguments))
    text = text_of_file(PROFILES / "examples" / "hammer.yaml")
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    assert cli.main(["explore", "-", "--port", "0"]) == 0
    assert cli.main(["explore", "--set", "chain.diameter=8 mm", "--no-browser"]) == 0
    (piped, *first), (changed, *second) = begun
    assert (piped, first, second) == (text, [0, True], [8042, False])
    assert load_text(changed).chain.radius == pytest.approx(4e-3)


def test_an_invalid_file_is_reported_before_the_server_starts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "bad.yaml"
    file.write_text(f"{CHAIN}\nshock: {{}}\n", encoding="utf-8")
    assert cli.main(["explore", "--no-browser", str(file)]) == 3
    assert f"{file}:2:" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("chain", "message"),
    [
        ("granules: 2000, end: {wall: same}", "at most 300 here"),
        (f"granules: 20}}\n#{'-' * 300_000}\n#{{", "at most 262144 characters"),
    ],
)
def test_a_file_that_the_page_refuses_ends_the_command(
    chain: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(socket, "create_server", None)  # a server would end with another error
    file = tmp_path / "large.yaml"
    file.write_text(f"{CHAIN[:-1]}, {chain}}}\n{SHOCK}\n", encoding="utf-8")
    assert cli.main(["explore", "--no-browser", str(file)]) == 3
    assert message in capsys.readouterr().err


def test_an_impossible_port_is_an_error_of_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["explore", "--port", "70000"]) == 2
    assert capsys.readouterr().err == "--port: must be >= 0 and <= 65535 (got 70000) (see `shockwave explore --help`)\n"


def test_the_help_names_the_options_and_fits_80_columns(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit, match="0"):
        cli.main(["explore", "--help"])
    text = capsys.readouterr().out
    assert text.startswith("usage: shockwave explore")
    assert all(option in text for option in ("FILE", "--port", "--no-browser"))
    assert max(map(len, text.splitlines())) <= 80


def test_sensors_have_a_figure_with_their_first_pulses() -> None:
    text = WALL.replace("simulate:", "simulate:\n  sensors: [{contact: 2}, wall]") if "simulate:" in WALL else ""
    text = text or f"{WALL}\nsimulate: {{sensors: [{{contact: 2}}, wall]}}\n"
    figures = unescape(parts_of(text)["figures"])
    assert "Force at sensors" in figures
    assert re.search(r"First pulses: contact 2: [\d.]+ N, width [\d.]+ µs; wall: ", figures)
    assert "at sensors" not in parts_of(WALL)["figures"]


MOTION = """\
chain: {material: stainless-steel-316, diameter: 9.5 mm, granules: 6}
motion: {velocity: 1 m/s, until: 20 us}
"""


def test_a_prescribed_motion_has_controls_and_no_picture_of_a_shock() -> None:
    parts = parts_of(MOTION)
    assert 'id="motion.velocity"' in parts["controls"]
    assert "Space-time diagram" in parts["figures"]
    assert "The shock" not in parts["figures"]


def test_a_link_contains_the_samples_of_a_motion(tmp_path: Path) -> None:
    (tmp_path / "base.csv").write_text("time [us],acceleration [m/s^2]\n0,0\n5,100\n20,0\n")
    scene = MOTION.replace("{velocity: 1 m/s, until: 20 us}", "{file: base.csv, quantity: acceleration}")
    (tmp_path / "scene.yaml").write_text(scene)
    text = text_of_file(tmp_path / "scene.yaml")
    assert "file" not in text
    assert sw.predict(load_text(text)).greatest_force == sw.predict(tmp_path / "scene.yaml").greatest_force


def test_a_movable_end_and_sensors_of_motion_have_a_chart_for_each_unit() -> None:
    end = "end: {wall: rigid, mass: 1 kg, stiffness: 1e7 N/m}}"
    text = (
        MOTION.replace("granules: 6}", f"granules: 6, {end}")
        + "simulate: {sensors: [{granule: 2, quantity: velocity}]}\n"
    )
    figures = unescape(parts_of(text)["figures"])
    for name in ("Force", "Velocity", "Displacement", "Acceleration"):
        assert f"{name} at sensors" in figures
    assert "First pulses: granule 2 velocity: " in figures
    lowest = re.search(r"velocity \(m/s\)<.*?</svg>", figures, re.DOTALL)
    assert lowest is not None
    assert ">-" in lowest.group()
    assert figures.count('id="pause"') == 1


def test_histories_that_take_too_long_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise sw.NumericalError("the time limit was reached")

    monkeypatch.setattr("shockwave.simulation.chain_histories.record_chain", fail)
    parts = parts_of(MOTION)
    assert "No histories: the time limit was reached" in parts["results"]
    assert "Space-time diagram" not in parts["figures"]


def test_a_bar_is_an_end_that_a_wall_can_replace() -> None:
    end = "end: {bar: {material: steel-4340, diameter: 19 mm}}}"
    text = MOTION.replace("granules: 6}", f"granules: 6, {end}")
    (control,) = (each for each in list_controls(load_text(text))["Chain"] if each.name == "chain.end")
    assert control.text == "as in the text"
    walled = load_text(edit_text(text, {"chain.end": "wall: rigid"}))
    assert isinstance(walled.chain.end, sw.Wall)


def test_a_new_end_or_number_of_granules_leaves_out_sensors_that_may_be_gone() -> None:
    text = MOTION.replace("granules: 6}", "granules: 6, end: {wall: rigid}}") + "simulate: {sensors: [wall]}\n"
    for name, value in (("chain.end", "free end"), ("chain.granules", 3)):
        assert load_text(edit_text(text, {name: value})).simulate.sensors == ()
    assert load_text(edit_text(text, {"motion.velocity": "2 m/s"})).simulate.sensors


def test_every_contact_of_a_chain_with_a_striker_is_drawn() -> None:
    text = MOTION.partition("motion")[0] + "impact: {velocity: 1 m/s}\n"
    _, outcome = predict_text(text)
    assert outcome.simulated is not None
    assert outcome.simulated.recording.contacts == tuple(range(6))


def test_a_granule_before_a_wall_has_a_page() -> None:
    text = "chain: {material: ptfe, diameter: 9.5 mm, granules: 1, end: {wall: rigid}}\n"
    text += "shock: {profile: half-sine, peak_force: 10 N, duration: 0.1 ms}\n"
    assert "Force on the wall" in parts_of(text)["figures"]
