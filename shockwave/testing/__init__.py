"""Tests of plugins with pytest: the contracts of profiles, integrators and quadratures, clause by clause."""

from __future__ import annotations

from shockwave.testing.integrator_contract import IntegratorContract
from shockwave.testing.profile_contract import ProfileContract
from shockwave.testing.quadrature_contract import QuadratureContract

__all__ = ["IntegratorContract", "ProfileContract", "QuadratureContract"]
