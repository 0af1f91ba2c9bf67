"""Warnings of records that are not a pulse alone; `test_record_styles` follows the keys that they propose."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from shockwave.base.errors import InvalidValueError
from shockwave.profiles.tabulated import Tabulated
from shockwave.studies.record_keys import propose_keys
from support.record_styles import BLOW, MICROSECONDS

PULSE = np.sin(np.pi * np.arange(101) / 100) ** 2


@pytest.mark.parametrize("exponent", [0.3, 1.0, 5.0])
@pytest.mark.parametrize("samples", [4, 50, 3000])
def test_a_slow_rise_is_not_treated_as_a_baseline(samples, exponent):
    rise = np.linspace(0, 1, samples) ** exponent
    forces = np.concatenate((rise, rise[-2::-1]))
    profile = Tabulated(np.arange(forces.size), forces)
    assert profile.notes == profile.alarms == ()
    assert np.array_equal(profile.force(np.array(profile.breakpoints)), forces)


#: Forces at whole times, and the warning that they begin or end above zero.
JUMPS = {
    "start": ([0.25, 1, 0.5, 0], "The record begins at 25 % and ends at 0 % of its peak force"),
    "end": ([0, 1, 0.5, 0.015625], "The record begins at 0 % and ends at 1.6 % of its peak force"),
}


@pytest.mark.parametrize(("forces", "warning"), JUMPS.values(), ids=JUMPS)
def test_a_jump_at_an_end_is_a_warning_unless_a_crop_states_the_ends(forces, warning):
    profile = Tabulated(range(4), forces)
    assert profile.force(np.arange(4)).tolist() == forces
    (alarm,) = profile.alarms
    assert alarm.startswith(warning)
    assert "crop: [0 s, 3 s] keeps all of it" in alarm
    assert Tabulated(range(4), forces, crop=(0, 3)).alarms == ()


def test_a_baseline_that_makes_forces_negative_is_proposed_with_what_becomes_of_them():
    forces = np.concatenate((3 + 0.5 * np.sin(np.arange(60)), 3 + 60 * PULSE, 3 + 0.5 * np.sin(np.arange(60))))
    (alarm,) = Tabulated(np.arange(forces.size), forces).alarms
    assert re.search(r"\(baseline: .*, crop: .*, negative: zero would change ", alarm)


def test_a_crop_inside_the_pulse_is_a_warning():
    (alarm,) = Tabulated(range(101), PULSE, crop=(25, 75)).alarms
    assert alarm.startswith("The record begins at 50 % and ends at 50 % of its peak force")


#: Records without a warning.
QUIET = {
    "small-jumps": (range(4), [0.009, 1, 0.5, 0.009], {}),
    "small-tail": (range(601), np.append(PULSE, 0.0005 * np.exp(-np.arange(500) / 150)), {}),
    "table": (range(7), [0, 40, 100, 100, 100, 40, 0], {}),
    "uneven": (np.cumsum(1 + np.arange(101) % 3), PULSE, {}),
    "negative-but-for-a-baseline": (range(101), PULSE - 3, {"baseline": (0, 2), "crop": (0, 100), "negative": "zero"}),
}


@pytest.mark.parametrize(("times", "forces", "steps"), QUIET.values(), ids=QUIET)
def test_a_pulse_that_is_whole_is_no_warning(times, forces, steps):
    assert Tabulated(times, forces, **steps).alarms == ()


def test_a_record_that_is_a_pulse_only_if_filtered_is_examined():
    forces = np.concatenate((np.zeros(20), PULSE))
    forces[[10, 12]] = 1.5, -1.5
    steps = {"crop": (10, 120), "negative": "zero"}
    with pytest.raises(InvalidValueError, match="at an end"):
        Tabulated(range(121), forces, **steps)
    assert Tabulated(range(121), forces, low_pass=0.02, **steps).alarms == ()


@pytest.mark.parametrize("unit", [1.0, 1e-300, 1e140])
def test_an_offset_is_a_warning_with_the_keys_that_remove_it(unit):
    (alarm,) = Tabulated(MICROSECONDS, unit * BLOW).alarms
    assert (
        f"(baseline: [0 s, 11 us] (subtracts {5 * unit:.4g} N), crop: [20 us, 60 us] would change peak force" in alarm
    )
    settled = Tabulated(MICROSECONDS, unit * BLOW, baseline=("0 us", "9 us"), crop=("20 us", "60 us"))
    assert (settled.recorded_peak_force, settled.recorded_rise_time) == pytest.approx((100 * unit, 20e-6), rel=1e-12)
    assert settled.alarms == ()


def test_a_baseline_inside_the_pulse_is_a_warning():
    alarms = Tabulated(range(101), PULSE, baseline=(24, 26), negative="zero").alarms
    assert any("set baseline to a window" in alarm for alarm in alarms)


@pytest.mark.parametrize("lead", [[1.0] * 4, [0, 0.4, 0.9, 1.3, 1.6, 2.0, 2.9, 3.8]], ids=["short", "rising"])
def test_no_baseline_is_proposed_from_a_lead_that_is_not_a_level(lead):
    profile = Tabulated(np.arange(len(lead) + 5), [*lead, 40, 100, 50, 10, 0])
    assert profile.recorded_peak_force == 100
    assert not any("baseline:" in alarm for alarm in profile.alarms)


def test_a_note_states_the_effect_of_a_baseline_as_the_proposal_does(tmp_path: Path) -> None:
    times = np.arange(-200, 1000, 4.0)
    forces = 500 * np.sin(np.pi * np.clip(times / 400, 0, 1)) + 20
    rows = "".join(f"{time:.0f},{force:.6f}\n" for time, force in zip(times, forces, strict=True))
    (tmp_path / "blow.csv").write_text(f"time (us),force (N)\n{rows}")
    proposal = propose_keys(tmp_path / "blow.csv")
    (comment,) = re.findall(r"baseline: .*#.*(impulse \S+ %)", proposal.shock())
    notes = Tabulated.from_file(tmp_path / "blow.csv", **proposal.parameters).notes
    (note,) = (note for note in notes if "A baseline of" in note)
    assert comment in note
