"""First pulses at contacts and sensors: their figures, by their definition, and where they are shown."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from attrs import evolve

import shockwave as sw
from shockwave.simulation.first_pulse import FirstPulse
from shockwave.simulation.simulation_text import sensor_lines
from support.first_pulse_reference import SampledPulse
from support.scenes import CHAIN, UNITS, triangle

pytestmark = pytest.mark.compiled

RIGID = sw.Wall(material="rigid")
STRIKER = sw.Impact(velocity="0.4 m/s")
HEAVY = sw.Impact(velocity="0.4 m/s", diameter="20 mm")
LAYERS = (sw.Segment(count=4), sw.Segment(count=3, material="ptfe", diameter="6 mm"), sw.Segment(count=3))
DAMPING = sw.KuwabaraKono(time="2 us")
SPRUNG = sw.Wall(mass="20 g", stiffness="1e7 N/m", damping="50 N*s/m")
BEADS = evolve(CHAIN, granules=12)
#: Excitation, chain, sensor, end of the simulated time [s], and whether pulses merge.
SCENES: dict[str, tuple[Any, sw.Chain, Any, float, bool]] = {
    "separated": (STRIKER, BEADS, {"contact": 9}, 4e-4, False),
    "velocity": (STRIKER, BEADS, {"granule": 6, "quantity": "velocity"}, 4e-4, False),
    "train": (HEAVY, BEADS, {"contact": 9}, 6e-4, False),
    "train at its beginning": (HEAVY, BEADS, {"contact": 1}, 6e-4, False),
    "under a long shock": (triangle(12.0), BEADS, {"contact": 0}, 6e-4, False),
    "before a wall": (STRIKER, evolve(BEADS, end=RIGID), {"contact": 11}, 6e-4, True),
    "on a wall": (STRIKER, evolve(BEADS, end=RIGID), "wall", 6e-4, False),
    "granule at a wall": (STRIKER, evolve(BEADS, end=RIGID), {"granule": 12}, 6e-4, False),
    "precompressed": (triangle(2.0), evolve(BEADS, precompression=20.0), {"contact": 5}, 4e-4, False),
    "vertical": (STRIKER, evolve(CHAIN, granules=LAYERS, end=RIGID, gravity=9.81), {"contact": 8}, 6e-4, True),
    "damped": (STRIKER, evolve(CHAIN, granules=LAYERS, end=RIGID, damping=DAMPING), {"granule": 5}, 1e-3, True),
    "structure": (STRIKER, evolve(BEADS, end=SPRUNG), "structure", 8e-4, False),
}


@pytest.mark.parametrize("name", SCENES)
def test_the_figures_are_those_of_the_recorded_signal(name: str) -> None:
    """`test_sensors` compares the histories of sensors with an independent integration."""
    excitation, chain, sensor, until, merged = SCENES[name]
    dense = sw.simulate(excitation, chain, rtol=1e-11, until=until, sensors=[sensor], interval=4e-8).recording
    signal = np.asarray(dense.sensors[-1].values)  # of a structure the force of its spring comes last
    expected = SampledPulse(np.asarray(dense.times), signal - signal[0])
    for rtol in (1e-6, 1e-8):
        (found,) = sw.simulate(excitation, chain, rtol=rtol, until=until, sensors=[sensor]).sensors
        for figure in ("peak", "width", "impulse") if found.unit == "N" else ("peak", "width"):
            assert getattr(found, figure) == pytest.approx(getattr(expected, figure), rel=rtol), figure
        for figure in ("time", "arrival"):
            error = getattr(found, figure) - getattr(expected, figure)
            # the maximum of the reference is polished to the root of the rounding error
            assert abs(error) < 10 * max(rtol, 1e-7) * UNITS.time, figure
        assert found.merged is expected.merged is merged
        assert found.error_estimate < rtol


def test_a_separated_pulse_is_the_solitary_wave() -> None:
    far = sw.simulate(triangle(1.0), CHAIN, rtol=1e-8, sensors=[{"contact": 40}, {"contact": 50}])
    wave = far.primary
    first, second = far.sensors
    # the wave approaches its limit
    assert second.peak == pytest.approx(wave.peak_force, rel=1e-6)
    assert second.width == pytest.approx(wave.width, rel=1e-6)
    assert second.impulse == pytest.approx(wave.momentum, rel=5e-3)  # from 2 % of the peak on
    assert second.speed == pytest.approx(wave.speed, rel=1e-6)
    assert second.speed == second.speed_from(first) == first.speed_from(second)
    assert first.speed is first.speed_from(first) is None


def test_the_granule_of_a_sensor_has_a_lower_and_wider_pulse_than_its_contacts() -> None:
    before, inside, behind = sw.simulate(
        STRIKER, BEADS, sensors=[{"contact": 5}, {"granule": 6}, {"contact": 6}]
    ).sensors
    assert inside.peak < min(before.peak, behind.peak)
    assert inside.width > max(before.width, behind.width)
    assert before.arrival < inside.arrival < behind.arrival
    assert inside.position == pytest.approx((before.position + behind.position) / 2, rel=1e-12)  # rounding


def test_no_speed_is_that_between_two_quantities_of_a_granule_under_precompression() -> None:
    chain = sw.Chain(material="ptfe", diameter="9.5 mm", granules=6, precompression=5.0)
    force, velocity = sw.simulate(
        sw.Impact(velocity=0.2), chain, sensors=[{"granule": 3}, {"granule": 3, "quantity": "velocity"}]
    ).sensors
    assert velocity.position == force.position
    assert velocity.speed is None


NEAR = FirstPulse(
    sensor="contact_4", kind="contact_", unit="N", position=0.04, peak=5.0, arrival=1e-4, merged=False, greatest=5.0
)


@pytest.mark.parametrize(
    ("change", "speed"),
    [
        ({}, 400.0),
        ({"merged": True}, None),
        ({"arrival": 0.5e-4}, None),
        ({"arrival": None}, None),
        ({"kind": "granule_"}, None),
        ({"kind": ""}, None),
    ],
    ids=["separated", "merged", "out of order", "no pulse", "another kind", "at an end"],
)
def test_speeds_are_those_between_separated_pulses_of_a_kind_in_order(change: Any, speed: float | None) -> None:
    far = evolve(NEAR, **{"position": 0.08, "arrival": 2e-4, **change})
    # of a difference of positions
    assert far.speed_from(NEAR) == NEAR.speed_from(far) == (None if speed is None else pytest.approx(speed, rel=1e-12))


def test_no_speed_is_that_of_a_wave_to_an_end_and_the_text_says_so() -> None:
    sensors: Any = [{"contact": 2}, "structure", {"granule": 5}, {"contact": 6}, "wall", {"contact": 12}]
    result = sw.simulate(STRIKER, evolve(BEADS, end=SPRUNG), sensors=sensors)
    first, structure, granule, second, wall, last = result.sensors
    assert second.speed == second.speed_from(first) > 0
    assert {each.speed for each in (first, structure, granule, wall, last)} == {None}
    assert str(result).count("(speed: ") == 1
    assert "(speed: " not in str(sw.simulate(STRIKER, BEADS, sensors=[{"contact": 2}, {"contact": 6}]))


@pytest.mark.parametrize(("error", "shown"), [(1e-7, "1.762"), (0.13, "1.8")], ids=["accurate", "inaccurate"])
def test_digits_of_a_pulse_are_those_that_its_error_supports(error: float, shown: str) -> None:
    pulse = evolve(NEAR, peak=1762.3, error_estimate=error)
    result: Any = SimpleNamespace(sensors=[pulse], structure=None, chain=BEADS)
    assert f"  {shown} kN  " in "\n".join(sensor_lines(result))


def test_every_reported_contact_has_a_first_pulse_beside_its_greatest_force() -> None:
    result = sw.simulate(STRIKER, evolve(BEADS, end=RIGID), sensors=[{"contact": 3}], contacts=[3, 11])
    near, last = result.contacts
    # the greatest force may be a reflection
    for name in ("peak", "time", "arrival", "width", "impulse", "merged", "greatest"):
        # of its own list of histories, whose last digits depend on the processor
        assert getattr(near.first, name) == pytest.approx(getattr(result.sensors[0], name), rel=1e-12)
    assert near.first.peak <= near.peak_force * (1 + 1e-9)
    assert last.first.merged
    document = result.to_dict()["contacts"][0]["first"]
    assert set(document) >= {"sensor", "peak", "time", "arrival", "width", "impulse", "merged", "greatest"}
    assert document["peak"] == near.first.peak
    assert result.to_dict()["sensors"][0]["sensor"] == "contact_3"


def test_the_greatest_value_of_a_sensor_is_total_and_over_all_times() -> None:
    chain = evolve(CHAIN, granules=LAYERS, end=RIGID, gravity=9.81)
    whole = sw.simulate(STRIKER, chain, sensors=["wall", {"granule": 5}], interval=2e-7)
    wall, granule = whole.sensors
    assert wall.greatest == whole.transmitted.peak_force
    sampled = float(np.max(whole.recording.sensors[1].values))
    # the samples miss the maximum by a little
    assert sampled <= granule.greatest * (1 + 1e-9) <= sampled * (1 + 1e-4)


@pytest.mark.parametrize(
    ("until", "nulls"),
    [(2e-5, {"peak", "time", "arrival", "width", "impulse", "merged"}), (1.3e-4, {"width", "impulse"})],
    ids=["before the wave", "within the pulse"],
)
def test_what_the_simulated_time_does_not_show_is_null(until: float, nulls: set[str]) -> None:
    chain = evolve(BEADS, precompression=1.0) if until < 1e-4 else BEADS
    (pulse,) = sw.simulate(STRIKER, chain, until=until, sensors=[{"contact": 7}]).sensors
    figures = ("peak", "time", "arrival", "width", "impulse", "merged")
    assert {name for name in figures if getattr(pulse, name) is None} == nulls


def test_a_guided_granule_gives_first_pulses() -> None:
    shove = sw.Motion(velocity="0.5 m/s", until="20 us")
    near, wall = sw.simulate(shove, evolve(BEADS, end=RIGID), sensors=[{"contact": 0}, "wall"]).sensors
    assert near.arrival < wall.arrival
    recorded = sw.simulate(shove, evolve(BEADS, end=RIGID), sensors=["wall"], interval=1e-7).recording
    values = recorded.sensors[0].values
    # the samples miss the maximum by a little
    assert wall.peak == pytest.approx(float(values.max()), rel=1e-4)
    first = int(np.argmax(values > 0.02 * values.max()))
    passed = values[first : first + int(np.argmin(values[first:] > 0)) + 1]
    assert wall.impulse == pytest.approx(0.5e-7 * float(np.sum(passed[1:] + passed[:-1])), rel=1e-3)
    assert 0 < near.impulse < wall.impulse


def test_a_pulse_that_begins_with_a_jump_arrives_at_once() -> None:
    chain = evolve(CHAIN, granules=6, damping=sw.Dashpot(coefficient="100 N*s/m"))
    (pulse,) = sw.simulate(STRIKER, chain, sensors=[{"contact": 0}]).sensors
    assert pulse.arrival == pytest.approx(0.0, abs=1e-3 * UNITS.time)
    assert math.isfinite(pulse.impulse)


@pytest.mark.parametrize(
    ("error", "reported"),
    [(1.004e-6, []), (2.5e-2, ["the relative error of the first pulse at contact_4 is 2.5e-02 (time), not 1.0e-06."])],
    ids=["equal as printed", "missed"],
)
def test_a_missed_tolerance_is_reported_with_its_figure(
    monkeypatch: pytest.MonkeyPatch, error: float, reported: list[str]
) -> None:
    pulse = evolve(NEAR, error_estimate=error, worst="time")
    monkeypatch.setattr("shockwave.simulation.first_pulse_search._with_speeds", lambda *_: (pulse,))
    result = sw.simulate(STRIKER, BEADS, rtol=1e-6, sensors=[{"contact": 4}])
    assert [each for each in result.warnings if "first pulse" in each] == [
        f"The tolerance was not met: {sentence}" for sentence in reported
    ]


@pytest.mark.parametrize(
    ("repeated", "worst", "error"), [(4e-3, "width", 4e-3), (1e-7, "time", 1e-3)], ids=["confirmed", "by chance"]
)
def test_the_worst_figure_has_the_error_that_counts(
    monkeypatch: pytest.MonkeyPatch, repeated: float, worst: str, error: float
) -> None:
    estimates = iter([(1e-2, "time"), (repeated, "width"), (1.0, "peak")])

    def pulses(*_: Any) -> list[FirstPulse]:
        estimate, figure = next(estimates)
        return [evolve(NEAR, error_estimate=estimate, worst=figure)]

    monkeypatch.setattr("shockwave.simulation.first_pulse_search._pulses_of", pulses)
    (pulse,) = sw.simulate(STRIKER, BEADS, rtol=1e-6, sensors=[{"contact": 4}]).sensors
    assert (pulse.worst, pulse.error_estimate) == (worst, pytest.approx(error))


def test_text_and_tables_show_the_first_pulses() -> None:
    result = sw.simulate(
        STRIKER, BEADS, sensors=[{"granule": 4}, {"granule": 9}, {"granule": 2, "quantity": "velocity"}]
    )
    text = str(result)
    assert "granule 9" in text
    assert "m/s" in text
    assert "granule_9" in result._repr_html_().partition("<details")[0]
    frame = result.to_pandas()
    assert frame.index.tolist() == ["granule_4", "granule_9", "granule_2_velocity"]
    assert frame["width"]["granule_9"] == result.sensors[1].width
    assert [frame.attrs["units"][name] for name in ("arrival", "speed", "peak")] == ["s", "m/s", None]


def test_short_text_shows_every_requested_sensor_and_the_forces_beyond_first_yield() -> None:
    chain = sw.Chain(material="stainless-steel-302", diameter="9.5 mm", granules=20, end=sw.Wall())
    sensors = [{"contact": contact} for contact in range(15)]
    lines = str(sw.simulate(sw.Impact(velocity=200.0), chain, until=1e-4, sensors=sensors)).split("\n")
    assert sum(line.startswith("  contact ") for line in lines) == 15
    marks = [line for line in lines if line.startswith("  ! ")]
    assert [mark.split()[1] for mark in marks[:2]] == ["Beyond", "With"]
    assert "--verbose shows all" in marks[2]


def test_the_text_states_that_first_peaks_are_less_the_static_force() -> None:
    texts = [
        str(sw.simulate(triangle(1.0), evolve(CHAIN, precompression=force), sensors=[{"contact": 2}]))
        for force in (0.0, 1e-3)
    ]
    assert ["peak - static" in text for text in texts] == [False, True]


def test_only_what_reads_first_pulses_integrates_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shockwave.simulation.first_pulse_search.first_pulses", None)
    result = sw.simulate(STRIKER, BEADS, contacts=[3])
    assert str(result)
    assert result.error_estimate < 1e-6


@pytest.mark.parametrize("integrator", ["verlet", "rk4"])
def test_a_fixed_step_reads_first_pulses_to_its_estimate(integrator: str) -> None:
    (pulse,) = sw.simulate(triangle(1.0), CHAIN, integrator=integrator, sensors=[{"contact": 10}]).sensors
    (expected,) = sw.simulate(triangle(1.0), CHAIN, sensors=[{"contact": 10}]).sensors
    assert 0 < abs(pulse.peak / expected.peak - 1) < pulse.error_estimate < 1e-3


def test_pulses_that_miss_the_tolerance_are_computed_again_with_a_smaller_one() -> None:
    chain = evolve(BEADS, material="stainless-steel-302", contact=sw.ElasticPlastic())
    result = sw.simulate(STRIKER, chain, contacts=[*range(11)])
    estimates = [peak.first.error_estimate for peak in result.contacts if peak.first]
    assert len(estimates) == 11
    assert max(estimates) <= 1e-6
    tight = sw.simulate(STRIKER, chain, contacts=[*range(11)], rtol=1e-9)
    for first, reference in (
        (one.first, other.first) for one, other in zip(result.contacts, tight.contacts, strict=True)
    ):
        assert first.peak == pytest.approx(reference.peak, rel=first.error_estimate)
        assert first.width == pytest.approx(reference.width, rel=first.error_estimate)
