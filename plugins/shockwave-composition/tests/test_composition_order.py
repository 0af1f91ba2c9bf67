"""Order of the error on an ellipse of Kepler's, in arithmetic of 40 digits, and of the estimate."""

from __future__ import annotations

import functools
from typing import Any

import mpmath
import numpy as np
import pytest
from shockwave.hooks import Attempt, OneStep

from shockwave_composition.blanes_moan import BlanesMoan4, BlanesMoan6, BlanesMoan6Long
from shockwave_composition.splitting import Shares, Splitting
from shockwave_composition.verlet_richardson import VerletRichardson

SPAN, ECCENTRICITY = 3, mpmath.mpf("0.3")


class Pefrl(Splitting):
    """Position-extended Forest-Ruth-like method of Omelyan, Mryglod & Folk (2002), order 4."""

    shares = Shares.mirrored(
        stages=4,
        kicks="0.7123418310626054",
        drifts="0.1786178958448091 -0.06626458266981849",
        drift_first=True,
    )


def _array(*numbers: Any) -> np.ndarray:
    return np.array(numbers, dtype=object)


def _gravity(_: Any, x: np.ndarray) -> np.ndarray:
    return -x / mpmath.sqrt(x[0] ** 2 + x[1] ** 2) ** 3


def _ellipse(time: Any) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity on an ellipse of semi-major axis 1 since perihelion, by Kepler's equation."""
    e = ECCENTRICITY
    angle = mpmath.findroot(lambda angle: angle - e * mpmath.sin(angle) - time, time)
    minor, rate = mpmath.sqrt(1 - e**2), 1 / (1 - e * mpmath.cos(angle))
    x = _array(mpmath.cos(angle) - e, minor * mpmath.sin(angle))
    return x, _array(-mpmath.sin(angle) * rate, minor * mpmath.cos(angle) * rate)


def _off(attempt: Attempt, time: Any) -> Any:
    return max(map(abs, np.subtract(attempt[:2], _ellipse(time)).ravel()))


@functools.cache
def _error(method: type[OneStep], count: int) -> Any:
    """Error at the end after so many equal steps."""
    (x, v), size = _ellipse(mpmath.mpf(0)), mpmath.mpf(SPAN) / count
    tried = Attempt(x, v, _gravity(0, x), 0.0)
    for index in range(count):
        tried = method().attempt(_gravity, index * size, size, *tried[:3])
    return _off(tried, mpmath.mpf(SPAN))


# Of blanes-moan-4 the term of order 4 is so small that at longer steps that of order 6 hides it.
@pytest.mark.parametrize(
    ("method", "count"),
    [(BlanesMoan4, 256), (BlanesMoan6, 48), (BlanesMoan6Long, 32), (VerletRichardson, 32)],
    ids=lambda value: getattr(value, "name", ""),
)
def test_halved_steps_show_the_declared_order(method: type[OneStep], count: int) -> None:
    with mpmath.workdps(40):
        coarse, fine = _error(method, count), _error(method, 2 * count)
        # far above what the last of 15 printed decimals leaves, about 1e-15
        assert fine > 1e-13
        # what the next term adds, two orders higher
        assert float(mpmath.log(coarse / fine, 2)) == pytest.approx(method.order, abs=0.1)


def _estimated(size: Any) -> Attempt:
    x, v = _ellipse(mpmath.mpf(0))
    return VerletRichardson().attempt(_gravity, mpmath.mpf(0), size, x, v, _gravity(0, x))


def test_the_estimate_shows_the_order_of_the_shorter_extrapolation() -> None:
    with mpmath.workdps(40):
        coarse, fine = (_estimated(mpmath.mpf(size)).error for size in ("0.01", "0.005"))
        slope = float(mpmath.log(coarse / fine, 2))
    # at such steps the next order adds a thousandth; weights in double precision add less
    assert slope == pytest.approx(VerletRichardson.error_order + 1, abs=0.01)


@pytest.mark.parametrize("size", ["0.05", "0.2", "0.4"])
def test_the_estimate_exceeds_the_error(size: str) -> None:
    with mpmath.workdps(40):
        tried = _estimated(mpmath.mpf(size))
        error = _off(tried, mpmath.mpf(size))
        assert error < tried.error


def test_the_same_evaluations_leave_less_error_than_pefrl() -> None:
    with mpmath.workdps(40):
        # 300 evaluations, six a step or five
        assert _error(BlanesMoan4, 50) < _error(Pefrl, 60) / 100


def test_the_same_evaluations_leave_less_error_at_order_6_than_at_order_4() -> None:
    with mpmath.workdps(40):
        # 990 evaluations, eleven a step or six
        assert _error(BlanesMoan6, 90) < _error(BlanesMoan4, 165) / 5
