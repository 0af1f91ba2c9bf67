"""Chains with features whose forces an independent code has computed, as scenarios."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import shockwave as sw

#: Name of a chain -> its scenario as text, and its results.
CASES: dict[str, dict[str, Any]] = json.loads((Path(__file__).parents[1] / "data" / "chains.json").read_text())


@cache
def scenario_of(name: str) -> sw.Scenario:
    """Scenario of a reference chain."""
    return sw.Scenario.from_yaml(CASES[name]["scenario"])


@cache
def simulated(name: str, rtol: float) -> Any:
    """Simulation of a reference chain, once for all tests."""
    scenario = scenario_of(name)
    until, contacts = scenario.simulate.until, scenario.simulate.contacts
    return sw.simulate(scenario.excitation, scenario.chain, rtol=rtol, until=until, contacts=contacts)
