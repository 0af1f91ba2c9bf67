"""Draw error against run time for section 4, simulations, SciPy by hand, and every registered integrator.

    python research/draw/draw_error_time.py
    python research/draw/draw_error_time.py --drawn

measures all methods in some minutes, writes the runs to docs/benchmarks/error-time.csv and draws
docs/benchmarks/error-time.svg and docs/benchmarks/integrators.svg; with ``--drawn`` it draws the runs of the file. The
first picture has two problems: the peak force of the leading wave for the eight pulses of the paper, and the force on
the wall behind the mixed, damped chain of profiles/validation/damped.yaml. The second has the problem *wall* of
``shockwave bench``, with every registered integrator, also of installed plugins. Run times are process times over that
of ``simulate`` with rtol 1e-6 for the same pulse or chain, which is measured alternately with each run: such ratios
vary less between machines than seconds do. Simulations are also measured for a thousand pulses of one shape in one
call.

SciPy integrates the whole chain as a first-order system, restarts at the kinks of the force and evaluates the peak from
its own steps, as a careful user would. On the pulses it computes the force at contact 60, with the reference of that
contact, and not the limit along the chain.
"""

from __future__ import annotations

import csv
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from scipy.integrate import DOP853, LSODA, solve_ivp
from scipy.optimize import minimize_scalar

import shockwave as sw
from shockwave import pictures
from shockwave.benchmark import bench
from shockwave.benchmark.chain_problems import CASES
from shockwave.pictures.picture_elements import GREEN, PURPLE
from shockwave.scene.chain import Scales
from shockwave.scene.layout import Layout

sys.path.append(str(Path(__file__).parents[1] / "check"))
from compare_simulators import by_scipy, read_front
from independent_check import Array, Case, by_shockwave

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "benchmarks"
FILE = FOLDER / "error-time.csv"
PULSES, CHAIN, WALL = "pulses of the paper", "mixed, damped chain before a wall", "mixed chain before a wall"
#: Tolerances of the simulation and of SciPy.
SIMULATED = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
BY_HAND = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
SOLVERS = {"SciPy DOP853": DOP853, "SciPy LSODA": LSODA}
#: Contact at which SciPy computes the peak force, and length of its chain.
CONTACT, GRANULES = 60, 100
#: Fewest and most repetitions, process time after which no more are made [s], common runs for each repetition.
FEWEST, MOST, BUDGET, COMMON = 3, 25, 0.2, 4
#: Samples in each step of SciPy among which the greatest force on the wall is searched.
SAMPLES = 20
#: Number of shocks of one call, and the name of such runs.
MANY, TOGETHER = 1000, "together"
#: Longest run of an integrator [s].
LONGEST = 4.0
#: Smaller errors are drawn here.
LEAST = 1e-12

Run = Callable[[], float]


class Row(NamedTuple):
    """A run: its problem, pulse or chain, method, setting, relative error, and run time over that of the common run."""

    problem: str
    scene: str
    method: str
    setting: str
    error: float
    time: float


def ratio(run: Run, common: Run) -> float:
    """Median run time over that of the common run, measured alternately."""
    run()
    ratios: list[float] = []
    begin = time.process_time()
    while len(ratios) < FEWEST or (len(ratios) < MOST and time.process_time() - begin < BUDGET):
        marks = [time.process_time()]
        for timed in (run, *[common] * COMMON):
            timed()
            marks.append(time.process_time())
        own, *others = (after - before for before, after in pairwise(marks))
        ratios.append(own / statistics.median(others))
    return statistics.median(ratios)


# ---------------------------------------------------------------- pulses of the paper


