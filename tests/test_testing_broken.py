"""The test kit for plugins finds broken profiles: what breaks a clause fails the test of that clause alone."""

from __future__ import annotations

import math
import re
from typing import Any, ClassVar

import attrs
import numpy as np
import pytest
from attrs import define, frozen

from shockwave.fields import quantity
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.free_path import FreePath, of_powers
from shockwave.quadrature import FloatArray
from shockwave.testing import ProfileContract
from shockwave.testing.contract import Contract


@pytest.fixture(autouse=True)
def _nothing_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """What was found in another test does not count: classes are registered in one and not in the next."""
    monkeypatch.setattr("shockwave.testing.contract._known", {})


def outcomes(contract: type[Contract], member: Any) -> tuple[dict[str, str], dict[str, str]]:
    """The tests that fail for ``member`` and those that are skipped, with what is said of each."""
    failures, skipped = {}, {}
    for name in dir(contract):
        if name.startswith("test_"):
            try:
                getattr(contract(), name)(member)
            except pytest.skip.Exception as skip:
                skipped[name] = str(skip)
            except pytest.fail.Exception as failure:
                failures[name] = failure
    # Neither a traceback nor what led to the failure is printed.
    assert not any(failure.pytrace or failure.__context__ for failure in failures.values())
    return {name: " ".join(str(failure).split()) for name, failure in failures.items()}, skipped


def broken_clauses(contract: type[Contract], member: Any) -> dict[str, str]:
    """The clauses that do not hold for ``member``, with what is said of each; all that is no clause holds."""
    found = {}
    for name, text in outcomes(contract, member)[0].items():
        match = re.match(r"test_(one_step_)?clause_(\d+)_", name)
        clause = ("one-step " if match[1] else "") + match[2] if match else name
        assert clause not in found
        found[clause] = text
    return found


def check(contract: type[Contract], member: Any, shown: str, clause: str, message: str) -> None:
    found = broken_clauses(contract, member)
    assert list(found) == [clause], found
    text = found[clause]
    for part in (f"clause {clause.split()[-1]} of the contract of", shown, "found: ", message, "to mend: "):
        assert part in text
    assert "the clause: " in text


# ---------------------------------------------------------------- profiles


class Pulse(ShockProfile):
    """A triangle without closed forms, which keeps its contract."""

    duration_ratio = 3.0

    def rise(self, s: FloatArray) -> FloatArray:
        return 1.0 * s

    def decay(self, s: FloatArray) -> FloatArray:
        return (3.0 - s) / 2

    def __repr__(self) -> str:
        return f"{type(self).__name__}()"


def pulse(**methods: Any) -> Any:
    """A pulse of which some methods are others; what is no function is a property."""
    made = {
        name: value if callable(value) or isinstance(value, property) else property(lambda _, v=value: v)
        for name, value in methods.items()
    }
    return type("Broken", (Pulse,), made)()


@frozen
class Meaningless(Pulse):
    """A parameter of which nobody knows what it is."""

    size: float = quantity("m", "", default=1.0)


@frozen
class UnknownUnit(Pulse):
    """A parameter in a unit that does not exist."""

    size: float = quantity("smoots", "height of a man", default=1.0)


@define
class Changeable(Pulse):
    """One that can be changed, and so cannot be hashed."""

    size: float = quantity("m", "a size", default=1.0)


@frozen(eq=True)
class ArrayField(Pulse):
    """One that cannot be compared."""

    sizes: FloatArray = attrs.field(factory=lambda: np.ones(3))


def squared_in_place(_: Any, s: FloatArray) -> FloatArray:
    s *= s
    return s


def not_a_number(_: Any, s: FloatArray) -> FloatArray:
    return np.where(s == 0.5, math.nan, s)


def one_axis_only(_: Any, s: FloatArray) -> FloatArray:
    if s.ndim != 1:
        raise TypeError("one axis, please")
    return 1.0 * s


def for_one_number(_: Any, s: FloatArray) -> FloatArray:
    if s < 1:
        return 1.0 * s
    return np.ones_like(s)


def of_math(_: Any, s: Any) -> Any:
    return math.cos(s - 1)


DRAW = np.random.default_rng(1)


def at_random(_: Any, s: FloatArray) -> FloatArray:
    return s * (1 - 1e-3 * DRAW.random(s.shape))


def no_copy(*_: Any) -> None:
    raise TypeError("no copies")


class Fickle(Pulse):
    """It has another rise after it was called for other times than at first."""

    sizes: ClassVar[set[int]] = set()

    def rise(self, s: FloatArray) -> FloatArray:
        if s.size in (7, 101):
            self.sizes.add(s.size)
        return s * s if 7 in self.sizes and s.size == 101 else 1.0 * s


def wrong_path(_: Any) -> FreePath:
    table = of_powers(1.0, 1.0, 3.0)
    return FreePath(table.rows, table.coefficients * (1 + 1e-9), table.error)


