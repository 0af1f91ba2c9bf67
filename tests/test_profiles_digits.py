"""Closed integrals of the profiles against 40 digits, from the shortest times to the end of the shock."""

from __future__ import annotations

from typing import Any

import mpmath
import pytest

from shockwave.profiles.base import ShockProfile
from shockwave.profiles.exponential import Exponential
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.triangular import Triangular

# 40 are kept: a rise at rate -300 loses 130 to cancellation, one at rate 1e-9 and s = 1e-12 loses 60.
WORKING_DIGITS = 200

PROFILES: dict[str, ShockProfile] = {
    "triangle-1.1": Triangular(duration_ratio=1.1),
    "triangle-30": Triangular(duration_ratio=30),
    "power-1e-5-5": PowerLaw(rise_exponent=1e-5, decay_exponent=5, duration_ratio=2),
    "power-0.5-0.5": PowerLaw(rise_exponent=0.5, decay_exponent=0.5, duration_ratio=1.1),
    "power-5-1e-5": PowerLaw(rise_exponent=5, decay_exponent=1e-5, duration_ratio=30),
    "exponential-1e-9-1": Exponential(rise_rate=1e-9, decay_rate=1, duration_ratio=2),
    "exponential-1-1e-9": Exponential(rise_rate=1, decay_rate=1e-9, duration_ratio=30),
    "exponential-300-300": Exponential(rise_rate=300, decay_rate=300, duration_ratio=1.1),
    "exponential--300-2": Exponential(rise_rate=-300, decay_rate=2, duration_ratio=2),
    "exponential--1--300": Exponential(rise_rate=-1, decay_rate=-300, duration_ratio=30),
    "exponential-0.03--0.03": Exponential(rise_rate=0.03, decay_rate=-0.03, duration_ratio=2),
    # Either side of where a series takes over from the closed form.
    "exponential-1.99--2.01": Exponential(rise_rate=1.99, decay_rate=-2.01, duration_ratio=2),
    "exponential--1.99-2.01": Exponential(rise_rate=-1.99, decay_rate=2.01, duration_ratio=2),
}
RISING = (1e-12, 1e-6, 1e-3, 0.5, 1.0)
#: Shares of the decay.
FADING = (1e-6, 0.3, 0.9, 1 - 1e-6, 1.0)


def _rise(profile: ShockProfile, integrals: int, s: Any) -> Any:
    """Rise integrated from 0 to s none, once or twice."""
    match profile:
        case Exponential():
            return _ramp(mpmath.mpf(profile.rise_rate), s, integrals)
        case PowerLaw():
            return _power(mpmath.mpf(profile.rise_exponent), s, integrals)
    return _power(mpmath.mpf(1), s, integrals)


def _fade(profile: ShockProfile, integrals: int, left: Any) -> Any:
    """The decay seen from its end, as a function of the share of it that is left; integrated likewise."""
    match profile:
        case Exponential():
            return _ramp(-mpmath.mpf(profile.decay_rate), left, integrals)
        case PowerLaw():
            return _power(mpmath.mpf(profile.decay_exponent), left, integrals)
    return _power(mpmath.mpf(1), left, integrals)


def _power(exponent: Any, s: Any, integrals: int) -> Any:
    factor = mpmath.mpf(1)
    for j in range(1, integrals + 1):
        factor /= exponent + j
    return factor * s ** (exponent + integrals)


def _ramp(rate: Any, s: Any, integrals: int) -> Any:
    """(1 - e^(-k s)) / (1 - e^(-k)), integrated term by term."""
    ends = -mpmath.expm1(-rate)
    once = s + mpmath.expm1(-rate * s) / rate
    return [-mpmath.expm1(-rate * s), once, s**2 / 2 - once / rate][integrals] / ends


def _exact(profile: ShockProfile, integrals: int, s: float) -> float:
    with mpmath.workdps(WORKING_DIGITS):
        time, n = mpmath.mpf(s), mpmath.mpf(profile.duration_ratio)
        if time <= 1:
            return float(_rise(profile, integrals, time))
        after, decay = time - 1, n - 1
        left = 1 - after / decay
        a1 = _rise(profile, 1, mpmath.mpf(1))
        whole = _fade(profile, 1, mpmath.mpf(1))
        if integrals == 1:
            return float(a1 + decay * (whole - _fade(profile, 1, left)))
        lost = _fade(profile, 2, mpmath.mpf(1)) - _fade(profile, 2, left)
        start = _rise(profile, 2, mpmath.mpf(1))
        return float(start + (a1 + decay * whole) * after - decay**2 * lost)


METHODS = pytest.mark.parametrize(("method", "integrals"), [("running_impulse", 1), ("double_integral", 2)])


@pytest.mark.parametrize("s", RISING, ids=str)
@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
@METHODS
def test_integrals_keep_their_digits_while_it_rises(
    profile: ShockProfile, s: float, method: str, integrals: int
) -> None:
    # Relative, however small: a rounding of s is multiplied by a rate of 300.
    assert float(getattr(profile, method)(s)) == pytest.approx(_exact(profile, integrals, s), rel=1e-13, abs=0)


@pytest.mark.parametrize("share", FADING, ids=str)
@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
@METHODS
def test_integrals_are_good_to_rounding_while_it_decays(
    profile: ShockProfile, share: float, method: str, integrals: int
) -> None:
    integral, n = getattr(profile, method), profile.duration_ratio
    s = 1 + share * (n - 1)
    # Of the whole, as sums over the whole are subtracted.
    assert float(integral(s)) == pytest.approx(_exact(profile, integrals, s), rel=1e-15, abs=1e-15 * float(integral(n)))


@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
def test_areas_are_good_to_their_errors(profile: ShockProfile) -> None:
    with mpmath.workdps(WORKING_DIGITS):
        rise = _rise(profile, 1, mpmath.mpf(1))
        decay = (mpmath.mpf(profile.duration_ratio) - 1) * _fade(profile, 1, mpmath.mpf(1))
        areas = profile.areas()
        assert abs(areas.rise.value - rise) <= areas.rise.error
        assert abs(areas.decay.value - decay) <= areas.decay.error


@pytest.mark.parametrize("quadrature", ["gauss-legendre", "tanh-sinh", "quadpack"])
@pytest.mark.parametrize("s", [1e-9, 1e-3], ids=str)
def test_quadratures_keep_the_digits_of_short_times(quadrature: str, s: float) -> None:
    profile = PROFILES["exponential-1e-9-1"]
    # What the running impulse is to be good to.
    assert float(profile.running_impulse(s, quadrature)) == pytest.approx(_exact(profile, 1, s), rel=1e-12, abs=0)
