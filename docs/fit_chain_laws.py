"""Fit the laws of walls, strikers and damping to simulations of finite chains.

    python docs/fit_chain_laws.py

writes ``shockwave/prediction/chain_laws.json`` in a few minutes. ``--only wall`` (or ``striker``, ``damping``)
fits one of the laws and keeps the others.
"""

from __future__ import annotations

import argparse
import json
import math
import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import evolve
from numpy.polynomial import Chebyshev, Polynomial
from scipy.interpolate import CubicSpline

import shockwave as sw
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.prediction import chain_laws as laws
from shockwave.prediction.short_shock_law import IMPULSE_LIMIT
from shockwave.studies.chebyshev_fit import Piece, fitted

Array = npt.NDArray[np.float64]
FILE = Path(sw.__file__).parent / "prediction" / laws.RESOURCE

STEEL = sw.Material(youngs_modulus=200e9, poisson_ratio=0.3, density=7800.0)
CHAIN = sw.Chain(material=STEEL, radius=5e-3, granules=2)
VELOCITY = 0.5
# Units in which mass and contact stiffness of the granules and the velocity of the striker are 1.
FORCE = (CHAIN.granule_mass**3 * CHAIN.contact_stiffness**2 * VELOCITY**6) ** 0.2
TIME = CHAIN.granule_mass * VELOCITY / FORCE


def simulated(granules: int, until: float, mass_ratio: float = 1.0, chain: sw.Chain = CHAIN, **options: Any) -> Any:
    """Chain under a striker of the same radius and elasticity; times in units of TIME."""
    striker = sw.Impact(velocity=VELOCITY, material=evolve(STEEL, density=mass_ratio * STEEL.density))
    if "interval" in options:
        options["interval"] *= TIME
    return sw.simulate(striker, evolve(chain, granules=granules), until=until * TIME, **options)


# Decimals of the coefficients.
DIGITS = 11
# Tolerance of the simulations, and allowed error of the logarithm of the leading wave and of the rebound.
LEADING_RTOL = 1e-9
LEADING_ACCURACY = 1e-7
# Mass ratio above which the striker collides repeatedly with the first granule, and allowed error of its rebound there.
LIGHT = 1.1
REBOUND_ACCURACY = 1e-3
# Later waves: mass ratios, and weakest wave relative to the leading wave.
TRAIN_RATIOS = np.append([1.16, 1.2], np.geomspace(1.25, laws.MASS_RATIOS[1], 97))
WEAKEST = 2.5e-3
# Mass ratios that separate the pieces, degrees of the last piece and of the others, and number of points of the spline
# to which they are fitted.
SPLITS = (2.0, 3.4, 3.9)
LONG_DEGREE = 18
SHORT_DEGREE = 8
DENSE = 200
# Most samples of the history of a force.
MOST_SAMPLES = 8000


# ---------------------------------------------------------------- wall

# Granules before the wall, where the wave is separated from those that rebound.
BEFORE_WALL = 60
# Least stiffness ratio that is simulated.
SOFTEST = 1e-9
# Stiffness ratios around that at which a further contact opens before the peak, where the law is not smooth.
SWITCH = (0.4, 0.51, 0.52, 0.6)
# Allowed error of W / kappa^0.4.
WALL_ACCURACY = 3e-8


def wall_ratio(kappa: float, wave: float) -> float:
    """W / kappa^0.4 of a wave of peak force ``wave``."""
    compliance = laws.RIGID / max(kappa, SOFTEST) - 1
    material: Any = evolve(STEEL, youngs_modulus=STEEL.youngs_modulus / compliance) if compliance > 1e-14 else "rigid"
    chain = evolve(CHAIN, granules=BEFORE_WALL, end=sw.Wall(material=material))
    until = BEFORE_WALL / 0.83 + 20 + 8 * max(kappa, SOFTEST) ** -0.4
    found = simulated(BEFORE_WALL, until, chain=chain, rtol=1e-12, contacts=[BEFORE_WALL])
    return float(found.transmitted.peak_force / FORCE / wave / max(kappa, SOFTEST) ** 0.4)


