"""What comes behind the primary, as curves of one shape: the second wave, the recoil, and between how many waves."""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import define, evolve, field, frozen

from shockwave.chain.chain import Scales
from shockwave.curve import stored
from shockwave.curve.build import any_chain
from shockwave.curve.fit import fitted
from shockwave.curve.series import Series
from shockwave.curve.shape import Shape
from shockwave.errors import InvalidValueError
from shockwave.fields import Quantity, text_of
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import simulate
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.theory.short import CORRECTION

__all__ = ["TrainCurve"]

_TOLERANCE = Quantity("", "error allowed", at_least=3e-3, at_most=0.1)
_LONGEST = Quantity("", "longest duration n t0/T0", at_least=1.0, at_most=100)
# The weakest wave that is read. It comes out of nothing, and must not do so with a jump above the tolerance.
_THRESHOLD = 1e-3
_RTOL = 1e-5
# Shocks so short that the primary lacks no more than this share of what a blow would give make one wave and the recoil
# of a blow.
_LACK = 3e-4
# The recoil is a seventh of the impulse at the most, where a second wave may be twice the shock's peak force.
_RECOIL_SHARE = 0.2
_CAUTION = 3.0
_ROUNDING = 1e-12


@define
class _Trains:
    """Simulated trains of a shape, by the logarithm of n t0/T0."""

    profile: ShockProfile
    duration_ratio: float
    known: dict[float, SimulationResult] = field(factory=dict)

    def at(self, x: float) -> SimulationResult:
        if x not in self.known:
            chain = any_chain()
            rise_time = math.exp(x) / self.duration_ratio * Scales.of(chain, 1.0).time
            shock = Shock(profile=self.profile, peak_force=1.0, rise_time=rise_time)
            self.known[x] = simulate(shock, chain, rtol=_RTOL, wave_threshold=_THRESHOLD)
        return self.known[x]

    def second(self, x: float) -> float:
        """Peak force of the second wave over that of the shock, 0 without one."""
        waves = self.at(x).waves
        return waves[1].peak_force if len(waves) > 1 else 0.0

    def recoil(self, x: float) -> float:
        """Momentum of the granules that fly backwards, over the impulse."""
        result = self.at(x)
        return -result.recoil_momentum / result.applied_momentum


