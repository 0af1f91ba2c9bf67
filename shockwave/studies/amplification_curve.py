"""Universal curve of a shape: amplification as a function of t0/T0, from simulations on a refined grid."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import asdict, frozen
from scipy.interpolate import CubicSpline

from shockwave.base.arguments import explain_arguments
from shockwave.base.errors import InvalidValueError, NumericalError, ShockwaveError
from shockwave.base.numerics import FloatArray
from shockwave.base.quantity_fields import Declaration, Number, text_of
from shockwave.base.result import VERSION, Result, cached_property
from shockwave.base.result_tables import Table, along, evenly
from shockwave.base.text import facts, limits, notes, si, strong, table
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.scene.chain import Chain, Scales
from shockwave.scene.material import Material
from shockwave.scene.shock import Shock
from shockwave.simulation.simulate import simulate_many
from shockwave.studies.varied_scenes import RTOL
from shockwave.studies.warning_groups import WarningGroups

_LONGEST = Declaration("", "longest duration n t0/T0", at_least=1e-3, at_most=1e3)
# A chain whose scales cancel in the amplification.
_CHAIN = Chain(material=Material(youngs_modulus=1e9, poisson_ratio=0.3, density=1e3), radius=1e-3)
# Exponent of t0/T0 in the amplification of an impulse.
_IMPULSE_POWER = 1.2
# Deviation from the impulse limit over the cube of n t0/T0, at most. Two equal blows at the ends have 0.08.
_DEVIATION = 0.1
# Shortest over longest duration, at most.
_SPAN = 0.1
# Spacing of the first grid in ln t0/T0, with which the checks of neighbouring intervals notice ripples.
_SPACING = 0.25
# Narrowest interval over the first spacing. At a kink the error is proportional to the width.
_NARROWEST = 2.0**-10
# Greatest number of simulations. Ordinary shapes need 50 to 300.
_MOST = 2000
# Greatest number of force evaluations of the checks: about twenty seconds for waves that hardly separate. Ordinary
# curves take 1e5.
_BUDGET = 3_000_000
# Tolerance of a simulation over that of the curve.
_SIMULATION_RTOL = 0.03
# Largest difference at a midpoint, over the tolerance, for which an interval is not divided further.
_ACCEPTED = 0.3
# Stated error over the largest difference at the midpoints of an interval and its neighbours.
_SAFETY = 3.0
# Rows of the printed table.
_ROWS = 4
# Characters of the profile in the text: two lines.
_MOST_CHARACTERS = 110

# Columns of the table of points.
_FIGURES = ("amplification", "error", "section4_amplification")


@frozen(kw_only=True)
class CurvePoint:
    """Simulated point of a universal curve.

    Attributes
    ----------
    rise_time : float
        t0/T0.
    amplification : float
        Peak force of the leading wave over that of the shock.
    error : float
        Estimate of the relative error between this point and the next.
    section4_amplification : float or None
        The same ratio by section 4; None where it has no answer.
    """

    rise_time: float
    amplification: float
    error: float
    section4_amplification: float | Any


@frozen(init=False, slots=False, repr=False)
class UniversalCurve(Result):
    """Amplification as a function of t0/T0, for every endless chain and every peak force, with section 4 beside it.

    The logarithm of the amplification is a cubic spline in ln t0/T0 through simulated points. Each interval is halved
    until the spline predicts the simulation at its midpoint. Shorter shocks follow the impulse limit, which scales as
    ``(t0/T0)^(6/5)``.

    Parameters
    ----------
    profile : ShockProfile
        Shape of the shock.
    rtol : float
        Allowed relative error of the amplification, 1e-7 to 1e-2.
    longest : float
        Longest duration n t0/T0 covered, 1e-3 to 1000. There is no shortest duration.

    Attributes
    ----------
    profile, rtol, longest
        The parameters above.
    points : tuple of CurvePoint
        Simulated points, by ascending t0/T0.
    warnings : tuple of str
        Warnings of the simulations, by kind, and on the processing of a record.

    Raises
    ------
    InvalidValueError
        If an argument is out of range, or the force of the profile is negative somewhere.
    NumericalError
        If a simulation fails.

    Examples
    --------
    >>> import shockwave as sw
    >>> curve = sw.UniversalCurve(sw.Triangular(duration_ratio=3))
    >>> f"{float(curve.amplification(2.0)):.4f}"
    '1.3981'
    """

    profile: ShockProfile
    rtol: float
    longest: float
    points: tuple[CurvePoint, ...]
    warnings: tuple[str, ...]

    _brief = ("profile", "rtol", "longest")
    _picture = "shockwave.pictures.studies:draw_curve"
    _tables = (("points", "scaled_rise_time"),)

    @explain_arguments
    def __init__(self, profile: ShockProfile, rtol: Number = 1e-4, longest: Number = 50.0) -> None:
        if not isinstance(profile, ShockProfile):
            raise InvalidValueError.of("profile", f"must be a ShockProfile (got {text_of(profile)})")
        if profile.pulls:
            raise InvalidValueError.of(
                "profile", "must not pull, because a curve covers no negative forces (got a record)"
            )
        numbers: tuple[float, float] = (RTOL.check("rtol", rtol), _LONGEST.check("longest", longest))
        groups = WarningGroups()
        points = _simulate_points(profile, *numbers, groups)
        warnings = (*getattr(profile, "alarms", ()), *groups.sentences("simulations"))
        self.__attrs_init__(profile, *numbers, points, warnings)

    @property
    def notes(self) -> tuple[str, ...]:
        """Changes that were made to a record."""
        return tuple(self.profile.notes)

    @property
    def longest_rise_time(self) -> float:
        """Greatest t0/T0 covered."""
        return self.points[-1].rise_time

    @cached_property
    def highest(self) -> tuple[float, float]:
        """t0/T0 of the greatest amplification, and this amplification."""
        heights = self.amplification(self._landmarks)
        return float(self._landmarks[heights.argmax()]), float(heights.max())

    def amplification(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Peak force of the leading wave over that of the shock.

        Parameters
        ----------
        rise_time : array_like of float, any shape
            t0/T0, above 0 and at most `longest_rise_time`.

        Raises
        ------
        InvalidValueError
            If a value is out of this range.
        """
        x = np.log(self._check_range(rise_time))
        shortest = self._spline.x[0]
        missing = np.minimum(x - shortest, 0.0)
        return np.asarray(np.exp(self._spline(np.maximum(x, shortest)) + _IMPULSE_POWER * missing))

    def error(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Estimate of the relative error of `amplification`, for the same t0/T0."""
        shorter = self.points[0].error + _DEVIATION * self.rtol
        errors = [shorter, *(point.error for point in self.points)]
        starts = [point.rise_time for point in self.points]
        return np.array(errors)[np.searchsorted(starts, self._check_range(rise_time), side="right")]

    def to_dict(self) -> dict[str, Any]:
        """The document that ``shockwave curve -o FILE.json`` writes."""
        document = {"profile": str(self.profile), "rtol": self.rtol, "longest": self.longest}
        return {**VERSION, **document, "points": [asdict(point) for point in self.points], **self.remarks()}

    def __str__(self) -> str:
        ratio, most = self.highest
        worst = max(point.error for point in self.points)
        accuracy = f"accurate to {worst:.0e} (requested: {self.rtol:.0e}), {len(self.points)} simulations"
        lines = facts(
            [
                ("shape", text_of(self.profile, _MOST_CHARACTERS)),
                ("durations", f"n t0/T0 up to {self.longest:g}, t0/T0 up to {self.longest_rise_time:g}"),
                ("amplification", f"at most {si(most, '', error=worst)}, at t0/T0 = {ratio:.6g}"),
            ]
        )
        rows = [_row(self.points[index]) for index in evenly(len(self.points), _ROWS)]
        shown = table(("t0/T0", "amplification", "section 4"), rows)
        answer = [strong(f"universal curve {accuracy}"), *limits(self.warnings), *lines, shown]
        return "\n".join([*answer, *notes(self.notes)])

    def _table(self, name: str) -> Table:
        columns = {each: [getattr(point, each) for point in self.points] for each in _FIGURES}
        values = {each: np.array(column, dtype=float) for each, column in columns.items()}
        return along(dict(self._tables)[name], [point.rise_time for point in self.points], values)

    @cached_property
    def _spline(self) -> CubicSpline:
        return CubicSpline(*np.log([(point.rise_time, point.amplification) for point in self.points]).T)

    @cached_property
    def _landmarks(self) -> FloatArray:
        """t0/T0 of the ends and extrema of the spline, ascending."""
        turns = np.exp(self._spline.derivative().roots(extrapolate=False))
        return np.array([self.points[0].rise_time, *turns, self.longest_rise_time])

    def _check_range(self, rise_time: npt.ArrayLike) -> FloatArray:
        most = self.longest_rise_time
        ratios = np.asarray(rise_time, dtype=float)
        outside = ratios[~((ratios > 0) & (ratios <= most))]
        if outside.size:
            rule = f"must be t0/T0 > 0 and <= {most:g}"
            raise InvalidValueError.of("rise_time", f"{rule} (got {outside.flat[0]:g}; increase longest)")
        return ratios


def _row(point: CurvePoint) -> tuple[str, str, str]:
    section4 = point.section4_amplification
    by_section4 = "-" if section4 is None else si(section4, "", 4)
    return si(point.rise_time, "", 4), si(point.amplification, "", 4), by_section4


def _simulate_points(
    profile: ShockProfile, rtol: float, longest: float, warnings: WarningGroups
) -> tuple[CurvePoint, ...]:
    """The points of a curve."""
    shortest = min(math.cbrt(rtol), _SPAN * longest)
    n = float(profile.duration_ratio)
    grid = refine(partial(_simulate, profile, rtol, warnings), math.log(shortest / n), math.log(longest / n), rtol)
    shocks = [_scale_shock(profile, x) for x in grid[0].tolist()]
    outcomes: list[Any] = Predictor(model="section-4").predict_many(shocks, _CHAIN)
    return tuple(
        CurvePoint(
            rise_time=math.exp(x),
            amplification=math.exp(y),
            error=error,
            section4_amplification=None if isinstance(outcome, NumericalError) else outcome.amplification,
        )
        for (x, y, error), outcome in zip(np.transpose(grid).tolist(), outcomes, strict=True)
    )


def _scale_shock(profile: ShockProfile, x: float) -> Shock:
    """A shock with ln t0/T0 = ``x`` on the chain of the simulations."""
    return Shock(profile=profile, peak_force=1.0, rise_time=math.exp(x) * Scales.of(_CHAIN, 1.0).time)


def _simulate(
    profile: ShockProfile, rtol: float, warnings: WarningGroups, x: FloatArray
) -> tuple[FloatArray, FloatArray, int]:
    """Logarithms of the amplifications at ln t0/T0 = ``x``, their error estimates, and the force evaluations."""
    shocks = [_scale_shock(profile, place) for place in x.tolist()]
    results: list[Any] = simulate_many(shocks, _CHAIN, _SIMULATION_RTOL * rtol, waves="primary")
    for shock, result in zip(shocks, results, strict=True):
        if isinstance(result, NumericalError):
            duration = shock.duration / Scales.of(_CHAIN, 1.0).time
            raise NumericalError(f"no curve covers n t0/T0 = {duration:.4g}: {result}")
        if isinstance(result, ShockwaveError):
            raise result
        warnings.add(result.run_warnings)
    heights = np.log([result.amplification for result in results])
    errors = np.array([result.error_estimate for result in results])
    return heights, errors, sum(result.cost.force_evaluations for result in results)


def refine(
    simulated: Callable[[FloatArray], tuple[FloatArray, FloatArray, int]], begin: float, end: float, rtol: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Grid, values and error from each point to the next, such that a cubic spline meets the tolerance.

    Each round simulates the midpoints of the open intervals. Halves stay open where the spline missed the midpoint, or
    that of a neighbouring interval. Intervals that are open when the budget is spent have larger errors.
    """
    x = np.linspace(begin, end, math.ceil((end - begin) / _SPACING) + 1)
    narrowest = _NARROWEST * (x[1] - x[0])
    y, errors, _ = simulated(x)
    spent = 0
    differences = np.zeros(len(x) - 1)
    is_open = np.ones(len(x) - 1, dtype=bool)
    while is_open.any() and len(x) < _MOST and spent < _BUDGET:
        (index,) = is_open.nonzero()
        middle = (x[index] + x[index + 1]) / 2
        heights, estimates, evaluations = simulated(middle)
        spent += evaluations
        differences[index] = np.abs(CubicSpline(x, y)(middle) - heights)
        # a difference within the errors of the simulations is noise
        noise = estimates + np.maximum(errors[index], errors[index + 1])
        missed = np.zeros(len(is_open), dtype=bool)
        missed[index] = differences[index] > np.maximum(_ACCEPTED * rtol, noise)
        divided = _spread_maxima(missed) & (np.diff(x) > narrowest)
        halves = np.where(is_open, 2, 1)
        differences, is_open = np.repeat(differences, halves), np.repeat(divided, halves)
        x, y, errors = np.insert([x, y, errors], index + 1, [middle, heights, estimates], axis=1)
    between = _SAFETY * _spread_maxima(differences) + np.maximum(errors[:-1], errors[1:])
    return x, y, np.append(between, errors[-1])


def _spread_maxima(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The greatest of each value and its neighbours; for booleans, whether one of them is true."""
    around = np.pad(values, 1)
    return np.asarray(np.maximum(np.maximum(around[:-2], around[2:]), values))
