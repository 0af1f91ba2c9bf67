"""Quadratures: definite integrals with an error estimate, for profiles without closed forms."""

from shockwave.profiles.quadrature.base import Integral, Integrand, Quadrature

__all__ = ["Integral", "Integrand", "Quadrature"]
