"""Accuracy of the quantities of a sweep, from the columns that hold their errors."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from shockwave.text import si

# Main quantity of a sweep: the first of these columns that it has; a simulated one, where there is one.
_MAIN = ("amplification", "predicted_amplification")
_ESTIMATE = "estimate_amplification"
# Columns of simulated quantities, by the column of their error estimate: relative, but absolute for a momentum.
_ESTIMATES = {
    "peak_force": "error_estimate",
    "amplification": "error_estimate",
    "second_peak_force": "second_error_estimate",
    "recoil_momentum": "recoil_error",
    "greatest_force": "greatest_error",
}
# Columns of predicted quantities, after a prefix, that have an expected error.
_EXPECTED = ("peak_force", "amplification")
# Least ratio of prediction and simulation: an expected error of -100 % has no upper bound.
_LEAST_RATIO = 1e-3


def main_quantity(columns: Sequence[str]) -> str:
    """Name of the main quantity of a sweep with these ``columns`` of numbers."""
    simulated = "error_estimate" in columns
    names = _MAIN if simulated else (_ESTIMATE, *_MAIN)
    return next((name for name in names if name in columns), columns[0])


class Accuracy(NamedTuple):
    """Bounds of the true values, NaN where not known; their name; and a sentence, empty if the column has no error."""

    low: npt.NDArray[np.float64]
    high: npt.NDArray[np.float64]
    bounds: str
    sentence: str


def accuracy_of(name: str, columns: Collection[str], values_of: Callable[[str], npt.NDArray[Any]]) -> Accuracy:
    """Return the accuracy of the column ``name`` of a sweep with these ``columns``, each with ``values_of``."""
    values = values_of(name)
    low = high = np.full(values.shape, np.nan)
    if not np.isfinite(values).any():
        return Accuracy(low, high, "", "no point has a value")
    if (column := _ESTIMATES.get(name, "")) in columns:
        error = values_of(column)
        most = np.nanmax(error, initial=0.0)
        sentence = f"error at most {si(most, 'N s', 2)}"
        if column != "recoil_error":
            sentence, error = f"relative error at most {most:.1e}", error * np.abs(values)
        return Accuracy(values - error, values + error, "error estimate", sentence)
    if name in ("estimate", _ESTIMATE) and "estimate_low" in columns:
        low, high = (values_of(f"estimate_{side}") / values_of("estimate") for side in ("low", "high"))
        sentence = f"estimated, range of at most +-{max(1 - np.nanmin(low), np.nanmax(high) - 1):.1%}"
        return Accuracy(values * low, values * high, "range of the estimate", sentence)
    prefix = "predicted_" if name.startswith("predicted_") else ""
    sides = [f"{prefix}expected_error_{side}" for side in ("low", "high")]
    if name.removeprefix(prefix) not in _EXPECTED or sides[0] not in columns:
        return Accuracy(low, high, "", "")
    low, high = map(values_of, sides)
    sentence = "predicted, error not known"
    if (known := np.isfinite(low)).any():
        sentence = f"predicted, expected error {np.nanmin(low):+.1%} to {np.nanmax(high):+.1%}"
        if not known.all():
            sentence += f", known at {known.mean():.0%} of the points"
    ratio = np.maximum(1 + low, _LEAST_RATIO)
    return Accuracy(values / (1 + high), values / ratio, "expected range of a simulation", sentence)
