"""Measure the error of section 4 against simulations, over shapes, durations and duration ratios.

    python docs/map_section4.py

writes, in about two minutes and reproducibly on one machine,

- ``docs/section4/map.csv``: predicted and simulated peak forces for twelve shapes over the plane (n t0/T0, n);
- ``docs/section4/map.png``: the errors, the borders of the regimes, and where the conditions (3) fail;
- ``docs/section4/pulses.csv``: random shocks with built-in profiles that satisfy (3), with measures and peak forces;
- ``shockwave/prediction/expected_error.json``: the laws fitted to these shocks, for ranges of errors, and their tables
  in ``docs/trust.md``.

``--only map``, ``pulses``, ``laws`` or ``picture`` performs one step; the last two read the existing tables.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import shockwave as sw
from shockwave.chain import Scales
from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM
from shockwave.prediction.expected_error import RESOURCE, Law, monomials
from shockwave.prediction.model_interface import ScaledAnswer, ScaledShock, Settings
from shockwave.prediction.section4 import predict
from shockwave.prediction.shock_measures import measures
from shockwave.profiles.conditions import conditions

Array = NDArray[np.float64]

FOLDER = Path(__file__).parent / "section4"
PAGE = Path(__file__).parent / "trust.md"
LAWS = Path(sw.__file__).parent / "prediction" / RESOURCE

# For a given shape the amplification depends only on n t0/T0, so that chain and force are arbitrary.
CHAIN = sw.Chain(material=sw.Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0), radius=4.75e-3)
FORCE = 100.0
SCALES = Scales.of(CHAIN, FORCE)
# Requested relative error of the simulations.
RTOL = 1e-4

# Durations n t0/T0 and duration ratios n of the map.
DURATIONS = np.geomspace(0.1, 60.0, 45)
RATIOS = np.geomspace(1.1, 100.0, 27)

# Seed of the random shocks, their number, and the number of those of the regime single in addition.
SEED = 20240
COUNT = 7600
SINGLES = 400
# Range of the durations n t0/T0.
SHORTEST = 0.1
LONGEST = 60.0
# Range of durations in which one wave becomes many and more shocks are drawn.
BETWEEN = (1.5, 10.0)
# Largest error estimate of a simulation that is used.
MOST_DOUBT = 1e-3

# Upper ends of the bands of residuals of each law: spreads of the short law, which is valid up to the last, and
# logarithms of the strength of the long law.
SHORT = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.6, 0.7, 0.8)
LONG = tuple(math.log(strength) for strength in (1.4, 2.0, 2.8, 4.0, 6.0, 9.0, 14.0, 20.0))
# Fraction of the residuals of a band that is left out at each end.
TAIL = 0.01
# Each end of a band is extended by this fraction of its width ...
WIDENED = 0.125
# ... and by this, for the errors of simulations and tables.
LEAST = 5e-4
# Fraction of the shocks, the most unusual ones, that is outside the range of validity of a law.
OUTSIDE = 0.005
# Significant digits in the tables.
DIGITS = 6

MEASURES = ("strength", "spread", "skewness", "mean_force", "cubic_mean_force")

Maker = Callable[[float], sw.ShockProfile]


def record(rise: Callable[[Array], Array], decay: Callable[[Array], Array]) -> Maker:
    """Records of 41 samples of a shape; rise and decay are functions of the elapsed fraction of their duration."""
    share = np.linspace(0, 1, 21)
    forces = np.concatenate((rise(share), decay(share[1:])))
    times = np.concatenate((share, 1 + share[1:]))
    return lambda n: sw.Tabulated(times=times, forces=np.clip(forces, 0, 1), duration_ratio=n)


def power(rise: float, decay: float) -> Maker:
    """Power laws with these exponents."""
    return lambda n: sw.PowerLaw(rise_exponent=rise, decay_exponent=decay, duration_ratio=n)


def exponential(rise: float, decay: float) -> Maker:
    """Exponential profiles with these rates."""
    return lambda n: sw.Exponential(rise_rate=rise, decay_rate=decay, duration_ratio=n)


SHAPES: dict[str, Maker] = {
    "power law 0.00001, 1": power(1e-5, 1),
    "power law 0.5, 1": power(0.5, 1),
    "power law 0.5, 3": power(0.5, 3),
    "power law 1, 8": power(1, 8),
    "triangular": lambda n: sw.Triangular(duration_ratio=n),
    "power law 2, 1": power(2, 1),
    "power law 1, 0.5": power(1, 0.5),
    "exponential 2, 2": exponential(2, 2),
    "exponential 0, 8": exponential(0, 8),
    "exponential -2, 2": exponential(-2, 2),
    "record, sine and blast": record(lambda u: np.sin(np.pi / 2 * u), lambda u: (1 - u) * np.exp(-2 * u)),
    "record, half sine": record(lambda u: np.sin(np.pi / 2 * u), lambda u: np.cos(np.pi / 2 * u)),
}


def scaled(shock: sw.Shock) -> ScaledShock:
    """``shock`` in scaled units."""
    return ScaledShock(shock.profile, shock.profile.areas(), shock.rise_time / SCALES.time, MOMENTUM)


def answered(shock: sw.Shock) -> ScaledAnswer:
    """Answer of section 4 for ``shock``, without a range of errors."""
    return predict(scaled(shock), Settings())


def lasting(profile: sw.ShockProfile, duration: float) -> sw.Shock:
    """Shock with a given profile and ``duration`` in T0."""
    return sw.Shock.of_duration(profile=profile, peak_force=FORCE, duration=duration * SCALES.time)


def simulated(shocks: Iterable[sw.Shock]) -> list[float | None]:
    """Simulated amplifications; None for a simulation that is not accurate."""
    found = sw.simulate_many(shocks, CHAIN, rtol=RTOL, waves="primary")
    known = (result if isinstance(result, sw.SimulationResult) else None for result in found)
    return [None if r is None or r.error_estimate > MOST_DOUBT else r.amplification for r in known]


# ---------------------------------------------------------------- tables


def map_rows() -> Iterator[dict[str, Any]]:
    """Yield predicted and simulated peak forces over the plane, shape by shape."""
    for name, maker in SHAPES.items():
        places = [(duration, ratio) for ratio in RATIOS for duration in DURATIONS]
        profiles = {ratio: maker(float(ratio)) for ratio in RATIOS}
        shocks = [lasting(profiles[ratio], duration) for duration, ratio in places]
        for (duration, ratio), shock, peak in zip(places, shocks, simulated(shocks), strict=True):
            answer = answered(shock)
            yield {
                "shape": name,
                "n": f"{ratio:.4g}",
                "duration": f"{duration:.4g}",
                "conditions": int(meets(shock.profile)),
                "regime": answer.regime,
                "predicted": f"{answer.amplitudes[0]:.4g}",
                "simulated": "" if peak is None else f"{peak:.4g}",
            }


def random_profile(draw: np.random.Generator, kind: str) -> sw.ShockProfile:
    """A random profile of a built-in kind, which need not satisfy (3)."""
    # Shocks with equal rise and decay are at the border of (3); few of them would be drawn by chance.
    n = 1 + 10 ** (draw.uniform(0, 0.3) if draw.random() < 0.4 else draw.uniform(0, 2.0))
    steep = draw.random() < 0.5
    if kind == "power-law":
        rise = draw.choice([1e-5, draw.uniform(0, 1), 1.0], p=[0.2, 0.6, 0.2])
        return power(float(rise), float(10 ** draw.uniform(0, 1.5 if steep else 0.5)))(n)
    if kind == "exponential":
        rates = draw.uniform(0, 10), 10 ** draw.uniform(0, 2) if steep else draw.uniform(0, 8)
        return exponential(*map(float, rates))(n)
    if kind == "triangular":
        return sw.Triangular(duration_ratio=n)
    before, after = draw.integers(1, 6), draw.integers(1, 8)
    times = np.zeros(2)
    while np.min(np.diff(times)) < 1e-3:
        inner = np.sort(draw.uniform(0, 1, before)), np.sort(draw.uniform(1, n, after))
        times = np.concatenate(([0], inner[0], [1], inner[1], [n]))
    rise, decay = np.sort(draw.uniform(0, 1, before)), np.sort(draw.uniform(0, 1, after))[::-1]
    return sw.Tabulated(times=times, forces=np.concatenate(([0], rise, [1], decay, [0])))


def random_shocks(seed: int, count: int) -> list[tuple[str, sw.Shock]]:
    """Random shocks with one peak that satisfy (3), each with its kind."""
    draw = np.random.default_rng(seed)
    found: list[tuple[str, sw.Shock]] = []
    while len(found) < count:
        kind = str(draw.choice(["power-law", "exponential", "tabulated", "triangular"], p=[0.3, 0.25, 0.35, 0.1]))
        profile = random_profile(draw, kind)
        while not meets(profile):
            profile = random_profile(draw, kind)
        log_duration = draw.uniform(*np.log10(BETWEEN if draw.random() < 0.4 else (SHORTEST, LONGEST)))
        found.append((kind, lasting(profile, 10**log_duration)))
    return found


def single_waves(seed: int, count: int) -> list[tuple[str, sw.Shock]]:
    """Random shocks of the rare regime *single*: with a very short rise, and about as strong as one wave."""
    draw = np.random.default_rng(seed)
    found: list[tuple[str, sw.Shock]] = []
    while len(found) < count:
        profile = power(draw.uniform(0, 0.6), draw.uniform(1, 1.3))(1 + draw.uniform(0.8, 3))
        duration = draw.uniform(1.0, 1.35) * MOMENTUM * profile.duration_ratio / profile.areas().total
        shock = lasting(profile, duration)
        if meets(profile) and answered(shock).regime == "single":
            found.append(("power-law", shock))
    return found


def meets(profile: sw.ShockProfile) -> bool:
    """Whether a profile satisfies (3)."""
    return all(condition.holds for condition in conditions(profile.areas(), profile.duration_ratio))


def pulse_rows() -> Iterator[dict[str, Any]]:
    """Yield random shocks with their measures and predicted and simulated peak forces."""
    drawn = random_shocks(SEED, COUNT) + single_waves(SEED + 1, SINGLES)
    for (kind, shock), peak in zip(drawn, simulated(shock for _, shock in drawn), strict=True):
        found, answer = measures(scaled(shock)), answered(shock)
        if found is None or peak is None:
            continue
        n = shock.profile.duration_ratio
        numbers = {"n": n, "duration": n * shock.rise_time / SCALES.time}
        numbers |= {name: getattr(found, name) for name in MEASURES}
        numbers |= {"predicted": answer.amplitudes[0], "simulated": peak}
        yield {"kind": kind, "regime": answer.regime} | {k: f"{v:.{DIGITS}g}" for k, v in numbers.items()}


def write(name: str, rows: Iterable[dict[str, Any]]) -> None:
    """Write rows to a table."""
    rows = list(rows)
    with open(FOLDER / name, "w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def read(name: str) -> dict[str, NDArray[Any]]:
    """Columns of a table, as numbers except for texts."""
    with open(FOLDER / name, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    columns = {key: np.array([row[key] or "nan" for row in rows]) for key in rows[0]}
    texts = ("shape", "kind", "regime")
    return {key: column if key in texts else column.astype(float) for key, column in columns.items()}


# ---------------------------------------------------------------- laws


def fitted(pulses: dict[str, NDArray[Any]]) -> dict[str, Any]:
    """Contents of the file of the laws."""
    logarithm = np.log(pulses["simulated"] / (IMPULSE_LIMIT * pulses["strength"] ** 1.2))
    spread = pulses["spread"]
    short = law(
        "short",
        np.column_stack([spread, pulses["skewness"]])[spread <= SHORT[-1]],
        logarithm[spread <= SHORT[-1]],
        SHORT,
    )
    inputs = np.log(np.column_stack([pulses["strength"], pulses["mean_force"], pulses["cubic_mean_force"]]))
    # Some shocks in the range of the short law keep the long law accurate at its lower end.
    chosen = (spread > 0.8 * SHORT[-1]) & (inputs[:, 0] <= LONG[-1])
    names, counts = np.unique(pulses["kind"], return_counts=True)
    long = law("long", inputs[chosen], logarithm[chosen], LONG)
    return {
        "about": "ln of the simulated peak force over 1.1681817 F0 S^(6/5); described in docs/trust.md",
        "provenance": {
            "command": "python docs/map_section4.py",
            "shockwave": sw.__version__,
            "seeds": [SEED, SEED + 1],
            "pulses": {str(name): int(count) for name, count in zip(names, counts, strict=True)},
            "durations": [SHORTEST, LONGEST],
            "rtol": RTOL,
        },
        "laws": {"short": short, "long": long | {"longest": LONGEST}},
    }


def law(name: str, inputs: Array, logarithm: Array, bounds: tuple[float, ...]) -> dict[str, Any]:
    """Fit a polynomial of degree three by least squares; its range of validity, and its residuals by bands."""
    centre, scale = inputs.mean(axis=0), inputs.std(axis=0)
    factor = inputs[:, 0] ** 2 if name == "short" else np.ones(len(inputs))
    triangle = np.linalg.qr(monomials((inputs - centre) / scale, 3), mode="r")
    basis = np.linalg.inv(triangle) * math.sqrt(len(inputs))
    made = Law(name, 3, centre, scale, basis, np.zeros(len(basis)), 0.0, *np.zeros((3, 1)))
    terms = made.polynomials(inputs)
    leverage = np.mean(terms**2, axis=1)
    farthest = float(np.quantile(leverage, 1 - OUTSIDE))
    near = leverage <= farthest
    coefficients = np.linalg.lstsq(factor[near, None] * terms[near], logarithm[near], rcond=None)[0]
    residual = (logarithm - factor * (terms @ coefficients))[near]
    band = np.searchsorted(bounds, inputs[near, 0])
    ends = np.array([np.quantile(residual[band == i], [TAIL, 1 - TAIL]) for i in range(len(bounds))])
    wider = WIDENED * np.diff(ends, axis=1)[:, 0] + LEAST
    entries = {
        "degree": 3,
        "centre": centre,
        "scale": scale,
        "basis": basis,
        "coefficients": coefficients,
        "farthest": farthest,
        "bounds": np.array(bounds),
        "low": ends[:, 0] - wider,
        "high": ends[:, 1] + wider,
        "shocks": np.bincount(band, minlength=len(bounds)),
    }
    return {key: _rounded(value) for key, value in entries.items()}


def _rounded(value: Any) -> Any:
    """Round numbers for the file, because further digits depend on the machine."""
    if isinstance(value, np.ndarray):
        return [_rounded(each) for each in value.tolist()]
    if isinstance(value, list):
        return [_rounded(each) for each in value]
    return float(f"{value:.8g}") if isinstance(value, float) else value


def write_tables(found: dict[str, Any]) -> None:
    """Write the residuals of the laws into the tables of the page."""
    text = PAGE.read_text(encoding="utf-8")
    for name, entries in found["laws"].items():
        bounds = np.exp(entries["bounds"]) if name == "long" else entries["bounds"]
        columns = zip(bounds, entries["low"], entries["high"], entries["shocks"], strict=True)
        rows = "".join(f"| {b:.2g} | {100 * low:+.2f} | {100 * high:+.2f} | {n} |\n" for b, low, high, n in columns)
        pattern = rf"(<!-- table: {name} law -->\n.*\n\|---.*\n)(?:\|.*\n)*"
        text = re.sub(pattern, lambda head, rows=rows: head[1] + rows, text)
    PAGE.write_text(text, encoding="utf-8")


# ---------------------------------------------------------------- picture and command line


def draw(table: dict[str, NDArray[Any]]) -> None:
    """Draw the errors over the plane, a panel for each shape."""
    from shockwave.pictures import figure, save, trust_map

    drawn, places = figure(4, 3, (11.0, 12.0))
    for ax, name in zip(places, SHAPES, strict=True):
        own = table["shape"] == name
        plane = {key: column[own].reshape(len(RATIOS), len(DURATIONS)).T for key, column in table.items()}
        error = plane["predicted"] / plane["simulated"] - 1
        trust_map(ax, DURATIONS, RATIOS, error, plane["regime"], plane["conditions"] > 0)
        ax.set_title(name, fontsize=9)
    save(drawn, FOLDER / "map.png")


def main() -> None:
    """Perform all steps, or one of them."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", choices=("map", "pulses", "laws", "picture"))
    only = parser.parse_args().only
    FOLDER.mkdir(exist_ok=True)
    if only in (None, "map"):
        write("map.csv", map_rows())
    if only in (None, "pulses"):
        write("pulses.csv", pulse_rows())
    if only in (None, "laws"):
        found = fitted(read("pulses.csv"))
        LAWS.write_text(_compact(json.dumps(found, indent=1)) + "\n", encoding="utf-8")
        write_tables(found)
    if only in (None, "picture"):
        draw(read("map.csv"))


def _compact(text: str) -> str:
    """Join the lines of each list of numbers in JSON."""
    return re.sub(r"\[[^][{}]*\]", lambda row: " ".join(row[0].split()), text)


if __name__ == "__main__":
    main()
