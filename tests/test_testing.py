"""The test kit for plugins: what shockwave has itself passes it, and it has a test for each clause of each contract."""

from __future__ import annotations

import inspect
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import shockwave
from shockwave.profiles.exponential import Exponential
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.tabulated import Tabulated
from shockwave.profiles.triangular import Triangular
from shockwave.quadrature import Quadrature
from shockwave.quadrature.gauss_legendre import GaussLegendre
from shockwave.registry import entries, load
from shockwave.simulation.integrator import Integrator
from shockwave.simulation.nystroem import Rkn86
from shockwave.simulation.one_step import OneStep
from shockwave.simulation.verlet import Verlet
from shockwave.testing import IntegratorContract, ProfileContract, QuadratureContract
from shockwave.testing.contract import Contract, clauses_of
from shockwave.testing.smoothness import roughness, steepening

PACKAGE = Path(shockwave.__file__).parent
CONTRACTS = [ProfileContract, IntegratorContract, QuadratureContract]
by_name = {"ids": lambda cls: cls.__name__}


def own(kind: str) -> list[type]:
    return [load(kind, entry.name) for entry in entries(kind) if entry.distribution == "granular-shockwave"]


def record(seed: int, samples: int) -> Tabulated:
    """A force that goes up and down at random."""
    draw = np.random.default_rng(seed)
    forces = np.concatenate(([0.0], draw.uniform(0.05, 1.0, samples - 2), [0.0]))
    return Tabulated(times=np.append(0.0, np.cumsum(draw.uniform(0.1, 1.0, samples - 1))), forces=forces)


# ---------------------------------------------------------------- what shockwave has itself


class TestPowerLaw(ProfileContract):
    # steep, flat, infinitely steep at one end or the other, with jumps, straight, and next to straight
    profiles = tuple(
        PowerLaw(rise_exponent=rise, decay_exponent=decay, duration_ratio=n)
        for rise, decay, n in [
            (1, 1, 2),
            (0.5, 1, 3),
            (0, 0, 3),
            (0.95, 1.5, 30),
        ]
    )


@pytest.mark.slow
class TestExtremePowerLaw(ProfileContract):
    profiles = tuple(
        PowerLaw(rise_exponent=rise, decay_exponent=decay, duration_ratio=n)
        for rise, decay, n in [(1e-5, 50, 4), (50, 1e-5, 1.1), (2.5, 0.1, 1.0001), (1e6, 1e6, 3)]
    )


class TestTriangular(ProfileContract):
    profiles = (Triangular(duration_ratio=1.0001), Triangular(duration_ratio=2), Triangular(duration_ratio=1e9))


class TestExponential(ProfileContract):
    profiles = tuple(
        Exponential(rise_rate=rise, decay_rate=decay, duration_ratio=n)
        for rise, decay, n in [
            (1e-12, 1e-12, 2),
            (1, -1, 3),
        ]
    )


@pytest.mark.slow
class TestExtremeExponential(ProfileContract):
    profiles = tuple(
        Exponential(rise_rate=rise, decay_rate=decay, duration_ratio=n)
        for rise, decay, n in [(700, 700, 10), (-700, -700, 10), (300, 1e-12, 1.1), (1e6, 1e6, 10)]
    )


class TestTabulated(ProfileContract):
    profiles = (Tabulated([0.0, 1.0, 2.0, 5.0], [0.0, 1.0, 2.0, 0.0]), record(1, 12))


@pytest.mark.slow
class TestLongRecord(ProfileContract):
    profiles = (record(2, 1000),)


class TestIntegrators(IntegratorContract):
    # the one that is used by default, and one of fixed step
    integrators = (Rkn86, Verlet)


@pytest.mark.slow
class TestOtherIntegrators(IntegratorContract):
    integrators = tuple(cls for cls in own("integrators") if cls not in (Rkn86, Verlet))


class TestQuadratures(QuadratureContract):
    quadratures = tuple(own("quadratures"))


# ---------------------------------------------------------------- a test for each clause


def numbers(contract: type[Contract], kind: str) -> list[int]:
    """Numbers of the clauses for which the contract has a test."""
    names = [re.fullmatch(rf"test_{kind}clause_(\d+)_\w+", name) for name in dir(contract)]
    return sorted({int(name[1]) for name in names if name})


@pytest.mark.parametrize(
    ("contract", "kind", "signed", "count"),
    [
        (ProfileContract, "", "ShockProfile", 9),
        (IntegratorContract, "", "Integrator", 9),
        (IntegratorContract, "one_step_", "OneStep", 3),
        (QuadratureContract, "", "Quadrature", 5),
    ],
)
def test_each_clause_of_the_docstring_has_a_test(contract: type[Contract], kind: str, signed: str, count: int) -> None:
    classes = {cls.__name__: cls for cls in (*Triangular.__mro__, Integrator, OneStep, Quadrature)}
    clauses = clauses_of(classes[signed])
    # The count is written out, for a docstring that cannot be read would agree with no tests at all.
    assert list(clauses) == numbers(contract, kind) == list(range(1, count + 1))
    assert all(text.endswith(".") for text in clauses.values())


