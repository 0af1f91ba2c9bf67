"""Exponents: the powers with which the peak force of the primary scales with what makes the scene."""

from __future__ import annotations

import math

from attrs import astuple, frozen

from shockwave.scenario.uncertainty import TWINS

#: Values that leave the shape alone -> the power with which t0/T0 scales with them; none for Poisson's ratio.
POWERS = {
    "shock.peak_force": 1 / 6,
    "shock.rise_time": 1.0,
    "shock.duration": 1.0,
    "chain.radius": -4 / 3,
    "chain.diameter": -4 / 3,
    "chain.material.youngs_modulus": 1 / 3,
    "chain.material.density": -1 / 2,
    "chain.material.poisson_ratio": math.nan,
}
# Signs of the fields of `Exponents` in equations.
_SIGNS = ("R", "rho", "E", "nu", "F0", "t0")


@frozen(kw_only=True)
class Exponents:
    """Powers with which the peak force of the primary scales with what makes the scene: d ln F / d ln of each.

    All follow from the slope s of the curve, d ln (F/F0) / d ln (t0/T0).

    Attributes
    ----------
    radius, density, youngs_modulus, poisson_ratio : float
        Of the granules: -4/3 s, -s/2, s/3, 2/3 s nu^2/(1 - nu^2).
    peak_force, rise_time : float
        Of the shock: 1 + s/6, s.
    error : float
        Estimate of the absolute error of each.
    """

    radius: float
    density: float
    youngs_modulus: float
    poisson_ratio: float
    peak_force: float
    rise_time: float
    error: float

    @classmethod
    def of(cls, slope: float, slope_error: float, poisson_ratio: float) -> Exponents:
        """Those at a slope of the curve, of granules with this Poisson's ratio nu."""
        of_poisson = 2 / 3 * poisson_ratio**2 / (1 - poisson_ratio**2)
        return cls(
            radius=-4 / 3 * slope,
            density=-1 / 2 * slope,
            youngs_modulus=1 / 3 * slope,
            poisson_ratio=of_poisson * slope,
            peak_force=1 + 1 / 6 * slope,
            rise_time=slope,
            error=max(4 / 3, of_poisson) * slope_error,
        )

    def at(self, name: str) -> float:
        """That of the value called ``name``, which leaves the shape alone."""
        return float(getattr(self, dict(TWINS).get(name, name).rpartition(".")[2]))

    def __str__(self) -> str:
        powers = zip(_SIGNS, astuple(self), strict=False)  # the error is last
        return " ".join(f"{sign}^{power:.3f}" for sign, power in powers)