def of_pulse(scene: sw.Scenario) -> Iterator[Row]:
    """Runs of all methods for one pulse."""
    shock, chain = scene.shock, scene.chain

    def simulated(rtol: float) -> float:
        return sw.simulate(shock, chain, rtol=rtol, waves="primary").peak_force

    def common() -> float:
        return simulated(1e-6)

    paper = sw.Predictor(model="section-4")
    runs: list[tuple[str, str, Run]] = [("section 4", "", lambda: paper.predict(shock, chain).peak_force)]
    runs += [("simulate", f"{rtol:g}", lambda rtol=rtol: simulated(rtol)) for rtol in SIMULATED]
    reference = simulated(1e-12)
    for method, setting, run in runs:
        yield Row(PULSES, scene.name, method, setting, abs(run() / reference - 1), ratio(run, common))

    # many shocks of this shape in one call; the first is the pulse itself
    forces = shock.peak_force * np.linspace(1.0, 1.1, MANY)
    shocks = [sw.Shock(profile=shock.profile, peak_force=force, rise_time=shock.rise_time) for force in forces]

    def together() -> float:
        return sw.simulate_many(shocks, chain, waves="primary", threads=1)[0].peak_force

    error = abs(together() / reference - 1)
    yield Row(PULSES, scene.name, "simulate", f"1e-06 {TOGETHER}", error, ratio(together, common) / MANY)

    profile = shock.profile
    at = shock.rise_time / Scales.of(chain, shock.peak_force).time
    shape = (at, profile.duration_ratio, profile.rise_exponent, profile.decay_exponent)
    case = Case(*shape, GRANULES, {CONTACT: (0.0, 0.0)})
    answers = by_shockwave(case)
    assert answers is not None
    force, moment = answers[0].peaks[0].tolist()
    case = replace(case, references={CONTACT: (force, moment)})
    for method, solver in SOLVERS.items():
        solve = by_scipy(solver, case, np.inf)
        for tolerance in BY_HAND:

            def peak(solve: Any = solve, tolerance: float = tolerance) -> float:
                return read_front(case, solve, tolerance)[0]

            # with a loose tolerance a solver may find no peak
            with suppress(ArithmeticError):
                yield Row(PULSES, scene.name, method, f"{tolerance:g}", abs(peak() / force - 1), ratio(peak, common))


# ---------------------------------------------------------------- chain before a wall


def wall_force(scene: sw.Scenario, end: float, method: str, tolerance: float) -> float:
    """Greatest force on the wall by SciPy, for Hertz's contacts with the damping of Kuwabara and Kono."""
    layout, shock = Layout.of(scene.chain, scene.shock), scene.shock
    count, stiffness, damping = len(layout.masses), layout.pairs.stiffnesses, scene.chain.damping.time
    force, length = shock.peak_force, float((shock.peak_force / stiffness.max()) ** (2 / 3))
    unit = float(np.sqrt(layout.masses.min() * length / force))

    def contact_forces(state: Array) -> Array:
        places, velocities = state[:count], state[count:]
        overlaps = np.maximum(places - np.append(places[1:], 0.0), 0.0) * length
        closing = (velocities - np.append(velocities[1:], 0.0)) * length / unit
        return np.maximum(stiffness * np.sqrt(overlaps) * (overlaps + 1.5 * damping * closing), 0.0) / force

    def pushed(s: float) -> float:
        inside = shock.profile.rise if s <= 1 else shock.profile.decay
        return float(inside(np.asarray(s))) if s < shock.profile.duration_ratio else 0.0

    def rates(moment: float, state: Array) -> Array:
        forces = np.append(pushed(moment * unit / shock.rise_time), contact_forces(state))
        return np.concatenate([state[count:], (forces[:-1] - forces[1:]) * force * unit**2 / layout.masses / length])

    state, best = np.zeros(2 * count), 0.0
    for begin, until in pairwise((0.0, shock.rise_time / unit, shock.duration / unit, end / unit)):
        found = solve_ivp(rates, (begin, until), state, method, dense_output=True, rtol=tolerance, atol=tolerance)
        state = found.y[:, -1]

        def on_wall(moment: float, found: Any = found) -> float:
            return float(contact_forces(found.sol(moment))[-1])

        times = np.concatenate([np.linspace(*ends, SAMPLES, endpoint=False) for ends in pairwise(found.t)])
        values = [on_wall(moment) for moment in times]
        top = int(np.argmax(values))
        near = (times[max(top - 1, 0)], times[min(top + 1, len(times) - 1)])
        refined = minimize_scalar(lambda moment, value=on_wall: -value(moment), bounds=near, options={"xatol": 1e-10})
        best = max(best, max(values), -float(refined.fun))
    return best * force


def of_chain(scene: sw.Scenario) -> Iterator[Row]:
    """Runs of the simulation and of SciPy for the chain; section 4 does not cover it."""
    end = sw.simulate(scene).end

    def simulated(rtol: float) -> float:
        return sw.simulate(scene.shock, scene.chain, rtol=rtol, until=end).transmitted.peak_force

    def common() -> float:
        return simulated(1e-6)

    reference = simulated(1e-12)
    runs = [("simulate", f"{rtol:g}", lambda rtol=rtol: simulated(rtol)) for rtol in SIMULATED]
    for method in SOLVERS:
        name = method.removeprefix("SciPy ")
        runs += [
            (method, f"{rtol:g}", lambda name=name, rtol=rtol: wall_force(scene, end, name, rtol)) for rtol in BY_HAND
        ]
    for method, setting, run in runs:
        yield Row(CHAIN, scene.name, method, setting, abs(run() / reference - 1), ratio(run, common))


