"""The universal curve of a shape: amplification as a function of t0/T0, from few simulations."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import asdict, evolve, frozen

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.chain.yielding import require_elastic
from shockwave.errors import InvalidValueError, NumericalError
from shockwave.fields import Quantity, text_of
from shockwave.files import parse_json, read_bytes, structured, write_file
from shockwave.numerics import crossings
from shockwave.prediction.short_shock_law import CORRECTION, IMPULSE_LIMIT
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.guard import kept
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.result_base import Result
from shockwave.studies.chebyshev_fit import Piece
from shockwave.studies.universal_curve_fit import CurveData, fitted_curve
from shockwave.tables import Table, along
from shockwave.text import facts, paragraph, si, strong

#: Range of the tolerance of a curve.
RTOL = Quantity("", "relative error allowed", at_least=1e-7, at_most=1e-2)
_LONGEST = Quantity("", "longest duration n t0/T0", at_least=1e-3, at_most=1e3)
_TARGET = Quantity("", "amplification", above=0)
# Power of t0/T0 with which the error of the law of short shocks decreases below its end: that of its first term.
_ERROR_POWER = 3
# Error of the slope over that of the law of short shocks: the power of t0/T0 of its third term.
_SLOPE_FACTOR = 9.0
# Relative error of the constants of the law of short shocks.
_CONSTANTS_ERROR = 3e-9
# Fraction by which a rise time may exceed the longest because of rounding.
_ROUNDING = 1e-12
# Fraction by which the search for a solution begins below the solution for an impulse.
_MARGIN = 1e-9
# Points of the curve in a table, and the shortest over the longest rise time there.
_SHOWN = 200
_SHORTEST_SHOWN = 1e-2
_FUNCTIONS = ("amplification", "error", "slope")
_HEADER = {"format": "shockwave universal curve", "version": 1}
# Size limit of a file [bytes]; a curve has some thousands.
_MOST_BYTES = 2**24


@frozen(kw_only=True)
class CurveAnswer:
    """Prediction of a universal curve for one shock on one chain.

    Attributes
    ----------
    peak_force : float
        Peak force of the leading wave [N].
    amplification : float
        Peak force of the leading wave over that of the shock.
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
        amplification = si(self.amplification, "", error=self.error)
        force = si(self.peak_force, "N", error=self.error)
        accuracy = f"accurate to {self.error:.0e} (t0/T0 = {self.rise_time:.6g})"
        lines = paragraph("", f"amplification {amplification}, peak force {force}, {accuracy}", 2)
        return "\n".join(map(strong, lines))


