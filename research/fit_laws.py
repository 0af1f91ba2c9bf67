"""Fit the laws in closed form to simulations, and write ``shockwave/scene/closed_form_laws.json``.

    python research/fit_laws.py

takes a minute of an idle processor; the names of laws after it fit these and keep the others.
"""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import evolve
from numpy.polynomial import Chebyshev, Polynomial, chebyshev
from scipy.interpolate import CubicSpline

import shockwave as sw
from shockwave.scene import closed_form_laws as laws
from shockwave.scene.chain import Scales
from shockwave.scene.feature_rules import WAVE_EXPONENTS
from shockwave.scene.solitary_wave import IMPULSE_LIMIT, MOMENTUM, wave_law

Array = npt.NDArray[np.float64]
FILE = Path(laws.__file__).with_name("closed_form_laws.json")
STEEL = sw.Material(youngs_modulus=200e9, poisson_ratio=0.3, density=7800.0)
CHAIN = sw.Chain(material=STEEL, radius=5e-3)
VELOCITY = 0.5
# Units in which mass and contact stiffness of the granules and the velocity of the striker are 1.
FORCE = (CHAIN.granule_mass**3 * CHAIN.contact_stiffness**2 * VELOCITY**6) ** 0.2
TIME = CHAIN.granule_mass * VELOCITY / FORCE
# Decimals of the coefficients, and width below which a piece is not halved: a kink is inside.
DIGITS = 11
NARROWEST = 2e-3


def fitted(function: Callable[[float], float], edges: Sequence[float], degree: int, accuracy: float) -> dict[str, Any]:
    """Chebyshev interpolants of one degree; pieces are halved until their last coefficients are below ``accuracy``."""
    nodes, done, todo = chebyshev.chebpts1(degree + 1), [], [*pairwise(edges)][::-1]
    while todo:
        low, high = todo.pop()
        values = [function(float(x)) for x in (low + high + (high - low) * nodes) / 2]
        coefficients = chebyshev.chebfit(nodes, values, degree)
        if np.abs(coefficients[-3:]).max() > accuracy and high - low > NARROWEST:
            todo += [((low + high) / 2, high), (low, (low + high) / 2)]
        else:
            done.append(Chebyshev(coefficients, domain=(low, high)))
    return table(done)


def table(pieces: Sequence[Chebyshev]) -> dict[str, Any]:
    """Edges and coefficients of polynomials, padded to one length."""
    degree = max(piece.degree() for piece in pieces)
    rows = [np.pad(piece.coef, (0, degree - piece.degree())).round(DIGITS).tolist() for piece in pieces]
    return {"edges": [float(pieces[0].domain[0]), *(float(piece.domain[1]) for piece in pieces)], "coefficients": rows}


def striker(mass_ratio: float, granules: int, until: float, chain: sw.Chain = CHAIN, **options: Any) -> Any:
    """Chain under a striker of the radius and elasticity of its granules; times in units of TIME."""
    impact = sw.Impact(velocity=VELOCITY, material=evolve(STEEL, density=mass_ratio * STEEL.density))
    return sw.simulate(impact, evolve(chain, granules=granules), until=until * TIME, **options)


# ---------------------------------------------------------------- impulses and short shocks

# Duration of an impulse over the time of its wave; the error scales as its power p + 1.
IMPULSE = 1e-5
# Pulses of the fit: seed, number, least spread, power of the spread to which the weights are inverse.
SEED = 3601
COUNT = 4000
LEAST_SPREAD = 0.01
WEIGHT = 2.0
# Powers of spread and skewness in the terms of ln(F/limit).
POWERS = ((2.5, 0), (3.5, 0), (4.5, 0), (5.5, 0), (2.5, 1), (3.5, 1), (3.5, 2))
# Ends of the bands of the spread with a largest error.
BANDS = (0.0, 0.1, 0.2, 0.3, 0.45, laws.MOST_SPREAD)
GAUSS = np.polynomial.legendre.leggauss(100)


