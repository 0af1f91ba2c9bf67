"""Tests of plugins with pytest: the contracts of profiles, integrators and quadratures, clause by clause."""

from __future__ import annotations

from shockwave.testing.integrator import IntegratorContract
from shockwave.testing.profile import ProfileContract
from shockwave.testing.quadrature import QuadratureContract

__all__ = ["IntegratorContract", "ProfileContract", "QuadratureContract"]
