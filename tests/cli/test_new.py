"""The command new: every scenario that it writes runs, and an editor finds its schema."""

from __future__ import annotations

import json
import re
from importlib import resources
from pathlib import Path

import pytest
from jsonschema import Draft7Validator

import shockwave as sw
from shockwave.registry import built_ins
from support.command_line import shockwave
from support.scenario_texts import schema_faults

PROFILES = [entry.name for entry in built_ins.ENTRIES["profiles"]]
EXAMPLES = ("wall", "striker", "record", "plastic")
WAYS = {
    "plain": [],
    "full": ["--full"],
    **{name: ["--profile", name] for name in PROFILES},
    **{f"example {name}": ["--example", name] for name in EXAMPLES},
}


pytestmark = pytest.mark.usefixtures("folder")


@pytest.mark.parametrize("arguments", WAYS.values(), ids=WAYS)
def test_a_new_scenario_runs_without_a_warning(arguments: list[str], folder: Path) -> None:
    file = folder / "scene.yaml"
    file.write_text(shockwave("new", *arguments).out, encoding="utf-8")
    assert schema_faults(file.read_text(encoding="utf-8")) == []
    outcome, result = sw.predict(file), sw.simulate(file)
    assert outcome.warnings == result.warnings == ()
    assert result.yielding is not None
    assert result.yielding.elastic_ratio < 1


def test_the_default_is_a_half_sine_in_ten_lines() -> None:
    text = shockwave("new").out
    assert len(text.splitlines()) == 10
    assert "profile: half-sine" in text


def test_examples_are_those_of_the_package() -> None:
    files = resources.files("shockwave.scenario").joinpath("examples").iterdir()
    assert {file.name.partition(".")[0] for file in files} == set(EXAMPLES)


@pytest.mark.parametrize("arguments", [[], ["--full"], ["--example", "record"]], ids=["short", "full", "record"])
def test_an_editor_finds_the_schema_of_a_file(arguments: list[str], folder: Path) -> None:
    (folder / "inner").mkdir()
    assert shockwave("new", *arguments, "-o", "inner/mine.yaml").status == 0
    text = Path("inner/mine.yaml").read_text(encoding="utf-8")
    (name,) = re.findall(r"\A# yaml-language-server: \$schema=(\S+)\n", text)
    schema = json.loads((folder / "inner" / name).read_text(encoding="utf-8"))
    assert schema_faults(text, Draft7Validator(schema)) == []
    assert sw.load_scenario("inner/mine.yaml").name


def test_existing_files_are_kept(folder: Path) -> None:
    for name in ("scenario.schema.json", "record.csv"):
        (folder / name).write_text("kept")
    answer = shockwave("new", "--example", "record", "-o", "mine.yaml")
    assert (answer.status, answer.err.count(": exists, not changed\n")) == (0, 2)
    assert shockwave("new", "-o", "mine.yaml").status == 5
    assert {(folder / name).read_text() for name in ("scenario.schema.json", "record.csv")} == {"kept"}


@pytest.mark.parametrize("arguments", [["new", "--profile", "triangulr"], ["stress", "no-forc"]], ids=" ".join)
def test_an_unknown_name_on_the_command_line_is_an_error_of_usage(arguments: list[str]) -> None:
    answer = shockwave(*arguments)
    assert (answer.status, answer.out) == (2, "")
    assert "; did you mean " in answer.err


@pytest.mark.parametrize("other", [["--full"], ["--profile", "trapezoid"]], ids=" ".join)
def test_an_example_takes_no_other_option(other: list[str]) -> None:
    answer = shockwave("new", "--example", "wall", *other)
    assert answer.status == 2
    assert answer.err.startswith("--example: must be")
