"""Predicted trains: (5a) and (5i) hold to rounding for every wave, and eq. (5c) as printed gives its roots."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import scipy.integrate

import shockwave as sw
from shockwave.scene.chain import Scales
from support.scenes import CHAIN, FORCE, power_law

pytestmark = pytest.mark.compiled

T0 = Scales.of(CHAIN, FORCE).time
#: A F0^(-1/6) in seconds, with the exact coefficient, from eq. (4c) written out.
TIME = 4.344507853978653 * ((1 - 0.3**2) * 7958**1.5 * 4.75e-3**4 / 193e9) ** (1 / 3) * FORCE ** (-1 / 6)


#: Name -> profile, rise time over T0.
TRAINS: dict[str, tuple[sw.ShockProfile, float]] = {
    "table1-row1": (power_law(10, 1, 5), 15e-6 / T0),
    "table1-row2": (power_law(6, 0.5, 6), 15e-6 / T0),
    "table1-row3": (power_law(4, 0.25, 1), 15e-6 / T0),
    "triangle": (sw.Triangular(duration_ratio=10), 1.0),
    "long-triangle": (sw.Triangular(duration_ratio=50), 2.0),
    "slow-rise": (sw.Triangular(duration_ratio=3), 20.0),
    "step": (power_law(30, 0, 0), 0.5),
}
each_train = pytest.mark.parametrize("name", TRAINS)


def _shock(profile: sw.ShockProfile, rise_time: float) -> sw.Shock:
    return sw.Shock(profile=profile, peak_force=FORCE, rise_time=rise_time * T0)


@cache
def _outcome(name: str, threshold: float = 5e-3) -> sw.TrainOutcome:
    outcome = sw.Predictor(wave_threshold=threshold).section4(_shock(*TRAINS[name]), CHAIN)
    assert isinstance(outcome, sw.TrainOutcome)
    return outcome


def _force(profile: sw.ShockProfile) -> Callable[[float], float]:
    """Force over F0 at a time in rise times, from the formulae of the profiles written out."""
    n = profile.duration_ratio
    rise, decay = (profile.rise_exponent, profile.decay_exponent) if isinstance(profile, sw.PowerLaw) else (1, 1)
    return lambda s: s**rise if s <= 1 else ((n - s) / (n - 1)) ** decay


@cache
def _impulse(name: str, until: float) -> float:
    """Of the force up to a time [s], over F0 [s], by QUADPACK piece by piece."""
    profile, rise_time = TRAINS[name]
    end = min(until / (rise_time * T0), profile.duration_ratio)
    pieces = [(0.0, min(end, 1.0)), (1.0, max(end, 1.0))]
    parts = [scipy.integrate.quad(_force(profile), *piece, epsabs=0, epsrel=1e-12)[0] for piece in pieces]
    return float(sum(parts)) * rise_time * T0


def _alphas(name: str) -> tuple[float, float]:
    """alpha^F0 and alpha_New of section 4."""
    profile, rise_time = TRAINS[name]
    a1, total = (_impulse(name, until) / (rise_time * T0) for until in (rise_time * T0, math.inf))
    decay = abs(0.5 - (total - a1) / (profile.duration_ratio - 1)) ** 1.5
    return 2 - abs(0.5 - a1) ** 1.5 - decay, (8 - math.sqrt(2)) / 4 - decay


# ---------------------------------------------------------------- (5a) and (5i)


@each_train
def test_the_primary_satisfies_5a_and_later_waves_5i(name: str) -> None:
    amplitudes = np.array([wave.peak_force / FORCE for wave in _outcome(name).waves])
    assert len(amplitudes) > 1
    first, new = _alphas(name)
    # The left side of the second line of (5i) is the cumulative time.
    lasting = np.where(np.arange(len(amplitudes)) == 0, first, new)
    ends = np.cumsum(lasting * TIME * amplitudes ** (-1 / 6))
    gathered = np.cumsum(TIME * amplitudes ** (5 / 6))
    applied = [_impulse(name, end) for end in ends.tolist()]
    # The quadrature here is good to 1e-12, the root to rounding; of the whole impulse for later waves, as the
    # residuals of all waves before add up.
    assert gathered[0] == pytest.approx(applied[0], rel=1e-10)
    assert gathered == pytest.approx(applied, rel=0, abs=1e-10 * applied[-1])


@each_train
def test_all_waves_together_have_the_whole_impulse(name: str) -> None:
    outcome, every = _outcome(name), _outcome(name, threshold=1e-12)
    applied = sw.predict(_shock(*TRAINS[name]), CHAIN, model="section-4").applied_momentum
    # Rounding of a sum over some hundred waves, and of the quadratures.
    assert sum(wave.momentum for wave in outcome.waves) <= applied * (1 + 1e-12)
    assert sum(wave.momentum for wave in every.waves) == pytest.approx(applied, rel=1e-11)
    assert applied == pytest.approx(FORCE * _impulse(name, math.inf), rel=1e-11)


@pytest.mark.parametrize("threshold", [0.01, 0.7])
@pytest.mark.parametrize("name", ["table1-row1", "triangle"])
def test_waves_become_weaker_after_a_steep_rise_and_the_threshold_only_shortens_the_list(
    name: str, threshold: float
) -> None:
    every = _outcome(name, threshold=1e-12).waves
    forces = [wave.peak_force for wave in every]
    assert forces == sorted(forces, reverse=True)
    above = [wave for wave in every if wave.peak_force >= threshold * every[0].peak_force]
    assert list(_outcome(name, threshold).waves) == above


@each_train
def test_a_later_wave_that_is_stronger_than_the_leading_one_has_a_warning(name: str) -> None:
    first, *later = (wave.peak_force for wave in _outcome(name).waves)
    # a step makes equal waves; rounding
    stronger = max(later) > first * (1 + 1e-9)
    assert any("stronger than the leading wave" in warning for warning in _outcome(name).warnings) == stronger


def test_the_list_of_later_waves_ends_after_a_thousand_with_a_warning() -> None:
    outcome = sw.predict(_shock(power_law(2, 0, 0), 2000.0), CHAIN, model="section-4")
    assert len(outcome.waves) == 1001
    assert any("1000" in warning for warning in outcome.warnings)


# ---------------------------------------------------------------- (5c) as printed


def _literal(profile: sw.ShockProfile, rise_time: float) -> sw.TrainOutcome:
    outcome = sw.Predictor(alpha="literal").section4(_shock(profile, rise_time), CHAIN)
    assert isinstance(outcome, sw.TrainOutcome)
    return outcome


@pytest.mark.parametrize(
    ("profile", "rise_time"),
    [
        (sw.Triangular(duration_ratio=10), 1.0),
        (sw.Triangular(duration_ratio=1e8), 1e-7),
        (power_law(4, 0.25, 1), 1.0),
        (sw.Exponential(rise_rate=2, decay_rate=3, duration_ratio=9), 1.0),
    ],
    ids=repr,
)
def test_5a_with_5c_as_printed_has_two_roots(profile: sw.ShockProfile, rise_time: float) -> None:
    outcome = _literal(profile, rise_time)
    assert any("(5c)" in warning for warning in outcome.warnings)
    areas, n = profile.areas(), profile.duration_ratio
    deviation = abs(0.5 - areas.rise.value) ** 1.5 + abs(0.5 - areas.decay.value / (n - 1)) ** 1.5
    amplitudes = [root / FORCE for root in outcome.roots]
    ends = [(2 * each - deviation) * TIME * each ** (-1 / 6) / (rise_time * T0) for each in amplitudes]
    gathered = [float(profile.running_impulse(end)) * rise_time * T0 for end in ends]
    # the roots to rounding, which grows where the shock ends with its rise
    assert gathered == pytest.approx([TIME * each ** (5 / 6) for each in amplitudes], rel=1e-9)
    assert len(ends) == 2
    inside = [root for root, end in zip(outcome.roots, ends, strict=True) if end < n * (1 - 1e-9)]
    assert outcome.peak_force == inside[-1]
    if isinstance(profile, sw.Triangular):
        # alpha is 2 F/F0 alone: the roots end with the rise and with the shock
        assert ends == pytest.approx([1.0, n], rel=1e-9)


def test_without_a_root_the_leading_wave_takes_the_whole_impulse() -> None:
    outcome = _literal(power_law(5, 2, 7), 3.0)
    assert outcome.roots == ()
    # a1 = 1/3, a2 = 4/8; (5f); rounding
    assert outcome.amplification == pytest.approx((3 * T0 * (1 / 3 + 1 / 2) / TIME) ** 1.2, rel=1e-12)
    assert any("no root" in warning for warning in outcome.warnings)
