"""What a plugged-in profile returns is checked where it enters; a violation names profile, time and value."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
import pytest

from shockwave import cli
from shockwave.errors import PluginError
from shockwave.profiles import guard
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.shock import Shock
from shockwave.profiles.triangular import Triangular

if TYPE_CHECKING:
    from conftest import Install

WHO = "test_guard:"
CALLS: list[int] = []


@attrs.frozen
class Sound(ShockProfile):
    """A triangle by another, which the faulty ones below change in one point each."""

    duration_ratio: float = 3.0

    def rise(self, s: Any) -> Any:
        return s

    def decay(self, s: Any) -> Any:
        return (3.0 - s) / 2


class Scalar(Sound):
    def rise(self, s: Any) -> Any:
        return s if s < 0.5 else 0.5 + (s - 0.5)


class OneValue(Sound):
    def decay(self, s: Any) -> Any:
        return 0.5


class Column(Sound):
    def rise(self, s: Any) -> Any:
        return np.atleast_2d(s)


class Complex(Sound):
    def rise(self, s: Any) -> Any:
        return s + 0j


class NotANumber(Sound):
    def decay(self, s: Any) -> Any:
        return np.where(s > 2.5, np.nan, (3.0 - s) / 2)


class Negative(Sound):
    def decay(self, s: Any) -> Any:
        return (2.0 - s) + 0 * s


class TooHigh(Sound):
    def rise(self, s: Any) -> Any:
        return 4 * s * (1 - s) + s


class LowPeak(Sound):
    def rise(self, s: Any) -> Any:
        return 0.9 * s


class Drifting(Sound):
    def rise(self, s: Any) -> Any:
        CALLS.append(1)
        return s ** (1 + 1e-6 * len(CALLS))


class Crowd(Sound):
    def rise(self, s: Any) -> Any:
        return s / max(float(np.max(s, initial=0.0)), 1e-300)


class InPlace(Sound):
    def rise(self, s: Any) -> Any:
        s *= 1.0
        s += 0.125
        return np.minimum(s, 1.0)


class NoRatio(Sound):
    @property
    def duration_ratio(self) -> float:  # type: ignore[override]
        return 0.5

    def __init__(self) -> None:
        pass


class NoPeakAmongBreakpoints(Sound):
    @property
    def breakpoints(self) -> tuple[float, ...]:
        return (0.0, 2.0, 3.0)


class OtherSingularPoint(Sound):
    @property
    def singular_points(self) -> tuple[float, ...]:
        return (0.5,)


class OwnForce(Sound):
    def force(self, s: Any) -> Any:
        return np.ones_like(s)


class WrongArea(Sound):
    def closed_areas(self) -> tuple[float, float]:
        return 0.5, 1.01


class ThreeAreas(Sound):
    def closed_areas(self) -> Any:
        return 0.5, 1.0, 1.5


class InfiniteImpulse(Sound):
    def closed_running_impulse(self, s: Any) -> Any:
        return np.where(s > 1, np.inf, s**2 / 2)


class WrongPath(Sound):
    def closed_double_integral(self, s: Any) -> Any:
        return s**2


class OtherTable(Sound):
    def closed_free_path(self) -> Any:
        return Triangular(duration_ratio=30.0).free_path()


class NoTable(Sound):
    def closed_free_path(self) -> Any:
        return (1.0, 2.0)


class Leaving(Sound):
    def rise(self, s: Any) -> Any:
        raise SystemExit(0)


class TextRatio(Sound):
    def __init__(self) -> None:
        object.__setattr__(self, "duration_ratio", "3")


class MethodPoints(Sound):
    def breakpoints(self) -> Any:  # type: ignore[override]
        return (0.0, 1.0, 3.0)


class NoNotes(Sound):
    @property
    def notes(self) -> Any:
        return "a sentence"


class NegativeRecord(Sound):
    @property
    def recorded_peak_force(self) -> float:
        return -3.0


#: Faulty class -> what is told, with the value and the time where there is one.
TOLD: dict[type[ShockProfile], str] = {
    Scalar: r"rise\(s\) must take an array of any shape, and not raise \(got ValueError: ",
    OneValue: r"decay\(s\) must return floats of the shape of s \(got float64 of shape \(\) for s of shape \(\d+,\)\)",
    Column: r"rise\(s\) must return floats of the shape of s \(got float64 of shape \(1, \d+\)",
    Complex: r"rise\(s\) must return floats of the shape of s \(got complex128",
    NotANumber: r"decay\(s\) must be finite \(got nan\) at s = 2.50539, t = 5.01078e-05 s",
    Negative: r"decay\(s\) must be at least 0 and at most 1 \(got -0.00\d+\) at s = 2.00\d+, t = 4.01\d+e-05 s",
    TooHigh: r"rise\(s\) must be at least 0 and at most 1 \(got 1.0\d+\) at s = 0.25\d+, t = 5.0\d+e-06 s",
    LowPeak: r"rise\(1\) must be 1, the peak \(got 0.9\) at s = 1, t = 2e-05 s",
    Drifting: r"rise\(s\) must give the same value for the same s, \S+ as before \(got \S+\) at s = 1e-12",
    Crowd: r"rise\(s\) must depend on s alone, not on the array that it stands in \(got ",
    InPlace: r"rise\(s\) must leave s as it is",
    NoRatio: r"duration_ratio must be a finite number > 1 \(got 0.5\)",
    NoPeakAmongBreakpoints: r"breakpoints must ascend from 0 to n = 3 and contain 1 \(got \(0.0, 2.0, 3.0\)\)",
    OtherSingularPoint: r"singular_points must be among the breakpoints \(got \(0.5,\)\)",
    OwnForce: r"force must be left to ShockProfile",
    WrongArea: r"closed_areas\(\) must give the area under the decay, 1 by quadrature \(got 1.01\)",
    ThreeAreas: r"closed_areas\(\) must return a1 and a2",
    InfiniteImpulse: r"closed_running_impulse\(s\) must be 0.69, by quadrature \(got inf\) at s = 1.2",
    WrongPath: r"closed_double_integral\(s\) must be 0.0045, by quadrature \(got 0.09\) at s = 0.3, t = 6e-06 s",
    OtherTable: r"path of closed_free_path\(\) must be ",
    NoTable: r"closed_free_path\(\) must return a FreePath \(got \(1.0, 2.0\)\)",
    Leaving: r"rise\(s\) must take an array of any shape, and not raise \(got SystemExit: '0'\)",
    TextRatio: r"duration_ratio must be a finite number > 1 \(got '3'\)",
    MethodPoints: r"breakpoints must be a tuple of numbers",
    NoNotes: r"notes must be a tuple of sentences \(got 'a sentence'\)",
    NegativeRecord: r"recorded_peak_force must be None, or finite and > 0 \(got -3.0\)",
}
EVERY = pytest.mark.parametrize("cls", TOLD, ids=lambda cls: cls.__name__)


def shock_of(profile: ShockProfile) -> Shock:
    return Shock(profile=profile, peak_force=100.0, rise_time=2e-5)


@EVERY
def test_a_violation_is_told(cls: type[ShockProfile]) -> None:
    with pytest.raises(PluginError, match=f"^profile {WHO}{cls.__name__}: {TOLD[cls]}"):
        shock_of(cls())


def test_a_sound_profile_passes() -> None:
    assert shock_of(Sound()).profile == Sound()


@pytest.mark.parametrize("cls", [NotANumber, Negative, Scalar], ids=lambda cls: cls.__name__)
@pytest.mark.parametrize("use", ["areas", "force", "free_path"])
def test_values_are_checked_without_a_shock_too(cls: type[ShockProfile], use: str) -> None:
    profile = cls()
    uses = {"areas": profile.areas, "free_path": profile.free_path, "force": lambda: profile.force([0.1, 0.7, 2.9])}
    with pytest.raises(PluginError, match=f"profile {WHO}{cls.__name__}: "):
        uses[use]()


@attrs.frozen
class Narrow(Sound):
    """Wrong between the points at which a profile is examined."""

    def decay(self, s: Any) -> Any:
        return np.where(np.abs(s - 1.0051) < 1e-4, np.nan, (3.0 - s) / 2)


def test_what_the_examination_misses_is_told_where_it_is_used() -> None:
    shock = shock_of(Narrow())
    with pytest.raises(PluginError, match=r"must be finite \(got nan\) at s = 1.0051"):
        shock.profile.force(np.array([1.0051]))


def test_rounding_below_zero_enters_as_zero() -> None:
    class Rounded(Sound):
        def decay(self, s: Any) -> Any:
            return (3.0 - s) / 2 - 1e-17

    assert Rounded().force(3.0) == 0.0


def test_an_equal_profile_is_not_examined_again(monkeypatch: pytest.MonkeyPatch) -> None:
    shock_of(Sound(3.0))
    monkeypatch.setattr(guard, "_check_points", lambda _: pytest.fail("examined again"))
    shock_of(Sound(3.0))


def test_a_profile_of_shockwave_is_not_examined(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(guard, "_check_points", lambda _: pytest.fail("examined"))
    shock_of(Triangular(duration_ratio=3.0))


def test_a_violation_has_its_place_in_the_scenario(
    install: Install, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    install("test-pulses", name="test-pulse", pulse="from test_guard import NotANumber as Pulse\n")
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "chain: {material: paper-steel, diameter: 9.5 mm}\n"
        "shock: {profile: test-pulse, peak_force: 100 N, rise_time: 20 us}\n"
    )
    assert cli.main(["predict", str(scene)]) == 4
    told = capsys.readouterr().err
    assert told.startswith(f"{scene}:2:18: shock.profile: profile 'test-pulse' of test-pulses: ")
    assert "must be finite (got nan) at s = 2.50539, t = 5.01078e-05 s" in told


class Changing(ShockProfile):
    """One that can be changed, of which nothing may be kept."""

    duration_ratio = 3.0
    power = 1.0

    def rise(self, s: Any) -> Any:
        return s**self.power

    def decay(self, s: Any) -> Any:
        return (3.0 - s) / 2


@attrs.frozen
class Hidden(Sound):
    """One with a field that its equality leaves out."""

    power: float = attrs.field(default=1.0, eq=False)

    def rise(self, s: Any) -> Any:
        return s**self.power


def test_nothing_is_kept_of_a_profile_that_can_change() -> None:
    profile = Changing()
    before = profile.areas().rise.value, profile.free_path().at(1.0)[1]
    profile.power = 8.0
    after = profile.areas().rise.value, profile.free_path().at(1.0)[1]
    assert before == pytest.approx((1 / 2, 1 / 2), rel=1e-12)
    assert after == pytest.approx((1 / 9, 1 / 9), rel=1e-12)


def test_nothing_is_kept_of_a_profile_whose_equality_leaves_something_out() -> None:
    assert Hidden(3.0, 1.0) == Hidden(3.0, 8.0)
    areas = [shock_of(Hidden(3.0, power)).profile.areas().rise.value for power in (1.0, 8.0)]
    assert areas == pytest.approx([1 / 2, 1 / 9], rel=1e-12)


def test_a_wrong_ratio_is_told_where_the_duration_is_given() -> None:
    with pytest.raises(PluginError, match="duration_ratio must be a finite number > 1"):
        Shock.of_duration(profile=NoRatio(), peak_force=1.0, duration=1e-3)