def fit_wall() -> dict[str, Any]:
    """Pieces of W / kappa^0.4."""
    wave = simulated(120, 100.0, rtol=1e-12, contacts=[50]).contacts[0].peak_force / FORCE
    edges = (0.0, *SWITCH, laws.RIGID)
    pieces = [
        piece
        for low, high in pairwise(edges)
        for piece in fitted(lambda kappa: wall_ratio(kappa, wave), low, high, WALL_ACCURACY)
    ]
    return {"factor": plain(pieces)}


def plain(pieces: Sequence[Piece]) -> dict[str, Any]:
    """Pieces for the file."""
    return {
        "edges": [pieces[0].begin, *(piece.end for piece in pieces)],
        "coefficients": [[round(each, DIGITS) for each in piece.coefficients] for piece in pieces],
    }


# ---------------------------------------------------------------- striker


def leading(x: float) -> float:
    """ln of the peak force of the leading wave, over the impulse limit of an elastic rebound; x = ln mu."""
    mu = math.exp(x)
    contact = round(50 + 10 * mu**0.65)
    until = 1.3 * (contact + 30) / (0.9 * min(impulse_limit(mu), 1.0) ** (1 / 6)) + 20
    found = simulated(contact + 30, until, mu, rtol=LEADING_RTOL, contacts=[contact])
    return math.log(found.contacts[0].peak_force / FORCE / impulse_limit(mu))


def impulse_limit(mu: float) -> float:
    """Peak force of the leading wave of a light striker, which rebounds with its velocity."""
    return IMPULSE_LIMIT * (2 * mu / MOMENTUM) ** 1.2


def rebound(x: float) -> float:
    """Momentum transferred by the striker over that of an elastic rebound from one granule; x = ln mu."""
    mu = math.exp(x)
    granules, slowest = 60, min(impulse_limit(mu), 1.0) ** (1 / 6)
    found = simulated(granules, 60 / slowest + 300, mu, rtol=1e-10, contacts=[40])
    return (1 - found.velocities[0] / VELOCITY) * (1 + mu) / 2


def train(mu: float) -> Array:
    """Peak forces of the first waves over that of the leading wave, shape (WAVES,), zeros for those that are missing.

    They are local maxima of the force at a distant contact.
    """
    contact = round(60 + 12 * mu**0.65)
    # time in which the last of these waves arrives
    slowness = 3.2 if mu < 5 else 2.0 if mu < 20 else 1.35 if mu < 100 else 1.1
    until = slowness * contact + 60
    interval = max(0.1, until / MOST_SAMPLES)
    found = simulated(contact + 40, until, mu, rtol=1e-8, contacts=[contact], record=["forces"], interval=interval)
    force = found.recording.forces[:, 0] / FORCE
    at = np.flatnonzero((force[3:-3] > force[2:-4]) & (force[3:-3] >= force[4:-2])) + 3
    around = np.arange(-3, 4)
    peaks = [peak(around, force[place + around]) for place in at if force[place] > 1e-3 * force.max()][: laws.WAVES]
    return np.array([*peaks, *[0.0] * (laws.WAVES - len(peaks))]) / peaks[0]


def peak(x: Array, y: Array) -> float:
    """Maximum of the polynomial through seven points, in the middle of which the largest is."""
    polynomial = Polynomial.fit(x, y, 6)
    roots = polynomial.deriv().roots()
    inside = roots.real[(np.abs(roots.imag) < 1e-9) & (np.abs(roots.real) < 1)]
    return float(polynomial(inside).max(initial=y.max()))


def later_wave(x: Array, ratios: Array) -> dict[str, Any]:
    """Pieces of a later wave over the leading wave, from where it exceeds the threshold; x = ln mu."""
    begin = int(np.flatnonzero(ratios <= WEAKEST)[-1]) + 1 if ratios.min() <= WEAKEST else 0
    edges = [begin, *(place for place in np.searchsorted(x, np.log(SPLITS)) if place > begin + 2), len(x) - 1]
    pieces = []
    for low, high in pairwise(edges):
        own = slice(low, high + 1)
        places = np.linspace(x[low], x[high], DENSE)
        heights = CubicSpline(x[own], ratios[own])(places)
        polynomial = Chebyshev.fit(places, heights, LONG_DEGREE if high == edges[-1] else SHORT_DEGREE)
        pieces.append(Piece(x[low], x[high], tuple(polynomial.coef.tolist()), 0.0))
    return plain(pieces)


