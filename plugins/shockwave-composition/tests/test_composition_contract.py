"""The numbered contracts of `Integrator` and `OneStep`, clause by clause."""

from __future__ import annotations

from shockwave.testing import IntegratorContract

from shockwave_composition.blanes_moan import BlanesMoan4, BlanesMoan6, BlanesMoan6Long
from shockwave_composition.verlet_richardson import VerletRichardson


class TestBlanesMoan(IntegratorContract):
    integrators = (BlanesMoan4, BlanesMoan6, BlanesMoan6Long)


class TestVerletRichardson(IntegratorContract):
    integrators = (VerletRichardson,)
