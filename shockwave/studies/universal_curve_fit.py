"""Shape of a shock by its integrals, and the laws of its universal curve, fitted to simulations.

One law holds for short shocks, polynomials for longer ones.
"""

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
from shockwave.measurement.simulate import simulate
from shockwave.prediction.short_shock_law import CORRECTION, IMPULSE_LIMIT, correction
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.contract import examine
from shockwave.profiles.shock import Shock
from shockwave.studies.chebyshev_fit import Piece, fitted

# Shapes whose integrals agree to this are the same: a record in other units differs by rounding. The correction is a
# quadrature of its own.
_SAME = {"duration_ratio": 1e-8, "area": 1e-8, "centroid": 1e-8, "correction": 1e-6}
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


@frozen
class Shape:
    """A shape of shock: enough to evaluate a curve and to recognise its shocks.

    Attributes
    ----------
    profile : str
        Class and parameters.
    duration_ratio : float
        n.
    area : float
        a1 + a2, the impulse over F0 t0.
    centroid : float
        Of the force, in units of t0.
    correction : float
        As of `shockwave.prediction.short_shock_law.correction`.
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
            When the profile is not shockwave's own and breaks the contract of `ShockProfile`.
        """
        examine(profile)
        n = float(profile.duration_ratio)
        area = float(profile.areas().total)
        centroid = n - float(profile.double_integral(n)) / area
        return cls(repr(profile), n, area, centroid, correction(profile))

    def fits(self, profile: ShockProfile) -> bool:
        """Whether ``profile`` has this shape."""
        other = Shape.of(profile)
        return all(math.isclose(getattr(self, name), getattr(other, name), rel_tol=_SAME[name]) for name in _SAME)


@frozen(kw_only=True)
class ShortLaw:
    """The law of short shocks, g = -q (t0/T0)^3 + w (t0/T0)^6 with q known beforehand.

    Attributes
    ----------
    second_correction : float
        w.
    end : float
        Logarithm of n t0/T0 up to which it is used.
    error : float
        Bound on its relative error there.
    """

    second_correction: float
    end: float
    error: float = quantity("", "bound on the relative error", at_least=0)


@frozen(kw_only=True)
class CurveData:
    """A universal curve as plain data; see `shockwave.UniversalCurve`."""

    shape: Shape
    rtol: float = quantity("", "relative error allowed", above=0)
    longest: float = quantity("", "longest duration n t0/T0", above=0)
    simulations: int = quantity("", "number of simulations made", at_least=0, whole=True)
    made_with: Mapping[str, str] = field(hash=False)
    short: ShortLaw
    pieces: tuple[Piece, ...]


def scaled_scene(profile: ShockProfile, rise_time: float) -> tuple[Shock, Chain]:
    """A shock with this t0/T0 on a chain: any, as its units cancel."""
    chain = Chain(material=Material(youngs_modulus=1e9, poisson_ratio=0.3, density=1e3), radius=1e-3)
    return Shock(profile=profile, peak_force=1.0, rise_time=rise_time * Scales.of(chain, 1.0).time), chain


@define
class _Simulated:
    """g of a shape by simulation, at the logarithm of n t0/T0."""

    profile: ShockProfile
    shape: Shape
    rtol: float
    evaluations: int = 0
    estimates: dict[float, float] = field(factory=dict)

    def __call__(self, x: float) -> float:
        ratio = math.exp(x) / self.shape.duration_ratio
        result = simulate(*scaled_scene(self.profile, ratio), rtol=self.rtol, waves="primary")
        self.evaluations += result.cost.force_evaluations
        if result.error_estimate >= 1 or self.evaluations > _BUDGET:
            known = max((math.exp(shorter) for shorter in self.estimates if shorter < x), default=0.0)
            raise NumericalError(
                f"there is no curve so long: a simulation of {math.exp(x):.4g} characteristic times is too slow or"
                f" has no error estimate (shorter ones succeed up to {known:.4g}; make the curve or the shock shorter)"
            )
        self.estimates[x] = result.error_estimate
        strength = ratio * self.shape.area / MOMENTUM
        return math.log(result.amplification / IMPULSE_LIMIT) - 1.2 * math.log(strength)

    def greatest_estimate(self, begin: float, end: float) -> float:
        """The greatest error estimate in this range."""
        return max((estimate for x, estimate in self.estimates.items() if begin <= x <= end), default=0.0)


def fitted_curve(profile: ShockProfile, rtol: float, longest: float) -> CurveData:
    """The curve of a shape: its law of short shocks, and the polynomials up to n t0/T0 = ``longest``."""
    shape = Shape.of(profile)
    simulated = _Simulated(profile, shape, max(_SHARE * rtol, _TIGHTEST))
    end = math.log(longest)
    short = _short(simulated, rtol, end)
    probe = math.log(_PROBED)
    while probe < end:
        simulated(probe)
        probe += math.log(2)
    pieces = fitted(simulated, short.end, end, rtol) if short.end < end else ()
    checked = (
        evolve(piece, error=_CAUTION * piece.error + simulated.greatest_estimate(piece.begin, piece.end))
        for piece in pieces
    )
    return CurveData(
        shape=shape,
        rtol=rtol,
        longest=longest,
        simulations=len(simulated.estimates),
        made_with={"shockwave": __version__, "numpy": np.__version__},
        short=short,
        pieces=tuple(checked),
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