@pytest.mark.parametrize("contract", CONTRACTS, **by_name)
def test_the_docstring_shows_a_test_of_four_lines(contract: type[Contract]) -> None:
    block = inspect.getdoc(contract).split("::\n\n")[1].split("\n\nAttributes")[0]
    lines = [line for line in block.splitlines() if line.strip()]
    assert len(lines) == 4
    assert lines[0].strip() == f"from shockwave.testing import {contract.__name__}"


# ---------------------------------------------------------------- lists, and what is left out

MODULE = """
from shockwave import ShockProfile, Triangular
from shockwave.testing import IntegratorContract, ProfileContract, QuadratureContract

class ForOneNumber(ShockProfile):
    duration_ratio = 3.0

    def rise(self, s):
        if s < 0.5:
            return 0.8 * s
        return 1.2 * s - 0.2

    def decay(self, s):
        return (3 - s) / 2

class TestForOneNumber(ProfileContract):
    profiles = [ForOneNumber()]

class TestFourLines(ProfileContract):
    profiles = [Triangular(duration_ratio=3)]

class TestLeftOut(ProfileContract):
    profiles = [Triangular(duration_ratio=4)]
    leave_out = {"clause 7": "good to 1e-9 only", "test_it_is_a_value": "it is none"}

class TestNoList(ProfileContract):
    pass
"""


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory) -> str:
    """What pytest says of a test module."""
    folder = tmp_path_factory.mktemp("kit")
    (folder / "test_it.py").write_text(MODULE)
    options = ["-p", "no:cacheprovider", "-v", "-rs", "-W", "error", "--continue-on-collection-errors"]
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE.parent), "COLUMNS": "400"}
    command = [sys.executable, "-m", "pytest", *options, "test_it.py"]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment).stdout


def test_four_lines_are_a_test(said: str) -> None:
    passed = re.findall(r"TestFourLines::(test_\w+)\[Triangular\(duration_ratio=3\.0\)\] PASSED", said)
    assert set(passed) == {name for name in dir(ProfileContract) if name.startswith("test_")}


def test_contracts_that_a_module_imports_are_no_tests_themselves(said: str) -> None:
    assert set(re.findall(r"test_it\.py::(\w+)", said)) == {"TestForOneNumber", "TestFourLines", "TestLeftOut"}


def test_a_class_without_a_list_is_an_error_of_pytest(said: str) -> None:
    assert "TestNoList.profiles must be given: write  profiles = [MyProfile(duration_ratio=3)]  in the class" in said
    assert "1 error" in said.splitlines()[-1]


def test_one_fault_is_one_failure_without_code_of_the_kit(said: str) -> None:
    assert "1 failed" in said.splitlines()[-1]
    report = said.split("= FAILURES =")[1].split("= short test summary")[0]
    assert "found: rise(s) raises ValueError('The truth value of an array with more than one element" in report
    assert "(in test_it.py, line 9, `if s < 0.5:`) for an s of shape (5,)" in " ".join(report.split())
    # its heading, the five parts of the message, and no traceback
    assert len(report.strip().splitlines()) < 20
    assert "/testing/" not in report
    assert "During handling" not in said
    assert said.count("see clause 2 first") == 8 + 1


def test_what_is_left_out_is_skipped_with_its_reason(said: str) -> None:
    skipped = re.findall(r"TestLeftOut::test_(\w+?)_\w+\[.*\] SKIPPED \((.*)\)", said)
    assert sorted(skipped) == [("clause", "left out: good to 1e-9 only"), ("it", "left out: it is none")]
    assert "10 skipped" in said.splitlines()[-1]


class NoOrder(Integrator):  # type: ignore[misc]
    """Abstract still."""


REFUSED = {
    "no-list": (ProfileContract, {}, "profiles must be given: write  profiles = [MyProfile(duration_ratio=3)]"),
    "empty": (ProfileContract, {"profiles": []}, "profiles must be a list with one member at least (got [])"),
    "no-sequence": (ProfileContract, {"profiles": Triangular(duration_ratio=3)}, "with one member at least (got Tri"),
    "class": (ProfileContract, {"profiles": [Triangular]}, "profiles[0] must be an object, not its class (got <class"),
    "number": (ProfileContract, {"profiles": [Triangular(duration_ratio=3), 7]}, "[1] must be a ShockProfile (got 7)"),
    "integrator-object": (IntegratorContract, {"integrators": [Verlet()]}, "[0] must be a class, a subclass of"),
    "wrong-class": (IntegratorContract, {"integrators": [Triangular]}, "[0] must be a class, a subclass of Integrator"),
    "abstract": (IntegratorContract, {"integrators": [NoOrder]}, "[0] must be a class that writes steps (got"),
    "quadrature-object": (QuadratureContract, {"quadratures": [GaussLegendre()]}, "[0] must be a class, a subclass of"),
    "abstract-rule": (QuadratureContract, {"quadratures": [Quadrature]}, "[0] must be a class that writes _piece"),
}


