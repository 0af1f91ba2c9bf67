"""The tabulated profile: processing of records as asked, warnings, and exact integrals."""

from __future__ import annotations

import pathlib
import pickle
import re
from contextlib import suppress
from fractions import Fraction

import attrs
import numpy as np
import pint
import pytest
from scipy.integrate import solve_ivp

import shockwave as sw
from shockwave.base.errors import InvalidValueError, ShockwaveError
from shockwave.base.units import to_si
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.tabulated import Tabulated
from shockwave.scene.chain import Chain
from shockwave.scene.material_library import PAPER_STEEL
from shockwave.scene.segments import Segment
from shockwave.scene.shock import Shock
from shockwave.simulation.simulate import simulate
from shockwave.studies.amplification_curve import UniversalCurve

ROOT = pathlib.Path(__file__).parents[2]
HAMMER = ROOT / "profiles" / "examples" / "hammer.csv"


def clean():
    return Tabulated(times=[0, 1, 2, 3], forces=[0, 1, 0.5, 0])


# ---------------------------------------------------------------- record


def test_peak_force_rise_time_and_duration_are_those_of_the_record():
    profile = Tabulated(times=[0, 2e-6, 5e-6, 8e-6, 20e-6], forces=[0, 30, 120, 60, 0])
    # The force is linear between samples.
    assert profile.force([0.2, 0.4, 1.0, 1.3, 2.8, 4.0]).tolist() == pytest.approx([0.125, 0.25, 1, 0.75, 0.25, 0])
    assert profile.recorded_peak_force == 120
    assert profile.recorded_rise_time == 5e-6
    assert profile.duration_ratio == 20e-6 / 5e-6


def test_samples_can_be_lists_of_text_and_quantities():
    quantity = pint.UnitRegistry().Quantity
    plain = Tabulated(times=[0.0, 10e-6, 30e-6], forces=[0.0, 50.0, 0.0])
    assert Tabulated(times=["0 us", "10 us", "30 us"], forces=["0 N", "0.05 kN", "0 N"]) == plain
    microseconds = [quantity(time, "us") for time in (0, 10, 30)]
    assert Tabulated(times=microseconds, forces=[0.0, 50.0, 0.0]) == plain
    for times in (["0 us", "10 m", "30 us"], [quantity(1, "N")] * 3):
        with pytest.raises(InvalidValueError, match="times: must be a sequence of numbers"):
            Tabulated(times=times, forces=[0.0, 50.0, 0.0])


def test_samples_can_be_quantities_of_pint():
    quantity = pint.UnitRegistry().Quantity
    record = Tabulated(times=quantity(np.array([0.0, 1.0, 2.0]), "us"), forces=quantity([0.0, 3.0, 0.0], "kN"))
    assert (record.recorded_rise_time, record.recorded_peak_force) == (1e-6, 3000.0)
    with pytest.raises(InvalidValueError, match="times: must be a sequence of numbers"):
        Tabulated(times=quantity([0.0, 1.0, 2.0], "mm"), forces=[0, 3, 0])


def test_a_clean_record_is_not_changed():
    times, forces = np.array([0.0, 0.3, 0.7, 1.1, 1.9]), np.array([0.0, 0.1, 0.7, 0.3, 0.0])
    profile = Tabulated(times, forces)
    knots = times / 0.7
    assert profile.notes == ()
    assert profile.breakpoints == tuple(knots)
    assert np.array_equal(profile.force(knots), forces / 0.7)


@pytest.mark.parametrize("exponent", [0.3, 1.0, 2.0, 5.0])
@pytest.mark.parametrize("samples", [4, 50, 3000])
def test_a_slow_rise_is_not_treated_as_a_baseline(samples, exponent):
    rise = np.linspace(0, 1, samples) ** exponent
    forces = np.concatenate((rise, rise[-2::-1]))
    profile = Tabulated(np.arange(forces.size), forces)
    assert profile.notes == profile.alarms == ()
    assert np.array_equal(profile.force(np.array(profile.breakpoints)), forces)


