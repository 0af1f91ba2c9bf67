"""Accuracy of the quantities of a sweep, from the columns that hold their errors."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from shockwave.base.text import si

# Main quantity of a sweep: the first of these columns that it has; a simulated one, where there is one.
_MAIN = ("amplification", "section4_amplification")
# Columns of simulated quantities, by the column of their relative error estimate.
_ESTIMATES = {
    "peak_force": "error_estimate",
    "amplification": "error_estimate",
    "second_peak_force": "second_error_estimate",
    "greatest_force": "greatest_error",
}


def main_quantity(columns: Sequence[str]) -> str:
    """Name of the main quantity of a sweep with these ``columns`` of numbers."""
    return next((name for name in _MAIN if name in columns), columns[0])


class Accuracy(NamedTuple):
    """Absolute errors of the values, NaN where not known, and a sentence, empty if the column has no error."""

    errors: npt.NDArray[np.float64]
    sentence: str


def accuracy_of(name: str, columns: Collection[str], values_of: Callable[[str], npt.NDArray[Any]]) -> Accuracy:
    """Return the accuracy of the column ``name`` of a sweep with these ``columns``, each with ``values_of``."""
    values = values_of(name)
    unknown = np.full(values.shape, np.nan)
    if not np.isfinite(values).any():
        return Accuracy(unknown, "no point has a value")
    if name == "recoil_momentum" and "recoil_error" in columns:
        errors = values_of("recoil_error")
        return Accuracy(errors, f"error at most {si(np.nanmax(errors, initial=0.0), 'N s', 2)}")
    if (column := _ESTIMATES.get(name, "")) in columns:
        errors = values_of(column)
    elif name in ("peak_force", "amplification") and "low" in columns:
        errors = (values_of("high") - values_of("low")) / 2 / values_of("peak_force")
        if not np.isfinite(errors).any():
            return Accuracy(unknown, "by section 4, error not known")
    else:
        return Accuracy(unknown, "")
    return Accuracy(errors * np.abs(values), f"relative error at most {np.nanmax(errors, initial=0.0):.1e}")
