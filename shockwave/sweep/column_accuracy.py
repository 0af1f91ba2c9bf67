"""Accuracy of the quantities of a sweep, from the columns that hold their errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from shockwave.base.numerics import FloatArray
from shockwave.base.quantities import errors_of, unit_of
from shockwave.base.text import si

# Main quantity of a sweep: the first of these columns that it has; a simulated one, where there is one.
_MAIN = ("amplification", "section4_amplification")


def main_quantity(columns: Sequence[str]) -> str:
    """Name of the main quantity of a sweep with these ``columns`` of numbers."""
    return next((name for name in _MAIN if name in columns), columns[0])


class Accuracy(NamedTuple):
    """Absolute errors of the values, NaN where not known, and a sentence, empty if the column has no error."""

    errors: FloatArray
    sentence: str


def accuracy_of(name: str, units: Mapping[str, str | None], values_of: Callable[[str], FloatArray]) -> Accuracy:
    """Return the accuracy of the column ``name`` of a sweep, whose columns have these ``units`` and ``values_of``."""
    values = values_of(name)
    unknown = np.full(values.shape, np.nan)
    if not np.isfinite(values).any():
        return Accuracy(unknown, "no point has a value")
    columns = [next((each for each in errors_of(part) if each in units), "") for part in name.split(" / ")]
    column = columns[0]
    if not all(columns):
        return Accuracy(unknown, "")
    errors = np.sum([values_of(each) for each in columns], axis=0)
    if column == "low":
        errors = (values_of("high") - errors) / 2 / values_of("peak_force")
        if not np.isfinite(errors).any():
            return Accuracy(unknown, "by section 4, error not known")
    elif unit := unit_of(column):
        return Accuracy(errors, f"error at most {si(np.nanmax(errors, initial=0.0), unit, 2)}")
    return Accuracy(errors * np.abs(values), f"relative error at most {np.nanmax(errors, initial=0.0):.1e}")