def test_a_duration_ratio_stretches_only_the_decay():
    profile = Tabulated(times=[0, 1, 2, 3], forces=[0, 1, 0.5, 0], duration_ratio=7)
    assert profile.breakpoints == (0.0, 1.0, 4.0, 7.0)
    assert profile.closed_areas() == (0.5, 3.0)
    assert profile.recorded_rise_time == 1
    assert profile.notes == ("The decay was stretched in time: n is 7, that of the record 3.",)


# ---------------------------------------------------------------- refused records


NO_PULSES = {
    "two": ([0, 1], [0, 1], r"times: must be at least three"),
    "nan": (
        [0, 1, float("nan")],
        [0, 1, 0],
        r"times\[2\]: must be a finite number below 1e\+150 \(got nan, one of 1;",
    ),
    "infinite": (
        [0, 1, 2, 3],
        [0, float("inf"), 1, float("inf")],
        r"forces\[1\]: must be a finite .* one of 2;",
    ),
    "huge": ([0, 1, 2], [0, 1e300, 0], r"forces\[1\]: must be a finite number below 1e\+150 \(got 1e\+300"),
    "words": ([0, 1, 2], [0, "x", 0], r"forces: must be a sequence of numbers \(got \[0, 'x', 0\]\)"),
    "no-list": ([0, 1, 2], 3, r"forces: must be a sequence of numbers \(got 3\)"),
    "unsorted": (
        [0, 2, 1, 0.5],
        [0, 1, 1, 0],
        r"times\[2\]: must be greater .*one of 2; delete it, or sort the times",
    ),
    "lengths": ([0, 1, 2], [0, 1], r"times: must be at least three.*got 3 times and 2 forces\)"),
    "no-force": (
        [0, 1, 2],
        [0, -1, 0],
        r"forces: must be > 0 N somewhere \(got at most 0 N; if compression is negative, change the signs of forces\)",
    ),
    "no-rise": ([0, 1, 2], [1, 0.5, 0], r"forces: must rise to a peak .* at an end; add a sample of zero force"),
    "merged": ([-1, 1e-20, 2e-20, 1], [0, 0.5, 1, 0], r"times: must differ by more than rounding errors"),
    "overflow": ([0, 1e-20, 1e149], [0, 1, 0], r"times: .* span less than 1e\+150 rise times"),
}


@pytest.mark.parametrize(("times", "forces", "message"), NO_PULSES.values(), ids=NO_PULSES.keys())
def test_samples_that_are_not_a_pulse_are_refused(times, forces, message):
    with pytest.raises(InvalidValueError, match=f"(?s){message}"):
        Tabulated(times=times, forces=forces)


def test_a_duration_ratio_of_one_is_refused():
    with pytest.raises(InvalidValueError, match="duration_ratio: must be > 1"):
        Tabulated([0, 1, 2], [0, 1, 0], duration_ratio=1)


def test_the_sign_is_set_in_a_file_only(tmp_path):
    path = tmp_path / "pulse.csv"
    path.write_text("time [s], force [N]\n0,0\n1,-1\n2,0\n")
    with pytest.raises(InvalidValueError, match="if compression is negative, set sign: -1"):
        Tabulated.from_file(path)
    with pytest.raises(InvalidValueError, match="if compression is negative, change the signs of forces"):
        Tabulated(*PUSH_AND_PULL)


def test_errors_in_a_file_state_their_line(tmp_path):
    path = tmp_path / "pulse.csv"
    path.write_text("time [s], force [N]\n0,0\n# c\n2,1\n1,0\n")
    with pytest.raises(
        InvalidValueError, match=r"pulse.csv:5: times\[2\]: must be greater than the one before \(got 1, one of 1;"
    ):
        Tabulated.from_file(path)


@pytest.mark.parametrize("digits", [2, 5], ids=["one-time", "forty-times"])
def test_rounded_times_are_one_error_that_asks_for_the_interval(tmp_path, digits):
    times, forces = 1e-6 * np.arange(400), np.sin(np.pi * np.arange(400) / 399)
    rows = "".join(f"{time:.{digits}f},{force:.4f}\n" for time, force in zip(times, forces, strict=True))
    (tmp_path / "pulse.csv").write_text("time [s], force [N]\n" + rows)
    with pytest.raises(
        InvalidValueError, match=r"csv:3: times\[1\]: .*set interval to the sampling interval of"
    ) as caught:
        Tabulated.from_file(tmp_path / "pulse.csv")
    assert len(caught.value.faults) == 1
    record = Tabulated.from_file(tmp_path / "pulse.csv", interval=1e-6, negative="zero")
    assert record.recorded_rise_time == pytest.approx(200e-6, rel=0.01)  # rounding of the forces at the top


