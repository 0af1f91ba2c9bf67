"""Accuracy of the quantities of a sweep, from the columns that hold their errors."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from shockwave.text import si

# Main quantity of a sweep: the first of these columns that it has; a simulated one, where there is one.
_MAIN = ("amplification", "section4_amplification")
# Columns of simulated quantities, by the column of their error estimate: relative, but absolute for a momentum.
_ESTIMATES = {
    "peak_force": "error_estimate",
    "amplification": "error_estimate",
    "second_peak_force": "second_error_estimate",
    "recoil_momentum": "recoil_error",
    "greatest_force": "greatest_error",
}


def main_quantity(columns: Sequence[str]) -> str:
    """Name of the main quantity of a sweep with these ``columns`` of numbers."""
    return next((name for name in _MAIN if name in columns), columns[0])


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
    if name in ("peak_force", "amplification") and "low" in columns:
        error = (values_of("high") - values_of("low")) / 2 / values_of("peak_force")
        if not np.isfinite(error).any():
            return Accuracy(low, high, "", "by section 4, error not known")
        sentence = f"relative error at most {np.nanmax(error):.1e}"
        return Accuracy(values * (1 - error), values * (1 + error), "error estimate", sentence)
    return Accuracy(low, high, "", "")
