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
    value : float
        Of the scene.
    begin, end : float
        The range of the value, just inside a bound that is excluded; of a uniform one where it begins and ends.
    of_value : object
        Frozen distribution of SciPy; for a ``factor`` that of the logarithm.
    cut : float
        Share of the distribution that lay outside the range.
    """

    spread: Spread
    value: float
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

        first = spread.numbers[0]
        if spread.kind == "between":
            end = spread.numbers[1]
            return cls(spread, value, first, end, uniform(first, end - first), 0.0)
        if (spread.kind == "factor" and not value > 0) or (spread.kind == "relative" and value == 0):
            problem = f"must be {{sd: ...}} or {{between: ...}}, as the value is {value:g} (got {spread})"
            raise InvalidValueError.of(dotted(("uncertainty", spread.name)), problem)
        begin, end = _range(spread)
        centre = value
        scale = first * abs(value) if spread.kind == "relative" else first
        bounds = np.array([begin, end])
        if spread.kind == "factor":
            centre = math.log(value)
            scale = math.log(first)
            with np.errstate(divide="ignore"):
                bounds = np.log(np.maximum(bounds, 0.0))
        low, high = (bounds - centre) / scale
        cut = float(norm.cdf(low) + norm.sf(high))
        return cls(spread, value, begin, end, truncnorm(low, high, centre, scale), cut)

    @property
    def name(self) -> str:
        """Dotted name of the value."""
        return self.spread.name

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
