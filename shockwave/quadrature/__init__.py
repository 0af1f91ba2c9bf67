"""Quadratures: definite integrals with an error estimate, for profiles without closed forms."""

from shockwave.quadrature.base import FloatArray, Integral, Integrand, Quadrature

__all__ = ["FloatArray", "Integral", "Integrand", "Quadrature"]
