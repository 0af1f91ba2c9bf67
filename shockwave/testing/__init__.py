"""Tests for plugins: what a profile, an integrator or a quadrature has signed, clause by clause, for pytest."""

from __future__ import annotations

from shockwave.testing.integrator import IntegratorContract
from shockwave.testing.profile import ProfileContract
from shockwave.testing.quadrature import QuadratureContract

__all__ = ["IntegratorContract", "ProfileContract", "QuadratureContract"]
