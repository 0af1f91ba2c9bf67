"""Processing of records as requested: refused samples, the steps, and the notes on them."""

from __future__ import annotations

import re
from contextlib import suppress

import numpy as np
import pytest

from shockwave.base.errors import InvalidValueError, ShockwaveError
from shockwave.profiles.tabulated import Tabulated
from support.record_styles import BLOW, MICROSECONDS

PUSH_AND_PULL = ([0, 1, 2, 3, 4, 5], [0, 8, 4, 0, -3, 0])


def test_a_clean_record_is_not_changed():
    times, forces = np.array([0.0, 0.3, 0.7, 1.1, 1.9]), np.array([0.0, 0.1, 0.7, 0.3, 0.0])
    profile = Tabulated(times, forces)
    assert profile.notes == ()
    assert profile.breakpoints == tuple(times / 0.7)
    assert np.array_equal(profile.force(times / 0.7), forces / 0.7)


# ---------------------------------------------------------------- refused records


NO_PULSES = {
    "two": ([0, 1], [0, 1], r"times: must be at least three"),
    "nan": ([0, 1, np.nan], [0, 1, 0], r"times\[2\]: must be a finite number below 1e\+150 \(got nan, one of 1;"),
    "infinite": ([0, 1, 2, 3], [0, np.inf, 1, np.inf], r"forces\[1\]: must be a finite .* one of 2;"),
    "huge": ([0, 1, 2], [0, 1e300, 0], r"forces\[1\]: must be a finite number below 1e\+150 \(got 1e\+300"),
    "words": ([0, 1, 2], [0, "x", 0], r"forces\[1\]: must be a force, such as '100 N' \(got 'x'\)$"),
    "units": ([0, 1, 2, 3], [0, "1 KN", "2 KN", 0], r"forces\[1\]: must be a force.*did you mean 'kN'\?; one of 2\)$"),
    "no-list": ([0, 1, 2], 3, r"forces: must be a sequence of numbers \(got 3\)"),
    "unsorted": ([0, 2, 1, 0.5], [0, 1, 1, 0], r"times\[2\]: must be greater .*one of 2; delete it, or sort the times"),
    "lengths": ([0, 1, 2], [0, 1], r"times: must be at least three.*got 3 times and 2 forces\)"),
    "no-force": ([0, 1, 2], [0, -1, 0], r"forces: must be > 0 N somewhere .*compression is negative, change the signs"),
    "no-rise": ([0, 1, 2], [1, 0.5, 0], r"forces: must rise to a peak .* at an end; add a sample of zero force"),
    "merged": ([-1, 1e-20, 2e-20, 1], [0, 0.5, 1, 0], r"times: must differ by more than rounding errors"),
    "overflow": ([0, 1e-20, 1e149], [0, 1, 0], r"times: .* span less than 1e\+150 rise times"),
}


@pytest.mark.parametrize(("times", "forces", "message"), NO_PULSES.values(), ids=NO_PULSES.keys())
def test_samples_that_are_not_a_pulse_are_refused(times, forces, message):
    with pytest.raises(InvalidValueError, match=f"(?s){message}"):
        Tabulated(times=times, forces=forces)


def test_errors_in_a_file_state_their_line(tmp_path):
    (tmp_path / "pulse.csv").write_text("time [s], force [N]\n0,0\n# c\n2,1\n1,0\n")
    message = r"pulse.csv:5: times\[2\]: must be greater than the one before \(got 1, one of 1;"
    with pytest.raises(InvalidValueError, match=message):
        Tabulated.from_file(tmp_path / "pulse.csv")


UNEVEN = np.append(MICROSECONDS[:-1], 1e-3)


