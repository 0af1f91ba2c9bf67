"""Chains with two free ends: conservation, and granules that leave the ends."""

from __future__ import annotations

from functools import cache

import attrs
import pytest

import shockwave as sw
from shockwave.scene.simulate_options import Backend
from support.scenes import CHAIN, FORCE, UNITS, lasting, power, power_law, record, triangle

pytestmark = pytest.mark.compiled


@cache
def finite(granules: int) -> sw.Simulation:
    return sw.simulate(power(0.5), attrs.evolve(CHAIN, granules=granules))


@pytest.mark.parametrize("granules", [2, 5, 20, 300])
def test_a_finite_chain_conserves_momentum_and_energy(granules: int) -> None:
    # rounding, and rtol
    assert finite(granules).momentum_defect < 1e-13
    assert finite(granules).energy_defect < 1e-6


@pytest.mark.parametrize("granules", [2, 3, 20])
def test_granules_of_a_short_chain_carry_all_momentum_away(granules: int) -> None:
    result = finite(granules)
    momentum = CHAIN.granule_mass * sum(result.spall_velocities)
    # left out are granules slower than a thousandth of the fastest
    assert momentum + result.recoil_momentum == pytest.approx(result.applied_momentum, rel=5e-3)


def test_first_contacts_exceed_the_leading_wave_of_a_short_shock_by_19_percent() -> None:
    result = sw.simulate(lasting(sw.Triangular(duration_ratio=4), 0.01), attrs.evolve(CHAIN, granules=100))
    assert result.greatest_force.contact == 0
    assert result.greatest_force.peak_force / result.peak_force == pytest.approx(1.186, abs=5e-4)  # three digits


def test_waves_of_a_long_finite_chain_are_those_of_an_endless_one() -> None:
    endless = sw.simulate(power(0.5), CHAIN)
    assert finite(300).wave == endless.wave
    for here, there in zip(finite(300).waves, endless.waves, strict=True):
        # steps on finite chains are smaller where contacts open
        assert here.momentum == pytest.approx(there.momentum, rel=1e-6)
        assert here.peak_force == pytest.approx(there.peak_force, rel=here.error_estimate)
    assert endless.spall_velocities is None


def test_a_short_chain_states_its_greatest_force_first() -> None:
    shock = lasting(power_law(4, 1, 0.5), 12.0)
    result = sw.simulate(shock, attrs.evolve(CHAIN, granules=5))
    (warning,) = result.warnings
    assert "reach the free end" in warning
    assert str(result).startswith("greatest force 126.406621 N at contact 3, 96.48 us, estimated error")
    greatest = result.to_dict()["greatest_force"]
    assert greatest["contact"] == 3
    finer = sw.simulate(shock, attrs.evolve(CHAIN, granules=5), rtol=1e-10).greatest_force
    assert greatest["peak_force"] == pytest.approx(finer.peak_force, rel=greatest["error_estimate"])
    # the default rtol
    assert greatest["error_estimate"] < 1e-6


def test_the_greatest_force_of_a_short_shock_is_at_the_loaded_contact() -> None:
    greatest = finite(300).greatest_force
    assert greatest.contact == 0
    assert greatest.peak_force == pytest.approx(sw.simulate(power(0.5), CHAIN).passage(0).peak_force, rel=1e-6)  # rtol
    endless = sw.simulate(power(0.5), CHAIN)
    assert endless.greatest_force.contact == 0
    assert endless.greatest_force.peak_force == pytest.approx(greatest.peak_force, rel=1e-6)  # rtol
    assert str(endless).startswith("peak force")
    assert f"greatest force    {greatest.peak_force:.3f}"[:-1] in str(endless)
    # of a longer shock the waves grow along the chain
    assert sw.simulate(triangle(10.0), CHAIN).to_dict()["greatest_force"] is None


def test_granules_collide_after_a_long_free_flight() -> None:
    shock = record([0, 0.5, 1, 11, 11.5, 12], [0, 1, 0, 0, 1.05, 0])
    result = sw.simulate(shock, attrs.evolve(CHAIN, granules=2))
    # velocities after the blows, which a collision of equal masses exchanges
    last, first = (velocity / UNITS.velocity for velocity in result.spall_velocities)
    assert (first, last) == pytest.approx((0.497, 0.528), abs=5e-4)
    _, late = result.waves
    assert late.arrival_time / UNITS.time == pytest.approx(148, abs=0.5)
    # two equal masses that approach at this speed: 2/5 d^(5/2) = v^2/4; the tolerance is ten times the error estimate
    assert late.peak_force / FORCE == pytest.approx((5 / 8 * (last - first) ** 2) ** 0.6, rel=1e-5)
    assert not any("collide" in warning for warning in result.warnings)