def test_a_repeated_time_is_a_row_to_delete(tmp_path):
    rows = "".join(f"{time},{force}\n" for time, force in [(0, 0), (1, 1), (1, 1), (2, 0.5), (3, 0)])
    (tmp_path / "pulse.csv").write_text("time [s], force [N]\n" + rows)
    with pytest.raises(InvalidValueError, match=r"csv:4: times\[2\]: .*one of 1; delete it, or sort"):
        Tabulated.from_file(tmp_path / "pulse.csv")


# ---------------------------------------------------------------- processing


def test_only_zeros_at_the_ends_are_removed_unasked():
    profile = Tabulated(range(5, 14), [0, 0, 0, 1, 0.5, 0, 0.25, 0, 0])
    assert profile.breakpoints == (0.0, 1.0, 2.0, 3.0, 4.0, 5.0)
    assert profile.force(profile.breakpoints).tolist() == [0, 1, 0.5, 0, 0.25, 0]
    (removed,) = profile.notes
    assert removed == "Samples of zero force before and after the pulse were removed (rise time -66.67%)."
    assert profile.alarms == ()


#: Forces at whole times, and the warning that they begin or end above zero.
JUMPS = {
    "start": ([0.25, 1, 0.5, 0], "The record begins at 25.00% and ends at 0.00% of its peak force"),
    "end": ([0, 1, 0.5, 0.125], "The record begins at 0.00% and ends at 12.50% of its peak force"),
}


@pytest.mark.parametrize(("forces", "warning"), JUMPS.values(), ids=JUMPS)
def test_a_jump_at_an_end_is_a_warning_unless_a_crop_states_the_ends(forces, warning):
    profile = Tabulated(range(4), forces)
    assert profile.force(np.arange(4)).tolist() == forces
    (alarm,) = profile.alarms
    assert alarm.startswith(warning)
    assert "crop: [0 s, 3 s] keeps all of it" in alarm
    assert Tabulated(range(4), forces, crop=(0, 3)).alarms == ()


def test_a_crop_inside_the_pulse_is_a_warning():
    (alarm,) = Tabulated(range(101), PULSE, crop=(25, 75)).alarms
    assert alarm.startswith("The record begins at 50.00% and ends at 50.00% of its peak force")


def test_a_small_jump_is_no_warning():
    assert Tabulated(range(4), [0.009, 1, 0.5, 0.009]).alarms == ()
    assert Tabulated(range(4), [0.011, 1, 0.5, 0]).alarms
    assert Tabulated(range(4), [0, 1, 0.5, 0.011]).alarms


PULSE = np.sin(np.pi * np.arange(101) / 100) ** 2
#: Forces behind a pulse of 101 samples, each with more than 1 % of its impulse.
TAILS = {
    "decaying": 0.005 * np.exp(-np.arange(500) / 150),
    "constant": np.full(500, 0.005),
    "second-pulse": np.concatenate((np.zeros(50), 0.3 * PULSE)),
}


@pytest.mark.parametrize("mirrored", [False, True], ids=["behind", "before"])
@pytest.mark.parametrize("tail", TAILS.values(), ids=TAILS)
def test_an_impulse_beside_the_pulse_is_a_warning_with_the_crop_that_removes_it(tail, mirrored):
    forces = np.concatenate((PULSE, tail))[:: -1 if mirrored else 1]
    times = 1e-6 * np.arange(forces.size)
    (alarm,) = Tabulated(times, forces).alarms
    start, stop = (to_si(each, "s") for each in re.search(r"crop: \[(.*?), (.*?)\]", alarm).groups())
    # a tail of half a percent hides the ends of the pulse
    assert stop - start == pytest.approx(100e-6, rel=0.05)
    assert f"impulse {PULSE.sum() / forces.sum() - 1:+.0%}"[:-2] in alarm


