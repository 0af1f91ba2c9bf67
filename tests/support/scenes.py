"""Scenes that several tests share."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import shockwave as sw
from shockwave.scene.chain import Scales

STEEL = sw.Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
CHAIN = sw.Chain(material=STEEL, radius=4.75e-3)
FORCE = 100.0
#: Units in which the shocks of direct.json are written, on the paper's beads.
UNITS = Scales.of(CHAIN, FORCE)

TRUTH: list[dict[str, Any]] = json.loads((Path(__file__).parents[1] / "data" / "direct.json").read_text())


#: A power law that begins with an infinite slope.
POWER = sw.PowerLaw(rise_exponent=0.5, decay_exponent=1, duration_ratio=3)


def power(rise_time: float) -> sw.Shock:
    """A shock of 100 N that begins with an infinite slope; its rise time is in characteristic times."""
    return sw.Shock(profile=POWER, peak_force=FORCE, rise_time=rise_time * UNITS.time)


def lasting(profile: sw.ShockProfile, duration: float) -> sw.Shock:
    """A shock of 100 N; its duration is in characteristic times."""
    return sw.Shock(profile=profile, peak_force=FORCE, duration=duration * UNITS.time)


def record(times: ArrayLike, forces: ArrayLike) -> sw.Shock:
    """A recorded shock; its times are in characteristic times, its forces over 100 N."""
    return sw.Shock(profile=sw.Tabulated(times=np.multiply(times, UNITS.time), forces=np.multiply(forces, FORCE)))


def power_law(duration_ratio: float, rise: float, decay: float) -> sw.PowerLaw:
    """A power law with these exponents."""
    return sw.PowerLaw(rise_exponent=rise, decay_exponent=decay, duration_ratio=duration_ratio)


def triangle(duration: float) -> sw.Shock:
    """A triangular shock of 100 N; its duration is in characteristic times."""
    return sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=FORCE, rise_time=duration / 3 * UNITS.time)


#: A short shock, and a long one that makes a train; both are known to 20 digits.
CASE_A = power(2.0)
CASE_B = sw.Shock(
    profile=sw.PowerLaw(rise_exponent=1, decay_exponent=1, duration_ratio=10),
    peak_force=FORCE,
    rise_time=10 * UNITS.time,
)


def random_pulses(seed: int, count: int, shortest: float = 0.03, longest: float = 40.0) -> list[sw.Shock]:
    """Pulses of 100 N of all kinds in turn, with durations in characteristic times, from short to long."""
    draw = np.random.default_rng(seed)
    return [_random_pulse(draw, index % 3, shortest, longest) for index in range(count)]


def _random_pulse(draw: np.random.Generator, kind: int, shortest: float, longest: float) -> sw.Shock:
    total = float(np.exp(draw.uniform(np.log(shortest), np.log(longest)))) * UNITS.time
    profile: sw.ShockProfile
    if kind == 2:  # a record of one to ten peaks
        forces = np.concatenate(([0.0], draw.uniform(0.05, 1.0, draw.integers(2, 12)), [0.0]))
        times = np.append(0.0, np.cumsum(draw.uniform(0.1, 1.0, len(forces) - 1)))
        return sw.Shock(profile=sw.Tabulated(times=total * times / times[-1], forces=FORCE * forces / forces.max()))
    ratio = draw.uniform(1.2, 12.0)
    if kind == 0:
        profile = sw.PowerLaw(
            rise_exponent=draw.choice([0.3, 0.5, 1.0, 2.0, 4.0]),
            decay_exponent=draw.choice([0.5, 1.0, 2.0, 5.0]),
            duration_ratio=ratio,
        )
    else:
        rise, decay = draw.uniform(-5.0, 5.0, 2)
        profile = sw.Exponential(rise_rate=rise, decay_rate=decay, duration_ratio=ratio)
    return sw.Shock(profile=profile, peak_force=FORCE, rise_time=total / ratio)


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
def simulated(index: int, rtol: float) -> sw.Simulation:
    """Simulation of case ``index`` of direct.json, once for all tests."""
    return sw.simulate(shock_of(TRUTH[index]), CHAIN, rtol=rtol)
