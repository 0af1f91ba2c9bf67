"""Results for chains beyond equal spheres beside published ones; ``docs/validation.md`` states the sources of all."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from attrs import evolve, frozen
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import shockwave as sw
from shockwave.scene.elastic_plastic import Loading
from shockwave.scene.layout import Layout

from .sampled_peak import sampled_peak

SCENES = Path(__file__).parents[2] / "profiles" / "validation"
# Relative tolerance of all simulations.
RTOL = 1e-8
# Coefficients of the series of the restitution for low velocities (Ramirez et al. 1999).
SERIES = (1.15344, 0.79826)
# Digits that are shown beyond those of a reference.
MORE_DIGITS = 2
Array = NDArray[np.float64]


@frozen
class Row:
    """A result beside its reference, which is the text of a number; the estimated error is relative."""

    quantity: str
    reference: str
    value: float
    estimate: float | None = None

    @property
    def difference(self) -> float:
        """Relative difference from the reference."""
        return self.value / float(self.reference) - 1

    @property
    def agrees(self) -> bool:
        """Whether the difference is within the rounding of the reference and the estimated error."""
        rounding = 0.501 * 10.0**-self.decimals
        return abs(self.value - float(self.reference)) <= rounding + (self.estimate or 0.0) * abs(self.value)

    @property
    def decimals(self) -> int:
        """Number of decimals of the reference."""
        return len(self.reference.partition(".")[2])

    def __str__(self) -> str:
        estimate = "-" if self.estimate is None else f"{max(self.estimate, 1e-15):.0e}"
        shown = f"{self.value:.{self.decimals + MORE_DIGITS}f}"
        difference = "within rounding" if self.agrees else f"{self.difference:+.1e}"
        return f"| {self.quantity} | {self.reference} | {shown} | {estimate} | {difference} |"


@frozen
class Unit:
    """Mass, stiffness and radius of a chain of equal spheres, and scaled units of an impact on it."""

    material: sw.Material
    radius: float
    velocity: float = 1.0

    @property
    def mass(self) -> float:
        """Mass of a sphere [kg]."""
        return self.material.density * 4 / 3 * math.pi * self.radius**3

    @property
    def stiffness(self) -> float:
        """Stiffness of a contact of two spheres [N/m^(3/2)]."""
        modulus = self.material.youngs_modulus / (2 * (1 - self.material.poisson_ratio**2))
        return 4 / 3 * modulus * math.sqrt(self.radius / 2)

    @property
    def force(self) -> float:
        """Force for which mass, stiffness and velocity are 1 [N]."""
        return float(self.stiffness**0.4 * (self.mass * self.velocity**2) ** 0.6)

    @property
    def time(self) -> float:
        """Time for which mass, stiffness and velocity are 1 [s]."""
        return float((self.mass**2 / (self.stiffness**2 * self.velocity)) ** 0.2)


def scene(name: str) -> tuple[Any, sw.Chain, Unit]:
    """Impact, chain and units of a scenario file."""
    scenario = sw.load_scenario(SCENES / f"{name}.yaml")
    impact, chain = scenario.excitation, scenario.chain
    return impact, chain, Unit(chain.material, chain.radius, impact.velocity)


def scaled(material: sw.Material, density: float = 1.0, modulus: float = 1.0) -> sw.Material:
    """The material with multiples of density and Young's modulus."""
    return evolve(
        material, density=material.density * density, youngs_modulus=material.youngs_modulus * modulus, name=None
    )


# ---------------------------------------------------------------- published results


def taperchain() -> Iterator[Row]:
    """Velocity of the granules in the wave and force on the wall in the run of TaperChain."""
    impact, chain, unit = scene("taperchain")
    # contact 50 and the granule between contacts 49 and 50, long before the wave returns
    end = 1.9e-3
    wave = sw.simulate(impact, chain, rtol=RTOL, contacts=[50], until=end, record=["field"], interval=0.02 * unit.time)
    recording = wave.recording
    velocities = recording.velocities[:, 50]
    yield Row("peak velocity of granule 50 over that of the first bead", "0.6815", peak(velocities) / impact.velocity)
    wall = sw.simulate(impact, chain, rtol=RTOL, contacts=[50], until=2.9e-3).transmitted
    yield Row("force on the wall, N", "36.22", wall.peak_force, wall.error_estimate)


