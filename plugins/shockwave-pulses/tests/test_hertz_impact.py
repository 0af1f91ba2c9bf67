"""The impact of a ball: its force against mpmath and the equation of motion, and what its speed gives."""

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from shockwave import Chain, InvalidValueError, Material, Predictor, Shock, simulate
from shockwave.hooks import FloatArray

from shockwave_pulses.hertz_impact import HertzImpact

PROFILE = HertzImpact()
# (2/5) B(2/5, 1/2), to the last digit of a float.
TURN = 1.471637592162352328690894
ENDS = np.array([1e-3, 0.1, 0.3, 0.499, 0.5, 0.501, 0.55, 0.6, 0.8, 0.999, 1.0, 1.001, 1.4, 1.9, 2.0])
# The oracle loses half of them where integrals are differences.
_DIGITS = 50
STEEL: dict[str, Any] = {"youngs_modulus": 193e9, "poisson_ratio": 0.3}
BALL: dict[str, Any] = {
    "ball_mass": 1.1e-4,
    "ball_speed": 2.0,
    "ball_radius": 1.5e-3,
    "ball_youngs_modulus": 193e9,
    "ball_poisson_ratio": 0.3,
    "struck_youngs_modulus": 72e9,
    "struck_poisson_ratio": 0.22,
}


def _exact(s: float) -> Any:
    """w = u^(5/2) at s to 50 digits, by Newton's method on I_w(2/5, 1/2) = s."""
    with mpmath.workdps(_DIGITS):
        a, b = mpmath.mpf(2) / 5, mpmath.mpf(1) / 2
        w = (s * mpmath.mpf(TURN)) ** (5 / mpmath.mpf(2))
        w = min(w / (1 + w / 2), mpmath.mpf("0.99"))
        for _ in range(60):
            wrong = mpmath.betainc(a, b, 0, w, regularized=True) - mpmath.mpf(s)
            step = wrong * mpmath.beta(a, b) * w ** (1 - a) * (1 - w) ** (1 - b)
            w = min(max(w - step, w / 2), (1 + w) / 2)
            if abs(step) < mpmath.mpf(10) ** -45 * w:
                break
        return w


@pytest.mark.parametrize("s", [1e-9, 1e-3, 0.1, 0.3, 0.5, 0.501, 0.7, 0.9, 0.99])
def test_the_force_is_the_inverse_of_the_incomplete_beta_function(s: float) -> None:
    # The inverse is raised to 3/5, after what SciPy leaves of it: ten units in the last place.
    assert PROFILE.force(s) == pytest.approx(float(_exact(s) ** mpmath.mpf("0.6")), rel=2e-15, abs=0)


@pytest.mark.parametrize("s", [1e-9, 1e-3, 0.1, 0.3, 0.5, 0.501, 0.6, 0.7, 0.9, 0.99])
def test_integrals_are_exact_to_rounding(s: float) -> None:
    w = _exact(s)
    with mpmath.workdps(_DIGITS):
        turn = mpmath.beta(mpmath.mpf(2) / 5, mpmath.mpf(1) / 2) * 2 / 5
        area = mpmath.mpf("0.8") / turn
        impulse = area * (1 - mpmath.sqrt(1 - w))
        path = area * (mpmath.mpf(s) - w ** mpmath.mpf("0.4") / turn)
    assert PROFILE.running_impulse(s) == pytest.approx(float(impulse), rel=4e-15, abs=0)
    table = PROFILE.free_path()
    assert table.error < 1e-14
    assert table.at(s) == pytest.approx((float(path), float(impulse)), rel=0, abs=table.error)


def test_a_ball_against_a_held_body_makes_this_force() -> None:
    # Mass, stiffness and speed 1: x'' = -x^(3/2) from x = 0 with x' = 1.
    depth = 1.25**0.4
    times = np.linspace(0, 2 * TURN * depth, 41)

    def motion(_: float, state: FloatArray) -> list[float]:
        return [state[1], -(max(state[0], 0.0) ** 1.5)]

    solved = solve_ivp(
        motion, (0, times[-1]), [0.0, 1.0], method="DOP853", t_eval=times, rtol=1e-12, atol=1e-14
    )
    force = np.maximum(solved.y[0], 0) ** 1.5 / depth**1.5
    # The solver's tolerance a hundredfold, for what grows over its steps.
    np.testing.assert_allclose(PROFILE.force(times / (TURN * depth)), force, rtol=0, atol=1e-10)


def test_the_impulse_agrees_with_quadrature() -> None:
    assert PROFILE.running_impulse(0.0) == 0.0
    # What tanh-sinh is good to here.
    impulses = PROFILE.running_impulse(ENDS, "tanh-sinh")
    np.testing.assert_allclose(PROFILE.running_impulse(ENDS), impulses, rtol=2e-14, atol=0)


def test_it_fails_the_third_condition_by_the_margin_of_the_docstring() -> None:
    chain = Chain(material=Material(density=7958.0, **STEEL), radius=4.75e-3)
    shock = Shock(profile=PROFILE, peak_force=100.0, rise_time=2e-5)
    found = Predictor(model="section-4").predict(shock, chain).conditions
    # Roundings of areas of order 1.
    margins = [0, 0.8 / TURN - 0.5, 0.5 - 0.8 / TURN]
    assert [condition.margin for condition in found] == pytest.approx(margins, rel=1e-13, abs=1e-13)
    assert [condition.holds for condition in found] == [True, True, False]


# ---------------------------------------------------------------- from the ball to the force


def test_without_a_ball_there_is_no_force_of_its_own() -> None:
    assert PROFILE.recorded_peak_force is None
    assert PROFILE.recorded_rise_time is None
    assert PROFILE.notes == ()