@pytest.mark.parametrize(("contract", "written", "message"), REFUSED.values(), ids=REFUSED)
def test_a_list_that_will_not_do_is_refused(contract: type[Contract], written: dict[str, object], message: str) -> None:
    made = type("TestIt", (contract,), written)()
    with pytest.raises(pytest.fail.Exception) as caught:
        made._members()
    assert message in str(caught.value)


LEFT_OUT = {
    "empty": ({"clause 7": " "}, "leave_out['clause 7'] must be a reason in words (got ' ')"),
    "no-text": ({"clause 7": True}, "leave_out['clause 7'] must be a reason in words (got True)"),
    "unknown": ({"clause 10": "why"}, "must be one of clause 1, clause 2, clause 3, clause 4, clause 5, clause 6"),
    "other-kind": ({"one-step clause 1": "why"}, "or the name of a test (got 'one-step clause 1')"),
    "unknown-test": ({"test_it_is_fast": "why"}, "or the name of a test (got 'test_it_is_fast')"),
    "no-dict": (["clause 7"], "must be a dict of clauses and reasons (got ['clause 7'])"),
}


@pytest.mark.parametrize(("left_out", "message"), LEFT_OUT.values(), ids=LEFT_OUT)
def test_leaving_out_needs_a_clause_and_a_reason(left_out: object, message: str) -> None:
    made = type("TestIt", (ProfileContract,), {"leave_out": left_out})()
    with pytest.raises(pytest.fail.Exception) as caught:
        made._left_out()
    assert message in str(caught.value)


def test_clauses_of_both_contracts_of_a_one_step_method_can_be_left_out() -> None:
    reasons = {"clause 2": "one", "one-step clause 2": "two"}
    made = type("TestIt", (IntegratorContract,), {"leave_out": reasons})()
    assert sorted(made._left_out().values()) == ["one", "two"]
    assert len({name for name in made._left_out() if "clause_2_" in name}) == 2


def test_nothing_else_of_shockwave_needs_pytest() -> None:
    text = [file for file in PACKAGE.rglob("*.py") if re.search(r"\bpytest\b", file.read_text())]
    assert {file.parent.name for file in text} == {"testing"}


# ---------------------------------------------------------------- what is smooth

STEEP = {
    "layer": lambda s: (1 + np.tanh(1e4 * (s - 0.3))) / 2,
    "resonance": lambda s: 1 / (1 + (1e3 * (s - 0.77)) ** 2),
    "bell": lambda s: np.exp(-((1e5 * (s - 0.5)) ** 2)),
    "root": lambda s: s**0.3,
    "logarithm": lambda s: -s * np.log(s),
    "no-series": lambda s: np.exp(-1 / s),
    "both-ends": lambda s: (4 * s * (1 - s)) ** 0.5,
    "waves": lambda s: np.sin(1e3 * s) ** 2,
}


@pytest.mark.parametrize("function", STEEP.values(), ids=STEEP)
def test_what_is_steep_or_singular_at_an_end_is_smooth_between(function) -> None:  # type: ignore[no-untyped-def]
    assert roughness(function, (0.0, 1.0)) is None


# Anywhere, at simple fractions, and where panels are divided first.
CORNERS = (0.5, 0.25, 1 / 3, 0.4563, 0.5311, 0.123456789, 0.9, 1e-3, 0.999)


@pytest.mark.parametrize("corner", CORNERS)
@pytest.mark.parametrize(
    ("power", "size", "kind"),
    [
        (0, 1.0, "a jump"),
        (0, 1e-6, "a jump"),
        (1, 1.0, "a kink"),
        (1, 1e-3, "a kink"),
        (2, 1.0, "a jump of a higher derivative"),
    ],
)
def test_jumps_and_kinks_are_found_and_named(corner: float, power: int, size: float, kind: str) -> None:
    def function(s: np.ndarray) -> np.ndarray:
        return np.exp(-s) + size * np.where(s > corner, np.abs(s - corner) ** power, 0.0)

    found = roughness(function, (0.0, 1.0))
    assert found is not None
    assert found.kind == kind
    assert found.begin <= corner <= found.end
    # A jump of the second derivative sinks into rounding on panels of 1e-5 at the latest.
    assert found.end - found.begin < 1e-2


@pytest.mark.parametrize("corner", CORNERS)
def test_a_corner_that_is_told_is_none(corner: float) -> None:
    assert roughness(lambda s: np.minimum(s, corner), (0.0, corner, 1.0)) is None


@pytest.mark.parametrize("exponent", [1e-5, 0.1, 0.5, 0.95])
def test_the_slope_of_a_root_grows_without_end(exponent: float) -> None:
    slope = steepening(lambda s: (3 - s) ** exponent, 3.0, 1.0)
    assert slope is not None
    assert slope > 1


@pytest.mark.parametrize("rate", [1.0, 1e3, 1e6])
def test_the_slope_of_an_exponential_does_not(rate: float) -> None:
    assert steepening(lambda s: np.expm1(-rate * s), 0.0, 1.0) is None


@pytest.mark.parametrize("exponent", [1, 1.001, 1.5, 2, 50])
def test_nor_does_that_of_a_power_from_1_on(exponent: float) -> None:
    assert steepening(lambda s: s**exponent, 0.0, 1.0) is None
