"""The conditions (3) with their margins."""

from __future__ import annotations

from typing import Any

import pytest

from shockwave.profiles.area_conditions import evaluate_conditions
from shockwave.profiles.exponential import Exponential
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.quadrature import Integral
from shockwave.profiles.shock_profile import Areas, ShockProfile
from shockwave.profiles.tabulated import Tabulated
from shockwave.profiles.triangular import Triangular
from support.profile_references import sine

NAMES = ("decay-outweighs-rise", "steep-rise", "slow-decay")


def _power(n: float, rise: float, decay: float) -> PowerLaw:
    return PowerLaw(rise_exponent=rise, decay_exponent=decay, duration_ratio=n)


def _checked(profile: ShockProfile, quadrature: str | None = None) -> tuple[Any, ...]:
    return evaluate_conditions(profile.areas(quadrature), profile.duration_ratio)


# ---------------------------------------------------------------- margins


def test_each_condition_states_its_inequality() -> None:
    statements = [(condition.name, condition.statement) for condition in _checked(Triangular(duration_ratio=2))]
    assert statements == list(zip(NAMES, ["a2 >= a1", "a1 >= 1/2", "a2 <= (n-1)/2"], strict=True))


def test_an_inequality_holds_within_the_error_of_the_areas() -> None:
    decay = Integral(0.6, 0.0, 1, "exact")
    for error, holds in ((1e-6, True), (1e-7, False)):
        _, steep, _ = evaluate_conditions(Areas(Integral(0.5 - 5e-7, error, 1, "exact"), decay), 3.0)
        assert steep.holds == holds


@pytest.mark.parametrize("quadrature", [None, "gauss-legendre", "tanh-sinh", "quadpack"])
@pytest.mark.parametrize("index", range(3), ids=NAMES)
def test_equality_is_inclusive(index: int, quadrature: str | None) -> None:
    # (2, 1, 1) of Table 2 meets all three with equality.
    condition = _checked(_power(2, 1, 1), quadrature)[index]
    assert condition.margin == 0  # rounding errors do not give it a sign
    assert condition.holds


#: Rows of Tables 1 and 2: n and exponents, with the margins of some.
ROWS: dict[tuple[float, float, float], tuple[float, ...] | None] = {
    (10, 1, 5): None,
    (6, 0.5, 6): None,
    (4, 0.25, 1): None,
    (3, 0.5, 1): (1 - 2 / 3, 1 / 6, 0),
    (4, 1e-5, 1): (1.5 - 1 / 1.00001, 1 / 1.00001 - 0.5, 0),
}


@pytest.mark.parametrize(("row", "margins"), ROWS.items(), ids=map(str, ROWS))
def test_every_row_of_the_paper_satisfies_all_conditions(
    row: tuple[float, ...], margins: tuple[float, ...] | None
) -> None:
    found = _checked(_power(*row))
    assert all(condition.holds for condition in found)
    if margins is not None:
        # Differences of closed forms of order 1.
        assert [condition.margin for condition in found] == pytest.approx(margins, abs=1e-15)


BROKEN = {
    "haversine": (sine(2), set()),
    "half-sine": (sine(1), {"slow-decay"}),
    "rectangular": (_power(2, 0, 0), {"slow-decay"}),
    "spike": (_power(10, 1, 200), {"decay-outweighs-rise"}),
    "parabolic-rise": (_power(3, 2, 1), {"steep-rise"}),
    "late-pulse": (_power(10, 3, 0.5), {"steep-rise", "slow-decay"}),
    "exponential": (Exponential(rise_rate=2, decay_rate=1, duration_ratio=4), set()),
    "initial-peak-sawtooth": (Tabulated([0, 0.01, 5], [0, 1, 0]), set()),
}


@pytest.mark.parametrize(("profile", "broken"), BROKEN.values(), ids=BROKEN)
def test_conditions_that_a_pulse_violates(profile: ShockProfile, broken: set[str]) -> None:
    assert {condition.name for condition in _checked(profile) if not condition.holds} == broken


@pytest.mark.parametrize(("below", "holds"), [(0.9e-9, True), (1.1e-9, False)], ids=["within", "beyond"])
@pytest.mark.parametrize("n", [1.5, 2.0, 1000.0])
def test_the_tolerance_is_1e_minus_9_of_the_duration(n: float, below: float, holds: bool) -> None:
    exact = Integral(0.5 - below * n, 0.0, 0, "closed form")
    areas = Areas(rise=exact, decay=Integral(n / 2, 0.0, 0, "closed form"))
    assert evaluate_conditions(areas, n)[1].holds is holds