@frozen(init=False, slots=False, repr=False)
class UniversalCurve(Result, CurveData):
    """Amplification as a function of t0/T0, for every endless chain and every peak force.

    With S = (t0/T0) (a1 + a2)/1.652067 the amplification is 1.168181738 S^(6/5) e^g. For short shocks g is
    -q (t0/T0)^3 + w (t0/T0)^6 with q from `shockwave.prediction.short_shock_law`; for longer ones it is a piecewise
    Chebyshev series in the logarithm of n t0/T0.

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
    shape : Shape
        Name and integrals of the profile.
    rtol, longest : float
        The parameters above.
    short : ShortLaw
        g of short shocks.
    pieces : tuple of Piece
        g of longer shocks; empty if the law of short shocks covers all durations.
    simulations : int
        Number of simulations.
    made_with : mapping
        Versions of the programs that computed the curve.

    Raises
    ------
    InvalidValueError
        If an argument is out of range, or the force of the profile is negative somewhere.
    NumericalError
        If a simulation fails.
    """

    def __init__(self, profile: ShockProfile, rtol: float = 1e-4, longest: float = 50.0) -> None:
        if not isinstance(profile, ShockProfile):
            raise InvalidValueError.of("profile", f"must be a ShockProfile (got {text_of(profile)})")
        if profile.pulls:
            raise InvalidValueError.of(
                "profile", "must not pull, because the laws cover no negative forces (got a record)"
            )
        data = fitted_curve(profile, RTOL.checked("rtol", rtol), _LONGEST.checked("longest", longest))
        self.__attrs_init__(**asdict(data, recurse=False))

    @property
    def longest_rise_time(self) -> float:
        """Greatest t0/T0 covered."""
        return self.longest / self.shape.duration_ratio

    @cached_property
    def _landmarks(self) -> FloatArray:
        """All t0/T0 of extrema and of joints between the laws, and the longest, ascending."""
        turns = [x for piece in self.pieces for x in (*piece.turns(1.2), piece.end)]
        return np.asarray(np.exp([self.short.end, *turns]) / self.shape.duration_ratio)

    @cached_property
    def highest(self) -> tuple[float, float]:
        """t0/T0 of the greatest amplification, and this amplification."""
        heights = self.amplification(self._landmarks)
        most = int(heights.argmax())
        return float(self._landmarks[most]), float(heights[most])

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
        ratios = self._checked(rise_time)
        reduced = self._by_law(ratios, lambda x: self._of_short(x, 1, 1), lambda piece: piece.polynomial)
        limit = math.log(IMPULSE_LIMIT) + 1.2 * math.log(self.shape.area / MOMENTUM)
        return np.asarray(np.exp(limit + 1.2 * np.log(ratios) + reduced))

    def error(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Bound on the relative error of `amplification`, for the same t0/T0."""
        return self._by_law(self._checked(rise_time), self._error_of_short, lambda piece: piece.error)

    def slope(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Local exponent of `amplification`, d ln (F/F0) / d ln (t0/T0): 6/5 for short shocks."""
        ratios = self._checked(rise_time)
        return 1.2 + self._by_law(ratios, lambda x: self._of_short(x, 3, 6), lambda piece: piece.polynomial.deriv())

    def slope_error(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Estimate of the absolute error of `slope`, for the same t0/T0."""
        ratios = self._checked(rise_time)
        return self._by_law(ratios, lambda x: _SLOPE_FACTOR * self._error_of_short(x), lambda piece: piece.slope_error)

    def answer(self, shock: Shock, chain: Chain) -> CurveAnswer:
        """Peak force of the leading wave of ``shock`` on ``chain``, which is treated as endless.

        Raises
        ------
        InvalidValueError
            If the shock has another shape, or is longer than the curve covers, or if the chain must be elastic and the
            wave is beyond first yield.
        """
        if not chain.is_uniform:
            from shockwave.chain.coverage import covered  # not needed for equal granules

            chain = covered(chain, shock, "the universal curve")
        if not self.shape.fits(shock.profile):
            rule = f"must have the shape {self.shape.profile}"
            raise InvalidValueError.of("profile", f"{rule} (got {text_of(shock.profile)})")
        return answer_of(self, shock, chain)

    def peak_force(self, shock: Shock, chain: Chain) -> float:
        """Peak force of the leading wave [N]; see `answer`."""
        return self.answer(shock, chain).peak_force

    def solve(self, amplification: float) -> tuple[float, ...]:
        """All t0/T0 with this amplification, ascending; an empty tuple if it is out of reach.

        Raises
        ------
        InvalidValueError
            If it is not a finite number above 0.
        """
        target = math.log(_TARGET.checked("amplification", amplification))
        # the impulse limit is an upper bound of the amplification: no solution is shorter than that of an impulse
        impulse = (amplification / IMPULSE_LIMIT) ** (1 / 1.2) * MOMENTUM / self.shape.area
        first, *others = self._landmarks.tolist()
        least = min(impulse, first) * (1 - _MARGIN)
        return tuple(crossings(lambda ratio: math.log(self.amplification(ratio)) - target, [least, first, *others]))

    _brief = ("shape.profile", "rtol", "longest", "simulations")
    _tables = (("curve", "rise_time"),)

    def _table(self, name: str) -> Table:
        ratios = np.geomspace(_SHORTEST_SHOWN, 1, _SHOWN) * self.longest_rise_time
        return along("rise_time", ratios, {name: getattr(self, name)(ratios) for name in _FUNCTIONS})

    def to_dict(self) -> dict[str, Any]:
        """The document that `save` writes, with all digits; it holds the fields of the shape beside the others."""
        document = asdict(self)
        return {**_HEADER, **document.pop("shape"), **document}

    @classmethod
    def from_dict(cls, document: Mapping[str, Any]) -> UniversalCurve:
        """The curve of a document of `to_dict`, equal to the last bit.

        Raises
        ------
        InvalidValueError
            If the document is not that of a curve.
        """
        known = document if isinstance(document, Mapping) else {}
        for key, value in _HEADER.items():
            if known.get(key) != value:
                raise InvalidValueError.of(key, f"must be {value!r} (got {text_of(known.get(key))})")
        data = structured({**known, "shape": known}, CurveData, "document", "that of a curve")
        curve = cls.__new__(cls)
        curve.__attrs_init__(**asdict(data, recurse=False))
        return curve

    def save(self, file: str | os.PathLike[str]) -> None:
        """Write the curve to ``file`` as JSON; raises FileAccessError if the file cannot be written."""
        write_file(file, json.dumps(self.to_dict(), indent=1, allow_nan=False) + "\n")

    @classmethod
    def load(cls, file: str | os.PathLike[str]) -> UniversalCurve:
        """Read the curve in ``file``, which is equal to the saved one.

        Raises
        ------
        FileAccessError
            If the file cannot be read.
        InvalidValueError
            If the file does not contain a curve.
        """
        document = parse_json(read_bytes(file, _MOST_BYTES), os.fspath(file))
        try:
            return cls.from_dict(document)
        except InvalidValueError as error:
            raise InvalidValueError(evolve(fault, location=os.fspath(file)) for fault in error.faults) from None

    def __str__(self) -> str:
        ratio, most = self.highest
        worst = max([self.short.error + _CONSTANTS_ERROR, *(piece.error for piece in self.pieces)])
        accuracy = f"accurate to {worst:.0e} (requested: {self.rtol:.0e})"
        later = f", {len(self.pieces)} polynomials above" if self.pieces else ""
        source = f"law of short shocks up to n t0/T0 = {math.exp(self.short.end):.3g}{later}"
        lines = facts(
            [
                ("shape", self.shape.profile),
                ("durations", f"n t0/T0 up to {self.longest:g}, t0/T0 up to {self.longest_rise_time:g}"),
                ("amplification", f"at most {si(most, '', error=worst)}, at t0/T0 = {ratio:.6g}"),
                ("computed from", f"{self.simulations} simulations: {source}"),
            ]
        )
        return "\n".join([strong(f"universal curve {accuracy}"), *lines])

    def _by_law(
        self, ratios: FloatArray, of_short: Callable[[FloatArray], FloatArray], of_piece: Callable[[Piece], Any]
    ) -> FloatArray:
        """A function of x = ln (n t0/T0), given for the law of short shocks and for each piece."""
        x = np.log(ratios * self.shape.duration_ratio)
        ends = [self.short.end, *(piece.end for piece in self.pieces)][: len(self.pieces)]
        law = np.searchsorted(ends, x)
        functions = [of_short, *map(of_piece, self.pieces)]
        return np.piecewise(x, [law == k for k in range(len(functions))], functions)

    def _of_short(self, x: FloatArray, first: float, second: float) -> FloatArray:
        """The two terms of the law of short shocks, multiplied by ``first`` and ``second``."""
        cube = np.exp(3 * x) / self.shape.duration_ratio**3
        correction = CORRECTION * self.shape.correction
        return np.asarray(second * self.short.second_correction * cube**2 - first * correction * cube)

    def _error_of_short(self, x: FloatArray) -> FloatArray:
        decrease = np.exp(_ERROR_POWER * np.minimum(x - self.short.end, 0.0))
        return np.asarray(self.short.error * decrease + _CONSTANTS_ERROR)

    def _checked(self, rise_time: npt.ArrayLike) -> FloatArray:
        most = self.longest_rise_time
        ratios = np.asarray(rise_time, dtype=float)
        wrong = ratios[~((ratios > 0) & (ratios <= most * (1 + _ROUNDING)))]
        if wrong.size:
            rule = f"must be t0/T0 > 0 and <= {most:g}"
            raise InvalidValueError.of("rise_time", f"{rule} (got {wrong.flat[0]:g}; increase longest)")
        return np.asarray(np.minimum(ratios, most))


def answer_of(curve: UniversalCurve, shock: Shock, chain: Chain) -> CurveAnswer:
    """`UniversalCurve.answer` without checks that the shock has the shape of the curve and the granules are equal."""
    ratio = Scales.of(chain, shock.peak_force).rise_time(shock.rise_time)
    value = float(curve.amplification(ratio))
    require_elastic(chain, value * shock.peak_force)
    return CurveAnswer(
        peak_force=value * shock.peak_force, amplification=value, error=float(curve.error(ratio)), rise_time=ratio
    )


@kept
def cached_curve(profile: ShockProfile, rtol: float, longest: float) -> UniversalCurve | NumericalError:
    """The curve, or the error of its computation; cached for immutable profiles."""
    try:
        return UniversalCurve(profile, rtol, longest)
    except NumericalError as error:
        return error
