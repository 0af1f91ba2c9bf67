"""Scenes that several tests share."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import shockwave as sw
from shockwave.chain import Scales

STEEL = sw.Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
CHAIN = sw.Chain(material=STEEL, radius=4.75e-3)
FORCE = 100.0
#: Units in which the shocks of direct.json are written, on the paper's beads.
UNITS = Scales.of(CHAIN, FORCE)

TRUTH: list[dict[str, Any]] = json.loads((Path(__file__).parent / "data" / "direct.json").read_text())


def name_of(case: dict[str, Any]) -> str:
    """An id for a case of direct.json."""
    return f"{TRUTH.index(case)}-{case['kind']}"


def shock_of(case: dict[str, Any]) -> sw.Shock:
    """The shock of a case of direct.json, on the paper's beads at 100 N."""
    if case["kind"] == "tabulated":
        times = [time * UNITS.time for time in case["times"]]
        return sw.Shock(profile=sw.Tabulated(times=times, forces=[force * FORCE for force in case["forces"]]))
    profile: sw.ShockProfile
    if case["kind"] == "power":
        profile = sw.PowerLaw(rise_exponent=case["eta1"], decay_exponent=case["eta2"], duration_ratio=case["n"])
    else:
        profile = sw.Exponential(rise_rate=case["k1"], decay_rate=case["k2"], duration_ratio=case["n"])
    return sw.Shock(profile=profile, peak_force=FORCE, rise_time=case["T"] * UNITS.time)


@cache
def simulated(index: int, rtol: float) -> sw.SimulationResult:
    """Simulation of case ``index`` of direct.json, once for all tests."""
    return sw.simulate(shock_of(TRUTH[index]), CHAIN, rtol=rtol)
