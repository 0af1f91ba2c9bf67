"""Verdict on a force: whether it stays below a limit, with what is known of it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Literal

import attrs
from attrs import evolve, field, frozen

from shockwave.base.errors import Fault, InvalidValueError
from shockwave.base.quantity_fields import SI, Number, Value, declaration_of, one_of, quantity, text_of
from shockwave.base.text import alarm, percent, round_bound, si, significant_digits

Decision = Literal["below", "above", "undecided"]
#: Description of the force transmitted by an endless chain.
WAVE = "peak force of the leading wave"
#: Description of the force transmitted by a finite chain without an end, and with one.
LAST, WALL, BAR = "force at the last contact", "force on the wall", "force on the bar"
#: Description of the force that spring and dashpot of a movable end exert on the ground.
SPRING = "force of the spring on the ground"
#: Remedies for a force that may be greater later: where a later end of the simulated time helps, and where none does.
LATER = "set a later simulate.until"
UNDAMPED = "state a damping (without damping, waves never cease)"
FALLING = "state chain.end.stiffness, because a wall without a spring gives way under the weight of the striker"
UNBOUNDED = "compare longer simulations, because no bound of the later force is known"
#: Beginnings of warnings of a greater force after the simulated time.
COLLISION, GROWTH = "A later collision may exert a greater force", "The spring force may still grow"
AGAIN, STILL_ACTS = "The striker may fall on the chain again", "The shock ends after the simulated time"
# Most digits of a limit in newtons, and digits of one in other units.
_STATED = 9
_ROUNDED = 6
# Relative half-width below which the printed digits show the range.
_SMALL = 1e-3
# Relative error that the digits of the ends of a wide range show: three digits.
_FINEST = 0.03


@frozen(kw_only=True)
class Limit(Value):
    """Limit on the transmitted force.

    Parameters
    ----------
    force : float
        Largest admissible force [N].
    at : "chain" or "spring"
        Whether it limits the force that leaves the chain (default), or that of spring and dashpot of a movable end on
        the ground, without the static load.

    Examples
    --------
    >>> import shockwave as sw
    >>> chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
    >>> shock = sw.Shock(
    ...     profile="triangular", duration_ratio=3, peak_force="50 N", rise_time="20 us"
    ... )
    >>> outcome = sw.predict(shock, chain, limit=sw.Limit(force="60 N"))
    >>> print(outcome.verdict)
    below the limit of 60 N: peak force of the leading wave 53.610578 N
    """

    force: SI[float] = quantity("N", "largest admissible transmitted force", above=0, example="60 N")
    at: Literal["chain", "spring"] = field(default="chain", validator=one_of("chain", "spring"))

    def force_of(self, leaving: LeavingForce) -> LeavingForce:
        """The force that it limits: that which leaves the chain, or that of the spring behind it."""
        if self.at == "chain":
            return evolve(leaving, spring=None)
        return leaving.spring or evolve(leaving, name=SPRING)

    def verdict(self, result: Any) -> Verdict:
        """Verdict on the transmitted force in ``result``, of a prediction or a simulation.

        Raises
        ------
        InvalidValueError
            If it is neither.
        """
        if not isinstance(force := getattr(result, "leaving", None), LeavingForce):
            problem = f"must be the result of a prediction or a simulation (got {text_of(result)})"
            raise InvalidValueError.of("result", problem)
        return verdict(self, force)


def limit_of(limit: Limit | Number | None) -> Limit | None:
    """A limit, given as such or as its force [N] or text with a unit; None if nothing is given.

    Raises
    ------
    InvalidValueError
        If it is something else.
    """
    if limit is None or isinstance(limit, Limit):
        return limit
    spec = declaration_of(attrs.fields(Limit).force)
    assert spec is not None
    return Limit(force=spec.check("limit", limit))


def limit_faults(limit: Limit | None, end: Any) -> list[Fault]:
    """Error of a limit on a spring that the ``end`` of the chain does not have."""
    if limit is None or limit.at == "chain" or (end is not None and (end.stiffness or end.damping)):
        return []
    rule = "must be chain for an end without a spring or dashpot"
    return [Fault("limit.at", f"{rule} (got 'spring'; give mass and stiffness of the wall)")]


def name_force(end: Any) -> str:
    """Description of the force transmitted by a finite chain with this end, or None."""
    return LAST if end is None else f"force on the {end.word}"


@frozen(kw_only=True)
class LeavingForce:
    """Transmitted force: on the wall, else at the last contact, else of the leading wave.

    Attributes
    ----------
    name : str
        Description of the force.
    value, low, high : float or None
        The force and the ends of its range [N]; None where they are not known.
    remedy : str
        What would decide a verdict that this range leaves open.
    later, later_remedy : float, str
        Bound of the force after the end of the simulated time [N], and what would decide a verdict that only this
        bound leaves open.
    spring : LeavingForce or None
        Force of the spring or dashpot of a movable end on the ground.
    law_error : (float, float) or None
        Least and greatest relative error of the contact law, where these are known.
    """

    name: str
    value: float | None = None
    low: float | None = None
    high: float | None = None
    remedy: str = ""
    later: float = 0.0
    later_remedy: str = LATER
    spring: LeavingForce | None = None
    law_error: tuple[float, float] | None = None

    @classmethod
    def from_simulation(
        cls, name: str, value: float, error: float, arrived: bool = True, later: float = 0.0
    ) -> LeavingForce:
        """The force by simulation with the estimate of its absolute ``error`` [N]; an error of 100 % is not known.

        Before the leading wave has ``arrived`` there is no upper end. After the end of the simulated time the force is
        less than ``later`` [N].
        """
        low, high = (value - error, value + error) if error < value else (None, None)
        remedy = "simulate with a smaller tolerance" if arrived else LATER
        return cls(name=name, value=value, low=low, high=high if arrived else None, remedy=remedy, later=later)


@frozen(kw_only=True)
class Verdict:
    """Decision on a limit.

    Attributes
    ----------
    limit : float
        Limit of the force [N].
    value, low, high : float or None
        The transmitted force, and the ends of its range [N]; None where they are not known.
    decision : "below", "above" or "undecided"
        Whether the whole range, widened by the error of the contact law where this is known, lies below the limit or
        above it. A force that equals the limit is not below it.
    force : str
        Description of the force.
    remedy : str or None
        What would decide it; None if it is decided.
    beside : str or None
        The other of the two forces at a movable end with a spring or dashpot, and its decision.
    reached : float or None
        Upper end within the simulated time [N], where ``high`` is the bound of the force afterwards.
    """

    limit: float
    value: float | None
    low: float | None
    high: float | None
    decision: Decision
    force: str
    remedy: str | None = None
    beside: str | None = None
    reached: float | None = field(default=None, repr=False)

    def __str__(self) -> str:
        # a number of newtons is shown as it was stated, one converted from other units rounded
        digits = _STATED if float(f"{self.limit:.{_STATED}g}") == self.limit else _ROUNDED
        limit = f"the limit of {si(self.limit, 'N', digits)}"
        figures = "; ".join(filter(None, (f"{self.force} {self._figures()}", self.beside)))
        if self.decision == "undecided":
            return f"undecided for {limit}: {figures}; to decide, {self.remedy}"
        return f"{self.decision} {limit}: {figures}"

    def _figures(self) -> str:
        """The force and its range."""
        if self.value is None:
            return "is not known"
        if self.value == 0:
            return "has not acted yet"
        if self.low is None or self.high is None:
            return f"{self._end(self.low)} or more" if self.low else f"{si(self.value, 'N', 2)}, error not known"
        ends = [self.low, self.reached or self.high, self.high]
        width, later = ((end - self.low) / 2 / self.value for end in ends[1:])
        low, high, bound = (self._end(end, min(later / 10, _FINEST)) for end in ends)
        value = si(self.value, "N", error=1 - self.low / self.value)
        value += f", range {low} to {high}" if width > _SMALL else ""
        return f"{value}, later at most {bound}" if later - width > _SMALL else value

    def _end(self, force: float, error: float = _FINEST) -> str:
        """An end of the range, rounded outwards, but not across the limit."""
        up, digits = force != self.low, significant_digits(force, error)
        while (bound := round_bound(force, up, digits)) != force and (bound < self.limit) != (force < self.limit):
            digits += 1
        return si(bound, "N", digits)


def verdict(limit: Limit, force: LeavingForce) -> Verdict:
    """The verdict on a ``force``, or on that of the spring behind it.

    It is undecided where the error of the contact law may change it.
    """
    judged = _allow_for_law(_judge(limit, limit.force_of(force)), force.law_error)
    if force.spring is None:
        return judged
    other = _allow_for_law(_judge(limit, force if limit.at == "spring" else force.spring), force.law_error)
    return evolve(judged, beside=f"{other.force} {other._figures()}, {other.decision}")


def _judge(limit: Limit, force: LeavingForce) -> Verdict:
    reached = force.high
    if force.high is not None and force.later > force.high:
        advice = force.later_remedy if force.high < limit.force else force.remedy
        force = evolve(force, high=force.later if force.later < math.inf else None, remedy=advice)
    decision: Decision = "undecided"
    if force.high is not None and force.high < limit.force:
        decision = "below"
    elif force.low is not None and force.low >= limit.force:
        decision = "above"
    known: dict[str, Any] = {"value": force.value, "low": force.low, "high": force.high}
    remedy = force.remedy if decision == "undecided" else None
    return Verdict(limit=limit.force, **known, decision=decision, force=force.name, remedy=remedy, reached=reached)


def _allow_for_law(judged: Verdict, law_error: tuple[float, float] | None) -> Verdict:
    """A verdict that allows for the least and the greatest relative error of the contact law."""
    if law_error is None or judged.low is None or judged.decision == "undecided":
        return judged
    low, high = judged.low / (1 + law_error[1]), (judged.high or math.inf) / (1 + law_error[0])
    if not low < judged.limit <= high:
        return judged
    end = f"to {si(round_bound(high, up=True), 'N', 3)}" if judged.high else "or more"
    ends = f"{si(round_bound(low, up=False), 'N', 3)} {end}"
    return evolve(
        judged,
        decision="undecided",
        remedy=f"use a test or finite elements: with the error of the contact law the force may be {ends}",
    )


def may_grow(warnings: Iterable[str]) -> bool:
    """Whether one of the warnings is of a greater force after the simulated time."""
    return any(each in warning for warning in warnings for each in (COLLISION, GROWTH, AGAIN, STILL_ACTS))


def verdict_facts(result: Any, note: str = "") -> list[tuple[str, str]]:
    """Label and text of the verdict of a result, with a ``note``, if it has a limit."""
    found = result.verdict
    if found is None:
        return []
    return [("verdict", f"{found}{note}" if found.decision == "below" else alarm(f"{found}{note}"))]


@frozen(kw_only=True)
class Exceedance:
    """Probability that the transmitted force reaches a limit.

    Attributes
    ----------
    limit : float
        The limit [N].
    probability : float
        Fraction of the scenes whose force is not below the limit.
    low, high : float
        Interval of the probability, which includes the 95 % confidence interval of sampling and the scenes that are not
        decided because of the errors of the simulations and, beyond first yield, of the contact law.
    draws, undecided : int
        Numbers of scenes, and of those that are not decided.
    """

    limit: float
    probability: float
    low: float
    high: float
    draws: int
    undecided: int

    def __str__(self) -> str:
        share = percent(self.probability)
        low, high = (percent(round_bound(end, up, 2)) for end, up in ((self.low, False), (self.high, True)))
        if self.undecided:
            rest = f"{self.undecided} of {self.draws} scenes are undecided"
            return f"probability between {low} and {high}, {share} by the simulated forces alone; {rest}"
        return f"probability {share}, between {low} and {high}"