def test_a_record_that_is_negative_before_its_baseline_is_subtracted_is_examined():
    assert Tabulated(range(101), PULSE - 3, baseline=(0, 2), crop=(0, 100), negative="zero").alarms == ()


def test_a_record_that_is_a_pulse_only_if_filtered_is_examined():
    forces = np.concatenate((np.zeros(20), PULSE))
    forces[[10, 12]] = 1.5, -1.5
    steps = {"crop": (10, 120), "negative": "zero"}
    with pytest.raises(InvalidValueError, match="at an end"):
        Tabulated(range(121), forces, **steps)
    assert Tabulated(range(121), forces, low_pass=0.02, **steps).alarms == ()


def test_a_tail_of_little_impulse_is_no_warning():
    assert Tabulated(range(601), np.append(PULSE, 0.0005 * np.exp(-np.arange(500) / 150))).alarms == ()


@pytest.mark.parametrize("forces", [1.0, 0.0, 0.4], ids=["spike", "dropout", "offset"])
def test_a_single_sample_far_from_its_neighbours_is_a_warning(forces):
    values = 0.2 * PULSE
    values[40] = forces
    (alarm,) = Tabulated(range(101), values).alarms
    assert f"A sample, {forces:.4g} N at 40 s, is far" in alarm
    assert Tabulated(range(101), values, crop=(41, 100)).alarms[0].startswith("The record begins")


def test_lost_samples_are_a_warning():
    kept = np.delete(np.arange(101), range(20, 40))
    (alarm,) = Tabulated(kept, PULSE[kept]).alarms
    assert alarm == "Samples are lost: 20 after 19 s."
    assert Tabulated(kept, PULSE[kept], crop=(40, 100)).alarms[0].startswith("The record begins")
    assert Tabulated(np.cumsum(1 + np.arange(101) % 3), PULSE).alarms == ()  # uneven samples


#: A blow of 100 N on a baseline of 5 N, with 20 quiet samples on either side.
BLOW = 5 + 100 * np.sin(np.pi / 40 * np.clip(np.arange(81) - 20, 0, 40))
MICROSECONDS = 1e-6 * np.arange(81)


def test_an_offset_is_a_warning_with_the_keys_that_remove_it():
    (alarm,) = Tabulated(MICROSECONDS, BLOW).alarms
    assert "(baseline: [0 s, 11 us] (subtracts 5 N), crop: [20 us, 60 us] would change peak force -4.76%" in alarm
    settled = Tabulated(MICROSECONDS, BLOW, baseline=("0 us", "9 us"), crop=("20 us", "60 us"))
    assert (settled.recorded_peak_force, settled.recorded_rise_time) == pytest.approx((100, 20e-6), rel=1e-12)
    assert settled.alarms == ()


@pytest.mark.parametrize("force", [1e-300, 1e140])
def test_the_size_of_forces_does_not_matter(force):
    profile = Tabulated(MICROSECONDS, force * BLOW)
    assert "crop: [20 us, 60 us]" in profile.alarms[0]


FLAT = np.minimum(100 * np.sin(np.pi * np.arange(101) / 100) ** 2, 60)
NOISY = np.clip(100 - np.abs(np.arange(201) - 100) + np.random.default_rng(2).normal(0, 1, 201), 0, 90)
#: Forces, and whether they look clipped.
TOPS = {
    "flat": (FLAT, True),
    "flat-noise": (NOISY, True),
    "flat-then-noise": (
        np.minimum(100 * np.sin(np.pi * np.arange(501) / 500) ** 2, 80)
        + np.random.default_rng(3).normal(0, 0.1, 501).clip(0),
        True,
    ),
    "smooth": (np.round(100 * np.sin(np.pi * np.arange(2001) / 2000) ** 2, 3).clip(0), False),
    "eight-bit": (np.round(200 * np.sin(np.pi * np.arange(2001) / 2000) ** 2), False),
    "table": (np.array([0, 40, 100, 100, 100, 40, 0]), False),
}