def test_forces_of_collisions_after_the_run_are_bounded() -> None:
    shock = lasting(power_law(4, 1, 0.5), 12.0)
    result = sw.simulate(shock, attrs.evolve(CHAIN, granules=400))
    assert any("may collide after" in warning for warning in result.warnings)
    # no contact force of this train exceeds that of the settled leading wave
    assert str(result).startswith("peak force")


def test_two_granules_collide_according_to_their_relative_motion() -> None:
    result = sw.simulate(triangle(1e-4), attrs.evolve(CHAIN, granules=2), rtol=1e-8)
    # Two equal masses under an impulse: the relative coordinate has mass 1/2, so the greatest overlap stores half
    # the kinetic energy, 2/5 d^(5/2) = v^2/4.
    speed = result.applied_momentum / CHAIN.granule_mass
    # the shock is short against the collision; its spread acts at the order of the ratio of their durations
    assert result.amplification == pytest.approx((5 / 8 * (speed / UNITS.velocity) ** 2) ** 0.6, rel=1e-4)
    # an elastic collision of equals, to the square of that ratio
    assert result.spall_velocities[0] == pytest.approx(speed, rel=1e-7)


def test_granules_that_are_struck_again_cost_no_accuracy() -> None:
    shock = record([0.0, 2.36, 4.72, 27.4, 29.83, 32.26], [0, 0.98, 0, 0, 1, 0])
    default, finer = (sw.simulate(shock, attrs.evolve(CHAIN, granules=7), rtol=rtol) for rtol in (1e-6, 1e-10))
    # 6e-7 where steps pass over contacts that open or close
    assert default.greatest_force.peak_force == pytest.approx(finer.greatest_force.peak_force, rel=3e-8)


def test_a_run_to_the_end_of_a_long_chain_is_refused_with_its_cost() -> None:
    result = sw.simulate(triangle(30), attrs.evolve(CHAIN, granules=2000))
    (warning,) = result.train.warnings
    assert "would take about 56 s or more (set a timeout" in warning
    assert result.waves == (result.primary,)


def test_a_leading_wave_at_the_end_of_a_long_chain_is_refused_with_its_cost() -> None:
    shock = record([0, 20, 180, 200], [0, 1, 1, 0])
    chain = attrs.evolve(CHAIN, granules=1500)
    with pytest.raises(sw.NumericalError, match=r"reach the free end.* would take about 36 s or more"):
        sw.simulate(shock, chain, rtol=1e-4)
    with pytest.raises(sw.NumericalError, match="the time limit was reached"):
        sw.simulate(shock, chain, rtol=1e-4, timeout=0.3)


@pytest.mark.parametrize("backend", ["compiled", "numpy"])
def test_the_maximum_at_the_loaded_contact_is_found_where_newtons_method_leaves_the_step(backend: Backend) -> None:
    times = [0, 0.12997250086889478, 0.25994500173778956, 2.7017285108232443, 2.9847894953053054]
    times += [3.267850479787367, 4.162823643692499, 4.442106989759448, 4.7213903358263964]
    shock = record(times, [0, 0.6049112727592162, 0, 0, 1, 0, 0, 0.3326553953063144, 0])
    greatest = sw.simulate(shock, attrs.evolve(CHAIN, granules=2), backend=backend).greatest_force
    # by DOP853, restarted at the kinks, to the tolerance of the simulation
    assert greatest.peak_force / FORCE == pytest.approx(0.13340315788, rel=1e-6)


@pytest.mark.parametrize("granules", [30, 120])
def test_a_table_of_contacts_leaves_out_none_next_to_the_ends(granules: int) -> None:
    walled = attrs.evolve(CHAIN, granules=granules, end=sw.Wall(material="same"))
    lines = sw.simulate(sw.Impact(velocity=0.5), walled, rtol=1e-3).text("explain").splitlines()
    table = lines[next(at for at, line in enumerate(lines) if line.startswith("  -------")) + 1 :]
    contacts = [int(line.split()[0]) for line in table if line.split()[:1] and line.split()[0].isdigit()]
    last = granules  # a striker adds a contact
    assert contacts[:10] == [*range(10)]
    assert contacts[-10:] == [*range(last - 9, last + 1)]
    assert (len(contacts) == last + 1) == (granules == 30)