def impulse_limit(exponent: float) -> float:
    """I_p, from a very short shock with the impulse of a wave of 1 N."""
    chain = evolve(CHAIN, contact=sw.PowerContact(exponent=exponent, stiffness=1e10))
    peak_force = 2 * wave_law(exponent).momentum / IMPULSE
    rise_time = IMPULSE / 2 * Scales.of(chain, 1.0).time
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=2), peak_force=peak_force, rise_time=rise_time)
    return float(sw.simulate(shock, chain, rtol=1e-11).peak_force)


def fit_impulse() -> dict[str, Any]:
    """ln(I_p - 1) as a function of ln(p - 1)."""
    ends = [math.log(end - 1) for end in WAVE_EXPONENTS]
    return fitted(lambda x: math.log(impulse_limit(1 + math.exp(x)) - 1), (ends[0], math.log(0.2), ends[1]), 14, 1e-8)


def random_profile(draw: np.random.Generator, kind: int) -> sw.ShockProfile:
    """A power law, an exponential or a record of one to ten peaks, inside or outside the conditions (3)."""
    ratio = 1 + 10 ** draw.uniform(-1, 1.1)
    if kind == 0:
        rise, decay = 2 ** draw.uniform(-3, 3, 2)
        return sw.PowerLaw(rise_exponent=rise, decay_exponent=decay, duration_ratio=ratio)
    if kind == 1:
        rise, decay = draw.uniform(-6, 6, 2)
        return sw.Exponential(rise_rate=rise, decay_rate=decay, duration_ratio=ratio)
    forces = draw.uniform(0.05, 1, draw.integers(1, 12))
    return sw.Tabulated(times=np.append(0, np.cumsum(draw.uniform(0.1, 1, len(forces) + 1))), forces=[0, *forces, 0])


def moments(profile: sw.ShockProfile) -> tuple[float, float, float]:
    """Integral, standard deviation and skewness of the force over F0 as a function of t/t0."""
    nodes, weights, decay = (1 + GAUSS[0]) / 2, GAUSS[1] / 2, profile.duration_ratio - 1
    s = np.append(nodes, 1 + decay * nodes)
    density = np.append(weights, decay * weights) * profile.force(s)
    density /= density.sum()
    off = s - (density * s).sum()
    second, third = ((density * off**power).sum() for power in (2, 3))
    return profile.areas().total, math.sqrt(second), float(third / second**1.5)


def random_shocks(seed: int, count: int) -> tuple[Array, list[sw.Shock]]:
    """Strength, spread and skewness of random shocks of 100 N, shape (3, count), and the shocks."""
    draw, units = np.random.default_rng(seed), Scales.of(CHAIN, 100.0)
    rows: list[tuple[float, float, float]] = []
    shocks: list[sw.Shock] = []
    while len(rows) < count:
        profile = random_profile(draw, len(rows) % 3)
        area, sigma, skewness = moments(profile)
        spread = draw.uniform(LEAST_SPREAD, laws.MOST_SPREAD)
        time = (spread * MOMENTUM / sigma * (MOMENTUM / area) ** 0.2) ** (1 / 1.2)
        if abs(skewness) <= laws.MOST_SKEWNESS:
            rows.append((area * time / MOMENTUM, spread, skewness))
            shocks.append(sw.Shock(profile=profile, peak_force=100.0, rise_time=time * units.time))
    return np.array(rows).T, shocks


def amplifications(shocks: list[sw.Shock]) -> Array:
    """Simulated F/F0."""
    results: list[Any] = sw.simulate_many(shocks, CHAIN, rtol=1e-6, waves="primary")
    return np.array([result.amplification for result in results])


def short_columns(spread: Array, skewness: Array) -> Array:
    """Terms of the law of short shocks."""
    return np.stack([spread**a * skewness**b for a, b in POWERS], axis=1)