@frozen(init=False)
class TrainCurve:
    """Second wave, recoil and number of waves as functions of t0/T0, for every chain and peak force.

    Piecewise Chebyshev series in the logarithm of n t0/T0; nothing and a constant before they begin.

    Parameters
    ----------
    profile : ShockProfile
        The shape.
    tolerance : float
        Error allowed of the second wave's peak force over F0, 3e-3 to 0.1; a fifth of it of the recoil's share.
    longest : float
        Of the durations n t0/T0 for which they are to hold, 1 to 100.

    Attributes
    ----------
    shape : Shape
        What is known of the profile.
    tolerance, longest : float
        As given.
    second_wave, recoil_share : Series
        The two, with errors.
    counts : tuple of (float, int)
        Logarithm of n t0/T0 and number of waves above a thousandth of the primary, where it was simulated; ascending.
    versions : tuple
        Of the programs that made it.

    Raises
    ------
    InvalidValueError
        When a value is out of range, or the shape so concentrated that no shock up to ``longest`` makes a train.
    NumericalError
        When a simulation fails.
    """

    shape: Shape
    tolerance: float
    longest: float
    second_wave: Series
    recoil_share: Series
    counts: tuple[tuple[float, int], ...]
    versions: tuple[tuple[str, str], ...]

    def __init__(self, profile: ShockProfile, tolerance: float = 5e-3, longest: float = 20.0) -> None:
        for name, spec, value in (("tolerance", _TOLERANCE, tolerance), ("longest", _LONGEST, longest)):
            if problem := spec.problem(value):
                raise InvalidValueError.of(name, problem)
        if not isinstance(profile, ShockProfile):
            raise InvalidValueError.of("profile", f"must be a ShockProfile (got {text_of(profile)})")
        shape = Shape.of(profile)
        begin = math.log(shape.duration_ratio) + math.log(_LACK / (CORRECTION * shape.correction)) / 3
        end = math.log(longest)
        if begin >= end:
            problem = (
                f"must be above {math.exp(begin):.3g} for this shape: shorter shocks make one wave, as a blow does"
            )
            raise InvalidValueError.of("longest", f"{problem} (got {longest:g})")
        trains = _Trains(profile, shape.duration_ratio)
        second = _cautious(fitted(trains.second, begin, end, tolerance))
        recoil = _cautious(fitted(trains.recoil, begin, end, _RECOIL_SHARE * tolerance))
        counts = tuple((x, len(result.waves)) for x, result in sorted(trains.known.items()))
        self.__attrs_init__(shape, float(tolerance), float(longest), second, recoil, counts, stored.versions())

    @property
    def simulations(self) -> int:
        """How many it took."""
        return len(self.counts)

    @property
    def longest_rise_time(self) -> float:
        """Greatest t0/T0 at which it holds."""
        return self.longest / self.shape.duration_ratio

    def second(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Peak force of the second wave over that of the shock; 0 where there is none.

        Parameters
        ----------
        rise_time : array_like of float, any shape
            t0/T0, above 0 and at most `longest_rise_time`.

        Raises
        ------
        InvalidValueError
            When one is beyond.
        """
        x = self._checked(rise_time)
        values = np.maximum(self.second_wave(np.maximum(x, self.second_wave.begin)), 0.0)
        return np.where(x > self.second_wave.begin, values, 0.0)

    def recoil(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Momentum of the granules that fly backwards over the impulse, 0 or above; ``rise_time`` as of `second`."""
        x = np.maximum(self._checked(rise_time), self.recoil_share.begin)
        return np.asarray(np.maximum(self.recoil_share(x), 0.0))

    def waves(self, rise_time: npt.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Least and greatest number of waves above a thousandth of the primary; ``rise_time`` as of `second`.

        They are the numbers of the simulated shocks next to this one: where both are the same it is that number,
        unless a wave has come and gone between the two.
        """
        x = self._checked(rise_time)
        known = np.array([point for point, _ in self.counts])
        numbers = np.array([number for _, number in self.counts])
        above = np.clip(np.searchsorted(known, x), 0, len(known) - 1)
        below = np.where((above > 0) & (known[above] > x), above - 1, above)
        return np.minimum(numbers[below], numbers[above]), np.maximum(numbers[below], numbers[above])

    def second_error(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Bound on the error of `second`, absolute."""
        return self.second_wave.error(np.maximum(self._checked(rise_time), self.second_wave.begin))

    def recoil_error(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Bound on the error of `recoil`, absolute."""
        return self.recoil_share.error(np.maximum(self._checked(rise_time), self.recoil_share.begin))

    def _checked(self, rise_time: npt.ArrayLike) -> FloatArray:
        """Logarithms of n t0/T0."""
        try:
            ratios = np.array(rise_time, dtype=float)
        except (TypeError, ValueError):
            ratios = np.array(math.nan)
        most = self.longest_rise_time
        if not np.all((ratios > 0) & (ratios <= most * (1 + _ROUNDING))):
            remedy = f"make the curve with longest above {self.longest:g}"
            raise InvalidValueError.of(
                "rise_time", f"must be t0/T0 > 0 and <= {most:g} (got {text_of(rise_time)}; {remedy})"
            )
        return np.asarray(np.log(np.minimum(ratios * self.shape.duration_ratio, self.longest)))

    # ---------------------------------------------------------------- files

    def to_dict(self) -> dict[str, Any]:
        """All of it, as JSON holds it."""
        return stored.train_to_dict(self)

    @classmethod
    def from_dict(cls, document: Any) -> TrainCurve:
        """The curve that `to_dict` has told, to the last bit.

        Raises
        ------
        InvalidValueError
            When it is none.
        """
        curve = cls.__new__(cls)
        curve.__attrs_init__(*stored.train_from_dict(document))
        return curve

    def save(self, file: str | os.PathLike[str]) -> None:
        """Write it to ``file`` as JSON; see `UniversalCurve.save`."""
        stored.write(file, self.to_dict())

    @classmethod
    def load(cls, file: str | os.PathLike[str]) -> TrainCurve:
        """The curve in ``file``, equal to what was saved; see `UniversalCurve.load`."""
        return cls.from_dict(stored.read(file))

    def __str__(self) -> str:
        second = max(piece.error for piece in self.second_wave.pieces)
        recoil = max(piece.error for piece in self.recoil_share.pieces)
        lines = [
            f"train curve of {self.shape}",
            f"  durations      n t0/T0 up to {self.longest:g}, t0/T0 up to {self.longest_rise_time:g}",
            f"  second wave    within {second:.0e} of the shock's peak force",
            f"  recoil         within {recoil:.0e} of the impulse",
            f"  waves          up to {max(number for _, number in self.counts)}",
            f"  made from      {self.simulations} simulations",
        ]
        return "\n".join(lines)


def _cautious(series: Series) -> Series:
    pieces = tuple(evolve(piece, error=_CAUTION * piece.error + _RTOL) for piece in series.pieces)
    return Series(pieces)
