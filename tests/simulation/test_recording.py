"""Histories: their content, and their agreement with the motion of the chain."""

from __future__ import annotations

import json
from functools import cache

import attrs
import numpy as np
import pytest

import shockwave as sw
from shockwave.simulation.recording import Recording
from support.scenes import CASE_A, CHAIN, UNITS, power

pytestmark = pytest.mark.compiled

CONTACTS = (0, 3, 5)
INTERVAL = 0.05 * UNITS.time
SHOCK = power(0.5)
END_OF_FORCE = 1.5 * UNITS.time


@cache
def result() -> sw.Simulation:
    return sw.simulate(
        SHOCK, CHAIN, rtol=1e-8, contacts=CONTACTS, record=["forces", "field", "energies"], interval=INTERVAL
    )


def recorded(shock: sw.Shock = SHOCK, chain: sw.Chain = CHAIN, **options: object) -> Recording:
    return sw.simulate(shock, chain, **options).recording  # type: ignore[arg-type]


def test_energy_and_momentum_after_the_force_are_its_work_and_impulse() -> None:
    found, record = result(), result().recording
    after = record.times > END_OF_FORCE
    energy = np.add(record.kinetic_energy, record.contact_energy)[after]
    # what steps at rtol 1e-8 lose
    assert energy == pytest.approx(np.full(len(energy), found.wave.applied_energy), rel=1e-8)
    momentum = CHAIN.granule_mass * np.sum(record.velocities, axis=1)[after]
    # kept by every step, to rounding
    assert momentum == pytest.approx(np.full(len(momentum), found.applied_momentum), rel=1e-13)


def test_energies_and_forces_are_those_of_the_field() -> None:
    record = result().recording
    # rounding
    kinetic = 0.5 * CHAIN.granule_mass * np.sum(np.square(record.velocities), axis=1)
    assert record.kinetic_energy == pytest.approx(kinetic, rel=1e-12)
    overlap = np.maximum(record.displacements[:, 3] - record.displacements[:, 4], 0.0)
    stiffness = UNITS.force / (UNITS.energy / UNITS.force) ** 1.5
    assert record.forces[:, 1] == pytest.approx(stiffness * overlap**1.5, rel=1e-9, abs=1e-12 * UNITS.force)


def test_a_recording_ends_after_the_last_contact_or_the_measurement_of_the_leading_wave() -> None:
    assert result().recording.times[-1] > result().passages[-1].arrival_time
    found = sw.simulate(SHOCK, CHAIN, rtol=1e-4, waves="primary", record=["energies"])
    assert found.recording.times[-1] > found.primary.arrival_time
    assert "recorded          energies: " in found.text("verbose")


def test_interval_and_end_are_those_that_are_given_and_change_no_sample() -> None:
    fine, coarse = (
        recorded(record=["forces"], contacts=[2, 500], interval=share * UNITS.time, until=5 * UNITS.time)
        for share in (0.25, 0.5)
    )
    # rounding
    assert fine.times == pytest.approx(UNITS.time * np.arange(21) / 4, rel=1e-12)
    # the steps are the same; so is what is read within them, to rounding
    assert fine.forces[::2] == pytest.approx(coarse.forces, rel=1e-12)
    # a contact that is not reached has no force
    assert np.any(fine.forces, axis=0).tolist() == [True, False]


@pytest.mark.parametrize(
    ("kept", "shapes"),
    [
        ("forces", {"forces": (81, 1)}),
        ("field", {"displacements": (81, 10), "velocities": (81, 10)}),
        ("energies", {"kinetic_energy": (81,), "contact_energy": (81,)}),
    ],
)
def test_only_requested_histories_are_kept(kept: str, shapes: dict[str, tuple[int, ...]]) -> None:
    chain = attrs.evolve(CHAIN, granules=10)
    span = {"interval": UNITS.time / 4, "until": 20 * UNITS.time}
    found = sw.simulate(SHOCK, chain, waves="primary", record=[kept], contacts=[1], **span)
    document = json.loads(json.dumps(found.to_dict(), allow_nan=False))["recording"]
    assert len(document.pop("times")) == 81
    assert document.pop("contacts") == [1]
    assert document.pop("sensors") == []
    assert {name: np.shape(history) for name, history in document.items() if history is not None} == shapes


@pytest.mark.parametrize(
    "settings",
    [{"record": ["field"], "interval": 1e-15}, {"record": ["field"], "until": 10.0}, {"contacts": [9]}],
    ids=["interval", "until", "contact"],
)
def test_impossible_requests_are_refused_before_the_simulation(
    settings: dict[str, object], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr("shockwave.simulation.leading_wave.find_primaries")
    with pytest.raises(sw.InvalidValueError, match=r"interval: must be longer|contacts: must be at most 8"):
        sw.simulate(SHOCK, attrs.evolve(CHAIN, granules=10), **settings)  # type: ignore[arg-type]


def test_histories_and_passages_of_a_method_of_fixed_step_agree() -> None:
    options = {"contacts": [4], "record": ["forces"], "interval": 0.5 * UNITS.time, "until": 12 * UNITS.time}
    exact, verlet = (sw.simulate(CASE_A, CHAIN, integrator=name, **options) for name in ("rkn1210", "verlet"))
    # errs by the square of the step, of forces up to 140 N, and over the time to a contact
    assert verlet.recording.forces == pytest.approx(exact.recording.forces, abs=0.05)
    assert verlet.passage(6).arrival_time == pytest.approx(exact.passage(6).arrival_time, rel=2e-4)


def test_histories_of_sensors_do_not_count_the_granules_of_a_long_chain(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shockwave.simulation.recording.MOST_NUMBERS", 20_000)
    chain = attrs.evolve(CHAIN, granules=100, end=sw.Wall())
    span = {"interval": UNITS.time / 4, "until": 200 * UNITS.time}
    sensors = [{"contact": 5}, {"granule": 3, "quantity": "velocity"}]
    recorded = sw.simulate(CASE_A, chain, sensors=sensors, **span)  # type: ignore[arg-type]
    assert [history.values.shape for history in recorded.recording.sensors] == [(801,), (801,)]
    with pytest.raises(sw.InvalidValueError, match="histories would have 801 samples"):
        sw.simulate(CASE_A, chain, record=["field"], **span)  # type: ignore[arg-type]
