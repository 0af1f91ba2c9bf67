"""What the catalogue of extremes has shown to be wrong, case by case."""

from __future__ import annotations

from typing import Any

import attrs
import pytest

import shockwave as sw
from scenes import CHAIN, FORCE, UNITS
from shockwave.benchmark.scenes import noisy, record
from shockwave.simulation.backend import compiled

each_backend = pytest.mark.parametrize(
    "backend",
    [
        "numpy",
        pytest.param("compiled", marks=pytest.mark.skipif(compiled is None, reason="built without a C compiler")),
    ],
)


def primary(shock: sw.Shock, **options: Any) -> sw.SimulationResult:
    return sw.simulate(shock, CHAIN, waves="primary", **options)


def lasting(profile: sw.ShockProfile, duration: float) -> sw.Shock:
    """A shock of 100 N that lasts so many characteristic times."""
    return sw.Shock.of_duration(profile=profile, duration=duration * UNITS.time, peak_force=FORCE)


def exponential(rise: float, decay: float, ratio: float) -> sw.Exponential:
    return sw.Exponential(rise_rate=rise, decay_rate=decay, duration_ratio=ratio)


def power(rise: float, decay: float, ratio: float) -> sw.PowerLaw:
    return sw.PowerLaw(rise_exponent=rise, decay_exponent=decay, duration_ratio=ratio)


# ---------------------------------------------------------------- thin layers

#: Layers within a step, whose work the stages of the step did not see: each was said to miss its tolerance.
STEEP = {
    "drop-at-the-end": (exponential(1e-12, -700.0, 1e4), 0.8187274743520316),
    "drop-after-the-peak": (exponential(1.0, 1e4, 3.0), 6.0),
    "high-power-of-a-train": (power(0.1, 1000.0, 1.5), 4.0191158124611315),
    "steep-at-both-ends": (exponential(-100.0, -700.0, 1e4), 0.4858348223366917),
}


@pytest.mark.parametrize("name", STEEP)
def test_steep_pulses_are_accurate_to_their_estimate_and_to_any_tolerance(name: str) -> None:
    found, tight = (primary(lasting(*STEEP[name]), rtol=rtol) for rtol in (1e-6, 1e-10))
    assert found.warnings == ()
    assert abs(found.peak_force / tight.peak_force - 1) <= found.error_estimate + tight.error_estimate
    assert tight.error_estimate < 1e-9


# ---------------------------------------------------------------- rough and long records


@each_backend
def test_noise_does_not_count_as_lost_energy(backend: str) -> None:
    found = primary(noisy(1000)[0], backend=backend)
    assert found.error_estimate < 1e-6
    # by the stages' own integral of the impulse it was 3e-7 to 1e-6
    assert found.energy_defect < 1.5e-7


# ---------------------------------------------------------------- late pulses, slow pushes


def test_a_primary_that_is_judged_late_is_known_at_once() -> None:
    gap = 300.0
    found = primary(record([0, 1, 2, gap, gap + 1, gap + 2], [0, 1, 0, 0, 1, 0])[0])
    # the default tolerance, once for each
    assert found.peak_force == pytest.approx(primary(record([0, 1, 2], [0, 1, 0])[0]).peak_force, rel=2e-6)
    # twice the duration passes before it is judged; it went on for 60 000 contacts
    assert found.found.contact < 2 * (2 * gap)


@pytest.mark.parametrize(
    ("granules", "exponent", "duration", "amplification"),
    [pytest.param(2, 2.0, 3000.0, 0.5001607835, marks=pytest.mark.slow), (5, 3.0, 2000.0, 0.6021994909)],
)
def test_estimate_covers_the_error_where_both_runs_take_their_longest_steps(
    granules: int, exponent: float, duration: float, amplification: float
) -> None:
    # amplifications at rtol 1e-11 by the method of order 12, to ten digits
    shock = lasting(power(exponent, exponent, 2.0), duration)
    found = sw.simulate(shock, attrs.evolve(CHAIN, granules=granules))
    assert abs(found.amplification / amplification - 1) <= found.error_estimate + 1e-10
    assert found.error_estimate < 1e-6
