"""The two laws of a universal curve, fitted to simulations: one of short shocks, polynomials for longer ones."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from attrs import define, evolve, field

import shockwave
from shockwave.chain.chain import Chain, Scales
from shockwave.chain.material import Material
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.errors import NumericalError
from shockwave.measurement.simulate import simulate
from shockwave.prediction.short_shock_law import CORRECTION, IMPULSE_LIMIT
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.shock import Shock
from shockwave.studies.chebyshev_fit import Piece, fitted
from shockwave.studies.universal_curve_data import CurveData, Shape, ShortLaw

# Error asked of a simulation, over that of the curve; and the tightest that is worth it.
_SHARE = 0.03
_TIGHTEST = 1e-12
# The law of short shocks is used while its second term is about so many times the tolerance: the third is far less. The
# second is one to four times the square of the first.
_SECOND = 2.0
_SQUARE = 1.4
# Where it is checked, over the longest for which it is used; how much shorter that becomes if the check fails, and how
# often at most.
_CHECK = 0.8
_SHORTER = 0.75
_MOST = 40
# Beyond this durations are tried by doubling: a simulation that does not report its error may take minutes, and longer
# ones more.
_PROBED = 50.0
# Force evaluations of all simulations of a curve: some twenty seconds of the most expensive, where waves of nearly
# equal height part slowly. Ordinary curves take a tenth of a million.
_BUDGET = 3_000_000
# The error is reported as so many times the greatest that checks have shown; measured on 95 shapes at rtol 1e-2 to
# 1e-6, 99.9 % are covered at each.
_CAUTION = 3.0


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
    estimates: dict[float, float] = field(factory=dict)

    def __call__(self, x: float) -> float:
        chain = any_chain()
        ratio = math.exp(x) / self.shape.duration_ratio
        shock = Shock(profile=self.profile, peak_force=1.0, rise_time=ratio * Scales.of(chain, 1.0).time)
        result = simulate(shock, chain, rtol=self.rtol, waves="primary")
        self.count += 1
        self.evaluations += result.cost.force_evaluations
        if result.error_estimate >= 1 or self.evaluations > _BUDGET:
            known = max((math.exp(shorter) for shorter in self.estimates if shorter < x), default=0.0)
            unknown = "does not tell how good it is" if result.error_estimate >= 1 else "is too slow"
            raise NumericalError(
                f"there is no curve so long: a simulation of {math.exp(x):.4g} natural times {unknown}"
                f" (shorter ones did up to {known:.4g}; try a longest up to that or in between, or shorten the shock)"
            )
        self.estimates[x] = result.error_estimate
        strength = ratio * self.shape.area / MOMENTUM
        return math.log(result.amplification / IMPULSE_LIMIT) - 1.2 * math.log(strength)

    def greatest_estimate(self, begin: float, end: float) -> float:
        """The greatest error estimate in this range."""
        return max((estimate for x, estimate in self.estimates.items() if begin <= x <= end), default=0.0)


def fitted_curve(profile: ShockProfile, rtol: float, longest: float) -> CurveData:
    """Find the law of short shocks and the polynomials of longer ones, up to n t0/T0 = ``longest``."""
    shape = Shape.of(profile)
    simulated = _Simulated(profile, shape, max(_SHARE * rtol, _TIGHTEST))
    end = math.log(longest)
    short = _short(simulated, rtol, end)
    pieces = _pieces(simulated, rtol, short.end, end) if short.end < end else ()
    return CurveData(
        shape=shape,
        rtol=rtol,
        longest=longest,
        simulations=simulated.count,
        made_with={"shockwave": shockwave.__version__, "numpy": np.__version__},
        short=short,
        pieces=pieces,
    )


def _pieces(simulated: _Simulated, rtol: float, begin: float, end: float) -> tuple[Piece, ...]:
    """The polynomials between two logarithms."""
    probe = math.log(_PROBED)
    while probe < end:
        simulated(probe)
        probe += math.log(2)
    return tuple(
        evolve(piece, error=_CAUTION * piece.error + simulated.greatest_estimate(piece.begin, piece.end))
        for piece in fitted(simulated, begin, end, rtol)
    )


def _short(simulated: _Simulated, rtol: float, longest: float) -> ShortLaw:
    """The law of short shocks, up to the logarithm of ``longest`` at the most."""
    first = CORRECTION * simulated.shape.correction
    n = simulated.shape.duration_ratio
    # where the square of the first term is that of the tolerance
    end = min(math.log(n) + math.log(math.sqrt(_SECOND / _SQUARE * rtol) / first) / 3, longest)
    for _ in range(_MOST):
        cube = math.exp(3 * end) / n**3
        second = (simulated(end) + first * cube) / cube**2
        check = end + math.log(_CHECK)
        earlier = math.exp(3 * check) / n**3
        off = abs(simulated(check) - earlier * (second * earlier - first))
        error = _CAUTION * off + simulated.greatest_estimate(check, end)
        if error <= rtol / 2:
            return ShortLaw(second_correction=second, end=end, error=error)
        end += math.log(_SHORTER)
    raise NumericalError("the law of short shocks does not show, however short the shock: its force is too uneven")
