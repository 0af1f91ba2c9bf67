"""Splitting methods, which alternate kicks and drifts, and their coefficients."""

from __future__ import annotations

from fractions import Fraction
from itertools import accumulate
from typing import ClassVar, Self

from attrs import define, field, frozen
from shockwave import InvalidValueError
from shockwave.hooks import Acceleration, Attempt, FloatArray, OneStep

__all__ = ["Shares", "Splitting"]


@frozen
class Shares:
    """Division of a step into kicks and drifts: a kick, then alternately a drift and a kick.

    Attributes
    ----------
    kicks : tuple of Fraction, shape (drifts + 1,)
        Fractions of the step in which velocities change at fixed positions; the first uses the acceleration
        at the beginning, the last that at the end. Their sum is 1.
    drifts : tuple of Fraction
        Fractions of the step in which positions change at fixed velocities. Their sum is 1.
    nodes : tuple of Fraction
        Time at which each drift ends, in units of the step; from 0 to 1.
    turns : tuple of (float, float, float)
        Each drift, its node and the kick there, as floats.

    Raises
    ------
    InvalidValueError
        If the numbers do not match, a sum is not 1, or a drift ends outside the step.
    """

    kicks: tuple[Fraction, ...]
    drifts: tuple[Fraction, ...]
    nodes: tuple[Fraction, ...] = field(init=False)
    turns: tuple[tuple[float, float, float], ...] = field(init=False)

    @nodes.default
    def _accumulated(self) -> tuple[Fraction, ...]:
        return tuple(accumulate(self.drifts))

    @turns.default
    def _rounded(self) -> tuple[tuple[float, float, float], ...]:
        rows = zip(self.drifts, self.nodes, self.kicks[1:], strict=False)
        return tuple((float(drift), float(node), float(kick)) for drift, node, kick in rows)

    def __attrs_post_init__(self) -> None:
        if len(self.kicks) != len(self.drifts) + 1:
            numbers = f"{len(self.kicks)} kicks, {len(self.drifts)} drifts"
            problem = f"must be one more than the drifts (got {numbers}; give 0 for no kick)"
            raise InvalidValueError.of("kicks", problem)
        for name, shares in (("kicks", self.kicks), ("drifts", self.drifts)):
            total = sum(shares, Fraction(0))
            if total != 1:
                raise InvalidValueError.of(name, f"must sum to 1 exactly (got {total})")
        outside = [node for node in self.nodes if not 0 <= node <= 1]
        if outside:
            problem = f"must end within the step (got {float(outside[0]):g} of it)"
            raise InvalidValueError.of("drifts", problem)

    @classmethod
    def mirrored(cls, *, stages: int, kicks: str, drifts: str, drift_first: bool = False) -> Self:
        """Time-symmetric method from the printed coefficients.

        Parameters
        ----------
        stages : int
            Number of drifts; or number of kicks, if a step begins and ends with a drift.
        kicks, drifts : str
            Decimals as printed, from the first on; the one or two in the middle follow from the sum.
        drift_first : bool
            Whether a step begins and ends with a drift; its first and last kick are then 0.

        Raises
        ------
        InvalidValueError
            If the number of decimals does not fit the number of stages.
        """
        if drift_first:
            inner = _completed("kicks", kicks, stages)
            return cls((Fraction(0), *inner, Fraction(0)), _completed("drifts", drifts, stages + 1))
        return cls(_completed("kicks", kicks, stages + 1), _completed("drifts", drifts, stages))


def _completed(name: str, printed: str, count: int) -> tuple[Fraction, ...]:
    """``count`` symmetric coefficients that begin with ``printed`` and have the sum 1."""
    leading = [Fraction(number) for number in printed.split()]
    needed = (count - 1) // 2
    if len(leading) != needed:
        raise InvalidValueError.of(name, f"must be {needed} numbers for {count} in all (got {len(leading)})")
    left = 1 - 2 * sum(leading, Fraction(0))
    middle = [left] if count % 2 else [left / 2, left / 2]
    return (*leading, *middle, *reversed(leading))


@define
class Splitting(OneStep):
    """Base class of symmetric, symplectic fixed-step methods; a subclass defines its order and ``shares``.

    With coefficients b of the kicks and a of the drifts, a step h at time t is v <- v + b_0 h x''(t, x) and
    then, for each i from 1,

        x <- x + a_i h v,   v <- v + b_i h x''(t + (a_1 + ... + a_i) h, x).

    It evaluates the acceleration once per drift: that of the last kick is reused in the next step.
    """

    adaptive: ClassVar[bool] = False
    shares: ClassVar[Shares]

    def attempt(
        self,
        acceleration: Acceleration,
        time: float | FloatArray,
        size: float | FloatArray,
        x: FloatArray,
        v: FloatArray,
        a: FloatArray,
    ) -> Attempt:
        v = v + float(self.shares.kicks[0]) * size * a
        for drift, node, kick in self.shares.turns:
            x = x + drift * size * v
            a = acceleration(time + node * size, x)
            v = v + kick * size * a
        return Attempt(x, v, a, 0.0)
