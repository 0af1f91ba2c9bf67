"""The test kit for plugins: the built-in classes pass it, and it reports violations of the contracts."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import shockwave
from shockwave.engine.integrator import Integrator
from shockwave.engine.one_step import OneStep
from shockwave.profiles.contract_check import CLAUSES
from shockwave.profiles.exponential import Exponential
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.quadrature import Integral, Quadrature
from shockwave.profiles.quadrature.gauss_legendre import GaussLegendre
from shockwave.profiles.quadrature.quadpack import Quadpack
from shockwave.profiles.quadrature.tanh_sinh import TanhSinh
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.profiles.tabulated import Tabulated
from shockwave.profiles.triangular import Triangular
from shockwave.scene.contact_law import ContactLaw
from shockwave.testing import ContactLawContract, IntegratorContract, ProfileContract, QuadratureContract
from shockwave.testing import quadrature_contract as kit
from shockwave.testing.profile_contract import rough_place

PACKAGE = Path(shockwave.__file__).parent


#: Straight, infinitely steep, with jumps, nearly straight.
EXPONENTS = [(1, 1), (0.5, 1), (0, 0), (0.95, 1.5)]
PROFILES = [
    *(PowerLaw(rise_exponent=a, decay_exponent=b, duration_ratio=3) for a, b in EXPONENTS),
    *(Triangular(duration_ratio=n) for n in (1.0001, 1e9)),
    *(Exponential(rise_rate=a, decay_rate=b, duration_ratio=3) for a, b in [(1e-12, 1e-12), (1, -1)]),
    Tabulated([0.0, 1.0, 2.0, 5.0], [0.0, 1.0, 2.0, 0.0]),
]
EXTREME = [
    *(PowerLaw(rise_exponent=a, decay_exponent=b, duration_ratio=4) for a, b in [(1e-5, 50), (50, 1e-5), (1e6, 1e6)]),
    *(Exponential(rise_rate=a, decay_rate=b, duration_ratio=9) for a, b in [(700, 700), (-700, -700), (300, 1e-12)]),
]


class TestProfiles(ProfileContract):
    profiles = PROFILES


@pytest.mark.slow
class TestExtremeProfiles(ProfileContract):
    profiles = EXTREME


class TestQuadratures(QuadratureContract):
    quadratures = (GaussLegendre, TanhSinh, Quadpack)


@pytest.mark.parametrize(
    ("contract", "kind", "signed", "count"),
    [
        (ProfileContract, "", ShockProfile, 7),
        (IntegratorContract, "", Integrator, 9),
        (IntegratorContract, "one_step_", OneStep, 3),
        (QuadratureContract, "", Quadrature, 5),
        (ContactLawContract, "", ContactLaw, 6),
    ],
    ids=["profile", "integrator", "one-step", "quadrature", "contact-law"],
)
def test_each_clause_of_the_docstring_has_a_test(contract: type, kind: str, signed: type, count: int) -> None:
    names = [re.match(rf"test_{kind}clause_(\d+)_", name) for name in dir(contract)]
    tested = {int(name[1]) for name in names if name}
    if contract is ProfileContract:
        tested |= {int(clause[7]) for clause in CLAUSES}
    written = {int(number) for number in re.findall(r"^ +(\d+)\. ", signed.__doc__ or "", re.MULTILINE)}
    # The count is explicit, because an unreadable docstring would agree with no tests at all.
    assert written == tested == set(range(1, count + 1))


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
    leave_out = {"clause 5": "good to 1e-9 only", "clause 6": "wrong on purpose", "test_it_is_a_value": "it is none"}

class TestNoList(ProfileContract):
    pass

class TestClass(ProfileContract):
    profiles = [Triangular]

class TestNoClass(IntegratorContract):
    integrators = [Triangular(duration_ratio=3)]
"""


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The output of pytest for a test module."""
    folder = tmp_path_factory.mktemp("kit")
    (folder / "test_it.py").write_text(MODULE)
    options = ["-p", "no:cacheprovider", "-v", "-rs", "-W", "error", "--continue-on-collection-errors"]
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE.parent), "COLUMNS": "400"}
    command = [sys.executable, "-m", "pytest", *options, "test_it.py"]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment).stdout


def test_contract_test_needs_four_lines(printed: str) -> None:
    results = re.findall(r"TestFourLines::test_\w+\[.*Triangular\(duration_ratio=3\.0\).*\] (\w+)", printed)
    assert set(results) == {"PASSED"}
    assert len(results) == len(CLAUSES) + sum(name.startswith("test_") for name in dir(ProfileContract)) - 1


def test_wrong_list_is_reported_by_pytest(printed: str) -> None:
    objects = "must be a list of objects (not classes) of subclasses of ShockProfile (got"
    assert f"TestNoList.profiles {objects} None)" in printed
    assert f"TestClass.profiles {objects} [<class" in printed
    assert "TestNoClass.integrators must be a list of classes (got [Triangular" in printed


def test_one_error_fails_one_test_and_shows_the_line(printed: str) -> None:
    results = re.findall(r"TestForOneNumber::test_\w+\[.*\] (\w+)", printed)
    assert results.count("FAILED") == 1
    report = printed.split("= FAILURES =")[1]
    assert "rise(s) must accept an array of any shape without raising (got ValueError: The truth value" in report
    assert "in test_it.py, line 9: if s < 0.5:" in report
    assert "see clause 2, vectorised first" in printed


def test_omitted_clauses_are_skipped_with_the_reason(printed: str) -> None:
    skipped = re.findall(r"TestLeftOut::(test_\w+)\[.*\] SKIPPED \((.*)\)", printed)
    assert sorted(skipped) == [
        ("test_clause_5_closed_forms_agree_with_quadrature", "left out: good to 1e-9 only"),
        ("test_it_holds", "left out: good to 1e-9 only"),
        ("test_it_holds", "left out: wrong on purpose"),
        ("test_it_is_a_value", "left out: it is none"),
    ]


def test_only_the_test_kit_imports_pytest() -> None:
    files = [file for file in PACKAGE.rglob("*.py") if re.search(r"\bpytest\b", file.read_text())]
    assert {file.parent.name for file in files} == {"testing"}


# Simple fractions, an arbitrary point, and points near the ends.
CORNERS = (0.5, 1 / 3, 0.123456789, 1e-3, 0.999)
STEEP = {
    "layer": lambda s: (1 + np.tanh(1e4 * (s - 0.3))) / 2,
    "resonance": lambda s: 1 / (1 + (1e3 * (s - 0.77)) ** 2),
    "root": lambda s: s**0.3,
    "logarithm": lambda s: -s * np.log(s),
    "no-series": lambda s: np.exp(-1 / (s + 1e-300)),
    "both-ends": lambda s: np.abs(s * (1 - s)) ** 0.5,
    "waves": lambda s: np.sin(1e3 * s) ** 2,
}


@pytest.mark.parametrize("function", STEEP.values(), ids=STEEP)
def test_steep_functions_and_singular_ends_count_as_smooth(function) -> None:  # type: ignore[no-untyped-def]
    assert rough_place(function, (0.0, 1.0, 2.0)) is None


@pytest.mark.parametrize("corner", CORNERS)
@pytest.mark.parametrize(("power", "size"), [(0, 1.0), (0, 1e-6), (1, 1.0), (1, 0.1)])
def test_jumps_and_kinks_that_are_not_breakpoints_are_found(corner: float, power: int, size: float) -> None:
    def force(s: np.ndarray) -> np.ndarray:
        return np.exp(-s) + size * np.where(s > corner, np.abs(s - corner) ** power, 0.0)

    assert rough_place(force, (0.0, corner, 1.0, 2.0)) is None
    # A kink of 0.1 on panels of 1e-6 is close to the rounding error.
    assert rough_place(force, (0.0, 1.0, 2.0)) == pytest.approx(corner, abs=1e-5)


def rule(change: Callable[..., Any]) -> type[Any]:
    """Gauss-Legendre with a changed result."""

    def piece(self: Any, integrand: Any, lower: float, upper: float, tolerance: float) -> Integral:
        found = GaussLegendre._piece(self, integrand, lower, upper, tolerance)
        return change(self, found, integrand)

    return type("Broken", (GaussLegendre,), {"_piece": piece})


def off(**factors: float) -> type[Any]:
    """Gauss-Legendre with factors on parts of the result."""
    return rule(lambda _, found, __: attrs.evolve(found, **{k: getattr(found, k) * f for k, f in factors.items()}))


def one_by_one(_: Any, found: Integral, integrand: Any) -> Integral:
    integrand(np.array(1.5))
    return attrs.evolve(found, evaluations=found.evaluations + 1)


def endless(_: Any, found: Integral, integrand: Any) -> Integral:
    while found.error > 1e-6:
        integrand(np.linspace(0, 1, 100_001))
    return found


def remembering(self: Any, found: Integral, _: Any) -> Integral:
    self.sum = getattr(self, "sum", 0.0) + 1e-16
    return attrs.evolve(found, error=found.error + self.sum)


QUADRATURES: dict[str, tuple[type[Any], int, str]] = {
    "wrong": (off(value=1 + 1e-9), 2, "with an error of"),
    "one-by-one": (rule(one_by_one), 3, "s must have one dimension"),
    "sure": (off(error=1e-3), 4, "its estimate"),
    "miscounted": (off(evaluations=2), 5, "points were evaluated"),
    "remembering": (rule(remembering), 5, "at first, and Integral(value="),
    "endless": (rule(endless), 4, "clause 5: more than 2000000 points are evaluated"),
}


def failures(method: type[Any], clause: int) -> list[str]:
    """Messages of the failed tests of a clause."""
    found = []
    (name,) = (name for name in dir(QuadratureContract) if name.startswith(f"test_clause_{clause}_"))
    cases = (*kit._SMOOTH_CASES, *kit._SINGULAR_CASES, *(kit._ROUGH_CASES if clause > 3 else ()))
    for case in cases:
        try:
            getattr(QuadratureContract(), name)(method, case, *([1e-4] if clause == 4 else []))
        except (pytest.fail.Exception, Exception) as failure:
            found.append(str(failure))
    return found


@pytest.mark.parametrize(("method", "clause", "message"), QUADRATURES.values(), ids=QUADRATURES)
def test_broken_quadrature_fails_the_test_of_its_clause(method: type[Any], clause: int, message: str) -> None:
    assert message in " ".join(failures(method, clause))


def test_quadrature_that_is_not_registered_is_reported() -> None:
    with pytest.raises(AssertionError, match="'gauss-legendre' is registered for another class"):
        QuadratureContract().test_clause_1_name_is_the_one_registered(off())