@pytest.mark.parametrize(("forces", "clipped"), TOPS.values(), ids=TOPS)
def test_a_flat_top_is_a_warning_if_the_other_samples_differ(forces, clipped):
    alarms = Tabulated(range(forces.size), forces).alarms
    assert any("saturated sensor" in alarm for alarm in alarms) == clipped


def test_a_baseline_is_the_mean_of_its_window():
    profile = Tabulated(MICROSECONDS, BLOW, baseline=(62e-6, 79e-6))
    assert profile.recorded_peak_force == pytest.approx(100, rel=1e-14)
    assert "the mean from 6.2e-05 to 7.9e-05 s, was subtracted (peak force -4.76%" in profile.notes[0]


def test_a_crop_keeps_the_samples_of_its_window():
    times, forces = [0, 1, 2, 3, 4, 5, 6, 7], [0, 0, 4, 2, 0, 9, 3, 0]
    profile = Tabulated(times, forces, crop=("1 s", 4))
    assert (profile.recorded_peak_force, profile.duration_ratio) == (4, 3)
    assert (
        "The record was cropped to 1 to 4 s (peak force -55.56%, rise time -80.00%, impulse -66.67%)." in profile.notes
    )


def test_the_baseline_is_that_of_the_whole_record():
    profile = Tabulated(MICROSECONDS, BLOW, baseline=(0, 20e-6), crop=(15e-6, 65e-6))
    assert (profile.recorded_peak_force, profile.recorded_rise_time) == pytest.approx((100, 20e-6), rel=1e-12)


def test_samples_at_the_ends_of_a_window_belong_to_it_despite_rounding():
    times, forces = 1e-6 * (0.1 * np.arange(31)), np.minimum(np.arange(31), 30 - np.arange(31)).clip(0, 10.0)
    # 0.1e-6 * 3 is not 0.3e-6
    assert Tabulated(times, forces, crop=("0.3 us", "2.7 us")).breakpoints[-1] == pytest.approx(24 / 7, rel=1e-12)


def test_a_low_pass_filter_that_distorts_the_pulse_is_a_warning():
    around, chain = np.full(100, 5.0), Chain(material=PAPER_STEEL, radius=5e-3)
    times, forces = 1e-6 * np.arange(281), np.concatenate((around, BLOW, around))
    for edge, distorted in ((10e3, True), (30e3, False)):
        steps = {"baseline": (0, 100e-6), "negative": "zero"}
        shock = Shock(profile=Tabulated(times, forces, low_pass=edge, **steps))
        warnings = [text for text in Predictor().predict(shock, chain).warnings if text not in shock.profile.notes]
        assert any("filter distorts the pulse" in text for text in warnings) == distorted


def test_a_low_pass_filter_does_not_shift_the_pulse():
    around = np.full(100, 5.0)
    times, forces = 1e-6 * np.arange(281), np.concatenate((around, BLOW, around)) - 5
    profile = Tabulated(times, forces, low_pass=30e3, negative="keep")
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


def test_each_step_is_refused_where_it_cannot_be_applied():
    uneven = np.append(MICROSECONDS[:-1], 1e-3)
    for times, settings, sentence in (
        (
            uneven,
            {"low_pass": 1e3},
            "low_pass: must be below half the sampling rate of evenly spaced samples",
        ),
        (MICROSECONDS, {"low_pass": 5e5}, r"low_pass: must be below half .* \(got 500000 Hz for 81 samples"),
        (MICROSECONDS, {"crop": (1.0, 2.0)}, "crop: must contain 3 samples or more"),
        (MICROSECONDS, {"baseline": ("2 s", 1.0)}, "baseline: must be two times, the earlier one first"),
        (MICROSECONDS, {"negative": "no"}, "negative: must be None, keep or zero"),
    ):
        with pytest.raises(InvalidValueError, match=f"^{sentence}"):
            Tabulated(times, BLOW, **settings)


PUSH_AND_PULL = ([0, 1, 2, 3, 4, 5], [0, 8, 4, 0, -3, 0])


