"""The universal curve of a shape: amplification of the primary against t0/T0, from few simulations."""

from __future__ import annotations

import math
import os
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.errors import InvalidValueError
from shockwave.fields import Quantity, text_of
from shockwave.numerics import bracketed_root
from shockwave.prediction.short_shock_law import CORRECTION, IMPULSE_LIMIT
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.studies.curve import stored
from shockwave.studies.curve.build import Built, built
from shockwave.studies.curve.series import Series
from shockwave.studies.curve.shape import Shape
from shockwave.text import si

__all__ = ["CurveAnswer", "UniversalCurve"]

_RTOL = Quantity("", "relative error allowed", at_least=1e-7, at_most=1e-2)
_LONGEST = Quantity("", "longest duration n t0/T0", at_least=1e-3, at_most=1e3)
_TARGET = Quantity("", "amplification", above=0)
# Below its end the law of short shocks errs by what its first term is off, at the most.
_NEXT_POWER = 3
# Its slope by so many times as much: the third term goes with the ninth power.
_SHORT_SLOPE = 9.0
# The law of short shocks has so many digits itself.
_DIGITS = 3e-9
# A rise time that is the longest but for rounding is the longest.
_ROUNDING = 1e-12


@frozen(kw_only=True)
class CurveAnswer:
    """What a curve says of one shock on one chain.

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
        What is known of the profile.
    rtol, longest : float
        As given.
    second_correction : float
        w.
    short_end, short_error : float
        Logarithm of n t0/T0 up to which the law of short shocks is used, and a bound on its relative error there.
    series : Series or None
        g, from there on; None where short shocks are all.
    simulations : int
        How many it took.
    versions : dict
        Of the programs that made it.

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
    second_correction: float
    short_end: float
    short_error: float
    series: Series | None
    simulations: int
    versions: tuple[tuple[str, str], ...]

    def __init__(self, profile: ShockProfile, rtol: float = 1e-4, longest: float = 50.0) -> None:
        for name, spec, value in (("rtol", _RTOL, rtol), ("longest", _LONGEST, longest)):
            if problem := spec.problem(value):
                raise InvalidValueError.of(name, problem)
        if not isinstance(profile, ShockProfile):
            raise InvalidValueError.of("profile", f"must be a ShockProfile (got {text_of(profile)})")
        shape = Shape.of(profile)
        found = built(profile, shape, float(rtol), float(longest))
        self._set(shape, float(rtol), float(longest), found, stored.versions())

    def _set(
        self, shape: Shape, rtol: float, longest: float, found: Built, versions: tuple[tuple[str, str], ...]
    ) -> None:
        self.__attrs_init__(
            shape,
            rtol,
            longest,
            found.second_correction,
            found.short_end,
            found.short_error,
            found.series,
            found.simulations,
            versions,
        )

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
        return np.asarray(np.exp(self._limit + 1.2 * np.log(ratios) + self._reduced(ratios)))

    def error(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Bound on the relative error of `amplification`, for the same t0/T0."""
        ratios = self._checked(rise_time)
        x = np.log(ratios * self.shape.duration_ratio)
        result = np.array(self.short_error * np.exp(_NEXT_POWER * np.minimum(x - self.short_end, 0.0)) + _DIGITS)
        if self.series is not None:
            later = x > self.short_end
            result[later] = self.series.error(x[later])
        return result

    def slope(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Power of t0/T0 with which `amplification` goes there, d ln (F/F0) / d ln (t0/T0): 6/5 for short shocks."""
        ratios = self._checked(rise_time)
        cube = ratios**3
        result = np.asarray(1.2 + 3 * cube * (2 * self.second_correction * cube - CORRECTION * self.shape.correction))
        x = np.log(ratios * self.shape.duration_ratio)
        later = x > self.short_end
        if self.series is not None:
            result[later] = 1.2 + self.series.slope(x[later])
        return result

    def slope_error(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Estimate of the error of `slope`, absolute, for the same t0/T0."""
        ratios = self._checked(rise_time)
        result = np.array(_SHORT_SLOPE * self.error(ratios))
        x = np.log(ratios * self.shape.duration_ratio)
        later = x > self.short_end
        if self.series is not None:
            result[later] = self.series.slope_error(x[later])
        return result

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

    # ---------------------------------------------------------------- back again

    def solve(self, amplification: float) -> tuple[float, ...]:
        """All t0/T0 at which the curve has this amplification, ascending; none if it is out of reach.

        Raises
        ------
        InvalidValueError
            When it is not a finite number above 0.
        """
        if problem := _TARGET.problem(amplification):
            raise InvalidValueError.of("amplification", problem)
        n, target = self.shape.duration_ratio, math.log(float(amplification)) - self._limit
        found = []
        end = math.exp(self.short_end) / n

        def off(ratio: float) -> float:
            return 1.2 * math.log(ratio) + float(self._short(ratio)) - target

        # g is negative there and its slope small against 6/5: one solution, later than without it
        if off(end) >= 0:
            begin = min(math.exp(target / 1.2), end) * (1 - 1e-9)
            found.append(bracketed_root(off, begin, end, "t0/T0") if off(begin) < 0 else begin)
        if self.series is not None:
            points = self.series.solve(target + 1.2 * math.log(n), 1.2)
            found += [math.exp(x) / n for x in points]
        return tuple(min(ratio, self.longest_rise_time) for ratio in found)

    @cached_property
    def highest(self) -> tuple[float, float]:
        """t0/T0 of the greatest amplification, and that: no solution is beyond."""
        x = self.short_end
        if self.series is not None:
            x = max(self.series.landmarks(1.2), key=lambda landmark: landmark[1])[0]
        ratio = min(math.exp(x) / self.shape.duration_ratio, self.longest_rise_time)
        return ratio, float(self.amplification(ratio))

    # ---------------------------------------------------------------- files

    def to_dict(self) -> dict[str, Any]:
        """All of it, as JSON holds it."""
        return stored.to_dict(self)

    @classmethod
    def from_dict(cls, document: Any) -> UniversalCurve:
        """The curve that `to_dict` has told, to the last bit.

        Raises
        ------
        InvalidValueError
            When it is none.
        """
        shape, rtol, longest, found, versions = stored.from_dict(document)
        curve = cls.__new__(cls)
        curve._set(shape, rtol, longest, found, versions)
        return curve

    def save(self, file: str | os.PathLike[str]) -> None:
        """Write it to ``file`` as JSON.

        Raises
        ------
        FileAccessError
            When that cannot be written.
        """
        stored.write(file, self.to_dict())

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
        return cls.from_dict(stored.read(file))

    def __str__(self) -> str:
        ratio, most = self.highest
        pieces = self.series.pieces if self.series is not None else ()
        worst = max([self.short_error + _DIGITS, *(piece.error for piece in pieces)])
        later = f", then {len(pieces)} polynomials" if pieces else ""
        lines = [
            f"universal curve of {self.shape}",
            f"  durations      n t0/T0 up to {self.longest:g}, t0/T0 up to {self.longest_rise_time:g}",
            f"  amplification  at most {most:.6g}, at t0/T0 = {ratio:.6g}",
            f"  error          below {worst:.0e} relative ({self.rtol:g} was asked for)",
            f"  made from      {self.simulations} simulations: the law of short shocks up to n t0/T0 ="
            f" {math.exp(self.short_end):.3g}{later}",
        ]
        return "\n".join(lines)

    # ---------------------------------------------------------------- inside

    @cached_property
    def _limit(self) -> float:
        """Logarithm of the amplification over (t0/T0)^(6/5), for short shocks."""
        return math.log(IMPULSE_LIMIT) + 1.2 * math.log(self.shape.area / MOMENTUM)

    def _short(self, ratio: Any) -> Any:
        cube = ratio**3
        return cube * (self.second_correction * cube - CORRECTION * self.shape.correction)

    def _reduced(self, ratios: FloatArray) -> FloatArray:
        """g."""
        if self.series is None:
            return np.asarray(self._short(ratios))
        x = np.log(ratios * self.shape.duration_ratio)
        later = x > self.short_end
        result = np.empty_like(ratios)
        result[~later] = self._short(ratios[~later])
        result[later] = self.series(x[later])
        return result

    def _checked(self, rise_time: npt.ArrayLike) -> FloatArray:
        try:
            ratios = np.array(rise_time, dtype=float)
        except (TypeError, ValueError):
            ratios = np.array(math.nan)
        most = self.longest_rise_time
        wrong = ~((ratios > 0) & (ratios <= most * (1 + _ROUNDING)))
        if wrong.any():
            first = float(ratios[wrong].flat[0])
            got = text_of(rise_time) if ratios.ndim == 0 else f"{first:g}"
            needed = first * self.shape.duration_ratio
            if 0 < needed <= float(_LONGEST.at_most or 0):
                got += f"; make the curve with longest={math.ceil(needed)}"
            raise InvalidValueError.of("rise_time", f"must be t0/T0 > 0 and <= {most:g} (got {got})")
        np.minimum(ratios, most, out=ratios)
        return ratios