@pytest.mark.parametrize(
    ("times", "steps", "message"),
    [
        (UNEVEN, {"low_pass": 1e3}, "low_pass: must be below half the sampling rate of evenly spaced samples"),
        (MICROSECONDS, {"low_pass": 5e5}, r"low_pass: must be below half .* \(got 500000 Hz for 81 samples"),
        (MICROSECONDS, {"crop": (1.0, 2.0)}, "crop: must contain 3 samples or more"),
        (MICROSECONDS, {"baseline": ("2 s", 1.0)}, "baseline: must be two times, the earlier one first"),
        (MICROSECONDS, {"negative": "no"}, "negative: must be None, keep or zero"),
        (MICROSECONDS, {"baseline": (39e-6, 41e-6)}, "forces: must be > 0 N somewhere"),
    ],
    ids=["uneven", "fast", "crop", "reversed", "negative", "baseline-at-the-peak"],
)
def test_a_step_is_refused_where_it_cannot_be_applied(times, steps, message):
    forces = np.where(np.abs(np.arange(81) - 40) < 2, 100.0, 0.0) if "forces" in message else BLOW
    with pytest.raises(InvalidValueError, match=f"^{message}"):
        Tabulated(times, forces, **steps)


def test_random_samples_give_a_pulse_or_an_error_of_our_own_without_numerical_warnings():
    draw, pulses = np.random.default_rng(5), 0
    for _ in range(400):
        size = int(draw.integers(3, 60))
        steps = {"negative": draw.choice([None, "zero", "keep"]), "crop": (0.1, 0.9) if draw.random() < 0.3 else None}
        forces = draw.choice([0, 0, 1, 5, -1, 300], size) if draw.random() < 0.5 else draw.normal(0, 1, size).cumsum()
        with suppress(ShockwaveError):
            profile = Tabulated(np.sort(draw.uniform(0, 1, size)), forces, **steps)
            assert profile.force(1.0) == 1
            assert len(profile.alarms) <= 3
            pulses += 1
    assert pulses > 100


# ---------------------------------------------------------------- steps


def test_only_zeros_at_the_ends_are_removed_unasked():
    profile = Tabulated(range(5, 14), [0, 0, 0, 1, 0.5, 0, 0.25, 0, 0])
    assert profile.breakpoints == (0.0, 1.0, 2.0, 3.0, 4.0, 5.0)
    assert profile.force(profile.breakpoints).tolist() == [0, 1, 0.5, 0, 0.25, 0]
    assert profile.notes == ("Samples of zero force before and after the pulse were removed (time to the peak -67 %).",)
    assert profile.alarms == ()


def test_a_baseline_is_the_mean_of_its_window():
    profile = Tabulated(MICROSECONDS, BLOW, baseline=(62e-6, 79e-6))
    assert profile.recorded_peak_force == pytest.approx(100, rel=1e-14)
    assert "the mean from 6.2e-05 to 7.9e-05 s, was subtracted (peak force -4.8 %" in profile.notes[0]


def test_the_baseline_is_that_of_the_whole_record():
    profile = Tabulated(MICROSECONDS, BLOW, baseline=(0, 10e-6), crop=(15e-6, 65e-6))
    assert (profile.recorded_peak_force, profile.recorded_rise_time) == pytest.approx((100, 20e-6), rel=1e-12)


def test_a_crop_keeps_the_samples_of_its_window():
    profile = Tabulated([0, 1, 2, 3, 4, 5, 6, 7], [0, 0, 4, 2, 0, 9, 3, 0], crop=("1 s", 4))
    assert (profile.recorded_peak_force, profile.duration_ratio) == (4, 3)
    note = "The record was cropped to 1 to 4 s (peak force -56 %, time to the peak -80 %, impulse -67 %)."
    assert note in profile.notes


def test_samples_at_the_ends_of_a_window_belong_to_it_despite_rounding():
    times, forces = 1e-6 * (0.1 * np.arange(31)), np.minimum(np.arange(31), 30 - np.arange(31)).clip(0, 10.0)
    # 0.1e-6 * 3 is not 0.3e-6
    assert Tabulated(times, forces, crop=("0.3 us", "2.7 us")).breakpoints[-1] == pytest.approx(24 / 7, rel=1e-12)


