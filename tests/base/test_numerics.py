"""The bracketed root, Newton's method, and running sums."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shockwave.base.errors import NumericalError
from shockwave.base.numerics import bracketed_root, newton_root, running_sums

#: Name -> function, bracket, root.
CASES: dict[str, tuple[Callable[[float], float], float, float, float]] = {
    "falling": (lambda x: 1 - x**2, 0.0, 5.0, 1.0),
    "steep": (lambda x: math.exp(x) - 1e300, 0.0, 700.0, 300 * math.log(10)),
    "sixth-power": (lambda x: x**-6 - 2, 1e-3, 1e3, 2 ** (-1 / 6)),
    "multiple": (lambda x: (x - 1) ** 9, -1.0, 4.0, 1.0),
    "wide": (math.log, 1e-300, 1e300, 1.0),
    "jump": (lambda x: math.copysign(1.0, x - 0.3), -1.0, 1e6, 0.3),
    "infinite-end": (lambda x: math.inf if x > 9 else x - 1.25, 0.0, 10.0, 1.25),
    "lower-end": (lambda x: x - 2.0, 2.0, 9.0, 2.0),
}


@pytest.mark.parametrize("name", CASES)
def test_the_root_is_found_to_the_last_digits_with_bounded_work_within_the_bracket(name: str) -> None:
    function, lower, upper, root = CASES[name]
    taken: list[float] = []
    found = bracketed_root(lambda x: taken.append(x) or function(x), lower, upper, "x")  # type: ignore[func-returns-value]
    # A few units in the last place: the functions round as well.
    assert found == pytest.approx(root, rel=1e-15, abs=0)
    assert lower <= min(taken) <= max(taken) <= upper
    # 200 steps and both ends.
    assert len(taken) <= 202


@settings(derandomize=True, deadline=None)
@given(
    # a root within 1e-12 of zero is zero: bisection takes more than the 200 steps to 1e-280
    root=st.floats(-1e6, 1e6).map(lambda x: round(x, 12)),
    below=st.floats(1e-3, 1e9),
    above=st.floats(1e-3, 1e9),
    power=st.sampled_from([1, 3]),
)
def test_the_root_does_not_depend_on_the_bracket(root: float, below: float, above: float, power: int) -> None:
    found = bracketed_root(lambda x: (x - root) ** power + (x - root), root - below, root + above, "x")
    # x - root is exact near the root.
    assert found == pytest.approx(root, rel=1e-15, abs=1e-300)


def test_without_a_change_of_sign_the_quantity_is_named() -> None:
    with pytest.raises(NumericalError, match=r"^time of a wave: no change of sign between 0 and 2$"):
        bracketed_root(lambda x: 1 + x, 0.0, 2.0, "time of a wave")


def test_a_bracket_that_does_not_close_is_an_error() -> None:
    # A triple root at zero: the bracket shrinks, its width relative to its ends does not.
    with pytest.raises(NumericalError, match=r"^root: not found in 200 steps between "):
        bracketed_root(lambda x: x**3, -1.0, 2.0, "root")


# ---------------------------------------------------------------- Newton's method

#: Name -> value and derivative with respect to ln x, root.
INCREASING: dict[str, tuple[Callable[[float], tuple[float, float]], float]] = {
    "power": (lambda x: (math.log(x) - 2.0, 1.0), math.exp(2.0)),
    "cube": (lambda x: (x**3 - 10.0, 3 * x**3), 10 ** (1 / 3)),
    "infinite-below": (lambda x: (-math.inf, 1.0) if x < 1 else (x - 3.0, x), 3.0),
    "kink": (lambda x: (x - 5.0, x) if x > 4 else (100 * (x - 4.01), 100 * x), 5.0),
}


@pytest.mark.parametrize("guess", [0.0, 4.0, 1e9])
@pytest.mark.parametrize("name", INCREASING)
def test_newtons_method_finds_the_root_from_any_guess(name: str, guess: float) -> None:
    function, root = INCREASING[name]
    # some roundings
    assert newton_root(function, 1e-3, 1e3, guess, "x") == pytest.approx(root, rel=4e-15, abs=0)


@pytest.mark.parametrize("root", [0.9e-3, 1.1e3])
@pytest.mark.parametrize("guess", [0.0, 1.0, 1e9])
def test_newtons_method_refuses_a_bracket_without_a_root(root: float, guess: float) -> None:
    with pytest.raises(NumericalError, match=r"^time of a wave: no change of sign between 0\.001 and 1000$"):
        newton_root(lambda x: (x - root, x), 1e-3, 1e3, guess, "time of a wave")


@pytest.mark.parametrize("place", [0, 500, 1000])
def test_running_sums_keep_terms_below_the_rounding_of_the_sum(place: int) -> None:
    terms = np.insert(np.full(1000, 1e-17), place, 1.0)
    sums = running_sums(terms)
    assert sums[place + 1 :] == pytest.approx(1 + 1e-17 * np.arange(place, 1001), rel=2e-16, abs=0)  # of a rounding
    assert sums[: place + 1] == pytest.approx(1e-17 * np.arange(place + 1), rel=1e-13, abs=0)
