"""Scenarios on the command line: standard input, and values given by options."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import attrs
import pytest

import shockwave as sw
from shockwave.cli.command_table import COMMANDS, OFFERED, Command
from shockwave.cli.parser import parse
from shockwave.cli.scenario_files import load_with_changes
from support.command_line import scenario, shockwave, unwrapped

PROGRAM = [sys.executable, "-m", "shockwave"]
SCENE = """\
name: scene
chain:
  material: brass-260
  diameter: 9.5 mm
  granules:
    - {count: 3}
    - {count: 2, diameter: 8 mm}
  end: {wall: same}
shock: {profile: triangular, peak_force: 50 N, rise_time: 20 us, duration_ratio: 3}
"""
# A record in the current folder.
RECORD = "shock: {profile: tabulated, parameters: {file: pulse.csv}}\n"
SWEEP = "sweep: {grid: {shock.peak_force: [10 N, 20 N]}}\n"
UNCERTAIN = "uncertainty: {shock.peak_force: 5 %}\n"
#: Every command that takes a scenario, as it is used on a small one.
READERS = {
    "predict": "predict {}",
    "simulate": "simulate {} --rtol 1e-2",
    "compare": "compare {} --rtol 1e-2",
    "validate": "validate {}",
    "report": "report {} -o page.html",
    "spectrum": "spectrum {} --mass 1kg --from 1kHz --to 2kHz",
    "curve": "curve {} --rtol 1e-2 --longest 1",
    "sweep": "sweep {} --workers 1 -o results",
    "design": "design {} --vary chain.diameter --between 2mm 4mm --target chain.mass<=9 --rtol 1e-2 --points 2",
    "uncertainty": "uncertainty {} --draws 64 --rtol 1e-2 -o picture.svg",
    "bench": "bench {} --quick --family quadratures --timeout 1e-3",
}
BLOCKS = {"sweep": SWEEP, "uncertainty": UNCERTAIN}


def test_every_command_that_reads_a_scenario_is_tried() -> None:
    commands = [each.name for each in COMMANDS if any("--set" in option.names for option in each.options)]
    assert {*READERS} == {*commands} - OFFERED.keys()


@pytest.mark.usefixtures("few_draws")
@pytest.mark.parametrize("command", READERS)
def test_a_dash_is_standard_input_and_set_holds_in_every_command(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("shockwave.report.html_page.choose_pictures", lambda _: {})  # a page without pictures
    (tmp_path / "pulse.csv").write_text("time (us),force (N)\n0,0\n10,50\n20,0\n")
    text = f"{SCENE.partition('shock:')[0]}{RECORD}{BLOCKS.get(command, '')}"
    words, equal = READERS[command].format("-").split(), ("--set", "chain.granules=6", "--set", "chain.end=")
    answer = shockwave(*words, *equal, stdin=text)
    assert answer.status == 0, answer.err
    for change, file, status, problem in (
        ("chain.diametr=8 mm", text, 2, "--set: chain.diametr: unknown key (got 'diametr'; did you mean 'diameter'? "),
        ("name=x", text.replace("8 mm", "8 kg"), 3, "<stdin>:7:28: chain.granules[1].diameter: must be "),
    ):
        answer = shockwave(*words, "--set", change, stdin=file)
        assert answer.status == status
        assert (answer.out if command == "validate" else answer.err).startswith(problem)


BRASS = sw.material("brass-260")
CONSTANTS = ("youngs_modulus", "poisson_ratio", "yield_strength")
#: Values at paths, and the text of a scenario that has them.
CHANGES = {
    "number": ("chain.diameter=8e-3", {"diameter: 9.5 mm": "diameter: 8 mm"}),
    "quantity": ("shock.peak_force=60 N", {"50 N": "60 N"}),
    "item": ("chain.granules[1].diameter=7 mm", {"8 mm": "7 mm"}),
    "new key": ("chain.granules[0].material=ptfe", {"{count: 3}": "{count: 3, material: ptfe}"}),
    "new block": ("limit.force=10 N", {"shock:": "limit: {force: 10 N}\nshock:"}),
    "mapping": ("chain.end={wall: rigid}", {"wall: same": "wall: rigid"}),
    "list": ("simulate.contacts=[1, 2]", {"shock:": "simulate: {contacts: [1, 2]}\nshock:"}),
    "deleted": ("chain.end=", {"  end: {wall: same}\n": ""}),
    "name": ("name=other", {"name: scene": "name: other"}),
    "constant of a material": (
        "chain.material.density=8000",
        {"brass-260": str({name: getattr(BRASS, name) for name in CONSTANTS} | {"density": 8000}).replace("'", "")},
    ),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_value_that_is_set_is_as_good_as_one_in_the_file(name: str, tmp_path: Path) -> None:
    change, replaced = CHANGES[name]
    text = SCENE
    for old, new in replaced.items():
        text = text.replace(old, new)
    file = str(scenario(tmp_path, SCENE))
    changed, original = (load_with_changes(file, parse(["predict", file, *more])) for more in (["--set", change], []))
    assert attrs.evolve(changed, path=None) == sw.Scenario.from_yaml(text) != attrs.evolve(original, path=None)


def test_values_are_set_in_turn_and_in_every_file(tmp_path: Path) -> None:
    files = [scenario(tmp_path, SCENE, name=name) for name in ("a", "b")]
    changes = ("--set", "chain.granules=[{count: 4}]", "--set", "chain.granules[0].count=6")
    documents = shockwave("simulate", "--json", "--rtol", "1e-2", *changes, *files).document
    assert [document["scene"]["granules"] for document in documents] == [6, 6]


#: Wrong values, and the beginnings of their errors.
WRONG = {
    "no value": ("chain.diameter", "--set: must be PATH=VALUE (got 'chain.diameter'; `chain.diameter=` deletes it)"),
    "no path": ("=3", "--set: must be PATH=VALUE with a path such as "),
    "syntax of the path": ("chain..diameter=3", "--set: must be PATH=VALUE with a path such as "),
    "syntax of the value": ("chain.end={wall: same", "--set chain.end: must be YAML (got: "),
    "key": ("chain.granules[1].diametr=3 mm", "--set: chain.granules[1].diametr: unknown key (got 'diametr'; did you"),
    "part of a value": ("chain.end={wal: same}", "--set: chain.end.wal: unknown key (got 'wal'; did you mean 'wall'? "),
    "last key of a path": ("diameter=3 mm", "--set: diameter: unknown key (got 'diameter'; did you mean 'chain.diam"),
    "block": ("shok.rise_time=1 us", "--set: shok: unknown key (got 'shok'; did you mean 'shock'? "),
    "item": (
        "chain.granules[2].diameter=3 mm",
        "--set: chain.granules[2].diameter: must be an item of chain.granules, a ",
    ),
    "no list": ("chain.diameter[0]=3 mm", "--set: chain.diameter[0]: must be below a list (got '9.5 mm' at chain.diam"),
    "no mapping": ("name.first=x", "--set: name.first: must be below a mapping (got 'scene' at name)"),
    "nothing to delete": ("chain.gravty=", "--set: chain.gravty: must be in the scenario to be deleted ("),
    "value that is required": ("shock.rise_time=", "--set: shock.rise_time: must be given (got nothing; "),
    "range": ("shock.peak_force=-1 N", "--set: shock.peak_force: must be > 0 N (got '-1 N')"),
    "swept": ("shock.peak_force=1 N", "--set: shock.peak_force: must not be varied by the sweep (got both; "),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_value_is_an_error_of_the_option(name: str, tmp_path: Path) -> None:
    change, problem = WRONG[name]
    answer = shockwave("sweep", "--dry-run", scenario(tmp_path, SCENE, SWEEP * (name == "swept")), "--set", change)
    assert answer.status == 2
    assert answer.err.startswith(problem)


@pytest.mark.parametrize("place", [0, 2], ids=["first", "last"])
def test_a_varied_value_may_be_set_if_the_sweep_is_deleted(place: int, tmp_path: Path) -> None:
    changes = ["--set", "shock.peak_force=1 N"]
    changes[place:place] = ["--set", "sweep="]
    answer = shockwave("validate", scenario(tmp_path, SCENE, SWEEP), *changes)
    assert answer.out.endswith(": valid\n")


def test_errors_of_files_and_of_options_are_reported_together(tmp_path: Path) -> None:
    files = [scenario(tmp_path, SCENE, name="good"), scenario(tmp_path, SCENE.replace("8 mm", "8 kg"), name="bad")]
    answer = shockwave("predict", *files, "--rtol", "2")
    assert answer.status == 3
    assert [line.partition(": must")[0] for line in answer.err.splitlines()] == [
        f"--rtol for {files[0]}: simulate.rtol",
        f"{files[1]}:7:28: chain.granules[1].diameter",
        f"--rtol for {files[1]}: simulate.rtol",
    ]


def test_a_sweep_keeps_the_scenario_that_was_run(tmp_path: Path) -> None:
    out = tmp_path / "out"
    changes = ("--set", "sweep.grid.shock.peak_force=[1 N, 2 N, 3 N]", "--set", "chain.diameter=8 mm")
    assert shockwave("sweep", "-", *changes, "-o", out, "--workers", "1", stdin=SCENE + SWEEP).status == 0
    kept = sw.load_scenario(out / "scenario.yaml")
    assert kept.document is not None
    assert kept.document.data["chain"]["diameter"] == "8 mm"
    assert shockwave("sweep", out / "scenario.yaml", "-o", out, "--resume").status == 0
    assert len(sw.load_sweep(out)) == 3


# ---------------------------------------------------------------- files that are written


def test_a_report_is_written_beside_no_other_file_of_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("shockwave.report.html_page.choose_pictures", lambda _: {})  # pages without pictures
    file = scenario(tmp_path, SCENE)
    assert shockwave("report", file).err == "scene.html: written\n"
    assert shockwave("report", file, "--set", "chain.diameter=7 mm").err == "scene.html: replaced\n"
    page = Path("scene.html").read_text(encoding="utf-8")
    assert "diameter: 7 mm" in page
    assert shockwave("report", file, "-o", "-", "--set", "chain.diameter=7 mm").out == page
    Path("scene.html").write_text("my own")
    answer = shockwave("report", file)
    assert answer.status == 5
    assert "scene.html: must be a report to be replaced (got another kind of file; give a name with" in answer.err
    assert Path("scene.html").read_text() == "my own"
    assert shockwave("report", file, "-o", "scene.html").err == "scene.html: replaced\n"
    assert shockwave("report", "-", stdin=SCENE).err == "stdin.html: written\n"


# ---------------------------------------------------------------- help and pipes


def test_without_a_command_help_is_printed_as_an_error() -> None:
    answer = shockwave()
    assert (answer.status, answer.out) == (2, "")
    assert answer.err == shockwave("--help").out
    assert answer.err == shockwave("--no-plugins").err


@pytest.mark.parametrize("command", [each for each in COMMANDS if each.options], ids=lambda each: each.name)
def test_help_has_examples_that_are_commands_and_a_link(command: Command) -> None:
    shown = shockwave(command.name, "--help").out
    assert f"/commands.html#{command.name}\n" in shown
    assert command.examples
    for example in command.examples:
        assert f"  {example}\n" in shown
        for part in example.replace("\\\n", "").partition(" < ")[0].split(" | "):
            program, *words = shlex.split(part)
            assert (program, bool(parse(words).command)) == ("shockwave", True)


def test_defaults_of_help_are_those_of_the_keys() -> None:
    shown = unwrapped(shockwave("predict", "--help").out)
    assert f"(default: {sw.Predictor().model})" in shown
    assert "for adaptive methods (default: 1e-6)" in shown


@pytest.mark.parametrize("command", ["--help", "predict -", "schema"])
def test_a_reader_that_ends_early_is_no_error(command: str) -> None:
    read, write = os.pipe()
    os.close(read)
    words = [*PROGRAM, *command.split()]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=write, stderr=subprocess.PIPE, text=True) as run:
        os.close(write)
        _, err = run.communicate(SCENE, timeout=600)
    assert (run.returncode, err) == (0, "")
