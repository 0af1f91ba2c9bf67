"""Histories: what is kept when asked for, and that it is what the chain does."""

from __future__ import annotations

import json
from functools import cache

import attrs
import numpy as np
import pytest

import shockwave as sw
from scenes import CASE_A, CHAIN, UNITS, power
from shockwave.measurement.recording import Recording

CONTACTS = (0, 3, 5)
INTERVAL = 0.05 * UNITS.time
SHOCK = power(0.5)
END_OF_FORCE = 1.5 * UNITS.time


@cache
def result() -> sw.SimulationResult:
    return sw.simulate(
        SHOCK, CHAIN, rtol=1e-8, contacts=CONTACTS, record=["forces", "field", "energies"], interval=INTERVAL
    )


def recording_of(found: sw.SimulationResult) -> Recording:
    assert found.recording is not None
    return found.recording


def recorded(**options: object) -> Recording:
    return recording_of(sw.simulate(SHOCK, CHAIN, **options))  # type: ignore[arg-type]


def test_histories_have_a_row_for_each_sample() -> None:
    record = recording_of(result())
    count = len(record.times)
    assert record.forces is not None
    assert record.forces.shape == (count, len(CONTACTS))
    assert record.displacements is not None
    assert record.velocities is not None
    assert record.displacements.shape == record.velocities.shape == (count, record.displacements.shape[1])
    assert record.kinetic_energy is not None
    assert record.contact_energy is not None
    assert record.kinetic_energy.shape == record.contact_energy.shape == (count,)


def test_samples_are_an_interval_apart_from_the_beginning_on() -> None:
    times = recording_of(result()).times
    assert times == pytest.approx(INTERVAL * np.arange(len(times)), rel=1e-12)


def test_chain_is_at_rest_at_the_beginning() -> None:
    record = recording_of(result())
    for history in (record.forces, record.displacements, record.velocities, record.kinetic_energy):
        assert not np.any(np.asarray(history)[0])


def test_energy_after_the_force_is_its_work() -> None:
    found, record = result(), recording_of(result())
    assert record.kinetic_energy is not None
    assert record.contact_energy is not None
    total = (record.kinetic_energy + record.contact_energy)[record.times > END_OF_FORCE]
    # what steps at rtol 1e-8 lose
    assert total == pytest.approx(np.full(len(total), found.found.work * found.scales.energy), rel=1e-8)


def test_momentum_of_the_field_after_the_force_is_the_impulse() -> None:
    found, record = result(), recording_of(result())
    assert record.velocities is not None
    momentum = CHAIN.granule_mass * record.velocities[record.times > END_OF_FORCE].sum(axis=1)
    # kept by every step, to rounding
    assert momentum == pytest.approx(np.full(len(momentum), found.applied_momentum), rel=1e-13)


def test_energies_are_those_of_the_field() -> None:
    record = recording_of(result())
    assert record.velocities is not None
    assert record.kinetic_energy == pytest.approx(0.5 * CHAIN.granule_mass * (record.velocities**2).sum(axis=1))


def test_forces_are_those_of_the_field() -> None:
    record = recording_of(result())
    assert record.displacements is not None
    assert record.forces is not None
    overlap = np.maximum(record.displacements[:, 3] - record.displacements[:, 4], 0.0)
    stiffness = UNITS.force / (UNITS.energy / UNITS.force) ** 1.5
    assert record.forces[:, 1] == pytest.approx(stiffness * overlap**1.5, rel=1e-9, abs=1e-12 * UNITS.force)


@pytest.mark.parametrize("column", range(3))
def test_recorded_force_has_its_top_at_the_passage(column: int) -> None:
    record, passage = recording_of(result()), result().passages[column]
    assert record.forces is not None
    top = int(np.argmax(record.forces[:, column]))
    # half an interval of 0.05 beside a peak of curvature about 1 lacks 0.025^2 / 2
    assert record.forces[top, column] == pytest.approx(passage.peak_force, rel=6e-4)
    assert record.times[top] == pytest.approx(passage.arrival_time, abs=INTERVAL)


def test_record_goes_on_until_the_last_contact_was_passed() -> None:
    assert recording_of(result()).times[-1] > result().passages[-1].arrival_time


def test_record_of_the_loaded_contact_goes_on_until_it_was_passed() -> None:
    profile = sw.PowerLaw(rise_exponent=2, decay_exponent=2, duration_ratio=2.5)  # its peak comes late
    shock = sw.Shock(profile=profile, peak_force=100.0, rise_time=10 * UNITS.time)
    found = sw.simulate(shock, CHAIN, rtol=1e-4, contacts=[0], record=["forces"])
    assert recording_of(found).times[-1] > found.passage(0).arrival_time


