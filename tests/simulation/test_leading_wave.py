"""The leading wave: references of 20 digits, random pulses, passages, long and extreme shocks."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import attrs
import numpy as np
import pytest

import shockwave as sw
from shockwave.engine.peak_limit import growth_since
from shockwave.engine.search_request import Primary, SearchRequest, SearchStatus, short_limits
from shockwave.scene.simulate_options import Backend
from shockwave.scene.solitary_wave import SPEED
from shockwave.simulation import leading_wave
from support.scenes import CASE_A, CASE_B, CHAIN, FORCE, UNITS, lasting, power, record
from support.slow_cases import keeping

pytestmark = pytest.mark.compiled

# Peak force and its time at contacts counted from 0, in scaled units, from two methods in quadruple precision that
# agree to 20 digits.
REFERENCES = {
    "A": {
        9: (1.490253931405875817, 12.118161972131167),
        19: (1.505058603966965105, 22.435361572695436),
        59: (1.505133369796510557, 63.699048040316566),
    },
    "B": {
        19: (1.538094367560425286, 25.977646903057054),
        59: (2.158638473372952823, 65.431771740630958),
        99: (2.177577433389049883, 104.250709436667145),
        199: (2.178748500679994696, 201.244071882915959),
    },
}
PLACES = [(case, contact) for case, places in REFERENCES.items() for contact in places]
each_reference = pytest.mark.parametrize(("case", "contact"), PLACES, ids=[f"{case}-{at}" for case, at in PLACES])


@cache
def reference_run(case: str, rtol: float) -> sw.Simulation:
    return sw.simulate({"A": CASE_A, "B": CASE_B}[case], CHAIN, rtol=rtol)


def off_reference(result: sw.Simulation, case: str, contact: int) -> float:
    """The larger of the relative errors of peak force and time at a contact."""
    force, time = REFERENCES[case][contact]
    found = result.passage(contact)
    return max(abs(found.peak_force / FORCE / force - 1), abs(found.arrival_time / UNITS.time / time - 1))


@each_reference
def test_tight_passages_have_twelve_digits_and_the_missed_tolerance_is_reported(case: str, contact: int) -> None:
    result = reference_run(case, 1e-13)
    # rounding of some hundred steps; the uncertainty of the limit is at most 5e-14
    assert off_reference(result, case, contact) < 1e-12
    (warning,) = result.first_warnings
    assert warning.startswith("The tolerance was not met")
    assert warning.endswith("Smaller steps did not reduce it further.")
    assert 1e-13 < result.error_estimate < 1e-11


@each_reference
@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-9])
def test_errors_of_passages_are_within_tolerance_and_estimate(case: str, contact: int, rtol: float) -> None:
    result = reference_run(case, rtol)
    assert off_reference(result, case, contact) <= min(rtol, result.passage(contact).error_estimate)


# ---------------------------------------------------------------- passages


def test_far_passages_follow_the_exact_wave_without_further_steps() -> None:
    result = sw.simulate(power(0.5), CHAIN, rtol=1e-8)
    cost = result.cost
    speed = SPEED * (result.peak_force / FORCE) ** (1 / 6) * UNITS.wave_speed
    near, far = result.passage(1000), result.passage(100_000)
    read = int(result.wave.scaled.contact)
    assert [result.passage(contact).exact for contact in (read - 1, 1000, 100_000)] == [False, True, True]
    assert far.peak_force == result.peak_force
    # rounding
    assert far.arrival_time - near.arrival_time == pytest.approx(99_000 * 2 * CHAIN.radius / speed, rel=1e-12)
    assert result.cost == cost


@pytest.mark.parametrize("contact", [-1, 2.5, 99], ids=repr)
def test_contact_outside_the_chain_is_refused(contact: object) -> None:
    result = sw.simulate(power(0.5), attrs.evolve(CHAIN, granules=100))
    rule = "contact: must be a whole number of at least 0 and at most 98, the last of this chain"
    with pytest.raises(sw.InvalidValueError, match=rule):
        result.passage(contact)  # type: ignore[arg-type]


# ---------------------------------------------------------------- long and extreme shocks


def test_a_very_long_shock_is_known_at_a_loose_tolerance() -> None:
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=2), peak_force=FORCE, duration=50e-3)
    result = sw.simulate(shock, CHAIN, rtol=1e-4, waves="primary")
    assert not result.warnings
    # the reference is known to 1e-8 by the other pair
    assert abs(result.peak_force / 230.24386224 - 1) < result.error_estimate + 1e-8


# ---------------------------------------------------------------- nearly equal waves that separate slowly

# Knots in characteristic times, forces in newtons, amplification of the leading wave after thousands of contacts of a
# complete chain, from two methods at tolerances of 1e-9 and 1e-11.
SHOCKS = {
    "spike-then-plateau": (
        [0, 0.006941884071686306, 0.013883768143372612, 45.791189766510975, 46.18813149663562],
        [0, 100, 65.36806117293285, 65.36806117293285, 0],
        1.51887925,
    ),
    "spike-then-rising-push": (
        [0, 0.8252779154059808, 1.6505558308119617, 86.17479221928951, 87.06591813797856],
        [0, 100, 33.637348142782045, 43.51998914795064, 0],
        0.975904774,
    ),
    "flat-top": (
        [0, 0.4898918702128825, 63.70096621624687, 63.7103512612787],
        [0, 100, 99.97257353977861, 0],
        2.32583028,
    ),
}


@pytest.mark.parametrize("rtol", keeping([1e-3, 1e-6, 1e-9], 1e-3))
@pytest.mark.parametrize("name", SHOCKS)
def test_leading_wave_is_not_accepted_too_early(name: str, rtol: float) -> None:
    times, forces, amplification = SHOCKS[name]
    # the knots were computed with a characteristic time of 14.58 us
    profile = sw.Tabulated(times=np.array(times) * 14.58e-6, forces=np.array(forces))
    result = sw.simulate(sw.Shock(profile=profile), CHAIN, rtol=rtol, waves="primary")
    # the references have nine digits; 14.58 us differs from the characteristic time in the fifth digit
    assert abs(result.amplification / amplification - 1) <= min(rtol, result.error_estimate) + 5e-8


#: Times of two triangular humps with a gap, over T0, and the peak force of the second over that of the first.
GAPS = {
    "thrice": ([0, 1, 2, 22, 24, 26], 3.0),
    "twice": ([0, 1.319, 2.638, 24.798, 26.125, 27.452], 2.152),
    "late": ([0, 1.465, 2.929, 23.125, 24.344, 25.562], 3.157),
}


@pytest.mark.parametrize("backend", ["compiled", "numpy"])
@pytest.mark.parametrize("rtol", [1e-6, 1e-8])
@pytest.mark.parametrize("name", GAPS)
def test_errors_of_contacts_that_open_and_close_are_estimated(name: str, rtol: float, backend: Backend) -> None:
    times, height = GAPS[name]
    shock = record(times, [0, 1, 0, 0, height, 0])
    reference = sw.simulate(shock, CHAIN, rtol=1e-12, waves="primary").peak_force
    found = sw.simulate(shock, CHAIN, rtol=rtol, waves="primary", backend=backend)
    assert found.error_estimate <= rtol
    assert abs(found.peak_force / reference - 1) <= found.error_estimate


#: Two triangular humps of 8 T0 with a gap of 2 T0: the second wave is stronger and overtakes after 1500 contacts.
OVERTAKEN = record([0, 4, 8, 10, 14, 18], [0, 1, 0, 0, 1, 0])


@pytest.mark.parametrize("rtol", [1e-6, pytest.param(1e-8, marks=pytest.mark.slow)])
def test_a_tighter_tolerance_keeps_the_answer(rtol: float) -> None:
    found = sw.simulate(OVERTAKEN, CHAIN, rtol=rtol, waves="primary")
    assert found.error_estimate <= rtol
    # the reference was found at rtol 1e-9, and at 1e-7 by the other pair
    assert abs(found.amplification / 1.58840432704 - 1) <= found.error_estimate


@pytest.mark.parametrize(("backend", "work"), [("compiled", 2e7), ("numpy", 2e6)], ids=["compiled", "numpy"])
def test_a_search_without_enough_work_states_how_much_another_wave_is_stronger(
    backend: Backend, work: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("shockwave.engine.search_request._MAX_WORK", work)
    found = sw.simulate(OVERTAKEN, CHAIN, rtol=1e-4, waves="primary", backend=backend)
    assert 1e-3 < found.error_estimate < 0.2
    assert abs(found.amplification / 1.588404327 - 1) <= found.error_estimate
    (warning,) = set(found.warnings) - set(OVERTAKEN.profile.alarms)
    assert warning.startswith("The tolerance was not met")
    assert "A wave behind it may still exceed it" in warning


def test_a_search_with_a_rival_is_repeated_although_its_estimate_meets_the_tolerance(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    find, patience = leading_wave.find_primaries, []

    def impatient(requests: Sequence[SearchRequest], *arguments: Any) -> list[Primary]:
        patience.append(requests[0].patience)
        (found,) = find(requests, *arguments)
        return [found if len(patience) > 1 else found._replace(status=SearchStatus.TOO_LONG, doubt=5e-3)]

    monkeypatch.setattr(leading_wave, "find_primaries", impatient)
    result = sw.simulate(CASE_A, CHAIN, rtol=1e-2, waves="primary")
    assert patience == [1.0, 10.0]
    assert result.error_estimate < 1e-3


@pytest.mark.parametrize(("growth", "stronger"), [(0.0, False), (0.005, False), (0.03, True)])
def test_a_wave_that_grows_may_become_the_strongest(growth: float, stronger: bool) -> None:
    # it has 0.6 of the force of the front, at contact 9, and each contact has peaked 1.5 later than the one before
    forces, times = 0.6 + growth * np.arange(-9, 1), 1.5 * np.arange(10)
    growing = short_limits(1.0, 1.0).growing
    assert (growth_since(forces, times, 15.0, growing).max() > 1.0) == stronger


def test_a_shock_that_is_too_long_is_refused_at_once_with_its_cost() -> None:
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=8), peak_force=100.0, rise_time=30e-3)
    steel = sw.Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
    with pytest.raises(sw.NumericalError, match="requires 5e\\+09 contact forces, and the maximum is 2e\\+09"):
        sw.simulate(shock, sw.Chain(material=steel, radius=4.75e-3))


@pytest.mark.parametrize("backend", ["auto", "numpy"])
@pytest.mark.parametrize("first", [0.2, 0.6])
def test_a_strong_short_blow_at_the_end_has_the_leading_wave(first: float, backend: Backend) -> None:
    forces = [0, first, 0, 0, 1, 0, 0]
    blows = sw.Tabulated(times=[0, 0.075, 0.15, 60.15, 60.225, 60.3, 61.3], forces=forces)
    last = sw.Tabulated(times=[0, 0.075, 0.15], forces=[0, 1, 0])
    found = sw.simulate(lasting(blows, 61.3), CHAIN, waves="primary", backend=backend)
    # it loses some of its energy to the granules that the first blow has moved
    assert found.peak_force == pytest.approx(sw.simulate(lasting(last, 0.15), CHAIN).peak_force, rel=0.06)
