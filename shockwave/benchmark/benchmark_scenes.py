"""Scenes of problems and extreme cases: shocks of 100 N on the beads of the paper, in characteristic times."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from attrs import evolve
from numpy.typing import ArrayLike

from shockwave.profiles.exponential import Exponential
from shockwave.profiles.power_law import PowerLaw
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.profiles.tabulated import Tabulated
from shockwave.scenario.scenario import parse_scenario
from shockwave.scenario.yaml_document import parse_document
from shockwave.scene.chain import Chain, Scales
from shockwave.scene.impact import Impact
from shockwave.scene.material_library import PAPER_STEEL
from shockwave.scene.shock import Shock

Scene: TypeAlias = tuple[Shock, Chain]

#: Peak force [N] and chain of the tables in the paper.
FORCE = 100.0
BEADS = Chain(material=PAPER_STEEL, radius=4.75e-3)
#: Characteristic units of this force and chain.
UNITS = Scales.of(BEADS, FORCE)


def make_scene(scene: dict[str, Any]) -> tuple[Any, Chain]:
    """Build a scene by the name of one of the functions below and its arguments."""
    ((name, arguments),) = scene.items()
    scene_of = _SCENES[name]
    return scene_of(**arguments) if isinstance(arguments, dict) else scene_of(*arguments)


def power_law(rise: float, decay: float, ratio: float, rise_time: float, granules: int | None = None) -> Scene:
    """Power law with these exponents; ``rise_time`` in characteristic times."""
    profile = PowerLaw(rise_exponent=rise, decay_exponent=decay, duration_ratio=ratio)
    return _shock(profile, rise_time), evolve(BEADS, granules=granules)


def exponential(rise: float, decay: float, ratio: float, rise_time: float) -> Scene:
    """Exponential shock with these rates; ``rise_time`` in characteristic times."""
    return _shock(Exponential(rise_rate=rise, decay_rate=decay, duration_ratio=ratio), rise_time), BEADS


def _shock(profile: ShockProfile, rise_time: float) -> Shock:
    return Shock(profile=profile, peak_force=FORCE, rise_time=rise_time * UNITS.time)


def record(times: ArrayLike, shares: ArrayLike, granules: int | None = None) -> Scene:
    """Record with samples ``shares``, in units of 100 N, at ``times``, in characteristic times."""
    profile = Tabulated(times=UNITS.time * np.asarray(times), forces=FORCE * np.asarray(shares))
    return Shock(profile=profile), evolve(BEADS, granules=granules)


def interpolated_record(count: int, times: Sequence[float], shares: Sequence[float]) -> Scene:
    """Record that is interpolated at ``count`` equidistant times."""
    finer = np.linspace(times[0], times[-1], count)
    return record(finer, np.interp(finer, times, shares))


def noisy_pulse(count: int) -> Scene:
    """Pulse of 6 characteristic times with noise of 2 % of its peak."""
    share = np.linspace(0.0, 1.0, count)
    forces = np.sin(np.pi * share) ** 2 + np.random.default_rng(3).normal(0.0, 0.02, count)
    forces[[0, -1]] = 0.0
    return record(6.0 * share, np.maximum(forces, 0.0))


def sampled_pulse(count: int, noise: float = 0.0) -> Scene:
    """Pulse of 20 characteristic times with a steeper rise; ``noise`` in units of the peak."""
    share = np.linspace(0.0, 1.0, count)
    forces = np.sin(np.pi * share**0.7) ** 2 + np.random.default_rng(20).normal(0.0, noise, count)
    return record(20.0 * share, np.maximum(forces, 0.0))


def scaled_shock(
    force: float = FORCE,
    radius: float = BEADS.radius,
    modulus: float = BEADS.material.youngs_modulus,
    ratio: float = BEADS.material.poisson_ratio,
    rise_time: float = 2.0,
) -> Scene:
    """One shape and one t0/T0 on a chain of any size; by the scaling law the same problem as on the beads."""
    chain = Chain(material=evolve(BEADS.material, youngs_modulus=modulus, poisson_ratio=ratio), radius=radius)
    profile = PowerLaw(rise_exponent=0.5, decay_exponent=1.0, duration_ratio=3.0)
    return Shock(profile=profile, peak_force=force, rise_time=rise_time * Scales.of(chain, force).time), chain


def chain_with_keys(chain: dict[str, Any], impact: dict[str, Any] | None = None) -> tuple[Shock | Impact, Chain]:
    """Chain with the keys of a scenario, and a triangle of 3 characteristic times or an impact."""
    shock = {"profile": "triangular", "peak_force": FORCE, "rise_time": UNITS.time, "duration_ratio": 3}
    excitation = {"shock": shock} if impact is None else {"impact": impact}
    beads = {"material": "paper-steel", "diameter": 2 * BEADS.radius}
    document = parse_document(json.dumps({"chain": {**beads, **chain}, **excitation}), "case")
    scenario = parse_scenario(document, None)
    return scenario.scene.impact or scenario.shock, scenario.chain


_OF_EQUAL_GRANULES = (power_law, exponential, record, interpolated_record, noisy_pulse, sampled_pulse, scaled_shock)
_SCENES = {scene.__name__: scene for scene in (*_OF_EQUAL_GRANULES, chain_with_keys)}