def fit_short() -> dict[str, Any]:
    """Coefficients of -ln(F/limit) by weighted least squares, and their largest errors on other pulses."""
    (strength, spread, skewness), shocks = random_shocks(SEED, COUNT)
    off = -np.log(amplifications(shocks) / (IMPULSE_LIMIT * strength**1.2))
    columns, weight = short_columns(spread, skewness), spread**-WEIGHT
    coefficients = np.linalg.lstsq(columns * weight[:, None], off * weight, rcond=None)[0].round(4)
    (strength, spread, skewness), shocks = random_shocks(SEED + 1, COUNT)
    law = IMPULSE_LIMIT * strength**1.2 * np.exp(-short_columns(spread, skewness) @ coefficients)
    error = np.abs(law / amplifications(shocks) - 1)
    largest = [float(error[(spread >= low) & (spread < high)].max().round(5)) for low, high in pairwise(BANDS)]
    return {"powers": POWERS, "coefficients": coefficients.tolist(), "spreads": BANDS[1:], "largest_errors": largest}


# ---------------------------------------------------------------- walls

# Granules before the wall, where the wave is separated from those that rebound, and least stiffness ratio simulated.
BEFORE_WALL = 60
SOFTEST = 1e-9
# Stiffness ratios around that at which a further contact opens before the peak, where the law is not smooth.
SWITCH = (0.4, 0.51, 0.52, 0.6)


def wall_ratio(kappa: float, wave: float) -> float:
    """W / kappa^0.4 of a wave of peak force ``wave``."""
    kappa = max(kappa, SOFTEST)
    compliance = laws.RIGID / kappa - 1
    material: Any = evolve(STEEL, youngs_modulus=STEEL.youngs_modulus / compliance) if compliance > 1e-14 else "rigid"
    until = BEFORE_WALL / 0.83 + 20 + 8 * kappa**-0.4
    chain = evolve(CHAIN, granules=BEFORE_WALL, end=sw.Wall(material=material))
    found = striker(1.0, BEFORE_WALL, until, chain, rtol=1e-12, contacts=[BEFORE_WALL])
    return float(found.transmitted.peak_force / FORCE / wave / kappa**0.4)


def formed_wave() -> float:
    """Peak force of the wave of a striker of mass ratio 1."""
    return float(striker(1.0, 120, 100.0, rtol=1e-12, contacts=[50]).contacts[0].peak_force / FORCE)


def fit_wall() -> dict[str, Any]:
    """W / kappa^0.4 as a function of kappa."""
    wave = formed_wave()
    return fitted(lambda kappa: wall_ratio(kappa, wave), (0.0, *SWITCH, laws.RIGID), 12, 1e-8)


# ---------------------------------------------------------------- strikers

# Least mass ratio, and that above which the striker collides repeatedly with the first granule.
LIGHTEST = 1e-3
LIGHT = 1.1
# Later waves: mass ratios of the simulations, weakest wave over the leading one, mass ratios that separate the pieces.
TRAINS = np.append([1.16, 1.2, 1.205, 1.21, *np.arange(1.22, 1.4, 0.02)], np.geomspace(1.4, laws.HEAVIEST, 97))
WEAKEST = 2.5e-3
SPLITS = (2.0, 3.4, 3.9)


def leading_wave(mass_ratio: float) -> float:
    """Peak force of the leading wave."""
    contact, slowness = round(50 + 10 * mass_ratio**0.65), max(mass_ratio, 1e-3) ** -0.2
    until = 1.3 * (contact + 30) / 0.9 * max(slowness, 1.0) + 20
    found = striker(mass_ratio, contact + 30, until, rtol=1e-9, contacts=[contact])
    return float(found.contacts[0].peak_force / FORCE)


def leading(x: float) -> float:
    """ln of the leading wave over the impulse limit of an elastic rebound; x = ln mu."""
    mass_ratio = math.exp(x)
    return math.log(leading_wave(mass_ratio) / (IMPULSE_LIMIT * (2 * mass_ratio / MOMENTUM) ** 1.2))


