"""Measure the error of section 4 against simulations, over shapes, durations and duration ratios.

    python docs/map_section4.py

writes, in about two minutes and reproducibly on one machine,

- ``docs/section4/map.csv``: predicted and simulated peak forces for twelve shapes over the plane (n t0/T0, n);
- ``docs/section4/map.png``: the errors, the borders of the regimes, and where the conditions (3) fail.

``--only map`` or ``--only picture`` performs one step; the latter reads the existing table.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import shockwave as sw
from shockwave.chain import Scales
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.prediction.model_interface import ScaledAnswer, ScaledShock, Settings
from shockwave.prediction.section4 import predict
from shockwave.profiles.conditions import conditions

Array = NDArray[np.float64]

FOLDER = Path(__file__).parent / "section4"

# For a given shape the amplification depends only on n t0/T0, so that chain and force are arbitrary.
CHAIN = sw.Chain(material=sw.Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0), radius=4.75e-3)
FORCE = 100.0
SCALES = Scales.of(CHAIN, FORCE)
# Requested relative error of the simulations.
RTOL = 1e-4

# Durations n t0/T0 and duration ratios n of the map.
DURATIONS = np.geomspace(0.1, 60.0, 45)
RATIOS = np.geomspace(1.1, 100.0, 27)

# Largest error estimate of a simulation that is used.
MOST_DOUBT = 1e-3

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


def meets(profile: sw.ShockProfile) -> bool:
    """Whether a profile satisfies (3)."""
    return all(condition.holds for condition in conditions(profile.areas(), profile.duration_ratio))


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
    parser.add_argument("--only", choices=("map", "picture"))
    only = parser.parse_args().only
    FOLDER.mkdir(exist_ok=True)
    if only in (None, "map"):
        write("map.csv", map_rows())
    if only in (None, "picture"):
        draw(read("map.csv"))


if __name__ == "__main__":
    main()