def test_a_negative_phase_must_be_resolved():
    with pytest.raises(
        InvalidValueError, match=r"^negative: must be keep or zero, because 1 of 6 .* 25.00% of that of"
    ):
        Tabulated(*PUSH_AND_PULL)
    zero, keep = (Tabulated(*PUSH_AND_PULL, negative=choice) for choice in ("zero", "keep"))
    assert (zero.duration_ratio, keep.duration_ratio) == (3, 5)
    assert (zero.pulls, keep.pulls) == (False, True)
    assert keep.areas().total == pytest.approx(9 / 8, rel=1e-15)
    assert keep.force(4.0) == -3 / 8
    # a rounding error is no phase
    assert not Tabulated([0, 1, 2, 3], [0, 1, 0.5, -1e-16]).pulls


def test_an_offset_below_zero_stays_a_warning_when_negative_samples_are_set_to_zero():
    times = np.arange(1000)
    forces = 100 * np.sin(np.pi * np.clip(times - 100, 0, 150) / 150) ** 2 - 30 + np.sin(times / 80)
    with pytest.raises(InvalidValueError, match=r"set baseline for an offset; negative: zero"):
        Tabulated(times, forces)
    profile = Tabulated(times, forces, negative="zero")
    assert any("of that of the others: set baseline" in alarm for alarm in profile.alarms)
    # the impulse changes its sign
    assert re.search(r"set to zero: \d+ of 1000 \(impulse \+", profile.notes[0])


def test_a_baseline_inside_the_pulse_is_a_warning():
    alarms = Tabulated(range(101), PULSE, baseline=(24, 26), negative="zero").alarms
    assert any("set baseline to a window" in alarm for alarm in alarms)


def test_the_error_of_negative_noise_proposes_all_keys():
    forces = BLOW - 5 + np.random.default_rng(1).normal(0, 0.1, BLOW.size)
    with pytest.raises(InvalidValueError, match=r"^negative: .*; crop: \[20 us, 60 us\] would change rise"):
        Tabulated(MICROSECONDS, forces)
    assert Tabulated(MICROSECONDS, forces, crop=(20e-6, 60e-6)).alarms == ()


def test_a_baseline_above_all_forces_is_refused():
    with pytest.raises(InvalidValueError, match=r"^forces: must be > 0 N somewhere"):
        Tabulated([0, 1, 2, 3], [0, 1, 0.5, 0], baseline=(0.9, 1.1))


def test_more_pull_than_push_is_no_shock():
    with pytest.raises(InvalidValueError, match=r"^forces: must have an impulse > 0 N s"):
        Tabulated([0, 1, 2, 3, 4], [0, 4, 0, -8, 0], negative="keep")


def test_pulling_forces_are_simulated_and_refused_by_formulas():
    shock = Shock(profile=Tabulated(*PUSH_AND_PULL, negative="keep"), peak_force=100.0, rise_time=1e-5)
    chain = Chain(material=PAPER_STEEL, radius=5e-3, granules=[Segment(count=3)])
    found = simulate(shock, chain, rtol=1e-8)
    reference = _reference(shock, chain)
    assert [peak.peak_force for peak in found.contacts] == pytest.approx(reference, rel=1e-5)  # that of its samples
    assert found.recoil_momentum is not None
    assert found.recoil_momentum < 0
    endless = Chain(material=PAPER_STEEL, radius=5e-3)
    outcome = Predictor().predict(shock, endless)
    assert outcome.peak_force == simulate(shock, endless).peak_force > 0
    assert outcome.section4 is None
    assert "section 4, which covers no negative forces" in outcome.section4_reason
    for refused in (
        lambda: Predictor(model="section-4").predict(shock, endless),
        lambda: UniversalCurve(shock.profile),
    ):
        with pytest.raises(InvalidValueError, match=r"covers? no negative forces"):
            refused()