def test_record_without_contacts_goes_on_until_the_primary_was_read() -> None:
    found = sw.simulate(SHOCK, CHAIN, rtol=1e-4, record=["energies"])
    assert recording_of(found).times[-1] > found.primary.arrival_time


def test_interval_and_end_are_those_that_are_given() -> None:
    times = recorded(record=["energies"], interval=0.25 * UNITS.time, until=3 * UNITS.time).times
    assert times == pytest.approx(UNITS.time * np.arange(13) / 4, rel=1e-12)


def test_samples_do_not_depend_on_their_interval() -> None:
    fine, coarse = (
        recorded(record=["forces"], contacts=[2], interval=share * UNITS.time, until=5 * UNITS.time).forces
        for share in (0.25, 0.5)
    )
    assert fine is not None
    assert coarse is not None
    # the steps are the same; so is what is read within them, to rounding
    assert fine[::2] == pytest.approx(coarse, rel=1e-12)


@pytest.mark.parametrize("kept", ["forces", "field", "energies"])
def test_only_what_is_asked_for_is_kept(kept: str) -> None:
    record = recorded(record=[kept], contacts=[1], until=2 * UNITS.time)
    parts = {"forces": record.forces, "field": record.velocities, "energies": record.kinetic_energy}
    assert [name for name, history in parts.items() if history is not None] == [kept]


def test_nothing_is_kept_when_nothing_is_asked_for() -> None:
    assert sw.simulate(SHOCK, CHAIN).recording is None


def test_forces_without_contacts_are_refused() -> None:
    with pytest.raises(sw.InvalidValueError, match="contacts: must be given where record has forces"):
        recorded(record=["forces"])


@pytest.mark.parametrize(
    ("kept", "interval", "until"), [("energies", 1e-12, None), ("field", 1e-4, 1000.0)], ids=["samples", "field"]
)
def test_more_than_fits_into_memory_is_refused(kept: str, interval: float, until: float | None) -> None:
    end = None if until is None else until * UNITS.time
    with pytest.raises(sw.InvalidValueError, match="interval: must be longer, for the histories would have"):
        recorded(record=[kept], interval=interval * UNITS.time, until=end)


def test_record_of_a_contact_beyond_a_finite_chain_is_refused() -> None:
    chain = attrs.evolve(CHAIN, granules=10)
    with pytest.raises(sw.InvalidValueError, match="at most 8, the last of this chain"):
        assert sw.simulate(SHOCK, chain, contacts=[50], record=["forces"], until=3 * UNITS.time).recording


def test_a_contact_that_is_not_reached_has_no_force() -> None:
    forces = recorded(record=["forces"], contacts=[1, 500], until=3 * UNITS.time).forces
    assert forces is not None
    assert forces[:, 0].max() > 0
    assert not np.any(forces[:, 1])


def test_field_of_a_finite_chain_has_its_granules() -> None:
    chain = attrs.evolve(CHAIN, granules=10)
    record = recording_of(sw.simulate(SHOCK, chain, record=["field"], until=40 * UNITS.time))
    assert record.velocities is not None
    assert record.velocities.shape[1] == 10


def test_json_has_lists() -> None:
    document = json.loads(json.dumps(result().to_dict(), allow_nan=False))["recording"]
    assert document["contacts"] == list(CONTACTS)
    assert len(document["forces"]) == len(document["times"])
    assert len(document["forces"][0]) == len(CONTACTS)


def test_json_of_a_result_without_histories_says_so() -> None:
    assert sw.simulate(SHOCK, CHAIN, waves="primary").to_dict()["recording"] is None


def test_print_tells_what_was_recorded() -> None:
    shown = str(sw.simulate(SHOCK, CHAIN, waves="primary", record=["energies"], interval=UNITS.time))
    assert "recorded          energies: " in shown


@pytest.mark.slow
def test_histories_of_a_method_of_fixed_step_agree() -> None:
    options = {"contacts": [4], "record": ["forces"], "interval": 0.5 * UNITS.time, "until": 12 * UNITS.time}
    exact, verlet = (
        recording_of(sw.simulate(CASE_A, CHAIN, **method, **options)).forces  # type: ignore[arg-type]
        for method in ({"rtol": 1e-8}, {"integrator": "verlet", "step": 0.02})
    )
    # errs by the square of the step, of forces up to 140 N
    assert verlet == pytest.approx(exact, abs=0.05)
