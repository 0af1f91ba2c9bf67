"""Tests for plugins: the contract of a profile, an integrator or a quadrature, clause by clause, for pytest."""

from __future__ import annotations

from shockwave.testing.integrator import IntegratorContract
from shockwave.testing.profile import ProfileContract
from shockwave.testing.quadrature import QuadratureContract

__all__ = ["IntegratorContract", "ProfileContract", "QuadratureContract"]
