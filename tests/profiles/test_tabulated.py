"""The tabulated profile: its samples, its force between them, exact integrals, and pulling forces."""

from __future__ import annotations

import pickle
from fractions import Fraction

import attrs
import numpy as np
import pint
import pytest

import shockwave as sw
from shockwave.base.errors import InvalidValueError
from shockwave.profiles.tabulated import Tabulated
from shockwave.studies.amplification_curve import UniversalCurve
from support.chain_reference import Reference
from support.pages import ROOT
from support.scenes import CHAIN


def clean():
    return Tabulated(times=[0, 1, 2, 3], forces=[0, 1, 0.5, 0])


# ---------------------------------------------------------------- samples


def test_peak_force_rise_time_and_duration_are_those_of_the_record():
    profile = Tabulated(times=[0, 2e-6, 5e-6, 8e-6, 20e-6], forces=[0, 30, 120, 60, 0])
    # The force is linear between samples.
    assert profile.force([0.2, 0.4, 1.0, 1.3, 2.8, 4.0]).tolist() == pytest.approx([0.125, 0.25, 1, 0.75, 0.25, 0])
    assert (profile.recorded_peak_force, profile.recorded_rise_time) == (120, 5e-6)
    assert profile.duration_ratio == 20e-6 / 5e-6


QUANTITY = pint.Quantity


@pytest.mark.parametrize(
    ("times", "forces"),
    [
        (["0 us", "10 us", "30 us"], ["0 N", "0.05 kN", "0 N"]),
        ([QUANTITY(time, "us") for time in (0, 10, 30)], [0.0, 50.0, 0.0]),
    ],
    ids=["text", "quantities"],
)
def test_samples_can_have_units(times, forces):
    assert Tabulated(times=times, forces=forces) == Tabulated(times=[0.0, 10e-6, 30e-6], forces=[0.0, 50.0, 0.0])


def test_samples_can_be_an_array_with_a_unit():
    record = Tabulated(times=QUANTITY(np.array([0.0, 1.0, 2.0]), "us"), forces=QUANTITY([0.0, 3.0, 0.0], "kN"))
    assert (record.recorded_rise_time, record.recorded_peak_force) == (1e-6, 3000.0)


@pytest.mark.parametrize("times", [["0 us", "10 m", "30 us"], [QUANTITY(1, "N")] * 3, QUANTITY([0.0, 1.0, 2.0], "mm")])
def test_samples_of_another_dimension_are_refused(times):
    with pytest.raises(InvalidValueError, match=r"times\[[01]\]: must be a time"):
        Tabulated(times=times, forces=[0.0, 50.0, 0.0])


def test_a_duration_ratio_stretches_only_the_decay():
    profile = attrs.evolve(clean(), duration_ratio=7)
    assert profile.breakpoints == (0.0, 1.0, 4.0, 7.0)
    assert profile.closed_areas() == (0.5, 3.0)
    assert profile.recorded_rise_time == 1
    assert profile.notes == ("The decay was stretched in time: n is 7, that of the record 3.",)
    with pytest.raises(InvalidValueError, match="duration_ratio: must be > 1"):
        attrs.evolve(clean(), duration_ratio=1)


def test_profiles_compare_by_value():
    assert clean() == attrs.evolve(clean(), duration_ratio=3) == pickle.loads(pickle.dumps(clean()))
    assert hash(clean()) == hash(clean())
    assert clean() != Tabulated([0, 1, 2, 3], [0, 1, 0.6, 0])
    with pytest.raises(ValueError, match="read-only"):
        clean().times[0] = 1.0


def test_the_hammer_example_is_the_pulse_of_its_comment():
    shock = sw.load_scenario(ROOT / "profiles" / "examples" / "hammer.yaml").shock
    profile = shock.profile
    assert profile.alarms == ()
    assert profile.recorded_peak_force == pytest.approx(850, abs=4 * 1.2)
    assert profile.recorded_rise_time == pytest.approx(48e-6, abs=2e-6)
    impulse = profile.areas().total * profile.recorded_peak_force * profile.recorded_rise_time
    assert impulse == pytest.approx(850 * 160e-6 / 2, rel=5e-3)


# ---------------------------------------------------------------- integrals


def exact_integrals(profile):
    """Running impulse and its integral at the breakpoints and halfway between them, in rational numbers."""
    knots = [Fraction(s) for s in profile.breakpoints]
    values = [Fraction(float(v)) for v in profile.force(np.array(profile.breakpoints))]
    impulses, paths = [Fraction(0)], [Fraction(0)]
    for k in range(len(knots) - 1):
        h, left, right = (knots[k + 1] - knots[k]) / 2, values[k], values[k + 1]
        for begin, end in ((left, (left + right) / 2), ((left + right) / 2, right)):
            paths.append(paths[-1] + h * impulses[-1] + h * h * (2 * begin + end) / 6)
            impulses.append(impulses[-1] + h * (begin + end) / 2)
    return np.array([float(a) for a in impulses]), np.array([float(b) for b in paths])


# the longest is longer than the parts in which a table is computed
@pytest.mark.parametrize("size", [3, 4, 50, 5000])
def test_integrals_are_exact_to_the_last_digits(size):
    draw = np.random.default_rng(7)
    times = np.append(0.0, np.cumsum(draw.uniform(0.1e-6, 2e-6, size - 1)))
    profile = Tabulated(times, np.concatenate(([0.0], draw.uniform(1.0, 300.0, size - 2), [0.0])))
    impulses, paths = exact_integrals(profile)
    knots = np.array(profile.breakpoints)
    # Each sample adds three roundings of its own small term; the sum itself adds none.
    np.testing.assert_allclose(profile.closed_running_impulse(knots), impulses[::2], rtol=1e-15)
    table, s = profile.free_path(), np.interp(np.arange(2 * size - 1), 2 * np.arange(size), knots)
    assert len(table.rows) == size - 1
    assert table.error < 1e-14
    errors = np.abs(np.array([table.at(each) for each in s.tolist()]) - np.transpose([paths, impulses]))
    assert (errors <= table.error * np.array([paths[-1], impulses[-1]])).all()


# ---------------------------------------------------------------- pulling forces


def test_pulling_forces_are_simulated_and_refused_by_formulas():
    profile = Tabulated([0, 1, 2, 3, 4, 5], [0, 8, 4, 0, -3, 0], negative="keep")
    shock = sw.Shock(profile=profile, peak_force=100.0, rise_time=1e-5)
    short = attrs.evolve(CHAIN, granules=[sw.Segment(count=3)])
    result = sw.simulate(shock, short, rtol=1e-8)
    peaks, _ = Reference(shock, short, 1e-5).greatest(2e-4)
    assert [peak.peak_force for peak in result.contacts] == pytest.approx(peaks, rel=1e-8)
    assert result.recoil_momentum < 0
    outcome = sw.predict(shock, CHAIN)
    assert outcome.peak_force == sw.simulate(shock, CHAIN).peak_force > 0
    assert outcome.section4 is None
    assert "section 4, which covers no negative forces" in outcome.section4_reason
    for refused in (lambda: sw.predict(shock, CHAIN, model="section-4"), lambda: UniversalCurve(profile)):
        with pytest.raises(InvalidValueError, match=r"covers? no negative forces"):
            refused()