def of_integrators() -> Iterator[Row]:
    """Runs of the simulation and of all integrators for the mixed chain; settings that take too long are left out."""
    methods = list(bench.integrators(CASES["wall"])[1])
    common = partial(methods[0].run, 1e-6)
    for method in methods:
        for value in method.values:
            begin = time.process_time()
            run = partial(method.run, value)
            error = run().errors["peak force"]
            yield Row(WALL, "wall", method.name, method.text(value), error, ratio(run, common))
            if time.process_time() - begin > LONGEST:
                break


# ---------------------------------------------------------------- picture

#: Colour and mark of each method.
LOOKS = {
    "section 4": {"color": pictures.METHODS["section 4"], "marker": "X"},
    "simulate": {"color": pictures.METHODS["simulation"], "marker": "o"},
    "SciPy DOP853": {"color": GREEN, "marker": "s"},
    "SciPy LSODA": {"color": PURPLE, "marker": "^"},
}


def read_rows() -> list[Row]:
    """The runs of the file."""
    with FILE.open(newline="", encoding="utf-8") as lines:
        table = list(csv.reader(lines))[1:]
    return [Row(*cells[:4], float(cells[4]), float(cells[5])) for cells in table]


def draw_integrators() -> Figure:
    """Draw the runs of the integrators in the file, with a line for each."""
    figure, (ax,) = pictures.figure(1, 1, (7.6, 4.6))
    runs = [
        SimpleNamespace(method=row.method, error=max(row.error, LEAST), seconds=row.time, problem="")
        for row in read_rows()
        if row.problem == WALL
    ]
    pictures.work_precision(runs, "relative error of the force on the wall", ax=ax)
    ax.set(xlabel="run time over that of simulate at rtol 1e-6", ylim=(LEAST / 3, 0.3))
    ax.legend(loc="center left", bbox_to_anchor=(1, 0.5), fontsize="small")
    return figure


def draw() -> Figure:
    """Draw the runs of the file, a panel for each problem: runs as faint marks, medians over pulses joined by lines."""
    rows = read_rows()
    figure, places = pictures.figure(1, 2, (7.6, 4.2))
    for ax, problem in zip(places, (PULSES, CHAIN), strict=True):
        for method, look in LOOKS.items():
            own = [row for row in rows if row.problem == problem and row.method == method]
            settings = list(dict.fromkeys(row.setting for row in own))
            points = [
                [
                    statistics.median(max(getattr(row, name), least) for row in own if row.setting == setting)
                    for setting in settings
                ]
                for name, least in (("time", 0.0), ("error", LEAST))
            ]
            ax.plot([row.time for row in own], [max(row.error, LEAST) for row in own], ls="", ms=2, alpha=0.4, **look)
            single = [index for index, setting in enumerate(settings) if TOGETHER not in setting]
            ax.plot(*([values[index] for index in single] for values in points), ms=6, lw=1.2, label=method, **look)
            if len(single) < len(settings):
                ax.plot(points[0][-1], points[1][-1], ms=8, mfc="none", ls="", **look)
        ax.set(xscale="log", yscale="log", xlabel="run time over that of simulate at rtol 1e-6")
        ax.set_title(problem, fontsize="medium")
        ax.set(xlim=(1e-3, 3e3), ylim=(LEAST / 3, 3))
        ax.minorticks_off()
        ax.grid(alpha=0.3)
    places[0].set_ylabel("relative error of the force")
    title = f"hollow: {MANY} at once"
    places[1].legend(*places[0].get_legend_handles_labels(), loc="lower left", fontsize="small", title=title)
    places[1].get_legend().get_title().set_fontsize("small")
    return figure


def main() -> None:
    """Measure all runs, or read them, and draw them."""
    if "--drawn" not in sys.argv:
        rows = [
            row for file in sorted((ROOT / "profiles/paper").glob("*.yaml")) for row in of_pulse(sw.load_scenario(file))
        ]
        rows += of_chain(sw.load_scenario(ROOT / "profiles/validation/damped.yaml"))
        rows += of_integrators()
        with FILE.open("w", newline="", encoding="utf-8") as out:
            writer = csv.writer(out, lineterminator="\n")
            writer.writerow(Row._fields)
            writer.writerows((*row[:4], f"{row.error:.2g}", f"{row.time:.3g}") for row in rows)
    pictures.save(draw(), FOLDER / "error-time.svg")
    pictures.save(draw_integrators(), FOLDER / "integrators.svg")


if __name__ == "__main__":
    main()
