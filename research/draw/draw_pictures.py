"""Draw all pictures of the documentation.

    python research/draw/draw_pictures.py
    python research/draw/draw_pictures.py --folder elsewhere pictures/landing universal/ends

writes files ``.svg`` in folders of docs, all or those that are named, in a minute, and ``docs/report/screenshot.png``
if Chromium is installed. The run times in ``benchmarks/error-time`` are those of its ``.csv``, which draw_error_time.py
measures. The extra ``plot`` of shockwave is required.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from attrs import frozen
from matplotlib.figure import Figure
from scipy.interpolate import CubicSpline

import shockwave as sw
from shockwave import pictures, report
from shockwave.pictures.studies import ranking_size
from shockwave.studies.amplification_curve import UniversalCurve
from shockwave.sweep.results import SweepResults
from shockwave.sweep.sweep_picture import plot

sys.path.append(str(Path(__file__).parent))
import draw_error_time
import draw_universal

ROOT = Path(__file__).parents[2]
PROFILES = ROOT / "profiles"
FOLDER = ROOT / "docs"
#: Width and height of the picture of a report: what a screen shows of it.
SCREEN = 1200, 800


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


# Beads of the landing picture, and the time at which it shows them [s].
BEADS, MOMENT = 38, 0.61e-3
# Granules to which the duration of the shock is stretched, at the left of the first bead, and their distance.
PULSE, APART = 9.0, 4.0


def landing() -> Figure:
    """A shock, the beads that it strikes, and the solitary waves that run along them a little later."""
    chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
    shock = sw.Shock(profile="triangular", peak_force="50 N", rise_time="40 us", duration="120 us")
    result = sw.simulate(shock, chain, contacts=range(BEADS), record=["forces"], until=MOMENT)
    forces = result.recording.forces[-1]
    blue, grey = pictures.METHODS["simulation"], pictures.METHODS["shock"]
    figure, (ax,) = pictures.figure(size=(7.6, 2.5))
    contacts = np.arange(BEADS) + 0.5
    fine = np.linspace(contacts[0], contacts[-1], 12 * BEADS)
    # the force of a solitary wave is close to the sixth power of a cosine
    height = CubicSpline(contacts, np.maximum(forces, 0) ** (1 / 6))(fine) ** 6
    along = [-0.5, *fine, BEADS + 0.5]  # as far as the beads
    height = np.pad(height, 1)
    ax.fill_between(along, height, color=blue, alpha=0.25, linewidth=0)
    ax.plot(along, height, color=blue, linewidth=1.6)
    top = forces.max()
    around = np.maximum(np.append(0, forces), np.append(forces, 0))
    ax.scatter(range(BEADS + 1), [-0.13 * top] * (BEADS + 1), s=92, c=around, cmap="Blues", vmin=-0.25 * top)
    ax.collections[-1].set(edgecolor="#444444", linewidth=0.6)
    # the beginning of the shock is at the right, next to the beads
    times = np.linspace(0, shock.duration, 200)
    places = -APART - PULSE * times / shock.duration
    applied = shock.peak_force * shock.profile.force(times / shock.rise_time)
    ax.fill_between(places, applied, color=grey, alpha=0.3, linewidth=0)
    ax.plot(places, applied, color=grey, linewidth=1.6)
    arrow = {"arrowstyle": "-|>", "color": grey, "linewidth": 1.6}
    ax.annotate("", (-0.8, -0.13 * top), (-APART - 1, -0.13 * top), arrowprops=arrow)
    look = {"ha": "center", "va": "bottom", "fontsize": 16}
    ax.text(-APART - PULSE / 3, 1.06 * shock.peak_force, "shock 50 N", color="#444444", **look)
    for number, wave in enumerate(result.waves[:3]):
        peaks = np.flatnonzero((forces[1:-1] > forces[:-2]) & (forces[1:-1] >= forces[2:])) + 1
        place = peaks[np.argsort(forces[peaks])[::-1][number]]
        name = "leading wave " if number == 0 else ""
        label = f"{name}{wave.peak_force:.1f} N"
        ax.text(contacts[place], forces[place] + 0.07 * top, label, color=blue, **look)
    ax.set(xlim=(-APART - PULSE - 1, BEADS + 4), ylim=(-0.24 * top, 1.35 * top))
    ax.set_axis_off()
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


def drawn(column: str | None = None) -> Figure:
    """A map of the plane."""
    figure, (ax,) = pictures.figure(size=(5.0, 3.6))
    plot(swept(), column, ax=ax)
    return figure


def amplification_map() -> Figure:
    """Amplification over the plane, with the borders of the regimes."""
    return drawn()


def trust_map() -> Figure:
    """Error of section 4 over the same plane."""
    return drawn("error")


def distribution() -> Figure:
    """Distribution of the peak force for uncertain beads and an uncertain shock, with a limit."""
    chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
    shock = sw.Shock(profile="triangular", peak_force="50 N", rise_time="20 us", duration="60 us")
    spreads = {"shock.peak_force": "5 %", "shock.rise_time": "5 %", "chain.material.youngs_modulus": "3 %"}
    figure, (ax,) = pictures.figure(size=(5.0, 3.0))
    pictures.distribution(sw.uncertainty(shock, chain, spreads, limit="60 N"), ax=ax)
    return figure


def materials() -> Figure:
    """Ranking of materials for a target."""
    names = ["nylon-66", "delrin", "pmma", "polycarbonate", "titanium-ti-6al-4v", "bearing-steel-52100"]
    result = sw.design(scene("examples/protector"), vary="chain.material", target="peak_force <= 17 N", among=names)
    figure, (ax,) = pictures.figure(size=ranking_size(result))
    pictures.materials(result, ax=ax)
    return figure


def finite_chain() -> Figure:
    """Force on the wall behind a short chain, and the greatest forces at its contacts."""
    chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm", granules=10, end=sw.Wall(material="same"))
    result = sw.simulate(sw.Impact(velocity=0.1), chain, record=["forces", "energies"])
    figure, (above, below) = pictures.figure(2, size="page")
    pictures.wall_force(result, ax=above)
    pictures.peak_forces(result, ax=below)
    return figure


def sensors() -> Figure:
    """Forces of sensors in three beads of a vertical chain and under its wall."""
    chain = sw.Chain(
        material="bearing-steel-52100", diameter="9.525 mm", granules=50, gravity="9.81 m/s**2", end=sw.Wall()
    )
    places = [{"granule": 10}, {"granule": 20}, {"granule": 30}, "wall"]
    result = sw.simulate(sw.Impact(drop_height="8 mm"), chain, sensors=places, interval="1 us")  # type: ignore[list-item]
    figure, (ax,) = pictures.figure(size="page")
    pictures.sensors(result, ax=ax)
    return figure


#: Functions that draw the pictures, by file name.
PICTURES: dict[str, Callable[[], Figure]] = {
    "pictures/landing": landing,
    "pictures/pulse": pulse,
    "pictures/contact-forces": contact_forces,
    "pictures/space-time": space_time,
    "pictures/train": train,
    "pictures/correction-area": correction_area,
    "pictures/approach": approach,
    "pictures/balance": balance,
    "pictures/amplification": amplification,
    "pictures/work-precision": work_precision,
    "pictures/distribution": distribution,
    "pictures/map": amplification_map,
    "pictures/trust-map": trust_map,
    "pictures/materials": materials,
    "pictures/sensors": sensors,
    "pictures/finite-chain": finite_chain,
    "benchmarks/error-time": draw_error_time.draw,
    "benchmarks/integrators": draw_error_time.draw_integrators,
    "universal/shocks": lambda: draw_universal.draw("shocks")[0],
    "universal/ends": lambda: draw_universal.draw("ends")[0],
}


def draw_report(file: Path) -> None:
    """Take the picture of a report in Chromium; raise OSError if there is none."""
    with TemporaryDirectory() as folder:
        page = Path(folder) / "page.html"
        page.write_text(report.page(scene(EJECTION)), encoding="utf-8")
        size = "--window-size={},{}".format(*SCREEN)
        options = ["--headless", "--no-sandbox", "--hide-scrollbars", size, f"--screenshot={file}"]
        subprocess.run(["chromium", *options, page.as_uri()], check=True, capture_output=True)


def main() -> None:
    """Draw all pictures, or those that are named."""
    parser = argparse.ArgumentParser(description="Draw the pictures of the documentation.")
    parser.add_argument("--folder", type=Path, default=FOLDER, help="folder of the folders of the pictures")
    parser.add_argument("names", nargs="*", help="pictures such as pictures/landing (default: all)")
    options = parser.parse_args()
    for folder in {"report", *(Path(name).parent for name in PICTURES)}:
        (options.folder / folder).mkdir(parents=True, exist_ok=True)
    for name in options.names or PICTURES:
        file = options.folder / f"{name}.svg"
        pictures.save(PICTURES[name](), file)
        print(file)
    if not options.names:
        with suppress(OSError):
            draw_report(options.folder / "report" / "screenshot.png")


if __name__ == "__main__":
    main()