PROFILES: dict[str, tuple[Any, str, str]] = {
    "whole-number": (pulse(duration_ratio=3), "1", "duration_ratio is 3"),
    "no-meaning": (Meaningless(), "1", "the field size has no meaning: it is ''"),
    "no-unit": (UnknownUnit(), "1", "the field size has the unit 'smoots', and there is no such unit"),
    "two-axes": (
        pulse(rise=one_axis_only),
        "2",
        """raises TypeError('one axis, please') (in test_testing_broken.py, line""",
    ),
    "if": (pulse(rise=for_one_number), "2", "to mend: s is an array: write numpy.where(s < 1, one, other) in place"),
    "math": (pulse(decay=of_math), "2", "to mend: s is an array: take numpy.sin, numpy.exp, ... in place of those"),
    "constant": (pulse(decay=lambda *_: 1.0), "2", "decay(s) for an s of shape (5,) of floats has shape () of float64"),
    "of-all": (
        pulse(rise=lambda _, s: s / max(s.max(initial=0), 0.5)),
        "2",
        "is 1.0 in an array of one, and 0.6000000000000001 in an array of shape (5,)",
    ),
    "axes": (
        pulse(rise=lambda _, s: 1.0 * s if s.ndim else np.asarray(0.54)),
        "2",
        "in an array of one, and 0.54 as a number without axes, of shape ()",
    ),
    "random": (pulse(rise=at_random), "4", "when called again"),
    "no-copy": (pulse(__deepcopy__=no_copy), "4", "it cannot be copied (TypeError('no copies') (in test_testing_br"),
    "an-axis-more": (
        pulse(decay=lambda _, s: np.atleast_1d((3 - s) / 2)),
        "2",
        "of shape () of floats has shape (1,)",
    ),
    "above-1": (pulse(rise=lambda _, s: s + np.sin(np.pi * s) / 2), "3", "must be finite, at least 0, at most 1"),
    "negative": (
        pulse(decay=lambda _, s: (3 - s) * (2 - s) / 2),
        "3",
        "s = 2.0010000000000003 is -0.000499",
    ),
    "not-finite": (pulse(rise=not_a_number), "3", "rise(s) at s = 0.5 is nan"),
    "rise-below-1": (pulse(rise=lambda _, s: 0.9 * s), "3", "rise(s) at s = 1.0 is 0.9"),
    "decay-below-1": (pulse(decay=lambda _, s: 0.45 * (3 - s)), "3", "decay(s) at s = 1.0 is 0.9, and must be 1"),
    "in-place": (pulse(rise=squared_in_place), "4", "rise(s) writes to the array that it is given: s = 0.01 became"),
    "fickle": (Fickle(), "4", "rise(s) at s = 0.01 is 0.01, and 0.0001 when called again"),
    "corner": (
        pulse(decay=lambda _, s: np.minimum(1.0, 3 - s)),
        "5",
        "decay(s) has a kink at s = 2",
    ),
    "no-points": (pulse(breakpoints=None), "5", "breakpoints is None"),
    "raising": (pulse(breakpoints=property(lambda self: self.corner)), "5", "AttributeError("),
    "jump": (pulse(decay=lambda _, s: np.where(s < 2.3, 1.0, 0.5)), "5", "decay(s) has a jump at s = 2.3"),
    "not-to-n": (pulse(breakpoints=(0.0, 1.0, 2.0)), "5", "must begin with 0, hold 1 and end with duration_ratio, 3.0"),
    "without-1": (pulse(breakpoints=(0.0, 3.0)), "5", "hold 1 and end with duration_ratio, 3.0 (got (0.0, 3.0))"),
    "descending": (pulse(breakpoints=(0.0, 1.0, 2.5, 2.0, 3.0)), "5", "2.0 follows 2.5 in breakpoints"),
    "root": (pulse(rise=lambda _, s: s**0.5), "6", "the slope of rise(s) next to s = 0.0 grows without end"),
    "end": (pulse(decay=lambda _, s: ((3 - s) / 2) ** 0.5), "6", "the slope of decay(s) next to s = 3.0 grows"),
    "no-breakpoint": (pulse(singular_points=(0.5,)), "6", "0.5 is in singular_points, and not in breakpoints"),
    "no-tuple": (pulse(singular_points=1.0), "6", "singular_points is 1.0"),
    "one-area": (pulse(closed_areas=lambda _: 1.5), "7", "closed_areas() gives 1.5"),
    "area-of-other": (pulse(closed_areas=lambda _: (0.5, 2.0)), "7", "gives a2 = 2, quadrature 1 "),
    "area": (
        pulse(closed_areas=lambda _: (0.5, 1.0 + 1e-9)),
        "7",
        "gives a2 = 1.000000001, quadrature 1 ",
    ),
    "impulse": (
        # 1 - (1 - s^2/2) has lost its digits at 1e-6
        pulse(closed_running_impulse=lambda _, s: np.where(s < 1, 1 - (1 - s**2 / 2), 1.5 - (3 - s) ** 2 / 4)),
        "7",
        "closed_running_impulse(s) at s = 1e-06 is 5.000444502911705e-13",
    ),
    "path": (
        pulse(closed_double_integral=lambda _, s: s**3 / 6),
        "7",
        "closed_double_integral(s) at s = 1.002 is 0.167668668, quadrature gives 0.167668666 +-",
    ),
    "impulse-shape": (
        pulse(closed_running_impulse=lambda _, s: np.array([3.0 if s.ndim == 0 else 4.0])),
        "7",
        "closed_running_impulse(s) for an s of shape (5,) has shape (1,)",
    ),
    "table": (pulse(closed_free_path=wrong_path), "7", "closed_free_path() gives the path at s = "),
    "negative-record": (pulse(recorded_peak_force=-1.0), "8", "recorded_peak_force is -1.0"),
    "record-in-words": (pulse(recorded_rise_time="1 ms"), "8", "recorded_rise_time is '1 ms'"),
    "one-note": (pulse(notes="a sentence"), "9", "notes is 'a sentence'"),
    "empty-note": (pulse(notes=("",)), "9", "notes is ('',)"),
}


