"""What a curve is made of, found by simulation."""

from __future__ import annotations

import math
from functools import cache

from attrs import define, evolve, field, frozen

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.material import Material
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.errors import NumericalError
from shockwave.measurement.simulate import simulate
from shockwave.prediction.short_shock_law import CORRECTION, IMPULSE_LIMIT
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.shock import Shock
from shockwave.studies.curve.fit import fitted
from shockwave.studies.curve.series import Series
from shockwave.studies.curve.shape import Shape

__all__ = ["Built", "any_chain", "built"]

# Error asked of a simulation, over that of the curve; and the tightest that is worth it.
_SHARE, _TIGHTEST = 0.03, 1e-12
# The law of short shocks is used while its second term is about so many times the tolerance: the third is far less. The
# second is one to four times the square of the first.
_SECOND, _SQUARE = 2.0, 1.4
# Where it is checked, over the longest for which it is used; how much shorter that becomes if the check fails, and how
# often at most.
_CHECK, _SHORTER, _MOST = 0.8, 0.75, 40
# Beyond this durations are tried by doubling: the simulation of one that does not tell its error may take minutes, and
# the longer the more.
_PROBED = 50.0
# Force evaluations of all simulations together that a curve may take: some twenty seconds of the dearest, where waves
# of nearly equal height part slowly. Ordinary curves take a tenth of a million.
_BUDGET = 3_000_000
# An error is told as so many times the greatest that checks have shown; measured on 95 shapes at rtol 1e-2 to 1e-6,
# 99.9 % are covered at each.
_CAUTION = 3.0


@frozen
class Built:
    """The parts of a curve that simulation gives; see `UniversalCurve`."""

    second_correction: float
    short_end: float
    short_error: float
    series: Series | None
    simulations: int


@cache
def any_chain() -> Chain:
    """Any chain will do: its units are taken off again."""
    return Chain(material=Material(youngs_modulus=1e9, poisson_ratio=0.3, density=1e3), radius=1e-3)


@define
class _Simulated:
    """g of a shape by simulation, at the logarithm of n t0/T0."""

    profile: ShockProfile
    shape: Shape
    rtol: float
    count: int = 0
    evaluations: int = 0
    doubts: dict[float, float] = field(factory=dict)

    def __call__(self, x: float) -> float:
        chain = any_chain()
        ratio = math.exp(x) / self.shape.duration_ratio
        shock = Shock(profile=self.profile, peak_force=1.0, rise_time=ratio * Scales.of(chain, 1.0).time)
        result = simulate(shock, chain, rtol=self.rtol, waves="primary")
        self.count += 1
        self.evaluations += result.cost.force_evaluations
        if result.error_estimate >= 1 or self.evaluations > _BUDGET:
            known = max((math.exp(known) for known in self.doubts if known < x), default=0.0)
            unknown = "does not tell how good it is" if result.error_estimate >= 1 else "is too slow"
            raise NumericalError(
                f"there is no curve so long: a simulation of {math.exp(x):.4g} natural times {unknown}"
                f" (shorter ones did up to {known:.4g}; try a longest up to that or in between, or shorten the shock)"
            )
        self.doubts[x] = result.error_estimate
        strength = ratio * self.shape.area / MOMENTUM
        return math.log(result.amplification / IMPULSE_LIMIT) - 1.2 * math.log(strength)

    def doubt(self, begin: float, end: float) -> float:
        """The greatest error estimate in this range."""
        return max((doubt for x, doubt in self.doubts.items() if begin <= x <= end), default=0.0)


def built(profile: ShockProfile, shape: Shape, rtol: float, longest: float) -> Built:
    """Find the law of short shocks and the series of long ones."""
    simulated = _Simulated(profile, shape, max(_SHARE * rtol, _TIGHTEST))
    second_correction, short_end, short_error = _short(simulated, rtol, math.log(longest))
    if short_end >= math.log(longest):
        return Built(second_correction, short_end, short_error, None, simulated.count)
    probe = _PROBED
    while probe < longest:
        simulated(math.log(probe))
        probe *= 2
    series = fitted(simulated, short_end, math.log(longest), rtol)
    pieces = tuple(
        evolve(piece, error=_CAUTION * piece.error + simulated.doubt(piece.begin, piece.end)) for piece in series.pieces
    )
    return Built(second_correction, short_end, short_error, Series(pieces), simulated.count)


def _short(simulated: _Simulated, rtol: float, longest: float) -> tuple[float, float, float]:
    """w, the logarithm of the n t0/T0 up to which the law holds, and its error there."""
    shape = simulated.shape
    first = CORRECTION * shape.correction
    # where the square of the first term is that of the tolerance
    end = math.log(shape.duration_ratio) + math.log(math.sqrt(_SECOND / _SQUARE * rtol) / first) / 3
    end = min(end, longest)
    for _ in range(_MOST):
        cube = math.exp(3 * end) / shape.duration_ratio**3
        second_correction = (simulated(end) + first * cube) / cube**2
        check = end + math.log(_CHECK)
        earlier = math.exp(3 * check) / shape.duration_ratio**3
        off = abs(simulated(check) - earlier * (second_correction * earlier - first))
        error = _CAUTION * off + simulated.doubt(check, end)
        if error <= rtol / 2:
            return second_correction, end, error
        end += math.log(_SHORTER)
    raise NumericalError("the law of short shocks does not show, however short the shock: its force is too uneven")