def around(forces, rest=5.0):
    """A record of 281 us with the forces in its middle."""
    return 1e-6 * np.arange(281), np.concatenate((np.full(100, rest), forces, np.full(100, rest)))


@pytest.mark.parametrize(("edge", "distorted"), [(10e3, True), (15e3, True), (30e3, False)])
def test_a_low_pass_filter_that_distorts_the_pulse_is_a_warning(edge, distorted):
    profile = Tabulated(*around(BLOW), low_pass=edge, baseline=(0, 100e-6), negative="zero")
    assert any("filter distorts the pulse" in alarm for alarm in profile.alarms) == distorted


def test_a_low_pass_filter_does_not_shift_the_pulse():
    profile = Tabulated(*around(BLOW - 5, rest=0.0), low_pass=30e3, negative="keep")
    # the blow is symmetric, and so it remains, but for transients of 1e-6 at the ends of the record
    half = np.linspace(0, 0.4, 50)
    np.testing.assert_allclose(profile.force(1 - half), profile.force(1 + half), atol=1e-5)
    assert any("A low-pass filter at 30000 Hz was applied (peak force -" in note for note in profile.notes)


def test_a_low_pass_filter_removes_noise():
    noise = 3 * np.random.default_rng(1).standard_normal(81)
    steps = {"baseline": (0, 20e-6), "crop": (15e-6, 65e-6), "negative": "zero"}
    rough, smooth = (Tabulated(MICROSECONDS, BLOW + noise, low_pass=edge, **steps) for edge in (None, 60e3))
    kinks = [np.abs(np.diff(each.force(np.array(each.breakpoints)), 2)).max() for each in (rough, smooth)]
    assert kinks[1] < 0.2 * kinks[0]
    # half a sine of 40 us has most of its power below 12.5 kHz: the filter leaves its peak; the baseline is uncertain
    assert smooth.recorded_peak_force == pytest.approx(100, rel=0.03)


# ---------------------------------------------------------------- negative forces


def test_a_negative_phase_must_be_resolved():
    message = r"^negative: must be keep or zero, because 1 of 6 .* 25 % of that of"
    with pytest.raises(InvalidValueError, match=message):
        Tabulated(*PUSH_AND_PULL)
    zero, keep = (Tabulated(*PUSH_AND_PULL, negative=choice) for choice in ("zero", "keep"))
    assert (zero.duration_ratio, keep.duration_ratio) == (3, 5)
    assert (zero.pulls, keep.pulls) == (False, True)
    assert keep.areas().total == pytest.approx(9 / 8, rel=1e-15)
    assert keep.force(4.0) == -3 / 8
    # a rounding error is no phase
    assert not Tabulated([0, 1, 2, 3], [0, 1, 0.5, -1e-16]).pulls


def test_more_pull_than_push_is_no_shock():
    with pytest.raises(InvalidValueError, match=r"^forces: must have an impulse > 0 N s"):
        Tabulated([0, 1, 2, 3, 4], [0, 4, 0, -8, 0], negative="keep")


def test_an_offset_below_zero_stays_a_warning_when_negative_samples_are_set_to_zero():
    times = np.arange(1000)
    forces = 100 * np.sin(np.pi * np.clip(times - 100, 0, 150) / 150) ** 2 - 30 + np.sin(times / 80)
    with pytest.raises(InvalidValueError, match=r"set baseline for an offset; negative: zero"):
        Tabulated(times, forces)
    with pytest.raises(InvalidValueError, match=r"their impulse is [^;]*; negative: zero ignores"):
        Tabulated(times, forces, baseline=(0, 50))
    profile = Tabulated(times, forces, negative="zero")
    assert any("of that of the others: set baseline" in alarm for alarm in profile.alarms)
    # the impulse changes its sign
    assert re.search(r"set to zero: \d+ of 1000 \(impulse \+", profile.notes[0])
