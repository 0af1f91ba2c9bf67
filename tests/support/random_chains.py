"""Seeded random chains with all features mixed, each with its excitation."""

from __future__ import annotations

import numpy as np

import shockwave as sw
from shockwave.registry.registry import load

SEED = 5000
MATERIALS = ("stainless-steel-302", "ptfe", "brass-260", "aluminium-6061-t6", "paper-steel", "copper", "tungsten")


def scene(number: int, most: int = 200) -> tuple[sw.Shock | sw.Impact, sw.Chain]:
    """One random chain with its excitation."""
    draw = np.random.default_rng((SEED, number))

    def between(low: float, high: float) -> float:
        return float(np.exp(draw.uniform(np.log(low), np.log(high))))

    def material() -> sw.Material:
        return load("materials", MATERIALS[draw.integers(len(MATERIALS))])

    def segment(count: int) -> sw.Segment:
        form: dict[str, object] = {}
        if draw.random() < 0.5:
            form["material"] = material()
        kind = draw.random()
        if kind < 0.3:
            form["diameter"] = between(2e-3, 20e-3)
        elif kind < 0.55 and count > 1:
            spacing = ("linear", "geometric")[draw.integers(2)]
            form["diameter"] = sw.Taper(first=between(4e-3, 12e-3), last=between(4e-3, 12e-3), spacing=spacing)
        if gaps and draw.random() < 0.5:
            form["gap"] = between(1e-8, 1e-5)
        return sw.Segment(count=count, **form)

    loaded = draw.random() < 0.35
    gaps = not loaded and draw.random() < 0.3
    parts: list[sw.Segment | sw.Cell] = []
    for _ in range(draw.integers(1, 4)):
        if draw.random() < 0.25:
            cell = [segment(int(draw.integers(1, 3))) for _ in range(draw.integers(2, 4))]
            parts.append(sw.Cell(repeat=int(draw.integers(2, 12)), cell=cell))
        else:
            parts.append(segment(int(between(1, most / 3))))
    if sum(part.granules for part in parts) < 2:
        parts.append(sw.Segment())
    features: dict[str, object] = {}
    hertz = draw.random() < 0.8
    if not hertz:
        exponent = float(draw.choice([1.25, 2.0, 2.5, 3.0]))
        features["contact"] = sw.PowerContact(exponent=exponent, stiffness=3e9 * 1e-6 ** (1.5 - exponent))
    kind = draw.random()
    if kind < 0.15:
        features["damping"] = sw.KuwabaraKono(time=between(1e-7, 1e-5))
    elif kind < 0.3:
        features["damping"] = sw.Dashpot(coefficient=between(0.1, 30.0))
    elif kind < 0.4 and hertz:
        features["damping"] = sw.Tsuji(restitution=float(draw.uniform(0.3, 0.99)))
    kind, wall = draw.random(), ("same", "rigid", material())[draw.integers(3)]
    if kind < 0.5:
        features["end"] = sw.Wall(material=wall)
    elif kind < 0.65:
        spring, dashpot = float(draw.choice([0.0, 1e5, 1e6])), float(draw.choice([0.0, 0.0, 50.0]))
        features["end"] = sw.Wall(material=wall, mass=between(1e-3, 5.0), stiffness=spring, damping=dashpot)
    if loaded:
        features["precompression"] = between(0.01, 100.0)
        if "end" in features and draw.random() < 0.4:
            features["gravity"] = 9.81
    chain = sw.Chain(material=material(), diameter=float(draw.uniform(5e-3, 12e-3)), granules=parts, **features)
    if draw.random() < 0.3:
        size = between(3e-3, 25e-3) if draw.random() < 0.5 else None
        return sw.Impact(velocity=between(0.05, 5.0), diameter=size), chain
    ratio = float(draw.uniform(1.5, 10.0))
    profile: sw.ShockProfile = sw.Triangular(duration_ratio=ratio)
    if draw.random() < 0.5:
        rise, decay = float(draw.choice([0.5, 1.0, 2.0])), float(draw.choice([0.5, 1.0, 3.0]))
        profile = sw.PowerLaw(rise_exponent=rise, decay_exponent=decay, duration_ratio=ratio)
    return sw.Shock(profile=profile, peak_force=between(5, 500), duration=between(3e-6, 4e-4)), chain
