"""Simulation against 20 shocks that two independent codes have simulated."""

from __future__ import annotations

import pytest

from scenes import FORCE, TRUTH, UNITS, name_of, simulated
from selection import thinned

INDICES = range(len(TRUTH))
IDS = [name_of(case) for case in TRUTH]
each_pulse = pytest.mark.parametrize("index", thinned(INDICES, 2), ids=IDS)

# This train's tail is chaotic: a run in 80-bit arithmetic finds less than 1e-13 where the reference has 5e-4 of
# the impulse, so the reference's figure is its own rounding, grown over 700 units of time.
CHAOTIC_TAIL = 3


@each_pulse
@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_primary_peak_is_within_the_tolerance(index: int, rtol: float) -> None:
    assert simulated(index, rtol).peak_force / FORCE == pytest.approx(TRUTH[index]["peaks"][0], rel=rtol)


@each_pulse
def test_later_waves_are_within_ten_tolerances(index: int) -> None:
    found = [wave.peak_force / FORCE for wave in simulated(index, 1e-6).waves]
    expected = TRUTH[index]["peaks"]
    assert found[: len(expected)] == pytest.approx(expected, rel=1e-5)


@each_pulse
def test_impulse_is_that_of_the_force(index: int) -> None:
    assert simulated(index, 1e-6).applied_momentum / UNITS.momentum == pytest.approx(TRUTH[index]["impulse"], rel=1e-10)


@pytest.mark.parametrize(
    "index",
    [
        pytest.param(i, id=name, marks=pytest.mark.xfail(strict=True, reason="the reference is rounding noise"))
        if i == CHAOTIC_TAIL
        else pytest.param(i, id=name)
        for i, name in zip(INDICES, IDS, strict=True)
    ],
)
def test_recoil_is_that_of_the_reference(index: int) -> None:
    recoil = simulated(index, 1e-6).recoil_momentum / UNITS.momentum
    assert recoil == pytest.approx(TRUTH[index]["recoil"], abs=1e-4 * TRUTH[index]["impulse"])


def test_nothing_recoils_from_the_slow_train() -> None:
    assert simulated(CHAOTIC_TAIL, 1e-6).recoil_momentum / UNITS.momentum == pytest.approx(0.0, abs=1e-6)


@each_pulse
@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_error_estimate_covers_the_error(index: int, rtol: float) -> None:
    result = simulated(index, rtol)
    error = abs(result.peak_force / FORCE / TRUTH[index]["peaks"][0] - 1)
    assert error <= result.error_estimate + 2e-9  # the reference is trusted to that
    assert result.error_estimate < rtol


@each_pulse
@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_momentum_book_closes_to_rounding(index: int, rtol: float) -> None:
    assert simulated(index, rtol).momentum_defect < 1e-13


@each_pulse
@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_energy_book_closes_to_the_tolerance(index: int, rtol: float) -> None:
    # a peak force goes with the 3/5 power of energy
    assert simulated(index, rtol).energy_defect < rtol


@each_pulse
@pytest.mark.parametrize("rtol", [1e-3, 1e-6])
def test_error_estimates_cover_the_later_waves(index: int, rtol: float) -> None:
    pairs = zip(simulated(index, rtol).waves, TRUTH[index]["peaks"], strict=False)
    # the later peaks of the reference are trusted to 1e-6
    excess = [abs(wave.peak_force / FORCE / peak - 1) - wave.error_estimate for wave, peak in pairs]
    assert max(excess) < 1e-6
