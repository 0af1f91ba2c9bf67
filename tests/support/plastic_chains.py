"""Chains with elastic-plastic contacts in scaled units, and those that independent codes have computed."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import shockwave as sw
from shockwave.engine.chain_assembly import Assembly
from shockwave.engine.chain_plastic import PlasticContacts
from shockwave.scene.elastic_plastic import Loading
from support.assemblies import uniform

#: Reference chains by name, and restitutions of two spheres by velocity.
REFERENCE: dict[str, Any] = json.loads((Path(__file__).parents[1] / "data" / "plastic.json").read_text())


@cache
def reference_scenario(name: str) -> sw.Scenario:
    """Scenario of a reference chain."""
    return sw.Scenario.from_yaml(REFERENCE["cases"][name]["scenario"])


def plastic(
    granules: int, strength: float = 0.01, rate: float = 0.0, radius: float = 500.0, some: Any = True, **changes: Any
) -> Assembly:
    """Equal granules before a wall; ``some`` contacts yield, from a force of about 0.2 on for a ``radius`` of 500."""
    count = np.ones(granules)
    law = Loading(count, radius * count, np.where(some, strength, np.inf) * count)
    contacts = PlasticContacts(law, rate * count, 1e-6 * count)
    return uniform(granules, plastic=contacts, **changes)
