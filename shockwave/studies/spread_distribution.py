"""Distributions of the values of a scene, truncated to the range of the value."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from attrs import frozen

from shockwave.errors import InvalidValueError
from shockwave.quadrature import FloatArray
from shockwave.scenario.uncertainty import Spread
from shockwave.scenario.yaml_document import dotted

# Draws keep this relative distance from a bound that is excluded.
_INSIDE = 1e-9


@frozen
class Distribution:
    """A truncated normal or lognormal distribution about the value of the scene, or a uniform one.

    Attributes
    ----------
    spread : Spread
        As it was given.
    begin, end : float
        The range of the value; just inside a bound that is excluded.
    of_value : object
        Frozen distribution of SciPy; for a ``factor`` that of the logarithm.
    cut : float
        Share of the distribution that lay outside the range.
    """

    spread: Spread
    begin: float
    end: float
    of_value: Any
    cut: float

    @classmethod
    def of(cls, spread: Spread, value: float) -> Distribution:
        """The distribution about ``value``.

        Raises
        ------
        InvalidValueError
            When a share of the value is asked for that is 0, or a factor of one that is not above 0.
        """
        from scipy.stats import norm, truncnorm, uniform

        begin, end = _range(spread)
        first = spread.numbers[0]
        if spread.kind == "between":
            return cls(spread, begin, end, uniform(first, spread.numbers[1] - first), 0.0)
        if (spread.kind == "factor" and not value > 0) or (spread.kind == "relative" and value == 0):
            got = f"got a {'factor' if spread.kind == 'factor' else 'percentage'} of it"
            problem = f"must be {{sd: ...}} or {{between: ...}}, as the value is {value:g} ({got})"
            raise InvalidValueError.of(dotted(("uncertainty", spread.name)), problem)
        centre, bounds = value, [begin, end]
        scale = first * abs(value) if spread.kind == "relative" else first
        if spread.kind == "factor":
            centre, scale = math.log(value), math.log(first)
            bounds = [math.log(bound) if bound > 0 else -math.inf for bound in bounds]
        low, high = ((bound - centre) / scale for bound in bounds)
        cut = float(norm.cdf(low) + norm.sf(high))
        return cls(spread, begin, end, truncnorm(low, high, centre, scale), cut)

    def at(self, shares: FloatArray) -> FloatArray:
        """The values below which these shares of the distribution lie, each above 0 and below 1."""
        values = self.of_value.ppf(shares)
        if self.spread.kind == "factor":
            values = np.exp(values)
        return np.asarray(np.clip(values, self.begin, self.end))

    @property
    def sd(self) -> float:
        """Standard deviation of the truncated distribution."""
        if self.spread.kind != "factor":
            return float(self.of_value.std())
        # by the midpoint rule in the share, which the tails of a normal distribution leave right to four digits
        count = 100_000
        return float(np.std(self.at((np.arange(count) + 0.5) / count)))


def _range(spread: Spread) -> tuple[float, float]:
    spec = spread.variable.key.spec
    assert spec is not None  # a spread is of a number
    begin = spec.at_least if spec.at_least is not None else -math.inf
    end = spec.at_most if spec.at_most is not None else math.inf
    if spec.above is not None:
        begin = spec.above + _INSIDE * max(abs(spec.above), 1e-3 * _INSIDE)
    if spec.below is not None:
        end = spec.below - _INSIDE * abs(spec.below)
    return begin, end