def rebound(x: float) -> float:
    """Momentum transferred by the striker over that of an elastic rebound from one granule; x = ln mu."""
    mass_ratio = math.exp(x)
    until = 60 * max(mass_ratio**-0.2, 1.0) + 300
    return float((1 - striker(mass_ratio, 60, until, rtol=1e-10).velocities[0] / VELOCITY) * (1 + mass_ratio) / 2)


def train(mass_ratio: float) -> Array:
    """Peak forces of the first six waves over that of the leading wave, from the force at a distant contact."""
    contact = round(60 + 12 * mass_ratio**0.65)
    slowness = 3.2 if mass_ratio < 5 else 2.0 if mass_ratio < 20 else 1.35 if mass_ratio < 100 else 1.1
    until = slowness * contact + 60
    recording = {"record": ["forces"], "interval": max(0.1, until / 8000) * TIME, "contacts": [contact]}
    force = striker(mass_ratio, contact + 40, until, rtol=1e-8, **recording).recording.forces[:, 0]
    at = np.flatnonzero((force[3:-3] > force[2:-4]) & (force[3:-3] >= force[4:-2])) + 3
    peaks = np.array([peak(force[place - 3 : place + 4]) for place in at if force[place] > 1e-3 * force.max()][:6])
    return np.asarray(np.pad(peaks, (0, 6 - len(peaks))) / peaks[0])


def peak(y: Array) -> float:
    """Maximum of the polynomial through seven points, in the middle of which the largest is."""
    polynomial = Polynomial.fit(np.arange(-3, 4), y, 6)
    roots = polynomial.deriv().roots()
    inside = roots.real[(np.abs(roots.imag) < 1e-9) & (np.abs(roots.real) < 1)]
    return float(polynomial(inside).max(initial=y.max()))


def fit_later() -> list[dict[str, Any]]:
    """Second to sixth wave over the leading wave, from where they exceed the threshold, as functions of ln mu."""
    x, laws_of_waves = np.log(TRAINS), []
    for ratios in np.array([train(float(mass_ratio)) for mass_ratio in TRAINS]).T[1:]:
        begin = int(np.flatnonzero(ratios <= WEAKEST)[-1]) + 1 if ratios.min() <= WEAKEST else 0
        edges = [begin, *(place for place in np.searchsorted(x, np.log(SPLITS)) if place > begin + 2), len(x) - 1]
        pieces = []
        for low, high in pairwise(edges):
            places = np.linspace(x[low], x[high], 200)
            heights = CubicSpline(x[low : high + 1], ratios[low : high + 1])(places)
            pieces.append(Chebyshev.fit(places, heights, 18 if high == edges[-1] else 12))
        laws_of_waves.append(table(pieces))
    return laws_of_waves


def fit_rebound() -> dict[str, Any]:
    """Rebound as a function of ln mu."""
    low, single, heavy = np.log([LIGHTEST, LIGHT, laws.HEAVY])
    light = fitted(rebound, (low, single), 12, 3e-8)
    repeated = fitted(rebound, (single, heavy), 12, 1e-4)
    return {
        "edges": light["edges"] + repeated["edges"][1:],
        "coefficients": light["coefficients"] + repeated["coefficients"],
    }


# ---------------------------------------------------------------- damping

# Damping times over TIME, each with a number of granules; contact at which the wave has formed; least peak force
# relative to that there, because the force behind the wave forms a second wave later.
DAMPED = ((0.001, 900), (0.003, 600), (0.01, 400), (0.03, 250))
FORMED = 15
LEAST_DECAYED = 0.1