def restitution() -> Iterator[Row]:
    """Restitution of two spheres with Kuwabara and Kono's damping, without and with the cut-off of attraction."""
    impact, chain, unit = scene("collision")
    time = chain.damping.time
    for velocity, uncut, cut in ((0.1, "0.809", "0.8116"), (3.0, "0.661", "0.6732")):
        yield Row(f"{velocity} m/s, with attraction (separate integration)", uncut, rebound(unit, time, velocity))
        result = sw.simulate(evolve(impact, velocity=velocity), chain, rtol=RTOL)
        yield Row(f"{velocity} m/s, never attractive", cut, result.restitution, result.error_estimate)
    for velocity in (1e-4, 1e-6, 1e-8):
        result = sw.simulate(evolve(impact, velocity=velocity), chain, rtol=RTOL)
        loss = 1.5 * time * (2 * unit.stiffness / unit.mass) ** 0.4 * velocity**0.2
        series = 1 - SERIES[0] * loss + SERIES[1] * loss**2
        yield Row(
            f"{velocity:.0e} m/s, two terms of the series", f"{series:.5f}", result.restitution, result.error_estimate
        )


def rebound(unit: Unit, time: float, velocity: float) -> float:
    """Restitution of two spheres that part when the overlap is zero again, by DOP853 of SciPy."""
    reduced, k = unit.mass / 2, unit.stiffness
    scale = (reduced / k) ** 0.4 * velocity**-0.2

    def rates(_: float, state: Array) -> list[float]:
        overlap = max(float(state[0]), 0.0)
        return [state[1], -k * (overlap**1.5 + 1.5 * time * math.sqrt(overlap) * state[1]) / reduced]

    def apart(now: float, state: Array) -> float:
        return float(state[0]) if now > 0.1 * scale else 1.0

    apart.terminal = True  # type: ignore[attr-defined]
    start = [0.0, velocity]
    run = solve_ivp(rates, (0, 20 * scale), start, "DOP853", events=apart, rtol=1e-11, atol=1e-16, max_step=scale / 20)
    return float(-run.y[1, -1] / velocity)


def lazaridi() -> Iterator[Row]:
    """Force on the wall in the chain of Lazaridi and Nesterenko, and with other values of what is uncertain."""
    impact, chain, _ = scene("lazaridi-nesterenko")

    def wall(chain: sw.Chain, impact: sw.Impact = impact) -> tuple[float, float]:
        found = sw.simulate(impact, chain, rtol=RTOL).transmitted
        return found.peak_force, found.error_estimate

    steel = chain.material
    yield Row("force on the wall, computed in 1985, N", "83", *wall(chain))
    yield Row("the same, 20 beads", "83", *wall(evolve(chain, granules=20)))
    yield Row("the same, rigid wall", "83", *wall(evolve(chain, end=sw.Wall(material="rigid"))))
    sphere = evolve(impact, material=steel, radius=chain.radius * 5 ** (1 / 3))
    yield Row("the same, the striker a larger sphere of steel", "83", *wall(chain, sphere))
    stiffer = scaled(steel, modulus=1.05)
    other = evolve(impact, material=scaled(impact.material, modulus=1.05))
    yield Row("the same, E 210 GPa", "83", *wall(evolve(chain, material=stiffer), other))
    yield Row("force on the wall, measured in 1985, N", "71", *wall(chain))
    for time in (2e-8, 4e-8, 8e-8):
        damped = evolve(chain, damping=sw.KuwabaraKono(time=time))
        yield Row(f"the same, Kuwabara-Kono time {1e9 * time:.0f} ns", "71", *wall(damped))


# ---------------------------------------------------------------- precise references


def walls() -> Iterator[Row]:
    """Wall force over the force of the solitary wave, for walls of several stiffnesses."""
    impact, chain, unit = scene("taperchain")
    before = sw.simulate(impact, chain, rtol=RTOL, contacts=[50], until=70 * unit.time).contacts[0]
    references = {
        0.25: "1.0143524", 0.5: "1.3449538", 1.0: "1.7504034", math.sqrt(2): "1.9439025", 2.0: "2.1110769",
        2 * math.sqrt(2): "2.2383756",
    }  # fmt: skip
    for kappa, reference in references.items():
        # kappa = 2 sqrt(2) r/(1 + r) with the ratio r of the moduli of wall and spheres
        soft = scaled(chain.material, modulus=kappa / (2 * math.sqrt(2) - kappa)) if kappa < 2.8 else "rigid"
        wall = sw.simulate(impact, evolve(chain, end=sw.Wall(material=soft)), rtol=RTOL, until=2.9e-3).transmitted
        estimate = wall.error_estimate + before.error_estimate
        yield Row(f"k_wall/k = {kappa:.5g}", reference, wall.peak_force / before.peak_force, estimate)


