"""Search of one parameter: all values that meet a requirement."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby, pairwise
from typing import Any

import numpy as np
from attrs import define, evolve, field

from shockwave.base.errors import InvalidValueError, ShockwaveError
from shockwave.base.numerics import FloatArray, bracketed_root
from shockwave.base.progress import report_progress
from shockwave.profiles.quadrature.gauss_legendre import interpolate
from shockwave.studies.design_options import VERIFIED_RTOL, DesignScenes
from shockwave.studies.design_result import Option
from shockwave.studies.quantities import Requirement
from shockwave.studies.warning_groups import kind_of_warning

# Most whole numbers that are tried one by one.
_MOST_WHOLE = 200
# Fewest cells of the grid on which the quantity is simulated.
_CELLS = 32
# Most scenes of the grid, and departure from a cubic that a cell is assumed to have, over that at its ends.
_MOST_SCENES = 1000
_CAUTION = 4.0
# Most times that a cell of the grid is halved, and most cells that may then be left, a few beside each jump.
_HALVINGS = 9
_MOST_JUMPS = 32
# Parts into which the cells beside an extremum are divided, and most times that they are.
_PARTS, _ROUNDS = 4, 12
# Tolerance of the simulations of the grid, over the tolerance of the solutions.
_GRID_SHARE = 0.1
# Distance from the target at which the search of a solution stops, over the tolerance of the solutions.
_STOP_SHARE = 0.01
# Differences of the quantity that give its slope, over its error.
_CLEAR = 100.0
# Warning on materials of a chain that must be elastic.
_BEYOND = "left out, because a force exceeds first yield or a yield strength is not known: "


def compare_values(scenes: DesignScenes, rtol: float) -> dict[str, Any]:
    """Compare materials or whole numbers; ``rtol`` is the allowed relative deviation from the target.

    Returns
    -------
    dict
        Fields of the `Design` that are the answer.

    Raises
    ------
    InvalidValueError
        If a scene is not possible, but for materials of a chain that must be elastic.
    NumericalError
        If a simulation fails.
    """
    (parameter,), (target,) = scenes.parameters, scenes.requirements
    low, high = map(int, parameter.between or (0, -1))
    if high - low >= _MOST_WHOLE:
        problem = f"must have at most {_MOST_WHOLE} whole numbers (got {high - low + 1}; narrow the interval)"
        raise InvalidValueError.of("between", problem)
    values = [(each,) for each in (parameter.among or range(low, high + 1))]
    options, beyond, refused = [], {}, {}
    for (value,), option in zip(values, scenes.options(values, VERIFIED_RTOL), strict=True):
        if isinstance(option, Option):
            options.append(option)
        elif isinstance(option, InvalidValueError) and option.faults[0].path == "chain.elastic_only":
            beyond[value] = option
        elif isinstance(option, InvalidValueError) and isinstance(value, str):
            refused[value] = option
        else:
            raise _interval_error(option) if parameter.between else option
    if not options:
        raise next(iter((beyond | refused).values()))
    ranked = sorted(options, key=lambda option: _distance(option.reached, target.value))
    # whole numbers ascend; materials have no other order
    rows = sorted(ranked, key=lambda option: 0.0 if isinstance(option.value, str) else option.value)
    equality = target.sign == "="
    solutions = tuple(each for each in rows if (_meets_target(target, each, rtol) if equality else each.violation <= 0))
    left_out = [_BEYOND + ", ".join(map(str, beyond))] if beyond else []
    left_out += [f"{value} is left out: {error.faults[0]}" for value, error in refused.items()]
    return {
        "solutions": solutions,
        "nearest": None if solutions else ranked[0],
        "table": tuple(rows),
        "warnings": (*_warnings(solutions or ranked[:1]), *left_out),
    }


def search_interval(scenes: DesignScenes, points: int, rtol: float) -> dict[str, Any]:
    """Find all values of a number that meet the target; ``points`` is the number of rows of the table.

    Returns and raises as `compare_values`.
    """
    try:
        return _Line(scenes, rtol).answer(points)
    except InvalidValueError as error:
        raise _interval_error(error) from None


def _interval_error(error: ShockwaveError) -> ShockwaveError:
    """The error of an interval that contains the scene of an ``error``."""
    if not isinstance(error, InvalidValueError) or error.faults[0].path in ("target", "chain.granules"):
        return error
    return InvalidValueError.of("between", f"must contain only valid cases ({error.faults[0]})")


def _distance(reached: float, value: float) -> float:
    """Absolute logarithm of the ratio of the reached value to the target value."""
    return abs(math.log(reached / value)) if reached > 0 else math.inf


def _meets_target(target: Requirement, option: Option, rtol: float) -> bool:
    """Whether an option has the value of the target within the tolerance and the error of its simulation."""
    return abs(option.reached / target.value - 1) <= rtol + option.reached_error


def _warnings(options: Sequence[Option]) -> list[str]:
    """The warnings of the options, one of those that differ in numbers alone."""
    return list({kind_of_warning(warning): warning for option in options for warning in option.warnings}.values())


def _departures(x: FloatArray, y: FloatArray) -> FloatArray:
    """Distances of values from the cubics through two neighbours on either side; next to the ends, of the nearest."""
    around = [[index - 2, index - 1, index + 1, index + 2] for index in range(2, len(x) - 2)]
    pairs = zip(x[2:-2].tolist(), around, strict=True)
    cubic = [float(interpolate(x[places], np.array([middle]))[0] @ y[places]) for middle, places in pairs]
    return np.pad(np.abs(cubic - y[2:-2]), 2, mode="edge")


@define
class _Line:
    """The required quantity along the interval of the parameter, known where its scenes were simulated."""

    scenes: DesignScenes
    rtol: float
    #: Options by their shares of the interval.
    options: dict[float, Option] = field(factory=dict)

    @property
    def target(self) -> Requirement:
        return self.scenes.requirements[0]

    def answer(self, points: int) -> dict[str, Any]:
        """Fields of the `Design` that are the answer."""
        each = -(-_CELLS // (points - 1))
        shares = np.linspace(0.0, 1.0, each * (points - 1) + 1).tolist()
        self.simulate(shares, _GRID_SHARE * self.rtol)
        table = [self.options[share] for share in shares[::each]]
        unresolved = self.resolve()
        if not unresolved:
            self.refine()
        limits = self.limits()
        solutions = [option for option in map(self.solution, limits) if _meets_target(self.target, option, self.rtol)]
        intervals = self.intervals(limits) if self.target.sign != "=" else ()
        shown = solutions or [self.verify(min(self.options, key=lambda share: abs(self.height(share))))]
        ends = {end for both in intervals for end in both} - {option.value for option in shown}
        of_ends = self.scenes.possible([(end,) for end in sorted(ends)], VERIFIED_RTOL)
        return {
            "solutions": tuple(solutions),
            "intervals": intervals,
            "nearest": None if solutions or intervals else shown[0],
            "table": tuple(table),
            "warnings": (*unresolved, *_warnings([*shown, *of_ends])),
        }

    def simulate(self, shares: Sequence[float], rtol: float) -> None:
        """Simulate scenes at shares of the interval."""
        values = [(self.scenes.parameters[0].at(share),) for share in shares]
        self.options |= zip(shares, self.scenes.possible(values, rtol), strict=True)
        report_progress("simulations", len(self.options))

    def height(self, share: float) -> float:
        """Excess of the quantity over the target, on a scale on which it is finite also where no force arrives.

        It is 0 where a solution needs no better value.
        """
        if share not in self.options:
            self.simulate([share], VERIFIED_RTOL)
        ratio = self.options[share].reached / self.target.value
        return 0.0 if abs(ratio - 1) <= _STOP_SHARE * self.rtol else math.asinh(ratio) - math.asinh(1.0)

    def resolve(self) -> tuple[str, ...]:
        """Halve the cells within which the quantity may reach the target; a warning if there are too many."""
        parameter = self.scenes.parameters[0]
        for left in reversed(range(_HALVINGS + 1)):
            shares = np.array(sorted(self.options))
            heights = np.array([self.height(share) for share in shares.tolist()])
            departures = _CAUTION * _departures(shares, heights)
            reach = np.maximum(np.minimum(*np.abs([heights[:-1], heights[1:]])), _CAUTION * _GRID_SHARE * self.rtol)
            cells = np.flatnonzero(np.maximum(departures[:-1], departures[1:]) > reach)
            if cells.size > (_MOST_SCENES - len(shares) if left else _MOST_JUMPS):
                first, last = (parameter.format(parameter.at(share)) for share in shares[[cells[0], cells[-1] + 1]])
                name = self.target.quantity.name
                return (f"{name} varies too fast between {first} and {last}: some solutions may be missing",)
            if left and cells.size:
                self.simulate(((shares[cells] + shares[cells + 1]) / 2).tolist(), _GRID_SHARE * self.rtol)
        return ()

    def refine(self) -> None:
        """Divide the cells beside the least and the greatest value, and beside extrema that may reach the target."""
        for _ in range(_ROUNDS):
            shares = sorted(self.options)
            heights = [self.height(share) for share in shares]
            inner = heights[1:-1]
            places: set[float] = set()
            for index, height in enumerate(heights):
                around = slice(max(index - 1, 0), index + 2)
                ranges = height in (min(heights), max(heights)) and height in inner
                if self.is_extremum(height, heights[around], ranges):
                    places |= {
                        begin + (end - begin) * part / _PARTS
                        for begin, end in pairwise(shares[around])
                        for part in range(1, _PARTS)
                    }
            if not places:
                return
            self.simulate(sorted(places), _GRID_SHARE * self.rtol)

    def is_extremum(self, height: float, around: Sequence[float], ranges: bool) -> bool:
        """Whether there is an extremum near a point of this height that is not yet known.

        ``around`` are its neighbours, too. Unless it ``ranges`` the quantity, the extremum counts if it may reach the
        target.
        """
        swing = max(abs(each - height) for each in around)
        below = height == max(around) and (height <= 0 or ranges)
        above = height == min(around) and (height >= 0 or ranges)
        nearest = 0.0 if ranges else abs(height)
        return (below or above) and max(nearest, _GRID_SHARE * self.rtol) < swing

    def limits(self) -> list[float]:
        """Shares at which the quantity crosses the target, or touches it within the tolerance."""
        shares = sorted(self.options)
        heights = [self.height(share) for share in shares]
        crossed = [index for index, (low, high) in enumerate(pairwise(heights)) if low * high < 0]
        limits = [bracketed_root(self.height, shares[index], shares[index + 1], "target") for index in crossed]
        near = (abs(self.options[share].reached / self.target.value - 1) <= self.rtol for share in shares)
        for is_near, group in groupby(enumerate(near), lambda pair: pair[1]):
            run = [index for index, _ in group]
            if is_near and not {*crossed} & {run[0] - 1, *run}:
                limits.append(shares[min(run, key=lambda index: abs(heights[index]))])
        return sorted(limits)

    def verify(self, share: float) -> Option:
        """The option at a share by a more accurate simulation."""
        if share not in self.options or not self.options[share].verified:
            self.simulate([share], VERIFIED_RTOL)
        return self.options[share]

    def solution(self, share: float) -> Option:
        """The verified option at a share with the error of its value, from the nearest clear difference."""
        option = self.verify(share)
        error = abs(option.reached / self.target.value - 1) + option.reached_error
        by_distance = sorted(self.options, key=lambda other: abs(other - share))
        for other in (self.options[place] for place in by_distance):
            change = abs(other.reached - option.reached) / self.target.value
            if change > _CLEAR * error:
                step = abs(float(other.value) - float(option.value))
                return evolve(option, value_error=error * step / change)
        return option

    def intervals(self, limits: Sequence[float]) -> tuple[tuple[float, float], ...]:
        """Intervals in which an inequality holds, ``limits`` included."""
        sense = 1.0 if self.target.sign == "<=" else -1.0
        shares = sorted({*self.options, *limits})
        groups = groupby(shares, lambda share: share in limits or sense * self.height(share) <= 0)
        spans = [list(group) for holds, group in groups if holds]
        at = self.scenes.parameters[0].at
        return tuple((at(span[0]), at(span[-1])) for span in spans)
