"""Tests of plugins with pytest: the contracts of profiles, contact laws, integrators and quadratures."""

from __future__ import annotations

try:
    import pytest as pytest
except ImportError as error:
    raise ImportError("shockwave.testing needs pytest: python -m pip install pytest") from error

from shockwave.testing.contact_law_contract import ContactLawContract
from shockwave.testing.integrator_contract import IntegratorContract
from shockwave.testing.profile_contract import ProfileContract
from shockwave.testing.quadrature_contract import QuadratureContract

__all__ = ["ContactLawContract", "IntegratorContract", "ProfileContract", "QuadratureContract"]
