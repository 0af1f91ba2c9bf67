"""Coefficients against published values, and against what the order asks of them, in exact fractions."""

from __future__ import annotations

from fractions import Fraction
from itertools import accumulate
from math import factorial

import pytest
from shockwave import InvalidValueError

from shockwave_composition.blanes_moan import BlanesMoan4, BlanesMoan6, BlanesMoan6Long
from shockwave_composition.splitting import Shares, Splitting
from shockwave_composition.verlet_richardson import extrapolation

Polynomial = list[Fraction]

every = pytest.mark.parametrize(
    "method", [BlanesMoan4, BlanesMoan6, BlanesMoan6Long], ids=lambda method: method.name
)


@pytest.mark.parametrize(
    ("method", "kicks", "drifts"),
    [
        # The shares in the middle, as in the tables of the n-body code Principia, which took the printed ones
        # from the paper by itself.
        (BlanesMoan4, {3: 0.1195241940131508}, {2: -0.350171622895351, 3: -0.350171622895351}),
        (BlanesMoan6, {5: 0.2366699247869311, 6: 0.2366699247869311}, {5: 0.20477705429147}),
        (BlanesMoan6Long, {7: -0.19641146648645423, 8: -0.19641146648645423}, {7: 0.2073050690568954}),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_shares_in_the_middle_are_the_published_ones(
    method: type[Splitting], kicks: dict[int, float], drifts: dict[int, float]
) -> None:
    # theirs are rounded to 16 digits
    assert {i: float(method.shares.kicks[i]) for i in kicks} == pytest.approx(kicks, rel=0, abs=2e-16)
    assert {i: float(method.shares.drifts[i]) for i in drifts} == pytest.approx(drifts, rel=0, abs=2e-16)


@every
def test_shares_sum_to_the_step_exactly(method: type[Splitting]) -> None:
    assert (sum(method.shares.kicks), sum(method.shares.drifts)) == (1, 1)


@every
def test_a_method_is_its_own_mirror_image(method: type[Splitting]) -> None:
    assert method.shares.kicks == method.shares.kicks[::-1]
    assert method.shares.drifts == method.shares.drifts[::-1]


def _oscillator(shares: Shares) -> tuple[tuple[Polynomial, Polynomial], tuple[Polynomial, Polynomial]]:
    """The step for x'' = -x as polynomials in h: what (1, 0) and (0, 1) become, as pairs of x and v."""

    def add(one: Polynomial, share: Fraction, other: Polynomial) -> Polynomial:
        # one + share h other
        moved = [Fraction(0), *(share * number for number in other)]
        longer = max(len(one), len(moved))
        padded = ([*part, *[Fraction(0)] * (longer - len(part))] for part in (one, moved))
        return [sum(pair, Fraction(0)) for pair in zip(*padded, strict=True)]

    ends = []
    for x, v in (([Fraction(1)], [Fraction(0)]), ([Fraction(0)], [Fraction(1)])):
        v = add(v, -shares.kicks[0], x)
        for drift, kick in zip(shares.drifts, shares.kicks[1:], strict=True):
            x = add(x, drift, v)
            v = add(v, -kick, x)
        ends.append((x, v))
    return ends[0], ends[1]


def _off_rotation(method: type[Splitting], power: int) -> float:
    """The greatest coefficient of h to the ``power`` by which the oscillator's step misses its rotation."""
    (xx, vx), (xv, vv) = _oscillator(method.shares)
    # x = cos h, v = -sin h from (1, 0); x = sin h, v = cos h from (0, 1)
    sign = Fraction((-1) ** (power // 2), factorial(power))
    cosine, sine = (sign, Fraction(0)) if power % 2 == 0 else (Fraction(0), sign)
    found = (xx[power] - cosine, vv[power] - cosine, vx[power] + sine, xv[power] - sine)
    return float(max(map(abs, found)))


@every
def test_the_oscillator_is_met_up_to_the_order(method: type[Splitting]) -> None:
    # the paper prints 15 decimals
    assert max(_off_rotation(method, power) for power in range(method.order + 1)) < 2e-15


@every
def test_the_oscillator_is_missed_beyond_the_order(method: type[Splitting]) -> None:
    assert _off_rotation(method, method.order + 1) > 1e-8


@every
def test_powers_of_the_time_are_integrated_up_to_the_order(method: type[Splitting]) -> None:
    # Kicks alone are a quadrature on the nodes: x'' = t^k.
    nodes = (Fraction(0), *accumulate(method.shares.drifts))
    for power in range(method.order):
        found = sum(b * c**power for b, c in zip(method.shares.kicks, nodes, strict=True))
        assert abs(found - Fraction(1, power + 1)) < Fraction(2, 10**15)


@pytest.mark.parametrize("counts", [(1, 2, 3, 4), (2, 3, 4), (1, 2, 4, 8, 16)], ids=str)
def test_extrapolation_leaves_the_constant_of_a_polynomial_in_the_square(counts: tuple[int, ...]) -> None:
    weights = extrapolation(counts)
    for power in range(len(counts)):
        found = sum(weight * Fraction(1, n ** (2 * power)) for weight, n in zip(weights, counts, strict=True))
        assert found == (power == 0)


def test_two_results_extrapolate_as_richardson_has_it() -> None:
    assert extrapolation((1, 2)) == (Fraction(-1, 3), Fraction(4, 3))


HALF = Fraction(1, 2)


@pytest.mark.parametrize(
    ("kicks", "drifts", "message"),
    [
        ((HALF, HALF), (HALF, HALF), r"kicks: must be one more than the drifts \(got 2 kicks, 2 drifts; "),
        ((HALF, HALF + HALF), (Fraction(1),), r"kicks: must sum to 1 exactly \(got 3/2\)"),
        ((HALF, HALF), (HALF,), r"drifts: must sum to 1 exactly \(got 1/2\)"),
        ((HALF, 0 * HALF, HALF), (3 * HALF, -HALF), r"drifts: must end within the step \(got 1.5 of it\)"),
    ],
    ids=["number", "kicks", "drifts", "outside"],
)
def test_shares_that_make_no_step_are_refused(
    kicks: tuple[Fraction, ...], drifts: tuple[Fraction, ...], message: str
) -> None:
    with pytest.raises(InvalidValueError, match=message):
        Shares(kicks, drifts)


def test_a_share_left_out_is_refused() -> None:
    with pytest.raises(InvalidValueError, match=r"drifts: must be 2 numbers for 6 in all \(got 1\)"):
        Shares.mirrored(stages=6, kicks="0.1 0.2 0.3", drifts="0.2")


def test_verlet_is_the_shortest_mirror_image() -> None:
    shares = Shares.mirrored(stages=1, kicks="", drifts="")
    assert (shares.kicks, shares.drifts) == ((HALF, HALF), (1,))
