"""The tabulated profile: cleaning of records, and exact integrals."""

from __future__ import annotations

import pathlib
import pickle
from fractions import Fraction

import attrs
import numpy as np
import pint
import pytest
from scipy.integrate import solve_ivp

from shockwave.chain.chain import Chain
from shockwave.chain.library import PAPER_STEEL
from shockwave.chain.segments import Segment
from shockwave.errors import InvalidValueError
from shockwave.measurement.simulate import simulate
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.shock import Shock
from shockwave.profiles.tabulated import Tabulated
from shockwave.studies.curve import UniversalCurve

pytestmark = pytest.mark.numerical

ROOT = pathlib.Path(__file__).parents[1]
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
    assert profile.notes == ()
    assert np.array_equal(profile.force(np.array(profile.breakpoints)), forces)


def test_a_duration_ratio_stretches_only_the_decay():
    profile = Tabulated(times=[0, 1, 2, 3], forces=[0, 1, 0.5, 0], duration_ratio=7)
    assert profile.breakpoints == (0.0, 1.0, 4.0, 7.0)
    assert profile.closed_areas() == (0.5, 3.0)
    assert profile.recorded_rise_time == 1
    assert profile.notes == ("The decay was stretched in time: n is 7, that of the record 3.",)


# ---------------------------------------------------------------- refused records