@pytest.mark.parametrize("struck_radius", [None, 4.75e-3], ids=["flat", "sphere"])
def test_momentum_and_energy_of_the_ball_are_what_its_force_takes(struck_radius: float | None) -> None:
    impact = HertzImpact(**BALL, struck_radius=struck_radius)
    shock = Shock(profile=impact)
    mass, speed = BALL["ball_mass"], BALL["ball_speed"]
    # It comes and leaves with the same speed: twice its momentum.
    impulse = impact.areas().total * shock.peak_force * shock.rise_time
    assert impulse == pytest.approx(2 * mass * speed, rel=1e-14)
    # At the peak its energy is stored: 2/5 of force times indentation.
    modulus = 1 / ((1 - 0.3**2) / 193e9 + (1 - 0.22**2) / 72e9)
    radius = 1 / (1 / 1.5e-3 + (1 / struck_radius if struck_radius else 0))
    depth = (shock.peak_force / (4 / 3 * modulus * math.sqrt(radius))) ** (2 / 3)
    assert 0.4 * shock.peak_force * depth == pytest.approx(mass * speed**2 / 2, rel=1e-14)


def test_the_time_of_contact_is_johnsons() -> None:
    # Johnson (1985), eq. (11.24): 2.87 (m^2/(R* E*^2 v))^(1/5), to its three digits.
    impact = HertzImpact(**BALL)
    modulus = 1 / ((1 - 0.3**2) / 193e9 + (1 - 0.22**2) / 72e9)
    contact = 2.87 * (1.1e-4**2 / (1.5e-3 * modulus**2 * 2.0)) ** 0.2
    assert impact.recorded_rise_time == pytest.approx(contact / 2, rel=2e-3)


@pytest.mark.parametrize(("name", "power"), [("ball_speed", 1.2), ("ball_mass", 0.6)])
def test_the_peak_force_scales_as_hertz_says(name: str, power: float) -> None:
    once, twice = HertzImpact(**BALL), HertzImpact(**{**BALL, name: 2 * BALL[name]})
    assert once.recorded_peak_force is not None
    assert twice.recorded_peak_force == pytest.approx(2**power * once.recorded_peak_force, rel=1e-14)


def test_that_the_body_is_held_is_noted() -> None:
    (note,) = HertzImpact(**BALL).notes
    assert "for a fixed body" in note


def test_an_impact_given_in_part_is_refused_with_all_that_lacks() -> None:
    with pytest.raises(InvalidValueError) as caught:
        HertzImpact(ball_speed=2.0, struck_radius=0.01)
    lacking = [name for name in BALL if name != "ball_speed"]
    assert [fault.path for fault in caught.value.faults] == lacking
    assert "must be given with ball_speed (got nothing; give all values of the impact or none)" in str(
        caught.value
    )


@pytest.mark.parametrize(
    ("name", "value"), [("ball_speed", 1e200), ("ball_speed", 1e-200), ("ball_radius", 1e-320)]
)
def test_a_force_beyond_a_float_is_refused(name: str, value: float) -> None:
    with pytest.raises(InvalidValueError, match="ball_mass: must give a force that a floating-point number"):
        HertzImpact(**{**BALL, name: value})


@pytest.mark.parametrize(("share", "too_much"), [(1.0, 1.96), (0.1, 1.12)], ids=["equal", "a tenth"])
def test_a_chain_that_gives_way_gets_less_by_what_the_docstring_says(share: float, too_much: float) -> None:
    chain = Chain(material=Material(density=7958.0, **STEEL), radius=4.75e-3)
    impact = HertzImpact(
        ball_mass=share * chain.granule_mass,
        ball_speed=1.0,
        ball_radius=share ** (1 / 3) * chain.radius,
        **{f"{body}_{name}": value for body in ("ball", "struck") for name, value in STEEL.items()},
        struck_radius=chain.radius,
    )
    found = simulate(Shock(profile=impact), chain, rtol=1e-6).peak_force
    truth = _primary_of_a_ball(share) * _unit_force(chain)
    # The docstring's figures have three digits.
    assert found / truth == pytest.approx(too_much, abs=0.006)


def test_the_oracle_for_a_ball_knows_the_impact_of_an_equal_sphere() -> None:
    # Known from direct simulation; dense output is good to 1e-6 here.
    assert _primary_of_a_ball(1.0) == pytest.approx(0.63955423, rel=1e-5)


def _unit_force(chain: Chain) -> float:
    """Force unit [N] in which granules, their contacts and a speed of 1 m/s are 1."""
    # Velocities scale as force^(5/6).
    return (chain.granule_mass / chain.time_at_unit_force) ** 1.2


def _primary_of_a_ball(share: float, granules: int = 40) -> float:
    """Peak force of the primary that a ball of that share of a granule's mass and unit speed makes."""
    radius = share ** (1 / 3)
    first = math.sqrt(2 * radius / (1 + radius))

    def motion(_: float, state: FloatArray) -> FloatArray:
        x, velocity = np.split(state, 2)
        force = np.maximum(x[:-1] - x[1:], 0.0) ** 1.5
        force[0] *= first
        acceleration = np.zeros_like(x)
        acceleration[:-1] -= force
        acceleration[1:] += force
        acceleration[0] /= share
        return np.concatenate((velocity, acceleration))

    start = np.zeros(2 * granules)
    start[granules] = 1.0
    # Late enough for the primary to have passed contact 28, early enough for it not to have met the far end.
    solved = solve_ivp(motion, (0, 60), start, method="DOP853", rtol=1e-9, atol=1e-11, dense_output=True)
    assert solved.sol is not None
    x = solved.sol(np.linspace(0, 60, 12001))[:granules]
    return float((np.maximum(x[28] - x[29], 0.0) ** 1.5).max())
