"""The universal curve of a shape: amplification of the primary against t0/T0, from few simulations."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import asdict, frozen

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.errors import InvalidValueError, NumericalError
from shockwave.fields import Quantity, text_of
from shockwave.prediction.short_shock_law import CORRECTION, IMPULSE_LIMIT
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.guard import kept
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.studies.chebyshev_fit import Piece
from shockwave.studies.universal_curve_fit import Shape, ShortLaw, fitted_laws
from shockwave.text import si

_RTOL = Quantity("", "relative error allowed", at_least=1e-7, at_most=1e-2)
_LONGEST = Quantity("", "longest duration n t0/T0", at_least=1e-3, at_most=1e3)
# Below its end the law of short shocks errs by the error of its first term at most, which scales as the cube.
_NEXT_POWER = 3
# The third term scales as the ninth power: so many times its error is that of the slope.
_SHORT_SLOPE = 9.0
# Error of the constants of the law of short shocks.
_DIGITS = 3e-9
# A rise time may exceed the longest by rounding.
_ROUNDING = 1e-12


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
class UniversalCurve:
    """Amplification of the primary as a function of t0/T0, for every chain and peak force.

    With S = (t0/T0) (a1 + a2)/1.652067 the amplification is 1.168181738 S^(6/5) e^g. For short shocks g is
    -q (t0/T0)^3 + w (t0/T0)^6 with q from `shockwave.prediction.short_shock_law`; for longer ones it is a piecewise
    Chebyshev series in the logarithm of n t0/T0.

    Parameters
    ----------
    profile : ShockProfile
        The shape.
    rtol : float
        Relative error allowed of the amplification, 1e-7 to 1e-2.
    longest : float
        Longest duration n t0/T0 covered, 1e-3 to 1000. There is no shortest.

    Attributes
    ----------
    shape : Shape
        The profile by name and by integrals.
    rtol, longest : float
        As given.
    short : ShortLaw
        g of short shocks.
    pieces : tuple of Piece
        g of longer ones; empty where the law of short shocks covers all.
    simulations : int
        Number of simulations made.

    Raises
    ------
    InvalidValueError
        When a value is out of range.
    NumericalError
        When a simulation fails.
    """

    shape: Shape
    rtol: float
    longest: float
    simulations: int
    short: ShortLaw
    pieces: tuple[Piece, ...]

    def __init__(self, profile: ShockProfile, rtol: float = 1e-4, longest: float = 50.0) -> None:
        for name, spec, value in (("rtol", _RTOL, rtol), ("longest", _LONGEST, longest)):
            if problem := spec.problem(value):
                raise InvalidValueError.of(name, problem)
        shape, short, pieces, simulations = fitted_laws(profile, float(rtol), float(longest))
        self.__attrs_init__(shape, float(rtol), float(longest), simulations, short, pieces)

    @property
    def longest_rise_time(self) -> float:
        """Greatest t0/T0 covered."""
        return self.longest / self.shape.duration_ratio

    @cached_property
    def highest(self) -> tuple[float, float]:
        """t0/T0 of the greatest amplification, and that amplification."""
        turns = [x for piece in self.pieces for x in (*piece.turns(1.2), piece.end)]
        ratios = np.exp(turns) / self.shape.duration_ratio if turns else np.array([self.longest_rise_time])
        heights = self.amplification(ratios)
        most = int(heights.argmax())
        return float(ratios[most]), float(heights[most])

    def amplification(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Peak force of the primary over that of the shock.

        Parameters
        ----------
        rise_time : array_like of float, any shape
            t0/T0, above 0 and at most `longest_rise_time`.

        Raises
        ------
        InvalidValueError
            When one is out of this range.
        """
        ratios = self._checked(rise_time)

        reduced = self._by_law(ratios, lambda x: self._of_short(x, 1, 1), lambda piece: piece.polynomial)
        limit = math.log(IMPULSE_LIMIT) + 1.2 * math.log(self.shape.area / MOMENTUM)
        return np.asarray(np.exp(limit + 1.2 * np.log(ratios) + reduced))

    def error(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Bound on the relative error of `amplification`, for the same t0/T0."""
        return self._by_law(self._checked(rise_time), self._error_of_short, lambda piece: piece.error)

    def slope(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Power of t0/T0 with which `amplification` scales there, d ln (F/F0) / d ln (t0/T0): 6/5 for short shocks."""

        ratios = self._checked(rise_time)
        return 1.2 + self._by_law(ratios, lambda x: self._of_short(x, 3, 6), lambda piece: piece.polynomial.deriv())

    def slope_error(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Estimate of the error of `slope`, absolute, for the same t0/T0."""
        return self._by_law(
            self._checked(rise_time),
            lambda x: _SHORT_SLOPE * self._error_of_short(x),
            lambda piece: piece.slope_error,
        )

    def answer(self, shock: Shock, chain: Chain) -> CurveAnswer:
        """Peak force of the primary of ``shock`` on ``chain``, taken as endless.

        Raises
        ------
        InvalidValueError
            When the shock has another shape, or is longer than the curve.
        """
        if not self.shape.fits(shock.profile):
            raise InvalidValueError.of(
                "profile", f"must be of the shape {self.shape.profile} (got {text_of(shock.profile)})"
            )
        ratio = Scales.of(chain, shock.peak_force).rise_time(shock.rise_time)
        value = float(self.amplification(ratio))
        return CurveAnswer(
            peak_force=value * shock.peak_force,
            amplification=value,
            error=float(self.error(ratio)),
            rise_time=ratio,
        )

    def to_dict(self) -> dict[str, Any]:
        """The document that ``curve -o FILE.json`` writes: the shape stands beside the rest."""
        document = asdict(self)
        return {"format": "shockwave universal curve", "version": 1, **document.pop("shape"), **document}

    def __str__(self) -> str:
        ratio, most = self.highest
        worst = max([self.short.error + _DIGITS, *(piece.error for piece in self.pieces)])
        later = f", then {len(self.pieces)} polynomials" if self.pieces else ""
        lines = [
            f"universal curve of {self.shape.profile}",
            f"  durations      n t0/T0 up to {self.longest:g}, t0/T0 up to {self.longest_rise_time:g}",
            f"  amplification  at most {most:.6g}, at t0/T0 = {ratio:.6g}",
            f"  error          below {worst:.0e} relative (requested: {self.rtol:g})",
            f"  made from      {self.simulations} simulations: the law of short shocks up to n t0/T0 ="
            f" {math.exp(self.short.end):.3g}{later}",
        ]
        return "\n".join(lines)

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

    def _of_short(self, x: FloatArray, first: float, second: float) -> FloatArray:
        """The two terms of the law of short shocks, with these factors."""
        cube = np.exp(3 * x) / self.shape.duration_ratio**3
        return np.asarray(
            second * self.short.second_correction * cube**2 - first * CORRECTION * self.shape.correction * cube
        )

    def _error_of_short(self, x: FloatArray) -> FloatArray:
        return np.asarray(self.short.error * np.exp(_NEXT_POWER * np.minimum(x - self.short.end, 0.0)) + _DIGITS)

    def _checked(self, rise_time: npt.ArrayLike) -> FloatArray:
        most = self.longest_rise_time
        ratios = np.asarray(rise_time, dtype=float)
        wrong = ratios[~((ratios > 0) & (ratios <= most * (1 + _ROUNDING)))]
        if wrong.size:
            rule = f"must be t0/T0 > 0 and <= {most:g}"
            raise InvalidValueError.of("rise_time", f"{rule} (got {wrong.flat[0]:g}; a longer curve goes further)")
        return np.asarray(np.minimum(ratios, most))


@kept
def kept_curve(profile: ShockProfile, rtol: float, longest: float) -> UniversalCurve | NumericalError:
    """The curve, or why there is none; kept for profiles that cannot change."""
    try:
        return UniversalCurve(profile, rtol, longest)
    except NumericalError as error:
        return error