#: Mass ratio of striker and granule, velocity of the striker afterwards, peak forces of the waves.
STRIKERS = {
    0.5: ("-0.36339", "0.38824"),
    1.0: ("-0.0710850", "0.6395542"),
    2.0: (None, "0.95026", "0.13456", "0.02112"),
    5.0: (None, "1.37709", "0.63372", "0.31242", "0.15896"),
    10.0: (None, "1.65379", "1.06960", "0.72754", "0.50687"),
}
# Contact at which the waves of a train are separate, number of granules, and end in scaled time.
TRAIN_CONTACT, TRAIN_GRANULES, TRAIN_END = 200, 400, 620


def strikers() -> Iterator[Row]:
    """Waves and striker's velocity for strikers of several masses with the same contact stiffness."""
    impact, chain, unit = scene("striker")
    chain = evolve(chain, granules=TRAIN_GRANULES)
    for ratio, (velocity, *forces) in STRIKERS.items():
        striker = evolve(impact, radius=chain.radius, material=scaled(chain.material, density=ratio))
        contacts, end, interval = [TRAIN_CONTACT], TRAIN_END * unit.time, 0.05 * unit.time
        result = sw.simulate(
            striker, chain, rtol=RTOL, contacts=contacts, until=end, record=["forces"], interval=interval
        )
        if velocity is not None:
            yield Row(f"mu = {ratio:g}: velocity of the striker", velocity, result.velocities[0] / impact.velocity)
        history = result.recording.forces[:, 0] / unit.force
        found = peaks(history)[: len(forces)]
        for number, (reference, force) in enumerate(zip(forces, found, strict=True), 1):
            estimate = result.contacts[0].error_estimate if number == 1 else None
            yield Row(f"mu = {ratio:g}: wave {number}", reference, force, estimate)


def dimers() -> Iterator[Row]:
    """Decay of the leading wave of dimers at anti-resonances and between them."""
    impact, chain, unit = scene("dimer")
    references = {
        0.3428: ("0.45511", "0.45511"), 0.1548: ("0.44370", "0.44370"), 0.0901: ("0.43677", "0.43677"),
        0.59: (None, "0.368"), 0.24: (None, "0.609"),
    }  # fmt: skip
    for ratio, (near, far) in references.items():
        light = sw.Segment(material=scaled(chain.material, density=ratio))
        cell = sw.Cell(repeat=180, cell=[sw.Segment(), light])
        until = 700 * unit.time
        result = sw.simulate(impact, evolve(chain, granules=(light, cell)), rtol=RTOL, contacts=[40, 340], until=until)
        one, other = result.contacts
        if near is None:
            estimate = one.error_estimate + other.error_estimate
            name = f"mass ratio {ratio}: force at contact 340 over that at contact 40"
            yield Row(name, far, other.peak_force / one.peak_force, estimate)
        else:
            for reference, contact in ((near, one), (far, other)):
                name = f"mass ratio {ratio}: force at contact {contact.contact}"
                yield Row(name, reference, contact.peak_force / unit.force, contact.error_estimate)


#: Total peak force over the static force, contacts between which the speed is measured, speed by another simulation.
SPEEDS = (
    (1.344, 150, 200, "1.0162"),
    (1.344, 700, 900, "1.0162"),
    (2.725, 250, 350, "1.0703"),
    (9.796, 250, 350, "1.2104"),
)


def precompression() -> Iterator[Row]:
    """Speed of solitary waves on a static force, over the speed of sound, against Coste's formula."""
    impact, chain, unit = scene("coste")
    static = chain.precompression
    sound = math.sqrt(1.5) * unit.stiffness ** (1 / 3) * static ** (1 / 6) / math.sqrt(unit.mass)

    def wave(velocity: float, first: int, last: int) -> tuple[float, float, float]:
        """Total peak force over the static force, speed over that of sound between two contacts, error of the speed."""
        striker, longer = evolve(impact, velocity=velocity), evolve(chain, granules=last + 100)
        until = (last + 60) / sound
        result = sw.simulate(striker, longer, rtol=RTOL, contacts=[first, last], until=until)
        one, other = result.contacts
        passage = other.time - one.time
        # the error of the time of a peak is at most 10 rtol characteristic times
        error = 2 * 10 * RTOL * result.characteristic_time / passage
        return other.peak_force / static, (last - first) / passage / sound, error

    for ratio, first, last, simulated in SPEEDS:

        def excess(velocity: float, *place: float) -> float:
            return wave(velocity, int(place[0]), int(place[1]))[0] - place[2]

        velocity = brentq(excess, 0.01, 1.0, (first, last, ratio), xtol=1e-6)
        _, speed, estimate = wave(velocity, first, last)
        name = f"f = {ratio}, contacts {first} to {last}"
        yield Row(f"{name}, separate simulation", simulated, speed, estimate)
        yield Row(f"{name}, Coste's formula", f"{coste(ratio):.5f}", speed, estimate)


