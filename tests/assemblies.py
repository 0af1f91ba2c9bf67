"""The reference chains of ``tests/data/chains.json`` as assemblies in scaled units."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml

import shockwave as sw
from shockwave.simulation.assembly import Assembly
from shockwave.simulation.problem import ChainProblem

REFERENCES: dict[str, Any] = json.loads((Path(__file__).parent / "data" / "chains.json").read_text(encoding="utf-8"))
UNITS = {"GPa": 1e9, "kg/m**3": 1.0, "": 1.0}


class Scaled(NamedTuple):
    """An assembly, the end of its simulated time, and the units of time and force."""

    assembly: Assembly
    until: float
    time: float
    force: float


def number(text: Any) -> float:
    """A number in SI units."""
    value, _, unit = str(text).partition(" ")
    return float(value) * UNITS[unit]


def scaled(name: str) -> Scaled:
    """The chain of a reference; its units are mass and first stiffness of the chain and a force."""
    scene = yaml.safe_load(REFERENCES[name]["scenario"])
    chain, shock, impact = scene["chain"], scene.get("shock"), scene.get("impact")
    balls = [impact] if impact else []
    balls += [segment for segment in chain["granules"] for _ in range(segment.get("count", 1))]
    parts = [{**chain["material"], **ball.get("material", {})} for ball in balls]
    radii = np.array([number(ball.get("diameter", chain["diameter"])) / 2 for ball in balls])
    masses = 4 / 3 * math.pi * radii**3 * [number(part["density"]) for part in parts]
    softness = [(1 - part["poisson_ratio"] ** 2) / number(part["youngs_modulus"]) for part in parts]
    curvatures = [*(1 / radii), 0.0]
    wall = chain.get("end", {}).get("wall")
    if wall is not None:
        softness.append(0.0 if wall == "rigid" else (1 - wall["poisson_ratio"] ** 2) / number(wall["youngs_modulus"]))
    pairs = range(len(softness) - 1)
    k = np.array(
        [4 / 3 / ((softness[j] + softness[j + 1]) * math.sqrt(curvatures[j] + curvatures[j + 1])) for j in pairs]
    )
    mass, stiffness = masses[0], k[0]
    velocity = number(impact["velocity"]) if impact else 0.0
    force = number(shock["peak_force"]) if shock else stiffness**0.4 * (mass * velocity**2) ** 0.6
    time, length = math.sqrt(mass) * stiffness ** (-1 / 3) * force ** (-1 / 6), (force / stiffness) ** (2 / 3)
    damping, power = np.zeros(len(k)), 0.0
    if chain.get("damping", {}).get("model") == "dashpot":
        damping += number(chain["damping"]["coefficient"]) * length / time / force
    elif "damping" in chain:
        damping, power = 1.5 * k / stiffness * number(chain["damping"]["time"]) / time, 0.5
    problem = None
    if shock:
        profile = sw.PowerLaw(duration_ratio=shock["duration_ratio"], **shock["parameters"])
        problem = ChainProblem(profile, number(shock["rise_time"]) / time, 1.0)
    assembly = Assembly(
        inverse_masses=mass / masses,
        stiffnesses=k / stiffness,
        overlaps=(number(chain.get("precompression", 0)) / k) ** (2 / 3) / length,
        exponent=1.5,
        fixed_wall=wall is not None,
        damping=damping,
        damping_power=power,
        force=problem,
        velocity=velocity * time / length,
    )
    return Scaled(assembly, number(scene["simulate"]["until"]) / time, time, force)
