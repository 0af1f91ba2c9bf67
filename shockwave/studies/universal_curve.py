"""The universal curve of a shape: amplification of the primary against t0/T0, from few simulations."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import asdict, evolve, frozen

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.errors import InvalidValueError, NumericalError
from shockwave.fields import Quantity, text_of
from shockwave.files import parse_json, read_bytes, write_file
from shockwave.numerics import crossings
from shockwave.prediction.short_shock_law import CORRECTION, IMPULSE_LIMIT
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.guard import is_value
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.studies.chebyshev_fit import Piece
from shockwave.studies.universal_curve_data import CurveData, structured, unstructured
from shockwave.studies.universal_curve_fit import fitted_curve
from shockwave.text import si

_RTOL = Quantity("", "relative error allowed", at_least=1e-7, at_most=1e-2)
_LONGEST = Quantity("", "longest duration n t0/T0", at_least=1e-3, at_most=1e3)
_TARGET = Quantity("", "amplification", above=0)
# Below its end the law of short shocks errs by what its first term is off, at the most.
_NEXT_POWER = 3
# Its slope by so many times as much: the third term scales as the ninth power.
_SHORT_SLOPE = 9.0
# The law of short shocks has so many digits itself.
_DIGITS = 3e-9
# A rise time that is the longest but for rounding is the longest.
_ROUNDING = 1e-12
# A turning point so near to an end is that end.
_END = 1e-9
# Largest file [bytes]; a curve takes some tens of thousands.
_MOST_BYTES = 2**24


@frozen(kw_only=True)
class CurveAnswer:
    """The prediction of a curve for one shock on one chain.

    Attributes
    ----------
    peak_force : float
        Of the primary [N].
    amplification : float
        Peak force of the primary over that of the shock.
    error : float
        Bound on the relative error of both.
    rise_time : float
        t0/T0.
    """

    peak_force: float
    amplification: float
    error: float
    rise_time: float

    def __str__(self) -> str:
        force = f"peak force {si(self.peak_force, 'N', 7)} within {self.error:.0e} relative"
        return f"{force}, {self.amplification:.7g} times the shock's, at t0/T0 = {self.rise_time:.6g}"


@frozen(init=False, slots=False)
class UniversalCurve(CurveData):
    """Amplification of the primary as a function of t0/T0, for every chain and peak force.

    With S = (t0/T0) (a1 + a2)/1.652067 the amplification is 1.168181738 S^(6/5) e^g, and g is, for short shocks,
    -q (t0/T0)^3 + w (t0/T0)^6 with q known beforehand, see `shockwave.prediction.short_shock_law`; from there on a
    piecewise Chebyshev series in the logarithm of n t0/T0.

    Parameters
    ----------
    profile : ShockProfile
        The shape.
    rtol : float
        Relative error allowed of the amplification, 1e-7 to 1e-2.
    longest : float
        Of the durations n t0/T0 for which it is to hold, 1e-3 to 1000. There is no shortest.

    Attributes
    ----------
    shape : Shape
        The profile by name and by integrals.
    rtol, longest : float
        As given.
    short : ShortLaw
        g of short shocks.
    pieces : tuple of Piece
        g, from there on; empty where short shocks are all.
    simulations : int
        How many it took.
    made_with : mapping
        Versions of the programs that made it.

    Raises
    ------
    InvalidValueError
        When a value is out of range.
    NumericalError
        When a simulation fails.
    """

    def __init__(self, profile: ShockProfile, rtol: float = 1e-4, longest: float = 50.0) -> None:
        for name, spec, value in (("rtol", _RTOL, rtol), ("longest", _LONGEST, longest)):
            if problem := spec.problem(value):
                raise InvalidValueError.of(name, problem)
        if not isinstance(profile, ShockProfile):
            raise InvalidValueError.of("profile", f"must be a ShockProfile (got {text_of(profile)})")
        self.__attrs_init__(**asdict(fitted_curve(profile, float(rtol), float(longest)), recurse=False))

    # ---------------------------------------------------------------- values

    @property
    def longest_rise_time(self) -> float:
        """Greatest t0/T0 at which it holds."""
        return self.longest / self.shape.duration_ratio

    def amplification(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Peak force of the primary over that of the shock.

        Parameters
        ----------
        rise_time : array_like of float, any shape
            t0/T0, above 0 and at most `longest_rise_time`.

        Raises
        ------
        InvalidValueError
            When one is beyond, where the curve was not made.
        """
        ratios = self._checked(rise_time)
        reduced = self._by_law(ratios, self._of_short, lambda piece: piece.polynomial)
        limit = math.log(IMPULSE_LIMIT) + 1.2 * math.log(self.shape.area / MOMENTUM)
        return np.asarray(np.exp(limit + 1.2 * np.log(ratios) + reduced))

    def error(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Bound on the relative error of `amplification`, for the same t0/T0."""
        return self._by_law(self._checked(rise_time), self._error_of_short, lambda piece: piece.error)

    def slope(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Power of t0/T0 with which `amplification` scales there, d ln (F/F0) / d ln (t0/T0): 6/5 for short shocks."""

        def of_short(x: FloatArray) -> FloatArray:
            cube = self._cube(x)
            return 3 * cube * (2 * self.short.second_correction * cube - CORRECTION * self.shape.correction)

        return 1.2 + self._by_law(self._checked(rise_time), of_short, lambda piece: piece.polynomial.deriv())

    def slope_error(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Estimate of the error of `slope`, absolute, for the same t0/T0."""
        return self._by_law(
            self._checked(rise_time),
            lambda x: _SHORT_SLOPE * self._error_of_short(x),
            lambda piece: piece.slope_error,
        )

    def answer(self, shock: Shock, chain: Chain) -> CurveAnswer:
        """Peak force of the primary of ``shock`` on ``chain``, as if that had no end.

        Raises
        ------
        InvalidValueError
            When the shock has another shape, or is longer than the curve reaches.
        """
        if not self.shape.fits(shock.profile):
            raise InvalidValueError.of("profile", f"must be of the shape {self.shape} (got {text_of(shock.profile)})")
        ratio = Scales.of(chain, shock.peak_force).rise_time(shock.rise_time)
        value = float(self.amplification(ratio))
        return CurveAnswer(
            peak_force=value * shock.peak_force,
            amplification=value,
            error=float(self.error(ratio)),
            rise_time=ratio,
        )

    def peak_force(self, shock: Shock, chain: Chain) -> float:
        """Peak force of the primary [N]; see `answer`."""
        return self.answer(shock, chain).peak_force

    # ---------------------------------------------------------------- inverse

    def solve(self, amplification: float) -> tuple[float, ...]:
        """All t0/T0 at which the curve has this amplification, ascending; none if it is out of reach.

        Raises
        ------
        InvalidValueError
            When it is not a finite number above 0.
        """
        if problem := _TARGET.problem(amplification):
            raise InvalidValueError.of("amplification", problem)
        # the amplification of an impulse, which is not below that of a shock, is reached later
        impulse = (amplification / IMPULSE_LIMIT) ** (1 / 1.2) * MOMENTUM / self.shape.area
        least = min(impulse, math.exp(self.short.end) / self.shape.duration_ratio) * (1 - 1e-9)
        points = [least, *self.turns(0.0, least, self.longest_rise_time), self.longest_rise_time]
        target = math.log(amplification)

        def off(ratio: float) -> float:
            return math.log(float(self.amplification(ratio))) - target

        return tuple(crossings(off, points))

    @cached_property
    def highest(self) -> tuple[float, float]:
        """t0/T0 of the greatest amplification, and that: no solution is beyond."""
        end = self.longest_rise_time
        points = [*self.turns(0.0, 0.0, end), end]
        heights = self.amplification(points).tolist()
        return max(zip(points, heights, strict=True), key=lambda point: point[1])

    def turns(self, slope: float, least: float, most: float) -> list[float]:
        """All t0/T0 between two at which (t0/T0)^slope times the amplification turns, or two of its laws join."""
        start = math.log(self.shape.duration_ratio)
        whole = 1.2 + slope
        points = [self.short.end, *(x for piece in self.pieces for x in (*piece.turns(whole), piece.end))]
        # for short shocks the derivative of its logarithm is a quadratic in (t0/T0)^3
        cubes = np.roots([6 * self.short.second_correction, -3 * CORRECTION * self.shape.correction, whole])
        short = np.log(cubes.real[np.isreal(cubes) & (cubes.real > 0)]) / 3 + start
        points += short[short < self.short.end].tolist()
        ratios = np.sort(np.exp(np.array(points) - start))
        # one that is an end but for rounding is no other point
        found: list[float] = ratios[(ratios > least * (1 + _END)) & (ratios < most * (1 - _END))].tolist()
        return found

    # ---------------------------------------------------------------- files

    def to_dict(self) -> dict[str, Any]:
        """All of it, as JSON holds it: floats keep all their digits."""
        return unstructured(self)

    @classmethod
    def from_dict(cls, document: Any) -> UniversalCurve:
        """The curve that `to_dict` has written, to the last bit.

        Raises
        ------
        InvalidValueError
            When it is none.
        """
        curve = cls.__new__(cls)
        curve.__attrs_init__(**asdict(structured(document), recurse=False))
        return curve

    def save(self, file: str | os.PathLike[str]) -> None:
        """Write it to ``file`` as JSON.

        Raises
        ------
        FileAccessError
            When that cannot be written.
        """
        write_file(file, json.dumps(self.to_dict(), indent=1, allow_nan=False) + "\n")

    @classmethod
    def load(cls, file: str | os.PathLike[str]) -> UniversalCurve:
        """The curve in ``file``, equal to what was saved.

        Raises
        ------
        FileAccessError
            When it cannot be read.
        InvalidValueError
            When it holds no curve.
        """
        document = parse_json(read_bytes(file, _MOST_BYTES), os.fspath(file))
        try:
            return cls.from_dict(document)
        except InvalidValueError as error:
            raise InvalidValueError(evolve(fault, location=os.fspath(file)) for fault in error.faults) from None

    def __str__(self) -> str:
        ratio, most = self.highest
        worst = max([self.short.error + _DIGITS, *(piece.error for piece in self.pieces)])
        later = f", then {len(self.pieces)} polynomials" if self.pieces else ""
        lines = [
            f"universal curve of {self.shape}",
            f"  durations      n t0/T0 up to {self.longest:g}, t0/T0 up to {self.longest_rise_time:g}",
            f"  amplification  at most {most:.6g}, at t0/T0 = {ratio:.6g}",
            f"  error          below {worst:.0e} relative ({self.rtol:g} was asked for)",
            f"  made from      {self.simulations} simulations: the law of short shocks up to n t0/T0 ="
            f" {math.exp(self.short.end):.3g}{later}",
        ]
        return "\n".join(lines)

    # ---------------------------------------------------------------- inside

    def _by_law(
        self,
        ratios: FloatArray,
        of_short: Callable[[FloatArray], FloatArray],
        of_piece: Callable[[Piece], Any],
    ) -> FloatArray:
        """A function of x = ln (n t0/T0): by the law of short shocks, then by each piece."""
        x = np.log(ratios * self.shape.duration_ratio)
        ends = [self.short.end, *(piece.end for piece in self.pieces)][: len(self.pieces)]
        law = np.searchsorted(ends, x)
        functions = [of_short, *map(of_piece, self.pieces)]
        return np.piecewise(x, [law == k for k in range(len(functions))], functions)

    def _cube(self, x: FloatArray) -> FloatArray:
        return np.asarray(np.exp(3 * x) / self.shape.duration_ratio**3)

    def _of_short(self, x: FloatArray) -> FloatArray:
        cube = self._cube(x)
        return cube * (self.short.second_correction * cube - CORRECTION * self.shape.correction)

    def _error_of_short(self, x: FloatArray) -> FloatArray:
        return np.asarray(self.short.error * np.exp(_NEXT_POWER * np.minimum(x - self.short.end, 0.0)) + _DIGITS)

    def _checked(self, rise_time: npt.ArrayLike) -> FloatArray:
        most = self.longest_rise_time
        try:
            ratios = np.asarray(rise_time, dtype=float)
        except (TypeError, ValueError):
            ratios = np.asarray(math.nan)
        wrong = ~((ratios > 0) & (ratios <= most * (1 + _ROUNDING)))
        if wrong.any():
            first = float(ratios[wrong].flat[0])
            got = text_of(rise_time) if ratios.ndim == 0 else f"{first:g}"
            needed = first * self.shape.duration_ratio
            if _LONGEST.problem(needed) is None:
                got += f"; make the curve with longest={math.ceil(needed)}"
            raise InvalidValueError.of("rise_time", f"must be t0/T0 > 0 and <= {most:g} (got {got})")
        return np.asarray(np.minimum(ratios, most))


def kept_curve(profile: ShockProfile, rtol: float, longest: float) -> UniversalCurve | NumericalError:
    """The curve, or why there is none; kept for profiles that cannot change."""
    make = made_curve if is_value(profile) else made_curve.__wrapped__
    return make(profile, rtol, longest)


@lru_cache(maxsize=64)
def made_curve(profile: ShockProfile, rtol: float, longest: float) -> UniversalCurve | NumericalError:
    """As `kept_curve`, for a profile that can be hashed."""
    try:
        return UniversalCurve(profile, rtol, longest)
    except NumericalError as error:
        return error