def _reference(shock, chain):
    """Greatest contact forces by an integration of the equations of motion that shares nothing with the package."""
    stiffness, mass = chain.contact_stiffness, chain.granule_mass

    def slope(time, state):
        x, v = np.split(state, 2)
        forces = stiffness * np.maximum(x[:-1] - x[1:], 0) ** 1.5
        own = shock.peak_force * float(shock.profile.force(time / shock.rise_time))
        return np.concatenate((v, (np.append(own, forces) - np.append(forces, 0)) / mass))

    times = np.linspace(0, 2e-4, 8001)
    found = solve_ivp(slope, (0, 2e-4), np.zeros(6), "DOP853", times, rtol=1e-9, atol=1e-14, max_step=2e-6)
    x = found.y[:3]
    return (stiffness * np.maximum(x[:-1] - x[1:], 0) ** 1.5).max(axis=1).tolist()


@pytest.mark.parametrize("lead", [[1.0] * 4, [0, 0.4, 0.9, 1.3, 1.6, 2.0, 2.9, 3.8]], ids=["short", "rising"])
def test_no_baseline_is_proposed_from_a_lead_that_is_not_a_level(lead):
    profile = Tabulated(np.arange(len(lead) + 5), [*lead, 40, 100, 50, 10, 0])
    assert profile.recorded_peak_force == 100
    assert not any("baseline:" in alarm for alarm in profile.alarms)


def test_the_hammer_example_is_the_pulse_of_its_comment():
    shock = sw.load_scenario(HAMMER.with_suffix(".yaml")).shock
    profile = shock.profile
    assert profile.alarms == ()
    assert profile.recorded_peak_force == pytest.approx(850, abs=4 * 1.2)
    assert profile.recorded_rise_time == pytest.approx(48e-6, abs=2e-6)
    impulse = profile.areas().total * profile.recorded_peak_force * profile.recorded_rise_time
    assert impulse == pytest.approx(850 * 160e-6 / 2, rel=5e-3)


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


# ---------------------------------------------------------------- integrals


def exact_integrals(profile):
    """Running impulse and its integral at the breakpoints, in rational numbers."""
    knots = [Fraction(s) for s in profile.breakpoints]
    values = [Fraction(float(v)) for v in profile.force(np.array(profile.breakpoints))]
    impulses, paths = [Fraction(0)], [Fraction(0)]
    for k in range(len(knots) - 1):
        h, left, right = knots[k + 1] - knots[k], values[k], values[k + 1]
        paths.append(paths[-1] + h * impulses[-1] + h * h * (2 * left + right) / 6)
        impulses.append(impulses[-1] + h * (left + right) / 2)
    return np.array([float(a) for a in impulses]), np.array([float(b) for b in paths])


def test_sums_are_exact_to_the_last_digits():
    draw = np.random.default_rng(7)
    times = np.append(0.0, np.cumsum(draw.uniform(0.1e-6, 2e-6, 2999)))
    profile = Tabulated(times, np.concatenate(([0.0], draw.uniform(1.0, 300.0, 2998), [0.0])))
    points = np.array(profile.breakpoints)
    impulses, paths = exact_integrals(profile)
    # Each sample adds three roundings of its own small term; the sum itself adds none.
    np.testing.assert_allclose(profile.closed_running_impulse(points), impulses, rtol=1e-15)
    np.testing.assert_allclose(profile.closed_double_integral(points), paths, rtol=1e-15)


# ---------------------------------------------------------------- as a value


def test_profiles_compare_by_value():
    assert clean() == clean()
    assert hash(clean()) == hash(clean())
    assert clean() == attrs.evolve(clean(), duration_ratio=3) == pickle.loads(pickle.dumps(clean()))
    assert clean() != Tabulated([0, 1, 2, 3], [0, 1, 0.6, 0])
    with pytest.raises(ValueError, match="read-only"):
        clean().times[0] = 1.0


def test_the_table_of_a_long_record_has_no_seams() -> None:
    # longer than the parts in which it is computed
    times = np.linspace(0.0, 1e-3, 10_001)
    record = Tabulated(times=times, forces=np.sin(np.pi * times / 1e-3) ** 2)
    table, s = record.free_path(), np.linspace(0.0, record.duration_ratio, 311)
    found = np.array([table.at(float(each)) for each in s])
    # rounding of sums over the samples
    assert found[:, 0] == pytest.approx(record.double_integral(s), rel=1e-11, abs=1e-12)
    assert found[:, 1] == pytest.approx(record.running_impulse(s), rel=1e-11, abs=1e-12)