def fit_striker() -> dict[str, Any]:
    """Leading wave, later waves relative to it, and rebound, as functions of ln mu."""
    low, high = np.log(laws.MASS_RATIOS)
    first = fitted(leading, low, high, LEADING_ACCURACY)
    single, heavy = math.log(LIGHT), math.log(laws.HEAVY)
    back = (
        *fitted(rebound, low, single, LEADING_ACCURACY),
        *fitted(rebound, single, heavy, REBOUND_ACCURACY),
    )
    ratios = np.array([train(mu) for mu in TRAIN_RATIOS])
    later = [later_wave(np.log(TRAIN_RATIOS), column) for column in ratios.T[1:]]
    return {"leading": plain(first), "rebound": plain(back), "later": later}


# ---------------------------------------------------------------- damping

# Damping times over that of the striker's unit, with the number of granules.
DAMPED = ((0.001, 900), (0.003, 600), (0.01, 400), (0.03, 250))
# Contact at which the wave has formed.
FORMED = 15
# Least peak force relative to that at this contact: the force behind the wave forms a second wave later.
LEAST_DECAYED = 0.1


def decay(damping: float, granules: int) -> tuple[Array, Array]:
    """Numbers of contacts, and characteristic times of the wave at them, from the contact where it has formed."""
    chain = evolve(CHAIN, damping=sw.KuwabaraKono(time=damping * TIME))
    contacts = np.arange(FORMED, granules - 1, 5)
    # the characteristic time grows by about 0.113 of that of the damping at each contact
    until = float(np.sum(1.1 + 0.113 * damping * np.arange(granules))) / 0.9 + 20
    found = simulated(granules, until, chain=chain, rtol=1e-7, contacts=contacts.tolist())
    force = np.array([peak.peak_force for peak in found.contacts]) / FORCE
    kept = force >= LEAST_DECAYED * force[0]
    return contacts[kept] - FORMED, force[kept] ** (-1 / 6)


def fit_damping() -> dict[str, Any]:
    """Coefficients of T_n = T + b A n - c A ln(1 + b n A/T), by the least squares of T_n/A, and their iteration."""
    slope, shortfall = 0.113, 0.0
    for _ in range(5):
        columns, targets = [], []
        for damping, granules in DAMPED:
            n, times = decay(damping, granules)
            weight = damping / times
            columns.append(np.stack([n, -np.log1p(slope * n * damping / times[0])]) * weight)
            targets.append((times - times[0]) / damping * weight)
        slope, shortfall = np.linalg.lstsq(np.hstack(columns).T, np.concatenate(targets), rcond=None)[0].tolist()
    return {"slope": round(slope, 5), "shortfall": round(shortfall, 3)}


LAWS = {"wall": fit_wall, "striker": fit_striker, "damping": fit_damping}


def written(entries: dict[str, Any]) -> str:
    """Text of the file, with the coefficients of a piece on one line."""
    text = json.dumps(entries, indent=1)
    return re.sub(r"\[[^][]*\]", lambda numbers: " ".join(numbers[0].split()), text)


def main() -> None:
    """Fit the laws and write them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", choices=LAWS, action="append")
    only = parser.parse_args().only or [*LAWS]
    entries = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
    entries |= {
        "about": "laws of walls, strikers and damping (shockwave.prediction.chain_laws), see docs/chain-laws.md",
        "provenance": {"command": "python docs/fit_chain_laws.py", "shockwave": sw.__version__},
    }
    for name in only:
        entries[name] = LAWS[name]()
        FILE.write_text(written(entries) + "\n", encoding="utf-8")
        print(name, "fitted")


if __name__ == "__main__":
    main()
