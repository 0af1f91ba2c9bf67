"""Free-particle displacement as a table, against 40 digits, closed forms and exact sums."""

from __future__ import annotations

import math

import numpy as np
import pytest
from attrs import evolve

from shockwave.base.numerics import FloatArray
from shockwave.profiles.exponential import Exponential
from shockwave.profiles.free_path import FreePath, _assemble, _sample
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.profiles.triangular import Triangular
from support.profile_references import Formula, exact_integral

#: Accuracy of a table, of impulse and path at the end of the shock.
TOLERANCE = 1e-14

RATIOS = (1.0001, 2.0, 30.0, 1e4)
EXPONENTS = ((1e-5, 0.25), (0.25, 1e-5), (0.5, 1.0), (1.0, 0.5), (5.0, 50.0), (50.0, 5.0), (0.0, 0.0), (2.0, 4.0))
RATES = ((1.0, 2.0), (1e-9, -1.0), (-1.0, 1e-9), (-20.0, 20.0), (20.0, -20.0), (1e4, 3.0))
SHARES = (0.0, 1e-9, 1e-5, 1e-3, 0.1, 0.3, 0.5, 0.77, 0.97, 1 - 1e-4, 1 - 1e-9, 1.0)


def open_form(profile: ShockProfile) -> Formula:
    """The force of a profile without its closed forms."""
    return Formula(profile.rise, profile.decay, profile.duration_ratio, profile.breakpoints)


def named(profile: ShockProfile) -> object:
    values = (getattr(profile, name) for name in type(profile).__annotations__)
    return pytest.param(profile, id="-".join([type(profile).__name__, *(f"{value:g}" for value in values)]))


TRIANGLES = [Triangular(duration_ratio=n) for n in RATIOS]
POWERS = [PowerLaw(rise_exponent=a, decay_exponent=b, duration_ratio=n) for a, b in EXPONENTS for n in RATIOS]
EXPONENTIALS = [Exponential(rise_rate=a, decay_rate=b, duration_ratio=n) for a, b in RATES for n in RATIOS]


def places(n: float) -> list[float]:
    return [*SHARES, *(min(1 + share * (n - 1), n) for share in SHARES[1:])]


def errors(table: FreePath, s: list[float], path: FloatArray, impulse: FloatArray) -> float:
    """Largest error of path and impulse, over their last value."""
    found = np.array([table.at(each) for each in s])
    return max(float(np.abs(got - true).max() / true[-1]) for got, true in zip(found.T, (path, impulse), strict=True))


def digits_lost(profile: ShockProfile, table: FreePath) -> float:
    s = places(profile.duration_ratio)
    path, impulse = (np.array([exact_integral(profile, integrals, each) for each in s]) for integrals in (2, 1))
    return errors(table, s, path, impulse)


# ---------------------------------------------------------------- digits


@pytest.mark.parametrize("profile", [named(profile) for profile in TRIANGLES + POWERS + EXPONENTIALS])
def test_built_in_profiles_are_accurate_to_fourteen_digits(profile: ShockProfile) -> None:
    table = profile.free_path()
    lost = digits_lost(profile, table)
    assert lost <= TOLERANCE
    assert lost <= table.error


@pytest.mark.parametrize("closed", [named(profile) for profile in POWERS])
def test_a_fit_is_accurate_to_fourteen_digits_next_to_infinite_slopes(closed: ShockProfile) -> None:
    table = open_form(closed).free_path()
    lost = digits_lost(closed, table)
    assert lost <= TOLERANCE
    # The estimate adds up what every piece may err by; the sum is to stay of the order of the tolerance.
    assert lost <= table.error <= 5 * TOLERANCE


@pytest.mark.parametrize("rates", [(1e4, 1e4), (-700.0, 300.0), (1e6, 1e6)], ids=str)
@pytest.mark.parametrize("n", RATIOS)
def test_the_error_covers_a_force_that_is_rounded(rates: tuple[float, float], n: float) -> None:
    # The share of the decay is rounded to 1e-16, and the rate multiplies that.
    profile = Exponential(rise_rate=rates[0], decay_rate=rates[1], duration_ratio=n)
    table = profile.free_path()
    assert digits_lost(profile, table) <= table.error <= 1e-11


@pytest.mark.parametrize("part", ["missing", "rounding"])
def test_the_error_contains_that_of_every_piece(part: str) -> None:
    pieces = [_sample(np.ones_like, *ends, 2.0) for ends in ((0.0, 1.0), (1.0, 2.0))]
    # a unit force has the impulse 2
    assert _assemble([evolve(piece, scale=1.0, **{part: 1e-9}) for piece in pieces]).error >= 1e-9


def test_declared_jumps_cost_no_accuracy() -> None:
    jumpy = Formula(lambda s: np.where(s < 0.5, 0.25, 1.0), lambda s: np.where(s <= 3, 0.5, 0.125), 5.0, (0.5, 3.0))
    table = jumpy.free_path()
    assert table.rows[:, 0].tolist() == [0.0, 0.5, 1.0, 3.0]
    s = np.array([0.25, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0])
    impulse = np.array([0.0625, 0.125, 0.625, 1.125, 1.625, 1.75, 1.875])
    path = np.array([0.0078125, 0.03125, 0.21875, 1.09375, 2.46875, 4.15625, 5.96875])
    assert errors(table, s.tolist(), path, impulse) <= table.error <= TOLERANCE


# ---------------------------------------------------------------- rough forces


def square_wave(rate: float) -> tuple[Formula, float, float]:
    """A force that jumps between 0 and 1 where sin(rate s) changes sign, undeclared; impulse and path at n = 2."""

    def force(s: FloatArray) -> FloatArray:
        return (np.sin(rate * s) > 0).astype(float)

    start = np.arange(0, 2, 2 * math.pi / rate)
    stop = np.minimum(start + math.pi / rate, 2)
    return Formula(force, force), math.fsum(stop - start), math.fsum((stop - start) * (2 - (start + stop) / 2))


@pytest.mark.parametrize("rate", [3.0, 50.0, 1000.0, 1e6])
def test_a_fit_of_undeclared_jumps_terminates_and_its_error_covers_them(rate: float) -> None:
    profile, impulse, path = square_wave(rate)
    table = profile.free_path()
    found = table.at(2.0)
    assert abs(found[0] - path) <= table.error * path
    assert abs(found[1] - impulse) <= table.error * impulse
    # Each of 1024 cuts leaves at most 18 pieces of 33 points.
    assert profile.points <= 1024 * 18 * 33
