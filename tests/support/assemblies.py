"""Chains in scaled units, for the engine of mixed granules."""

from __future__ import annotations

from typing import Any

import numpy as np
from attrs import evolve

import shockwave as sw
from shockwave.engine.chain_assembly import Assembly
from shockwave.engine.scaled_problem import ScaledProblem

try:
    from shockwave.engine import _chains as compiled
except ImportError:
    compiled = None

#: A triangular pulse of unit force and rise time.
PULSE = ScaledProblem(sw.PowerLaw(rise_exponent=1, decay_exponent=1, duration_ratio=3), 1.0, 1.0)


def uniform(granules: int, exponent: float = 1.5, damping_power: float = 0.0, **changes: Any) -> Assembly:
    """Equal granules before a wall, under a triangular pulse."""
    assembly = Assembly(
        inverse_masses=np.ones(granules),
        stiffnesses=np.ones(granules),
        overlaps=np.zeros(granules),
        exponents=np.full(granules, exponent),
        fixed_wall=True,
        damping=np.zeros(granules),
        damping_powers=np.full(granules, damping_power),
        force=PULSE,
    )
    return evolve(assembly, **changes)


def mixed(granules: int, **changes: Any) -> Assembly:
    """A chain whose first granules are the same for every length."""
    masses = np.random.default_rng(1).uniform(0.5, 2.0, 1000)[:granules]
    return uniform(granules, inverse_masses=1 / masses, **changes)
