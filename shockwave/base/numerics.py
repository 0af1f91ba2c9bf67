"""Root finding, and sums and products whose rounding does not depend on the processor."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from shockwave.base.errors import InvalidValueError, NumericalError, text_of

FloatArray: TypeAlias = npt.NDArray[np.float64]

# Iterations of the root search: bisection alone takes about 60 for a bracket of one power of ten.
_MOST_ITERATIONS = 200
# Steps of Newton's method after which a bisection is made: about six suffice.
_NEWTON_STEPS = 12
# Largest step of Newton's method for ln x; an exponential of more would overflow.
_LARGEST_STEP = 700.0
# Relative step after which the error, which is quadratic in the step, is a rounding error.
_SMALL_STEP = 1e-9


def floats(name: str, values: npt.ArrayLike) -> FloatArray:
    """``values`` of the argument ``name`` as an array; raises `InvalidValueError` if they are not numbers."""
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InvalidValueError.of(name, f"must be a number or an array of numbers (got {text_of(values)})") from None


def bracketed_root(function: Callable[[float], float], lower: float, upper: float, what: str) -> float:
    """Find the root of ``function`` between ``lower`` and ``upper`` to machine precision.

    The method is regula falsi (Illinois variant) with a bisection in every third step. It converges to any root except
    a multiple root at zero. ``what`` names the quantity in error messages.

    Raises
    ------
    NumericalError
        If ``lower`` is not less than ``upper``, the function has the same sign at both, or the bracket has not closed
        after 200 iterations.
    """
    if not lower < upper:
        raise NumericalError(f"{what}: no bracket (got {lower:g} and {upper:g})")
    at_lower, at_upper = function(lower), function(upper)
    if at_lower == 0:
        return lower
    if at_upper == 0:
        return upper
    if (at_lower > 0) == (at_upper > 0):
        raise NumericalError(f"{what}: no change of sign between {lower:g} and {upper:g}")
    for count in range(_MOST_ITERATIONS):
        middle = (lower * at_upper - upper * at_lower) / (at_upper - at_lower)
        # Every third step is a bisection, because regula falsi alone can converge slowly.
        if count % 3 == 2 or not lower < middle < upper:
            # Geometric mean if the bracket spans powers of ten.
            wide = 0 < 4 * lower < upper
            middle = math.sqrt(lower) * math.sqrt(upper) if wide else 0.5 * (lower + upper)
        if middle in (lower, upper):
            return middle
        at_middle = function(middle)
        if at_middle == 0:
            return middle
        if (at_middle > 0) == (at_upper > 0):
            upper, at_upper = middle, at_middle
            at_lower *= 0.5 if count % 3 != 2 else 1.0
        else:
            lower, at_lower = middle, at_middle
            at_upper *= 0.5 if count % 3 != 2 else 1.0
        if upper - lower <= 4e-16 * max(abs(lower), abs(upper)):
            return 0.5 * (lower + upper)
    raise NumericalError(f"{what}: not found in {_MOST_ITERATIONS} steps between {lower:g} and {upper:g}")


def newton_root(
    function: Callable[[float], tuple[float, float]], lower: float, upper: float, guess: float, what: str
) -> float:
    """Find the root of an increasing function between ``lower`` and ``upper``, both above 0, to machine precision.

    The method is Newton's for ln x, with bisections where it leaves the bracket or converges slowly. ``function`` gives
    the value and the derivative with respect to ln x; only next to a jump of the derivative is the relative error 1e-9.
    ``what`` names the quantity in error messages.

    Raises
    ------
    NumericalError
        If the function has no root between both, or the iteration has not converged after 200 steps.
    """
    x, begin, end = min(max(guess, lower), upper), lower, upper
    for count in range(1, _MOST_ITERATIONS):
        value, slope = function(x)
        lower, upper = (lower, x) if value > 0 else (x, upper)
        last, newton = x, x * math.exp(min(-value / slope, _LARGEST_STEP))
        x = newton
        if not lower <= x <= upper or count % _NEWTON_STEPS == 0:
            x = math.sqrt(lower) * math.sqrt(upper)
        if abs(x - last) <= _SMALL_STEP * x:
            # at an end of the bracket, only a small step of Newton's method shows that the root is there
            if (begin < lower and upper < end) or abs(newton - last) <= _SMALL_STEP * last:
                return x
            raise NumericalError(f"{what}: no change of sign between {begin:g} and {end:g}")
    raise NumericalError(f"{what}: not found in {_MOST_ITERATIONS} steps between {lower:g} and {upper:g}")


def product(left: npt.NDArray[np.float64], right: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Matrix product of ``left``, shape (..., m, n), and ``right``, shape (n, p), for small matrices.

    The order of summation is the same on every processor, unlike that of ``@`` and `numpy.einsum`, because a time
    integration amplifies a difference in the last digit.
    """
    return np.asarray(np.add.reduce(left[..., None] * right, axis=-2))


def running_sums(terms: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Sums of the first 0, 1, 2, ... ``terms``, shape (k + 1,), to machine precision by Knuth's two-sum."""
    sums = np.concatenate(([0.0], np.cumsum(terms)))
    before, after = sums[:-1], sums[1:]
    added = after - before
    lost = (before - (after - added)) + (terms - added)
    after += np.cumsum(lost)
    return sums


def elementwise(function: Callable[[float], float], values: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Apply ``function``, from the module `math`, to each element of ``values``; same shape.

    The last digits of NumPy's exponentials and powers depend on the vector instructions of the processor.
    """
    array = np.asarray(values)
    return np.fromiter(map(function, array.ravel().tolist()), float, array.size).reshape(array.shape)
