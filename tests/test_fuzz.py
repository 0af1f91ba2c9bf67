"""Random cases of the command line end with a documented status, in bounded time and memory; see fuzz.py."""

from __future__ import annotations

import random

import pytest

pytest.importorskip("resource", reason="limits of POSIX")

import fuzz


@pytest.mark.slow
def test_random_cases_end_as_documented() -> None:
    cases = [fuzz.case_of(0, number) for number in range(100)]
    assert [(case.arguments, wrong) for case, wrong in zip(cases, fuzz.run(cases), strict=True) if wrong] == []


def test_a_case_follows_from_its_seed_and_number() -> None:
    assert fuzz.case_of(3, 14) == fuzz.case_of(3, 14) != fuzz.case_of(3, 15)


@pytest.mark.parametrize(
    ("status", "seconds", "out", "err", "changed", "wrong"),
    [
        (0, 1.0, "{}", "", [], ""),
        (9, 1.0, "{}", "", [], "status 9"),
        (1, 1.0, "", "internal error: ValueError: odd", [], "internal error"),
        (0, 99.0, "{}", "", [], "took 99.0 s"),
        (0, 1.0, "{}", "", ["scene.yaml"], "changed"),
        (0, 1.0, '{"a": NaN}', "", [], "no JSON"),
    ],
    ids=["right", "status", "internal", "endless", "input", "json"],
)
def test_what_is_wrong_with_a_case_is_found(
    status: int, seconds: float, out: str, err: str, changed: list[str], wrong: str
) -> None:
    found = fuzz.fault(fuzz.Case(("validate", "scene.yaml", "--json"), {}), status, seconds, out, err, changed)
    assert found.startswith(wrong)
    assert bool(found) == bool(wrong)


def test_every_command_and_option_is_tried() -> None:
    tried: dict[str, set[str]] = {}
    for number in range(3000):
        name, *arguments = fuzz.command_case(random.Random(number)).arguments
        tried.setdefault(name, set()).update(arguments)
    for name, actions in fuzz.commands().items():
        longest = {max(action.option_strings, key=len) for action in actions if action.option_strings}
        assert longest - tried[name] == set()
