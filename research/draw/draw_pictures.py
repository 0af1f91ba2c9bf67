"""Draw the pictures of the documentation.

    python research/draw/draw_pictures.py
    python research/draw/draw_pictures.py --folder elsewhere

writes docs/pictures/*.svg in about ten seconds. The files change only if matplotlib or the simulated values change. The
extra ``plot`` of shockwave is required.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from attrs import frozen
from matplotlib.figure import Figure

import shockwave as sw
from shockwave import pictures
from shockwave.studies.amplification_curve import UniversalCurve
from shockwave.sweep.results import SweepResults
from shockwave.sweep.sweep_picture import plot

ROOT = Path(__file__).parents[2]
PROFILES = ROOT / "profiles"
FOLDER = ROOT / "docs" / "pictures"


@frozen
class Run:
    """A run, as required by `pictures.work_precision`."""

    method: str
    error: float | None
    seconds: float | None
    problem: str = ""


@cache
def scene(name: str) -> sw.Scenario:
    """A scenario of the source tree."""
    return sw.load_scenario(PROFILES / f"{name}.yaml")


# Scenarios of the pictures.
EJECTION = "paper/table2-row1"
RECORD = "examples/hammer"


@cache
def recorded(name: str, record: tuple[str, ...], contacts: tuple[int, ...]) -> sw.Simulation:
    """A simulation with histories."""
    return sw.simulate(scene(name).shock, scene(name).chain, contacts=contacts, record=record)  # type: ignore[arg-type]


def landing() -> Figure:
    """The way of a blow along the chain, and the waves into which it separates."""
    chain = sw.Chain(material=sw.material("stainless-steel-302"), diameter=9.5e-3)
    shock = sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=20.0, rise_time=80e-6)
    result = sw.simulate(shock, chain, contacts=range(80), record=["forces"])
    figure, (left, right) = pictures.figure(1, 2, (7.6, 3.0))
    pictures.space_time(result, ax=left)
    pictures.contact_forces(result, contacts=[10, 79], ax=right)
    return figure


@cache
def compared(name: str) -> sw.Comparison:
    """Section 4 and simulation of a scene."""
    return sw.compare(scene(name))


def pulse() -> Figure:
    """Record of a hammer with its areas."""
    figure, (ax,) = pictures.figure()
    pictures.pulse(scene(RECORD).shock, ax=ax)
    return figure


def contact_forces() -> Figure:
    """Contact forces at five contacts after a blow of the hammer."""
    figure, (ax,) = pictures.figure(size="page")
    pictures.contact_forces(recorded(RECORD, ("forces",), (0, 5, 10, 20, 30)), ax=ax)
    return figure


def space_time() -> Figure:
    """Contact forces at sixty contacts after the same blow."""
    figure, (ax,) = pictures.figure(size="page")
    pictures.space_time(recorded(RECORD, ("forces",), tuple(range(60))), ax=ax)
    return figure


def train() -> Figure:
    """Waves of a hammer and of a power law."""
    figure, (left, right) = pictures.figure(1, 2, "page")
    pictures.train(compared(RECORD), ax=left)
    pictures.train(compared("examples/power-law"), ax=right)
    return figure


def correction_area() -> Figure:
    """Figure 1 of the paper, for the first row of its Table 2."""
    figure, (ax,) = pictures.figure(size=(5.0, 3.0))
    pictures.correction_area(scene(EJECTION).shock, compared(EJECTION).predicted.section4, ax=ax)
    return figure


def approach() -> Figure:
    """Approach to the limit for a short shock and for a longer one."""
    figure, (left, right) = pictures.figure(1, 2, "page")
    pictures.approach(compared(EJECTION).simulated, ax=left)
    pictures.approach(compared(RECORD).simulated, ax=right)
    return figure


def balance() -> Figure:
    """Energy for the first row of Table 2, where the first granule rebounds."""
    figure, (ax,) = pictures.figure()
    pictures.balance(recorded(EJECTION, ("energies",), (3,)), ax=ax)
    return figure


def amplification() -> Figure:
    """Amplification for a triangle with n = 10 and for the shape of the first row of Table 2."""
    figure, (ax,) = pictures.figure()
    profiles = {"triangle": sw.Triangular(duration_ratio=10), "table 2, row 1": scene(EJECTION).shock.profile}
    pictures.universal_curves({name: UniversalCurve(profile) for name, profile in profiles.items()}, ax=ax)
    return figure


def work_precision() -> Figure:
    """Invented runs that show all kinds of marks."""
    slopes = {"order 4": 0.25, "order 8": 0.125, "order 12": 1 / 12}
    runs = [
        Run(name, 10.0**-digits, 2e-4 * 10 ** (0.6 * digits * 4 * slope) * (1 + index))
        for index, (name, slope) in enumerate(slopes.items())
        for digits in range(2, 13, 2)
        if index or digits < 9
    ]
    runs += [Run("formula", 0.03, 2e-5), Run("order 12", 0.0, 0.02), Run("order 4", None, 0.08, "too many steps")]
    figure, (ax,) = pictures.figure(size=(5.0, 3.2))
    pictures.work_precision(
        [*runs, Run("another", None, None, "not installed")], "relative error of the peak force", ax=ax
    )
    return figure


@cache
def swept() -> SweepResults:
    """Section 4 and simulations over the plane of rise time and duration ratio."""
    with TemporaryDirectory() as folder, ThreadPoolExecutor(1) as executor:
        sw.run_sweep(PROFILES / "maps" / "amplification.yaml", folder, executor)
        return sw.load_sweep(folder)


def amplification_map() -> Figure:
    """Amplification over the plane, with the borders of the regimes."""
    return plot(swept()).figure


def trust_map() -> Figure:
    """Error of section 4 over the same plane."""
    return plot(swept(), "error").figure


def materials() -> Figure:
    """Ranking of materials for a target."""
    names = ["ptfe", "nylon-66", "delrin", "pmma", "lead", "brass-260", "copper", "aluminium-6061-t6"]
    result = sw.design(scene("examples/protector"), vary="chain.material", target="peak_force <= 110 N", among=names)
    figure, (ax,) = pictures.figure(size=(4.6, 1.0 + 0.17 * len(result.table)))
    pictures.materials(result, ax=ax)
    return figure


#: Functions that draw the pictures, by file name.
PICTURES: dict[str, Callable[[], Figure]] = {
    "landing": landing,
    "pulse": pulse,
    "contact-forces": contact_forces,
    "space-time": space_time,
    "train": train,
    "correction-area": correction_area,
    "approach": approach,
    "balance": balance,
    "amplification": amplification,
    "work-precision": work_precision,
    "map": amplification_map,
    "trust-map": trust_map,
    "materials": materials,
}


def main() -> None:
    """Draw all pictures."""
    parser = argparse.ArgumentParser(description="Draw the pictures of the documentation.")
    parser.add_argument("--folder", type=Path, default=FOLDER, help="folder of the pictures")
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    for name, draw in PICTURES.items():
        pictures.save(draw(), folder / f"{name}.svg")
        print(folder / f"{name}.svg")


if __name__ == "__main__":
    main()
