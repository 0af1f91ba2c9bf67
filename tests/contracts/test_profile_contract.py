"""Violations of the contract of profiles are found when a profile is used and by the test kit."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
import pytest

from shockwave.base.errors import PluginError
from shockwave.base.numerics import FloatArray
from shockwave.base.quantity_fields import quantity
from shockwave.profiles.contract_check import CLAUSES
from shockwave.profiles.free_path import FreePath, tabulate_powers
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.scene.shock import Shock
from shockwave.testing import ProfileContract
from support.command_line import scenario, shockwave

if TYPE_CHECKING:
    from conftest import Install


class Sound(ShockProfile):
    """A correct triangle without closed forms."""

    duration_ratio = 3.0

    def rise(self, s: FloatArray) -> FloatArray:
        return 1.0 * s

    def decay(self, s: FloatArray) -> FloatArray:
        return (3.0 - s) / 2

    def __repr__(self) -> str:
        return f"{type(self).__name__}()"


class NotANumber(Sound):
    def decay(self, s: Any) -> Any:
        return np.where(s > 2.5, np.nan, (3.0 - s) / 2)


def broken(**members: Any) -> Any:
    """A triangle with some members replaced; a value that is not a function becomes a property."""
    plain = {name: value for name, value in members.items() if not (callable(value) or isinstance(value, property))}
    return type("Broken", (Sound,), members | {name: property(lambda _, v=value: v) for name, value in plain.items()})()


def shock_of(profile: ShockProfile) -> Shock:
    return Shock(profile=profile, peak_force=100.0, rise_time=2e-5)


def failures(profile: Any, contract: type[ProfileContract] = ProfileContract) -> dict[str, str]:
    """The tests of the kit that fail for the profile, by the clause or name, with their messages."""
    found = {}
    for name in (name for name in dir(contract) if name.startswith("test_")):
        cases = [(clause,) for clause in CLAUSES] if name == "test_it_holds" else [()]
        for case in cases:
            try:
                getattr(contract(), name)(profile, *case)
            except pytest.skip.Exception:
                continue
            except (pytest.fail.Exception, Exception) as failure:
                found[case[0][7] if case else name] = str(failure)
    return found


def for_one_number(_: Any, s: FloatArray) -> FloatArray:
    if s < 1:
        return 1.0 * s
    return np.ones_like(s)


DRAW = np.random.default_rng(1)


def at_random(_: Any, s: FloatArray) -> FloatArray:
    return s * (1 - 1e-3 * DRAW.random(s.shape))


def infinite(_: Any, s: FloatArray) -> FloatArray:
    return np.where(s > 1, np.inf, s**2 / 2)


@attrs.define
class Undecorated(Sound):
    size: float = quantity("m", "a size", default=1.0)


@attrs.frozen
class Hiding(Sound):
    decay: Any = 1.0


#: Violations found when the profile is used: profile, clause, message.
AT_ONCE: dict[str, tuple[Any, str, str]] = {
    "ratio": (broken(duration_ratio=0.5), "1", "duration_ratio must be > 1 (got 0.5)"),
    "hidden": (Hiding(), "2", "decay must be a method (got a field of this name; rename the field)"),
    "if": (broken(rise=for_one_number), "2", "rise(s) must accept an array of any shape without raising (got"),
    "constant": (broken(decay=lambda *_: 0.5), "2", "must return floats of the shape of s (got float64 of shape ()"),
    "above-1": (broken(rise=lambda _, s: s + np.sin(np.pi * s) / 2), "3", "rise(s) must be at least 0 and at most 1"),
    "not-finite": (NotANumber(), "3", "decay(s) must be finite (got nan) at s = 2.5"),
    "decay-below-1": (broken(decay=lambda _, s: 0.45 * (3 - s)), "3", "decay(1) must be 1, the peak (got 0.9)"),
    "random": (broken(rise=at_random), "2", "rise(s) must depend on s only"),
    "raising": (broken(breakpoints=property(lambda self: self.corner)), "4", "not raise (got AttributeError: 'Broken'"),
    "descending": (broken(breakpoints=(0.0, 1.0, 2.5, 2.0, 3.0)), "4", "breakpoints must be numbers that ascend"),
    "area": (broken(closed_areas=lambda _: (0.5, 1.01)), "5", "must be 1, the value by quadrature (got 1.01)"),
    "infinite": (broken(closed_running_impulse=infinite), "5", "the value by quadrature (got inf) at s = 1.6"),
    "no-table": (broken(closed_free_path=lambda _: (1.0, 2.0)), "5", "closed_free_path() must return a FreePath"),
    "negative-record": (broken(recorded_peak_force=-1.0), "6", "recorded_peak_force must be > 0 (got -1.0)"),
    "one-note": (broken(notes="a sentence"), "7", "notes must be a tuple of sentences (got 'a sentence')"),
}


@attrs.frozen
class UnknownUnit(Sound):
    size: float = quantity("smoots", "height of a man", default=1.0)


@attrs.frozen
class ScaledUnit(Sound):
    size: float = quantity("mm", "a length", default=1.0)


def lost_digits(_: Any, s: FloatArray) -> FloatArray:
    return np.where(s < 1, 1 - (1 - s**2 / 2), 1.5 - (3 - s) ** 2 / 4)


def wrong_table(_: Any) -> FreePath:
    table = tabulate_powers(1.0, 1.0, 3.0)
    return FreePath(table.rows, table.coefficients * (1 + 1e-9), table.error)


KINKS = "test_clause_4_every_jump_and_kink_is_a_breakpoint"
DIGITS = "test_clause_5_closed_forms_agree_with_quadrature"
FIELDS = "test_clause_1_fields_are_parameters_with_unit_and_meaning"
VALUE = "test_it_is_a_value"
#: Violations found only by the test kit: profile, test, message.
IN_TESTS: dict[str, tuple[Any, str, str]] = {
    "no-unit": (UnknownUnit(), FIELDS, "the unit must be an SI unit (got 'smoots')"),
    "scaled-unit": (ScaledUnit(), FIELDS, "the unit must be an SI unit (got 'mm')"),
    "corner": (broken(decay=lambda _, s: np.minimum(1.0, 3 - s)), KINKS, "has a jump or a kink at s = 2,"),
    "jump": (broken(decay=lambda _, s: np.where(s < 2.3, 1.0, 0.5)), KINKS, "has a jump or a kink at s = 2.3,"),
    "digits-of-area": (broken(closed_areas=lambda _: (0.5, 1.0 + 1e-9)), DIGITS, "must be 1, the value by quadrature"),
    "impulse": (broken(closed_running_impulse=lost_digits), DIGITS, "(got 5.000444502911705e-13) at s = 1e-06"),
    "table": (broken(closed_free_path=wrong_table), DIGITS, "closed_free_path(): displacement must be "),
    "changeable": (Undecorated(), VALUE, ""),
}


# ---------------------------------------------------------------- when it is used


@pytest.mark.parametrize(("profile", "clause", "message"), AT_ONCE.values(), ids=AT_ONCE)
def test_a_broken_profile_is_refused_when_it_is_used(profile: Any, clause: str, message: str) -> None:
    with pytest.raises(PluginError) as caught:
        shock_of(profile)
    assert re.match(rf"profile \w+:{type(profile).__name__}: ", str(caught.value))
    assert message in str(caught.value)


class Declaring(Sound):
    size: float = quantity("m", "a size", default=1.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (Declaring, r"^profile \w+:Declaring: must be decorated with attrs\.frozen, because"),
        (lambda: Declaring(size=2.0), r"^profile \w+:Declaring: must be decorated with attrs\.frozen, because"),
        (lambda: Sound(3.0), r"^profile \w+:Sound: .* or define __init__, to take arguments"),
    ],
    ids=["no arguments", "arguments", "no fields"],
)
def test_a_class_without_a_constructor_is_refused(make: Any, message: str) -> None:
    with pytest.raises(PluginError, match=message):
        make()


def test_another_base_class_may_have_a_constructor() -> None:
    class Sized:
        def __init__(self, size: float) -> None:
            self.size = size

    class Both(Sound, Sized):
        pass

    assert shock_of(Both(3.0)).profile.size == 3.0  # type: ignore[attr-defined]


@pytest.mark.parametrize("use", ["areas", "force", "free_path"])
@pytest.mark.parametrize("key", ["not-finite", "above-1", "if"])
def test_values_are_checked_without_a_shock_too(key: str, use: str) -> None:
    profile = AT_ONCE[key][0]
    uses = {"areas": profile.areas, "free_path": profile.free_path, "force": lambda: profile.force([0.1, 0.7, 2.9])}
    with pytest.raises(PluginError, match=r"^profile "):
        uses[use]()


def test_a_violation_has_its_place_in_the_scenario(install: Install, tmp_path: Path) -> None:
    install("test-pulses", name="test-pulse", pulse="from test_profile_contract import NotANumber as Pulse\n")
    shock = "shock: {profile: test-pulse, peak_force: 100 N, rise_time: 20 us}"
    file = scenario(tmp_path, "chain: {material: paper-steel, diameter: 9.5 mm}", shock)
    answer = shockwave("predict", file)
    assert answer.status == 4
    assert answer.err.startswith(f"{file}:2:18: shock.profile: profile 'test-pulse' of test-pulses: ")
    assert "must be finite (got nan) at s = 2.50" in answer.err


@attrs.frozen
class Power(Sound):
    """A profile that counts some of its calls; its equality can omit the power."""

    power: float = 1.0
    calls: list[int] = attrs.field(factory=list, eq=False, init=False)

    def rise(self, s: Any) -> Any:
        self.calls.append(1)
        return s**self.power


@attrs.frozen
class HiddenPower(Power):
    power: float = attrs.field(default=1.0, eq=False)


class ChangingPower(Sound):
    def __init__(self, power: float) -> None:
        self.power = power

    def rise(self, s: Any) -> Any:
        return s**self.power


def test_an_equal_profile_is_not_examined_again() -> None:
    first, second = Power(1.5), Power(1.5)
    shock_of(first)
    shock_of(second)
    assert (bool(first.calls), bool(second.calls)) == (True, False)


def test_nothing_is_cached_for_a_mutable_profile_or_with_incomplete_equality() -> None:
    profile = ChangingPower(1.0)
    profile.areas(), profile.free_path()
    profile.power = 8.0
    # rounding
    assert (profile.areas().rise.value, profile.free_path().at(1.0)[1]) == pytest.approx((1 / 9, 1 / 9), rel=1e-12)
    areas = [shock_of(HiddenPower(power)).profile.areas().rise.value for power in (1.0, 8.0)]
    assert areas == pytest.approx([1 / 2, 1 / 9], rel=1e-12)


# ---------------------------------------------------------------- in the test kit


def test_a_correct_profile_fails_no_test() -> None:
    assert failures(Sound()) == {}
    assert shock_of(Sound()).peak_force == 100.0


@pytest.mark.parametrize(
    ("profile", "test", "message"), [*AT_ONCE.values(), *IN_TESTS.values()], ids=AT_ONCE | IN_TESTS
)
def test_a_broken_profile_fails_the_test_of_its_clause_alone(profile: Any, test: str, message: str) -> None:
    found = failures(profile)
    found.pop(VALUE if test != VALUE else "", None)
    assert list(found) == [test]
    assert message in found[test]


def test_other_clauses_are_checked_if_one_is_left_out() -> None:
    left_out = type("TestIt", (ProfileContract,), {"leave_out": {"clause 6": "a wrong record on purpose"}})
    assert failures(broken(recorded_peak_force=-1.0, notes="one"), left_out).keys() == {"7"}


def test_clauses_on_which_no_other_relies_fail_together() -> None:
    values = {"closed_running_impulse": infinite, "recorded_peak_force": -1.0, "notes": "one"}
    assert failures(broken(**values)).keys() == {"5", "6", "7"}
