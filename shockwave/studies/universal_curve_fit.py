"""Fit of a universal curve to simulations: an asymptotic law for short shocks, polynomials for longer ones."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from attrs import define, evolve, field, frozen

from shockwave import __version__
from shockwave.chain.chain import Chain, Scales
from shockwave.chain.material import Material
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.errors import NumericalError
from shockwave.fields import quantity
from shockwave.log import logger
from shockwave.measurement.simulate import simulate
from shockwave.prediction.short_shock_law import CORRECTION, IMPULSE_LIMIT, correction
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.contract import examine
from shockwave.profiles.shock import Shock
from shockwave.progress import progressed
from shockwave.studies.chebyshev_fit import Piece, fitted

# Relative tolerances within which the integrals of equal shapes agree: a record in other units differs by rounding. The
# correction is computed by another quadrature.
_SAME = {"duration_ratio": 1e-8, "area": 1e-8, "centroid": 1e-8, "correction": 1e-6}
# Tolerance of a simulation, over that of the curve.
_SIMULATION_RTOL = 0.03
# Tightest tolerance of a simulation.
_TIGHTEST = 1e-12
# The law of short shocks ends where its second term is this multiple of the tolerance; the third term is far smaller.
_SECOND_TERM = 2.0
# Estimate of the second term over the square of the first; the values measured are 1 to 4.
_SQUARE = 1.4
# Duration at which the law of short shocks is checked, over its longest duration.
_CHECK = 0.8
# Factor by which the longest duration is reduced if the check fails.
_REDUCTION = 0.75
# Greatest number of reductions.
_REDUCTIONS = 40
# Beyond this duration [characteristic times], durations are tested by doubling: a simulation without an error estimate
# may take minutes, and longer ones take more.
_TESTED = 50.0
# Greatest number of force evaluations of all simulations of a curve: about twenty seconds for the most expensive ones,
# where waves of nearly equal height separate slowly. Ordinary curves take 1e5.
_BUDGET = 3_000_000
# Reported error over the greatest error of the checks; covers 99.9 % of the errors of 95 shapes at each rtol from 1e-2
# to 1e-6.
_SAFETY = 3.0
# Name of the work whose progress is reported.
_WORK = "simulations of the curve"
#: A chain whose scales cancel in the amplification.
SCALED = Chain(material=Material(youngs_modulus=1e9, poisson_ratio=0.3, density=1e3), radius=1e-3)


@frozen
class Shape:
    """Shape of a shock by its integrals, from which a curve is evaluated and its shocks are recognised.

    Attributes
    ----------
    profile : str
        Class and parameters of the profile.
    duration_ratio : float
        n.
    area : float
        a1 + a2, the impulse over F0 t0.
    centroid : float
        Centroid of the force in time, in units of t0.
    correction : float
        Leading correction of short shocks; see `shockwave.prediction.short_shock_law.correction`.
    """

    profile: str
    duration_ratio: float = quantity("", "n", above=1)
    area: float = quantity("", "impulse over F0 t0", above=0)
    centroid: float = quantity("", "centroid of the force over t0", above=0)
    correction: float = quantity("", "leading correction of short shocks", above=0)

    @classmethod
    def of(cls, profile: ShockProfile) -> Shape:
        """The shape of ``profile``.

        Raises
        ------
        PluginError
            If a profile of a plugin violates the contract of `ShockProfile`.
        """
        examine(profile)
        n = float(profile.duration_ratio)
        area = float(profile.total_area)
        centroid = n - float(profile.double_integral(n)) / area
        return cls(repr(profile), n, area, centroid, correction(profile))

    def fits(self, profile: ShockProfile) -> bool:
        """Whether ``profile`` has this shape."""
        other = Shape.of(profile)
        return all(math.isclose(getattr(self, name), getattr(other, name), rel_tol=_SAME[name]) for name in _SAME)


@frozen(kw_only=True)
class ShortLaw:
    """Law of short shocks, g = -q (t0/T0)^3 + w (t0/T0)^6, where q is an integral of the shape.

    Attributes
    ----------
    second_correction : float
        w.
    end : float
        Logarithm of the greatest n t0/T0 for which the law is used.
    error : float
        Bound on its relative error at that duration.
    """

    second_correction: float
    end: float
    error: float = quantity("", "bound on the relative error", at_least=0)


@frozen(kw_only=True)
class CurveData:
    """Data of a universal curve; see `shockwave.UniversalCurve`."""

    shape: Shape
    rtol: float = quantity("", "relative error allowed", above=0)
    longest: float = quantity("", "longest duration n t0/T0", above=0)
    simulations: int = quantity("", "number of simulations", at_least=0, whole=True)
    made_with: Mapping[str, str] = field(hash=False)
    short: ShortLaw
    pieces: tuple[Piece, ...]


def scaled_shock(profile: ShockProfile, rise_time: float, chain: Chain = SCALED) -> Shock:
    """A shock with this t0/T0 on a chain."""
    return Shock(profile=profile, peak_force=1.0, rise_time=rise_time * Scales.of(chain, 1.0).time)


@define
class _Simulated:
    """g of a shape by simulation, as a function of the logarithm of n t0/T0."""

    profile: ShockProfile
    shape: Shape
    rtol: float
    evaluations: int = 0
    estimates: dict[float, float] = field(factory=dict)

    def __call__(self, x: float) -> float:
        progressed(_WORK, len(self.estimates))
        ratio = math.exp(x) / self.shape.duration_ratio
        result = simulate(scaled_shock(self.profile, ratio), SCALED, rtol=self.rtol, waves="primary")
        self.evaluations += result.cost.force_evaluations
        if result.error_estimate >= 1 or self.evaluations > _BUDGET:
            succeeded = max((math.exp(shorter) for shorter in self.estimates if shorter < x), default=0.0)
            raise NumericalError(
                f"no curve covers this duration: a simulation of {math.exp(x):.4g} characteristic times is too slow or"
                f" has no error estimate (durations up to {succeeded:.4g} succeed; shorten the curve or the shock)"
            )
        self.estimates[x] = result.error_estimate
        strength = ratio * self.shape.area / MOMENTUM
        return math.log(result.amplification / IMPULSE_LIMIT) - 1.2 * math.log(strength)

    def greatest_estimate(self, begin: float, end: float) -> float:
        """Greatest error estimate of the simulations in an interval."""
        return max((estimate for x, estimate in self.estimates.items() if begin <= x <= end), default=0.0)


def fitted_curve(profile: ShockProfile, rtol: float, longest: float) -> CurveData:
    """Fit the law of short shocks of a shape and the polynomials up to n t0/T0 = ``longest``."""
    shape = Shape.of(profile)
    simulated = _Simulated(profile, shape, max(_SIMULATION_RTOL * rtol, _TIGHTEST))
    end = math.log(longest)
    short = _short(simulated, rtol, end)
    for tested in np.arange(math.log(_TESTED), end, math.log(2)).tolist():
        simulated(tested)
    pieces = fitted(simulated, short.end, end, rtol) if short.end < end else ()
    checked = (
        evolve(piece, error=_SAFETY * piece.error + simulated.greatest_estimate(piece.begin, piece.end))
        for piece in pieces
    )
    count = len(simulated.estimates)
    progressed(_WORK, count, count)
    logger.info("universal curve of %s: %d simulations", shape.profile, count)
    return CurveData(
        shape=shape,
        rtol=rtol,
        longest=longest,
        simulations=count,
        made_with={"shockwave": __version__, "numpy": np.__version__},
        short=short,
        pieces=tuple(checked),
    )


def _short(simulated: _Simulated, rtol: float, longest: float) -> ShortLaw:
    """Fit the law of short shocks, which ends at the logarithm ``longest`` or earlier."""
    first = CORRECTION * simulated.shape.correction
    n = simulated.shape.duration_ratio
    # where the estimate of the second term reaches its limit
    end = min(math.log(n) + math.log(math.sqrt(_SECOND_TERM / _SQUARE * rtol) / first) / 3, longest)
    for _ in range(_REDUCTIONS):
        cube = math.exp(3 * end) / n**3
        second = (simulated(end) + first * cube) / cube**2
        check = end + math.log(_CHECK)
        earlier = math.exp(3 * check) / n**3
        difference = abs(simulated(check) - earlier * (second * earlier - first))
        error = _SAFETY * difference + simulated.greatest_estimate(check, end)
        if error <= rtol / 2:
            return ShortLaw(second_correction=second, end=end, error=error)
        end += math.log(_REDUCTION)
    raise NumericalError("the law of short shocks does not hold for the shortest shock tested: the force is too rough")