def decay(damping: float, granules: int) -> tuple[Array, Array]:
    """Numbers of contacts, and characteristic times of the wave at them, from the contact where it has formed."""
    chain = evolve(CHAIN, granules=granules, damping=sw.KuwabaraKono(time=damping * TIME))
    contacts = np.arange(FORMED, granules - 1, 5)
    until = float(np.sum(1.1 + 0.113 * damping * np.arange(granules))) / 0.9 + 20
    found = striker(1.0, granules, until, chain, rtol=1e-7, contacts=contacts.tolist())
    force = np.array([each.peak_force for each in found.contacts]) / FORCE
    formed = force >= LEAST_DECAYED * force[0]
    return contacts[formed] - FORMED, force[formed] ** (-1 / 6)


def fit_damping() -> dict[str, Any]:
    """Coefficients of T_n = T + b A n - c A ln(1 + b n A/T), by the least squares of T_n/A, and their iteration."""
    waves = [(damping, *decay(damping, granules)) for damping, granules in DAMPED]
    slope, shortfall = 0.113, 0.0
    for _ in range(5):
        columns = [np.stack([n, -np.log1p(slope * n * a / times[0])]) * a / times for a, n, times in waves]
        targets = [(times - times[0]) / times for _, _, times in waves]
        slope, shortfall = np.linalg.lstsq(np.hstack(columns).T, np.concatenate(targets), rcond=None)[0].tolist()
    return {"slope": round(slope, 5), "shortfall": round(shortfall, 3)}


# ---------------------------------------------------------------- tapers

# Reductions of the radius; granules by which the ratio is constant to 3e-8, and contact at which it is read, before
# the end of the chain changes the force. A weak reduction needs more granules, as the wave adapts slowly.
TAPERED = [max(0.002, q) for q in (laws.MOST_TAPERED / 2 * (1 + chebyshev.chebpts1(16))).tolist()]
LONGEST_TAPER = 400
BEFORE_END = 16


def taper_ratio(reduction: float) -> float:
    """Peak force at a contact far along a geometric taper over that at the contact before."""
    granules = round(min(max(100, 12 + 1.2 / reduction**0.8), LONGEST_TAPER))
    first = 10 * CHAIN.radius
    taper = sw.Taper(first=first, last=first * (1 - reduction) ** (granules - 1), spacing="geometric")
    chain = evolve(CHAIN, radius=first, granules=[sw.Segment(count=granules, radius=taper)])
    last = granules - BEFORE_END
    result: Any = sw.simulate(sw.Impact(velocity=0.01), chain, rtol=1e-11, contacts=[last - 1, last])
    return float(result.contacts[1].peak_force / result.contacts[0].peak_force)


def fit_taper() -> dict[str, Any]:
    """Coefficients of P in (1 - q)^(1/5 + q P(q)), by least squares of the logarithm of the ratio."""
    q = np.array(TAPERED)
    losses = np.log([taper_ratio(each) for each in TAPERED]) / np.log1p(-q) - 0.2
    polynomial = Polynomial.fit(q, losses / q, 5, w=-q * np.log1p(-q)).convert()
    return {"coefficients": [round(float(c), 3) for c in polynomial.coef]}


LAWS: dict[str, Callable[[], Any]] = {
    "impulse": fit_impulse,
    "short": fit_short,
    "wall": fit_wall,
    "leading": lambda: fitted(leading, np.log([LIGHTEST, 1.0, 1.3, 1.5, laws.HEAVIEST]).tolist(), 14, 3e-8),
    "later": fit_later,
    "rebound": fit_rebound,
    "damping": fit_damping,
    "taper": fit_taper,
}


def main(names: Sequence[str]) -> None:
    """Fit the laws and write them, with the coefficients of a piece on one line."""
    tables = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
    tables["about"] = "laws of shockwave.scene.closed_form_laws, see docs/universal.md; written by research/fit_laws.py"
    for name in names or LAWS:
        tables[name] = LAWS[name]()
        text = json.dumps(tables, indent=1)
        FILE.write_text(re.sub(r"\[[^][]*\]", lambda row: " ".join(row[0].split()), text) + "\n", encoding="utf-8")
        print(name, "fitted")


if __name__ == "__main__":
    main(sys.argv[1:])