def test_a_profile_that_keeps_its_contract_breaks_no_clause() -> None:
    assert broken_clauses(ProfileContract, Pulse()) == {}


@pytest.mark.parametrize(("profile", "clause", "message"), PROFILES.values(), ids=PROFILES)
def test_a_broken_profile_is_found_by_its_clause_alone(profile: ShockProfile, clause: str, message: str) -> None:
    check(ProfileContract, profile, f"does not hold for {profile!r} ", clause, message)


def test_a_method_that_is_final_is_found() -> None:
    with pytest.raises(pytest.fail.Exception, match="its class writes a force of its own"):
        ProfileContract().test_other_methods_are_left_alone(pulse(force=lambda _, s: s))


@pytest.mark.parametrize(
    ("profile", "message"),
    [(Changeable(), "it cannot be hashed"), (ArrayField(), "it cannot be compared and hashed")],
    ids=["changeable", "array"],
)
def test_what_is_no_value_is_found(profile: ShockProfile, message: str) -> None:
    with pytest.raises(pytest.fail.Exception, match=message):
        ProfileContract().test_it_is_a_value(profile)


class CornersLeftOut(ProfileContract):
    leave_out: ClassVar[dict[str, str]] = {"clause 5": "to see what else would tell of a corner"}


def test_a_corner_that_is_not_told_shows_in_the_simulation_alone_if_at_all() -> None:
    # What the fifth clause is for: the answer is nearly right, and nothing else would tell.
    CornersLeftOut().test_it_is_simulated(PROFILES["corner"][0])


# ---------------------------------------------------------------- one fault, one failure


@pytest.mark.parametrize(
    ("key", "first", "count"),
    [
        ("if", "see clause 2 first (test_clause_2_rise_and_decay_keep_the_shape_of_their_argument)", 8),
        ("constant", "see clause 2 first (test_clause_2_rise_and_decay_keep_the_shape_of_their_argument)", 8),
        ("area-of-other", "see clause 7 first (test_clause_7_closed_forms_agree_with_quadrature)", 2),
        ("negative-record", "see clause 8 first (test_clause_8_recorded_values_are_positive_or_none)", 2),
    ],
)
def test_what_stands_on_a_broken_clause_is_skipped(key: str, first: str, count: int) -> None:
    failed, skipped = outcomes(ProfileContract, PROFILES[key][0])
    assert len(failed) == 1
    assert list(skipped.values()) == [first] * count


def test_a_clause_that_is_left_out_is_no_ground_to_skip_others() -> None:
    left_out = type("TestIt", (ProfileContract,), {"leave_out": {"clause 7": "a wrong area on purpose"}})
    failed, skipped = outcomes(left_out, PROFILES["area"][0])
    # The seventh test itself is skipped by a mark of pytest, which does not count here.
    assert list(failed) == ["test_clause_7_closed_forms_agree_with_quadrature"]
    assert skipped == {}


def test_an_error_that_no_clause_foresees_is_told_with_its_line() -> None:
    def notes(self: Any) -> Any:
        return self.source.upper()

    text = broken_clauses(ProfileContract, pulse(notes=property(notes)))["9"]
    assert "AttributeError(\"'Broken' object has no attribute 'source'\") (in test_testing_broken.py, line" in text
    assert "`return self.source.upper()`) is raised to mend: see to that line" in text


# ---------------------------------------------------------------- a forgotten decorator


class Loose(Pulse):
    """A class that declares a field, and was not made by attrs."""

    hump: float = quantity("", "height of the hump", default=1.0)


@pytest.mark.parametrize("member", [Loose(), Loose], ids=["object", "class"])
def test_a_forgotten_decorator_is_told_of_what_is_listed(member: Any) -> None:
    made = type("TestIt", (ProfileContract,), {"profiles": [member]})()
    with pytest.raises(pytest.fail.Exception, match=r"^TestIt.profiles\[0\]: Loose declares the field hump, and lacks"):
        made._members()