NO_PULSES = {
    "two": ([0, 1], [0, 1], r"times: must have at least three samples"),
    "nan": ([0, 1, float("nan")], [0, 1, 0], r"times\[2\]: must be a finite number of s \(got nan\)"),
    "words": ([0, 1, 2], [0, "x", 0], r"forces: must be a sequence of numbers \(got \[0, 'x', 0\]\)"),
    "no-list": ([0, 1, 2], 3, r"forces: must be a sequence of numbers \(got 3\)"),
    "unsorted": ([0, 2, 1, 1], [0, 1, 1, 0], r"times\[2\]: must be greater.*\ntimes\[3\]: must be greater"),
    "lengths": ([0, 1, 2], [0, 1], r"forces: must have one force for each.*got 2 forces and 3 times\)"),
    "no-force": (
        [0, 1, 2],
        [0, -1, 0],
        r"forces: must be > 0 N somewhere \(got at most 0 N; if compression is negative, change the signs of forces\)",
    ),
    "no-rise": ([0, 1, 2], [1, 0.5, 0], r"forces\[0\]: must not be the peak.*a sample of zero force before it"),
    "merged": ([-1, 1e-20, 2e-20, 1], [0, 0.5, 1, 0], r"times: must differ by more than rounding errors"),
    "overflow": ([-1e308, 0, 1e308], [0, 1, 0], r"times: .* span less than 1e\+150 rise times"),
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
    with pytest.raises(InvalidValueError, match=r"pulse.csv:5: times\[2\]: must be greater"):
        Tabulated.from_file(path)


# ---------------------------------------------------------------- cleaning


def test_a_constant_baseline_is_subtracted():
    profile = Tabulated(range(12), [1, 1, 1, 1, 1, 1, 5, 9, 7, 3, 1, 1])
    assert profile.recorded_peak_force == 8
    assert profile.breakpoints == (0.0, 0.5, 1.0, 1.5, 2.0, 2.5)
    # 31 N s become 20 N s, as one newton over the eleven seconds of the record is subtracted.
    found = "A baseline of 1 N, the mean of the 6 samples before the pulse, was subtracted"
    assert profile.notes[0] == f"{found} (peak force -11 %, impulse -35 %)."


#: Times, forces, expected shape at whole times, expected note.
CLEANED = {
    "start-time": (range(5, 9), [0, 1, 0.5, 0], [0, 1, 0.5, 0], "The times begin at 5 s and were shifted"),
    # 15.95 N s become 16 N s
    "below": (
        range(6),
        [0, 8, 4, -0.05, 4, 0],
        [0, 1, 0.5, 0, 0.5, 0],
        "Negative samples were set to zero: 1 of 6 (impulse +0.31 %)",
    ),
    "lead": (
        range(6),
        [0, 0, 0, 1, 0.5, 0],
        [0, 1, 0.5, 0],
        "Quiet samples before the pulse were removed: 2 (peak force and impulse unchanged)",
    ),
    "tail": (
        range(6),
        [0, 1, 0.5, 0, 0.009, 0],
        [0, 1, 0.5, 0],
        "Quiet samples after the pulse were removed: 2 (impulse -0.6 %",
    ),
    "start": (range(4), [0.25, 1, 0.5, 0], [0.25, 1, 0.5, 0], "The record begins at 0.25 N, 25 % of its peak"),
    "end": (range(4), [0, 1, 0.5, 0.125], [0, 1, 0.5, 0.125], "The record ends at 0.125 N, 12 % of its peak"),
}


@pytest.mark.parametrize(("times", "forces", "shape", "note"), CLEANED.values(), ids=CLEANED)
def test_a_record_is_cleaned_and_notes_state_it(times, forces, shape, note):
    profile = Tabulated(times, forces)
    assert profile.force(np.arange(len(shape))).tolist() == shape
    assert profile.duration_ratio == len(shape) - 1
    # where the cleaning changes impulse or peak force, a second note states it
    assert 1 <= len(profile.notes) <= 2
    assert note in profile.notes[0]


def test_a_record_can_be_left_as_it_is():
    times, forces = range(12), [1, 1, 1, 1, 1, 1, 5, 9, 7, 3, 1, 1]
    kept = Tabulated(times, forces, clean=False)
    assert (kept.recorded_peak_force, kept.duration_ratio) == (9, 11 / 7)
    assert kept.areas().total * kept.recorded_rise_time * 9 == pytest.approx(31, rel=1e-14)  # trapezoids; rounding
    # by the cleaning 31 N s become 20 N s, and 9 N become 8 N
    changes = "Together this changes the impulse by -35 % and the peak force by -11 %"
    assert any(note.startswith(changes) for note in Tabulated(times, forces).notes)
    with pytest.raises(InvalidValueError, match=r"forces\[3\]: must be >= 0 N in a record that is not cleaned"):
        Tabulated(range(6), [0, 4, 2, -1, 2, 0], clean=False)
    with pytest.raises(InvalidValueError, match=r"^clean: must be True or False \(got 'no'\)$"):
        Tabulated(times, forces, clean="no")


#: A blow of 100 N on a baseline of 5 N, with 20 quiet samples on either side.
BLOW = 5 + 100 * np.sin(np.pi / 40 * np.clip(np.arange(81) - 20, 0, 40))
MICROSECONDS = 1e-6 * np.arange(81)


def test_a_baseline_is_the_mean_of_its_window():
    profile = Tabulated(MICROSECONDS, BLOW, baseline=(62e-6, 79e-6))
    assert profile.recorded_peak_force == pytest.approx(100, rel=1e-14)
    assert any(
        "the mean from 6.2e-05 to 7.9e-05 s, was subtracted (peak force -4.8 %" in note for note in profile.notes
    )


def test_a_crop_keeps_the_samples_of_its_window():
    times, forces = [0, 1, 2, 3, 4, 5, 6, 7], [0, 0, 4, 2, 0, 9, 3, 0]
    profile = Tabulated(times, forces, crop=("1 s", 4))
    assert (profile.recorded_peak_force, profile.duration_ratio) == (4, 3)
    assert "The record was cropped to 1 to 4 s (peak force -56 %, impulse -67 %)." in profile.notes


def test_the_baseline_is_that_of_the_whole_record():
    times = 1e-4 * np.arange(-15, 16)
    forces = 20 + 100 * np.cos(np.pi / 10 * np.clip(np.arange(-15, 16), -5, 5))
    kept = Tabulated(times, forces, crop=(-0.6e-3, 0.6e-3))
    assert kept.recorded_peak_force == pytest.approx(100, rel=1e-12)
    # what precedes the lead is removed by the crop
    rough = Tabulated(np.append(times[0] - 1, times), np.append(50, forces), crop=(times[0], times[-1]))
    assert rough.recorded_peak_force == pytest.approx(100, rel=1e-12)


def test_a_low_pass_filter_that_distorts_the_pulse_is_a_warning():
    around, chain = np.full(100, 5.0), Chain(material=PAPER_STEEL, radius=5e-3)
    times, forces = 1e-6 * np.arange(281), np.concatenate((around, BLOW, around))
    for edge, distorted in ((10e3, True), (30e3, False)):
        shock = Shock(profile=Tabulated(times, forces, low_pass=edge, negative="zero"))
        warnings = [text for text in Predictor().predict(shock, chain).warnings if text not in shock.profile.notes]
        assert any("it distorts the pulse" in text for text in warnings) == distorted
    with pytest.raises(InvalidValueError, match=r"^low_pass: must keep the pulse \(got 1000 Hz"):
        Tabulated(times, forces, low_pass=1e3)


def test_a_low_pass_filter_does_not_shift_the_pulse():
    around = np.full(100, 5.0)
    profile = Tabulated(1e-6 * np.arange(281), np.concatenate((around, BLOW, around)), low_pass=30e3, negative="zero")
    # the blow is symmetric, and so it remains, but for transients of 1e-6 at the ends of the record
    half = np.linspace(0, min(1.0, profile.duration_ratio - 1), 50)
    np.testing.assert_allclose(profile.force(1 - half), profile.force(1 + half), atol=1e-5)
    assert any("A low-pass filter at 30000 Hz was applied (peak force -" in note for note in profile.notes)


def test_a_low_pass_filter_removes_noise():
    noise = 3 * np.random.default_rng(1).standard_normal(81)
    rough, smooth = (Tabulated(MICROSECONDS, BLOW + noise, low_pass=edge, negative="zero") for edge in (None, 60e3))
    kinks = [np.abs(np.diff(each.force(np.array(each.breakpoints)), 2)).max() for each in (rough, smooth)]
    assert kinks[1] < 0.2 * kinks[0]
    # half a sine of 40 us has most of its power below 12.5 kHz: the filter leaves its peak; the baseline is uncertain
    assert smooth.recorded_peak_force == pytest.approx(100, rel=0.03)


def test_each_step_is_refused_where_it_cannot_be_applied():
    uneven = np.append(MICROSECONDS[:-1], 1e-3)
    for times, settings, sentence in (
        (uneven, {"low_pass": 1e3}, "low_pass: must be left out .* for uneven sampling"),
        (MICROSECONDS, {"low_pass": 5e5}, r"low_pass: must be below 5e\+05 Hz, half the sampling rate"),
        (MICROSECONDS, {"crop": (1.0, 2.0)}, "crop: must contain 3 samples or more"),
        (MICROSECONDS, {"baseline": ("2 s", 1.0)}, "baseline: must be two times, the earlier one first"),
        (MICROSECONDS, {"negative": "no"}, "negative: must be None, keep or zero"),
    ):
        with pytest.raises(InvalidValueError, match=f"^{sentence}"):
            Tabulated(times, BLOW, **settings)


PUSH_AND_PULL = ([0, 1, 2, 3, 4, 5], [0, 8, 4, 0, -3, 0])


def test_a_negative_phase_must_be_resolved():
    with pytest.raises(InvalidValueError, match=r"^negative: must be keep or zero, because .* 25 % of the impulse"):
        Tabulated(*PUSH_AND_PULL)
    zero, keep = (Tabulated(*PUSH_AND_PULL, negative=choice) for choice in ("zero", "keep"))
    assert (zero.duration_ratio, keep.duration_ratio) == (3, 5)
    assert (zero.pulls, keep.pulls) == (False, True)
    assert keep.areas().total == pytest.approx(9 / 8, rel=1e-15)
    assert keep.force(4.0) == -3 / 8


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


@pytest.mark.parametrize("lead", [[1.0] * 4, [25.0] * 6, [0, 0.4, 0.9, 1.3, 1.6, 2.0]], ids=["short", "high", "rising"])
def test_a_lead_that_is_not_a_baseline_is_kept(lead):
    profile = Tabulated(np.arange(len(lead) + 5), [*lead, 40, 100, 50, 10, 0])
    assert profile.recorded_peak_force == 100
    assert not any("baseline" in note for note in profile.notes)


@pytest.mark.parametrize("baseline", [-40.0, 0.0, 8.0, 120.0])
@pytest.mark.parametrize("seed", range(3))
def test_the_pulse_of_a_noisy_record_is_recovered(seed, baseline):
    peak, rise, decay, noise = 850.0, 48e-6, 112e-6, 4.0
    times = np.arange(-80, 400) * 1e-6
    up = np.sin(np.pi / 2 * np.clip(times / rise, 0, 1)) ** 2
    force = peak * np.where(times < rise, up, np.cos(np.pi / 2 * np.clip((times - rise) / decay, 0, 1)) ** 2)
    noisy = force + baseline + noise * np.random.default_rng(seed).standard_normal(times.size)
    profile = Tabulated(times, noisy)
    assert any("baseline" in note for note in profile.notes) == (baseline != 0)
    assert profile.force(np.array([0.0, profile.duration_ratio])).tolist() == [0.0, 0.0]
    # The largest of the dozen samples near the top lies some three standard deviations too high, and up to
    # 5 us off: 850 sin^2 loses 4 N in 4 us before the peak. The part below 12 N takes 4 us to rise.
    assert profile.recorded_peak_force == pytest.approx(peak, abs=4 * noise)
    assert profile.recorded_rise_time == pytest.approx(rise, abs=9e-6)
    # The mean of 40 samples or more leaves 0.7 N of baseline, 0.16 % of the mean force, in one deviation.
    impulse = profile.areas().total * profile.recorded_peak_force * profile.recorded_rise_time
    assert impulse == pytest.approx(peak * (rise + decay) / 2, rel=0.01)
    assert profile.duration_ratio * profile.recorded_rise_time == pytest.approx(rise + decay, rel=0.15)


def test_the_hammer_example_is_the_pulse_of_its_comment():
    profile = Tabulated.from_file(HAMMER)
    assert profile.recorded_peak_force == pytest.approx(850, abs=4 * 1.2)
    assert profile.recorded_rise_time == pytest.approx(48e-6, abs=5e-6)
    impulse = profile.areas().total * profile.recorded_peak_force * profile.recorded_rise_time
    assert impulse == pytest.approx(850 * 160e-6 / 2, rel=5e-3)
    assert any("baseline" in note for note in profile.notes)


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
