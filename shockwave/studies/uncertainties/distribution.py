"""Distributions of the values of a scene, kept within what the values may be."""

from __future__ import annotations

import math

import numpy as np
from attrs import frozen

from shockwave.errors import InvalidValueError
from shockwave.quadrature import FloatArray
from shockwave.scenario.uncertainty import Spread
from shockwave.scenario.yaml_document import dotted

__all__ = ["Distribution"]

# Draws keep this relative distance from a bound that is excluded.
_INSIDE = 1e-9


@frozen
class Distribution:
    """A distribution by its inverse: normal or lognormal about the value of the scene, or uniform.

    What it has beyond the range of the value is cut off, and the rest scaled up.

    Attributes
    ----------
    spread : Spread
        What was said of the value.
    low, high : float
        Least and greatest probability of the distribution as it was before the cut.
    begin, end : float
        The range of the value.
    centre, scale : float
        Mean and standard deviation of the normal one, of the logarithm for ``factor``; for ``between`` begin and width.
    """

    spread: Spread
    low: float
    high: float
    begin: float
    end: float
    centre: float
    scale: float

    @classmethod
    def of(cls, spread: Spread, value: float) -> Distribution:
        """The distribution about ``value``.

        Raises
        ------
        InvalidValueError
            When a share of the value is asked for that is 0, or a factor of one that is not above 0.
        """
        from scipy.special import ndtr

        begin, end = _range(spread)
        first = spread.numbers[0]
        if spread.kind == "between":
            return cls(spread, 0.0, 1.0, first, spread.numbers[1], first, spread.numbers[1] - first)
        if spread.kind == "factor":
            if not value > 0:
                raise _unfit(spread, value, "a factor")
            centre, scale = math.log(value), math.log(first)
            bounds = (math.log(bound) if bound > 0 else -math.inf for bound in (begin, end))
            low, high = (float(ndtr((bound - centre) / scale)) for bound in bounds)
            return cls(spread, low, high, begin, end, centre, scale)
        if spread.kind == "relative" and value == 0:
            raise _unfit(spread, value, "a percentage")
        scale = first * abs(value) if spread.kind == "relative" else first
        low, high = (float(ndtr((bound - value) / scale)) for bound in (begin, end))
        return cls(spread, low, high, begin, end, value, scale)

    @property
    def cut(self) -> float:
        """The share that lay beyond the range."""
        return 1 - (self.high - self.low)

    def at(self, shares: FloatArray) -> FloatArray:
        """The values below which these shares of the distribution lie, each above 0 and below 1."""
        from scipy.special import ndtri

        if self.spread.kind == "between":
            return self.centre + self.scale * shares
        normal = self.centre + self.scale * ndtri(self.low + shares * (self.high - self.low))
        values = np.exp(normal) if self.spread.kind == "factor" else normal
        return np.asarray(np.clip(values, self.begin, self.end))

    @property
    def bounds(self) -> tuple[float, float]:
        """What the value may be at least and at most, drawn or not."""
        return _range(self.spread)

    @property
    def sd(self) -> float:
        """Standard deviation, after the cut."""
        # by the midpoint rule in the share, which the tails of a normal distribution leave right to four digits
        count = 100_000
        return float(np.std(self.at((np.arange(count) + 0.5) / count)))


def _range(spread: Spread) -> tuple[float, float]:
    """What the value may be at least and at most; just inside a bound that is excluded."""
    spec = spread.variable.key.spec
    assert spec is not None  # a spread is of a number
    begin = spec.at_least if spec.at_least is not None else -math.inf
    end = spec.at_most if spec.at_most is not None else math.inf
    if spec.above is not None:
        begin = spec.above + _INSIDE * max(abs(spec.above), 1e-3 * _INSIDE)
    if spec.below is not None:
        end = spec.below - _INSIDE * abs(spec.below)
    return begin, end


def _unfit(spread: Spread, value: float, what: str) -> InvalidValueError:
    problem = f"must be {{sd: ...}} or {{between: ...}}, as the value is {value:g} (got {what} of it)"
    return InvalidValueError.of(dotted(("uncertainty", spread.name)), problem)
