"""Distributions of the values of a scene, truncated to the range of the value."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np
from attrs import frozen

from shockwave.errors import InvalidValueError
from shockwave.quadrature import FloatArray
from shockwave.scenario.uncertainty import Spread
from shockwave.scenario.yaml_document import dotted

__all__ = ["Distribution"]

# Draws keep this relative distance from a bound that is excluded.
_INSIDE = 1e-9


@frozen(slots=False)
class Distribution:
    """A truncated normal or lognormal distribution about the value of the scene, or a uniform one.

    Attributes
    ----------
    spread : Spread
        As it was given.
    value : float
        Of the scene.
    begin, end : float
        The range of the value; just inside a bound that is excluded.
    """

    spread: Spread
    value: float
    begin: float
    end: float

    @classmethod
    def of(cls, spread: Spread, value: float) -> Distribution:
        """The distribution about ``value``.

        Raises
        ------
        InvalidValueError
            When a share of the value is asked for that is 0, or a factor of one that is not above 0.
        """
        if spread.kind == "factor" and not value > 0:
            raise _unfit(spread, value, "a factor")
        if spread.kind == "relative" and value == 0:
            raise _unfit(spread, value, "a percentage")
        spec = spread.variable.key.spec
        assert spec is not None  # a spread is of a number
        begin = spec.at_least if spec.at_least is not None else -math.inf
        end = spec.at_most if spec.at_most is not None else math.inf
        if spec.above is not None:
            begin = spec.above + _INSIDE * max(abs(spec.above), 1e-3 * _INSIDE)
        if spec.below is not None:
            end = spec.below - _INSIDE * abs(spec.below)
        return cls(spread, value, begin, end)

    @cached_property
    def _scipy(self) -> Any:
        """Of the value; for ``factor`` of its logarithm."""
        from scipy.stats import truncnorm, uniform

        first = self.spread.numbers[0]
        if self.spread.kind == "between":
            return uniform(first, self.spread.numbers[1] - first)
        centre, scale, begin, end = self.value, first, self.begin, self.end
        if self.spread.kind == "relative":
            scale = first * abs(self.value)
        if self.spread.kind == "factor":
            centre, scale = math.log(self.value), math.log(first)
            begin, end = (math.log(bound) if bound > 0 else -math.inf for bound in (begin, end))
        return truncnorm((begin - centre) / scale, (end - centre) / scale, centre, scale)

    @property
    def cut(self) -> float:
        """The share that lay beyond the range."""
        from scipy.stats import norm

        if self.spread.kind == "between":
            return 0.0
        low, high = self._scipy.args[:2]
        return float(norm.cdf(low) + norm.sf(high))

    def at(self, shares: FloatArray) -> FloatArray:
        """The values below which these shares of the distribution lie, each above 0 and below 1."""
        values = self._scipy.ppf(shares)
        if self.spread.kind == "between":
            return np.asarray(values)
        values = np.exp(values) if self.spread.kind == "factor" else values
        return np.asarray(np.clip(values, self.begin, self.end))

    @cached_property
    def sd(self) -> float:
        """Standard deviation, after the cut."""
        if self.spread.kind != "factor":
            return float(self._scipy.std())
        # by the midpoint rule in the share, which the tails of a normal distribution leave right to four digits
        count = 100_000
        return float(np.std(self.at((np.arange(count) + 0.5) / count)))


def _unfit(spread: Spread, value: float, what: str) -> InvalidValueError:
    problem = f"must be {{sd: ...}} or {{between: ...}}, as the value is {value:g} (got {what} of it)"
    return InvalidValueError.of(dotted(("uncertainty", spread.name)), problem)
