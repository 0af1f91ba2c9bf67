"""Exponents of the peak force of the leading wave with respect to the parameters of the chain and the shock."""

from __future__ import annotations

from attrs import astuple, frozen

from shockwave.scenario.uncertainty import TWINS
from shockwave.text import significant_digits

#: Parameters that do not change the shape -> exponents of t0/T0 and of the force of first yield, which scales as
#: R^2 E*^-2; those of 1 - nu^2 for Poisson's ratio.
POWERS = {
    "shock.peak_force": (1 / 6, 0),
    "shock.rise_time": (1.0, 0),
    "shock.duration": (1.0, 0),
    "chain.radius": (-4 / 3, 2),
    "chain.diameter": (-4 / 3, 2),
    "chain.material.youngs_modulus": (1 / 3, -2),
    "chain.material.density": (-1 / 2, 0),
    "chain.material.poisson_ratio": (-1 / 3, 2),
}
# Symbols of the fields of `Exponents`, in their order.
_SYMBOLS = ("R", "rho", "E", "nu", "F0", "t0")


@frozen(kw_only=True)
class Exponents:
    """Exponents of the peak force F of the leading wave: d ln F / d ln of each parameter.

    All of them follow from the slope of the universal curve, s = d ln (F/F0) / d ln (t0/T0).

    Attributes
    ----------
    radius, density, youngs_modulus, poisson_ratio : float
        For parameters of the granules: -4/3 s, -s/2, s/3, 2/3 s nu^2/(1 - nu^2).
    peak_force, rise_time : float
        For parameters of the shock: 1 + s/6, s.
    error : float
        Estimate of the absolute error of each exponent.
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
        """Exponents for a slope of the curve and granules with this Poisson's ratio."""
        poisson = 2 / 3 * poisson_ratio**2 / (1 - poisson_ratio**2)
        return cls(
            radius=-4 / 3 * slope,
            density=-1 / 2 * slope,
            youngs_modulus=1 / 3 * slope,
            poisson_ratio=poisson * slope,
            peak_force=1 + 1 / 6 * slope,
            rise_time=slope,
            error=max(4 / 3, poisson) * slope_error,
        )

    def at(self, name: str) -> float:
        """Exponent of the parameter ``name``, one of `POWERS`."""
        return float(getattr(self, dict(TWINS).get(name, name).rpartition(".")[2]))

    def __str__(self) -> str:
        decimals = min(significant_digits(1.0, self.error) - 1, 3)
        powers = zip(_SYMBOLS, astuple(self), strict=False)  # without the error, which is the last field
        return " ".join(f"{symbol}^{power:.{decimals}f}" for symbol, power in powers)