def coste(f: float) -> float:
    """Speed of a solitary wave of total peak force f times the static force, over the speed of sound."""
    return math.sqrt(4 / 15 * (3 + 2 * f ** (5 / 3) - 5 * f ** (2 / 3))) / (f ** (2 / 3) - 1)


def peak(history: Array) -> float:
    """Greatest maximum of a history."""
    return sampled_peak(history, 1.0)[0]


def peaks(history: Array) -> list[float]:
    """All maxima of a history, in the order of time."""
    inner = (history[1:-1] > history[:-2]) & (history[1:-1] >= history[2:]) & (history[1:-1] > 1e-3)
    return [peak(history[place - 4 : place + 7]) for place in np.flatnonzero(inner).tolist()]


#: Comparisons with rows of a reference, in the order of the page.
# ---------------------------------------------------------------- finite elements

# Law, rate constant and velocity of ten free beads, and the greatest forces at contacts 0, 2, 4, 6 and 8.
BEADS = {
    ("elastic", 0.0, 5): ("697.9", "618.2", "601.2", "595.3", "582.6"),
    ("elastic", 0.0, 20): ("3737.8", "3328.4", "3244.1", "3220.1", "3171.2"),
    ("plastic", 0.0, 5): ("598.8", "467.3", "376.5", "312.0", "279.2"),
    ("plastic", 0.0, 20): ("2899.0", "1805.0", "1287.6", "942.1", "741.9"),
    ("rate-dependent", 0.035, 5): ("666.9", "548.3", "484.2", "435.6", "399.0"),
    ("rate-dependent", 0.035, 20): ("3229.5", "2275.6", "1776.1", "1472.1", "1203.5"),
}
# Yield strength [MPa] -> forces at overlaps of 20, 50 and 100 um of two spheres with E 100 GPa.
STATIC = {
    600: ("188.4", "599.2", "1366.1"),
    1000: ("227.0", "763.0", "1826.2"),
    2000: ("270.6", "968.0", "2493.6"),
}
# Velocity [m/s] -> restitution of two of the beads.
RESTITUTION = {1: "0.958", 5: "0.781", 10: "0.708", 20: "0.629", 50: "0.486"}


def finite_elements() -> Iterator[Row]:
    """Forces in chains of ten beads, at given overlaps, and restitution of two beads, by finite elements."""
    scenario = sw.load_scenario(SCENES / "finite-elements.yaml")
    chain = scenario.chain
    for (law, constant, velocity), references in BEADS.items():
        contact = None if law == "elastic" else chain.contact
        beads = evolve(chain, material=evolve(chain.material, rate_constant=constant), contact=contact)
        result = sw.simulate(sw.Impact(velocity=velocity), beads, rtol=RTOL, contacts=[0, 2, 4, 6, 8])
        for each, reference in zip(result.contacts, references, strict=True):
            quantity = f"{law}, {velocity} m/s: force at contact {each.contact}, N"
            yield Row(quantity, reference, each.peak_force, each.error_estimate)
    for strength, references in STATIC.items():
        material = evolve(chain.material, youngs_modulus=100e9, yield_strength=strength * 1e6)
        pairs = sw.Chain(material=material, radius=chain.radius, granules=2, end=sw.Wall())
        layout = Layout.of(evolve(pairs, contact=chain.contact), scenario.excitation)
        ratios = strength * 1e6 / layout.pairs.moduli
        loading = Loading(layout.pairs.stiffnesses, layout.pairs.radii, ratios)
        for overlap, reference in zip((20, 50, 100), references, strict=True):
            quantity = f"strength {strength} MPa: static force at an overlap of {overlap} um, N"
            yield Row(quantity, reference, float(loading.force(np.full(ratios.shape, overlap * 1e-6))[0]))
    pair = evolve(chain, granules=1)
    for velocity, reference in RESTITUTION.items():
        result = sw.simulate(sw.Impact(velocity=velocity), pair, rtol=RTOL)
        yield Row(f"restitution at {velocity} m/s", reference, result.restitution, result.error_estimate)


CHECKS: dict[str, Callable[[], Iterator[Row]]] = {
    "taperchain": taperchain,
    "restitution": restitution,
    "walls": walls,
    "strikers": strikers,
    "dimers": dimers,
    "precompression": precompression,
    "lazaridi": lazaridi,
    "finite-elements": finite_elements,
}
