"""Random cases of the command line end with a documented status, in bounded time and memory; see fuzz.py."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

pytest.importorskip("resource", reason="limits of POSIX")

import fuzz
from fuzz_cases import case_of, command_case, commands


@pytest.mark.slow
def test_random_cases_end_as_documented() -> None:
    outcomes = fuzz.run(range(100), seed=0)
    assert len(outcomes) == 100
    assert [outcome for outcome in outcomes if outcome.wrong] == []


def test_a_case_follows_from_its_seed_and_number() -> None:
    assert case_of(3, 14) == case_of(3, 14) != case_of(3, 15)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("program", "wrong"),
    [
        ("raise ValueError('odd')", "internal error: ValueError: odd"),
        ("import sys; sys.exit(9)", "status 9"),
        ("while True: pass", "more than 10 s"),
        ("kept = bytearray(2**30)", "internal error: MemoryError"),
        ("open('scene.yaml', 'w').close()", "changed ['scene.yaml']"),
        ("import os; os.abort()", "ended by signal 6"),
    ],
    ids=["raises", "status", "endless", "memory", "input", "dies"],
)
def test_what_is_wrong_with_a_case_is_found(
    program: str, wrong: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # the worker of a copy, in which validating does something else
    worker = tmp_path / "broken.py"
    worker.write_text(
        "import sys; sys.path.insert(0, sys.argv.pop(1))\nimport fuzz\nimport shockwave.cli.scenes as scenes\n"
        f"def validate(options):\n    {program}\n    return 0\nscenes.validate = validate\n"
        "fuzz.case_of = lambda *_: fuzz.Case('own', ('validate', 'scene.yaml'), {'scene.yaml': b'x'})\nfuzz.main()\n"
    )
    monkeypatch.setattr(fuzz, "PROGRAM", (str(worker), str(fuzz.ROOT / "tests")))
    (outcome,) = fuzz.run([0], seed=0, workers=1)
    assert wrong in outcome.wrong


def test_every_command_and_option_is_tried() -> None:
    tried: dict[str, set[str]] = {}
    for number in range(3000):
        name, *arguments = command_case(random.Random(number)).arguments
        tried.setdefault(name, set()).update(arguments)
    missing = {
        (name, option)
        for name, actions in commands().items()
        for option in (max(action.option_strings, default="", key=len) for action in actions)
        if option and name != "report" and option not in tried[name]
    }
    assert missing == set()
