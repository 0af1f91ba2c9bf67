"""Forces at the contacts of chains beyond equal spheres, compared with an independent integration.

    python docs/check_chains.py

simulates 300 seeded random chains through the public interface: 2 to 200 granules in segments, tapers and cells of
seven materials, walls, movable ends, gaps, precompression, gravity, three dampings, contact exponents, shocks and
strikers. The reference is DOP853 of SciPy at 1e-13, which integrates all granules of the chain, restarts at the kinks
of the shock and wherever a contact opens, closes or is cut off, and knows nothing of windows, equilibria or
free-particle displacements. Collisions amplify its errors, too: if an error exceeds the tolerance or its estimate, the
reference is repeated with twice its tolerance, and only what exceeds their difference is counted. The table, at three
tolerances, is written into ``docs/chains.md``. It takes about an hour on one core; all cores are used. ``--count``
changes the number of chains.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853, DenseOutput
from scipy.optimize import brentq

import shockwave as sw
from shockwave.chain.layout import Layout
from shockwave.measurement.chain_result import ChainResult
from shockwave.registry import load

PAGE = Path(__file__).parent / "chains.md"
END = "<!-- end of table -->"
SEED = 5000
COUNT = 300
# Chains after which the table so far is printed.
PROGRESS = 50
TOLERANCES = (1e-4, 1e-6, 1e-8)
# Of DOP853; its longest step, in characteristic times; samples of a step in which a maximum is looked for.
RTOL, ATOL, STEP, SAMPLES = 1e-13, 1e-15, 0.3, 9
# Ratio of the tolerance of the repeated reference to that of the first.
LOOSER = 2.0
# Forces below this share of the greatest dynamic part are not compared.
LEAST = 1e-9
MATERIALS = ("stainless-steel-302", "ptfe", "brass-260", "aluminium-6061-t6", "paper-steel", "copper", "tungsten")
Array = NDArray[np.float64]


# ---------------------------------------------------------------- random chains


def scene(number: int, most: int = 200) -> tuple[sw.Shock | sw.Impact, sw.Chain]:
    """One random chain with its excitation."""
    draw = np.random.default_rng((SEED, number))

    def between(low: float, high: float) -> float:
        return float(np.exp(draw.uniform(np.log(low), np.log(high))))

    def material() -> sw.Material:
        return load("materials", MATERIALS[draw.integers(len(MATERIALS))])

    def segment(count: int) -> sw.Segment:
        form: dict[str, object] = {}
        if draw.random() < 0.5:
            form["material"] = material()
        kind = draw.random()
        if kind < 0.3:
            form["diameter"] = between(2e-3, 20e-3)
        elif kind < 0.55 and count > 1:
            spacing = ("linear", "geometric")[draw.integers(2)]
            form["diameter"] = sw.Taper(first=between(4e-3, 12e-3), last=between(4e-3, 12e-3), spacing=spacing)
        if gaps and draw.random() < 0.5:
            form["gap"] = between(1e-8, 1e-5)
        return sw.Segment(count=count, **form)

    loaded = draw.random() < 0.35
    gaps = not loaded and draw.random() < 0.3
    parts: list[sw.Segment | sw.Cell] = []
    for _ in range(draw.integers(1, 4)):
        if draw.random() < 0.25:
            cell = [segment(int(draw.integers(1, 3))) for _ in range(draw.integers(2, 4))]
            parts.append(sw.Cell(repeat=int(draw.integers(2, 12)), cell=cell))
        else:
            parts.append(segment(int(between(1, most / 3))))
    if sum(part.granules for part in parts) < 2:
        parts.append(sw.Segment())
    features: dict[str, object] = {}
    hertz = draw.random() < 0.8
    if not hertz:
        exponent = float(draw.choice([1.25, 2.0, 2.5, 3.0]))
        features["contact"] = sw.PowerContact(exponent=exponent, stiffness=3e9 * 1e-6 ** (1.5 - exponent))
    kind = draw.random()
    if kind < 0.15:
        features["damping"] = sw.KuwabaraKono(time=between(1e-7, 1e-5))
    elif kind < 0.3:
        features["damping"] = sw.Dashpot(coefficient=between(0.1, 30.0))
    elif kind < 0.4 and hertz:
        features["damping"] = sw.Tsuji(restitution=float(draw.uniform(0.3, 0.99)))
    kind, wall = draw.random(), ("same", "rigid", material())[draw.integers(3)]
    if kind < 0.5:
        features["end"] = sw.Wall(material=wall)
    elif kind < 0.65:
        spring, dashpot = float(draw.choice([0.0, 1e5, 1e6])), float(draw.choice([0.0, 0.0, 50.0]))
        features["end"] = sw.Wall(material=wall, mass=between(1e-3, 5.0), stiffness=spring, damping=dashpot)
    if loaded:
        features["precompression"] = between(0.01, 100.0)
        if "end" in features and draw.random() < 0.4:
            features["gravity"] = 9.81
    chain = sw.Chain(material=material(), diameter=float(draw.uniform(5e-3, 12e-3)), granules=parts, **features)
    if draw.random() < 0.3:
        size = between(3e-3, 25e-3) if draw.random() < 0.5 else None
        return sw.Impact(velocity=between(0.05, 5.0), diameter=size), chain
    ratio = float(draw.uniform(1.5, 10.0))
    profile: sw.ShockProfile = sw.Triangular(duration_ratio=ratio)
    if draw.random() < 0.5:
        rise, decay = float(draw.choice([0.5, 1.0, 2.0])), float(draw.choice([0.5, 1.0, 3.0]))
        profile = sw.PowerLaw(rise_exponent=rise, decay_exponent=decay, duration_ratio=ratio)
    return sw.Shock.of_duration(profile=profile, peak_force=between(5, 500), duration=between(3e-6, 4e-4)), chain


# ---------------------------------------------------------------- the reference


class Reference:
    """Equations of motion of a chain, in units of a time, a mass and a length."""

    def __init__(self, excitation: sw.Shock | sw.Impact, chain: sw.Chain, unit: float) -> None:
        layout = Layout.of(chain, excitation)
        wall = chain.end
        self.movable = wall is not None and wall.mass is not None
        masses = np.append(layout.masses, wall.mass) if self.movable else layout.masses
        self.mass, self.unit = float(np.median(layout.masses)), unit
        self.length = max(float(np.abs(layout.overlaps).max()), 1e-6)
        force = self.mass * self.length / unit**2
        self.force = force
        self.rates = self.mass / masses
        self.stiffnesses = layout.pairs.stiffnesses * self.length**layout.pairs.exponent / force
        self.exponent, self.power = layout.pairs.exponent, layout.damping_power
        self.damping = layout.damping_coefficients * self.length ** (self.power + 1) / unit / force
        self.offsets = layout.overlaps / self.length
        self.static = layout.static_forces / force
        self.spring = wall.stiffness * self.length / force if wall else 0.0
        self.dashpot = wall.damping * self.length / unit / force if wall else 0.0
        self.fixed = wall is not None and not self.movable
        self.shock = excitation if isinstance(excitation, sw.Shock) else None
        self.start = np.zeros(2 * len(masses))
        self.start[len(masses)] = layout.velocity * unit / self.length

    def contacts(self, states: Array) -> tuple[Array, Array]:
        """Total contact forces, and what changes its sign at their kinks, for states of shape (2 bodies, ...)."""
        bodies = len(self.rates)
        ends = [states[:bodies], states[bodies:]]
        if self.fixed:
            ends = [np.concatenate((end, np.zeros((1, *end.shape[1:])))) for end in ends]
        column = (-1,) + (1,) * (states.ndim - 1)
        overlap = self.offsets.reshape(column) + ends[0][:-1] - ends[0][1:]
        closed = np.maximum(overlap, 0.0)
        force = self.stiffnesses.reshape(column) * closed**self.exponent
        force += self.damping.reshape(column) * closed**self.power * (ends[1][:-1] - ends[1][1:])
        acts = overlap > 0
        return np.where(acts, np.maximum(force, 0.0), 0.0), np.where(acts & (force < 0), force, overlap)

    def __call__(self, time: float, state: Array) -> Array:
        bodies = len(self.rates)
        excess = self.contacts(state)[0] - self.static
        net = np.zeros(bodies)
        net[: len(excess)] -= excess
        net[1:] += excess[: bodies - 1]
        if self.shock is not None and time * self.unit < self.shock.duration:
            net[0] += float(self.shock.profile.force(time * self.unit / self.shock.rise_time)) * (
                self.shock.peak_force / self.force
            )
        if self.movable:
            net[-1] -= self.spring * state[bodies - 1] + self.dashpot * state[-1]
        return np.concatenate((state[bodies:], net * self.rates))

    def greatest(self, end: float, looser: float = 1.0) -> tuple[Array, Array]:
        """Greatest dynamic parts of the forces [N] and their times [s], from 0 to ``end`` [s]."""
        control = {"max_step": STEP, "rtol": looser * RTOL, "atol": looser * ATOL}
        stops = [end]
        if self.shock is not None:
            stops += [point * self.shock.rise_time for point in self.shock.profile.breakpoints]
        times = sorted({stop / self.unit for stop in stops if 0 <= stop <= end} | {0.0})
        state, best, when = self.start, self.contacts(self.start)[0], np.zeros(len(self.static))
        size: float | None = None
        for begin, stop in pairwise(times):
            time, kink, struck = begin, stop, -1
            while time < stop:
                step = None if size is None else min(size, kink - time)
                solver = DOP853(self, time, state, kink, first_step=step, **control)
                while solver.status == "running":
                    before = solver.y
                    solver.step()
                    dense, sampled = solver.dense_output(), np.linspace(solver.t_old, solver.t, SAMPLES)
                    forces, signs = self.contacts(dense(sampled))
                    if kink == stop and (found := self._kink(dense, sampled, signs, struck)):
                        # once more, to the kink
                        state, (time, kink, struck), size = before, (solver.t_old, *found), solver.step_size
                        break
                    struck = -1 if kink == stop else struck
                    for contact in np.flatnonzero(forces.max(axis=1) > best * (1 - 1e-3)):
                        at, force = self._top(dense, sampled, forces[contact], contact)
                        if force > best[contact]:
                            best[contact], when[contact] = force, at
                else:
                    state, time, size, kink = solver.y, kink, solver.h_abs, stop
        return (best - self.static) * self.force, when * self.unit

    def _kink(self, dense: DenseOutput, times: Array, signs: Array, struck: int) -> tuple[float, int] | None:
        """The first time within a step at which a contact opens, closes or is cut off, and the contact."""
        changes = signs[:, :-1] * signs[:, 1:] < 0
        changes[struck, :2] &= struck < 0
        if not changes.any():
            return None
        place = int(changes.any(axis=0).argmax())
        found = []
        for contact in np.flatnonzero(changes[:, place]).tolist():
            interval = float(times[place]), float(times[place + 1])
            sign = lambda time, own=contact: float(self.contacts(dense(np.array([time])))[1][own, 0])  # noqa: E731
            found.append((brentq(sign, *interval, xtol=1e-14, rtol=1e-14, disp=False), contact))
        time, contact = min(found)
        return (time, contact) if times[0] < time < times[-1] else None

    def _top(self, dense: DenseOutput, times: Array, forces: Array, contact: int) -> tuple[float, float]:
        """Time and value of the maximum of a force within a step, by two parabolas."""
        top = int(forces.argmax())
        found = float(times[top]), float(forces[top])
        step = times[1] - times[0]
        for _ in range(3):
            near = np.clip(found[0], times[0] + step, times[-1] - step) + step * np.array([-1.0, 0.0, 1.0])
            left, middle, right = self.contacts(dense(near))[0][contact].tolist()
            bend = left - 2 * middle + right
            if bend >= 0:
                break
            time = float(np.clip(near[1] + step * (left - right) / (2 * bend), times[0], times[-1]))
            force = float(self.contacts(dense(np.array([time])))[0][contact, 0])
            if force >= found[1]:
                found = time, force
            step /= 30
        return found


# ---------------------------------------------------------------- the comparison


def checked(number: int) -> list[tuple[float, ...]]:
    """A chain at each tolerance.

    Each row has the tolerance, the largest relative error of a force, the share of contacts whose errors are below the
    tolerance and below their estimates, the largest error over the largest estimate, whether there is a warning, the
    largest error of a time over the characteristic time, and the number of granules.
    """
    excitation, chain = scene(number)
    rows: list[tuple[float, ...]] = []
    known, end, repeated = None, None, False
    for rtol in sorted(TOLERANCES):
        result = sw.simulate(excitation, chain, rtol=rtol, until=end)
        if not isinstance(result, ChainResult):
            return []  # equal granules with free ends
        if known is None:
            end = result.end
            reference = Reference(excitation, chain, result.characteristic_time)
            known = reference.greatest(end)
            uncertain = np.zeros_like(known[0])
        dynamic, times = known
        judged = [peak.contact for peak in result.contacts if dynamic[peak.contact] > LEAST * dynamic.max()]
        found = [result.contacts[contact] for contact in judged]
        own = np.array([peak.peak_force - peak.static_force for peak in found])
        errors = np.abs(own - dynamic[judged]) / dynamic[judged]
        estimates = np.array([peak.error_estimate for peak in found])
        if np.any(errors > np.minimum(estimates, rtol)) and not repeated:
            repeated, uncertain = True, np.abs(reference.greatest(end, LOOSER)[0] - dynamic)
        errors = np.maximum(errors - uncertain[judged] / dynamic[judged], 0.0)
        late = np.abs([peak.time for peak in found] - times[judged]) / result.characteristic_time
        same = late < 0.5  # not another maximum of about the same force
        rows.append(
            (
                rtol,
                errors.max(),
                np.mean(errors <= rtol),
                np.mean(errors <= estimates),
                errors.max() / estimates.max(),
                bool(result.warnings),
                late[same].max(initial=0.0),
                len(result.velocities),
            )
        )
    return rows


def attempt(number: int) -> list[tuple[float, ...]] | str:
    """`checked`, or the error."""
    try:
        return checked(number)
    except sw.ShockwaveError as error:
        return f"chain {number}: {error}"


def table(found: list[list[tuple[float, ...]]]) -> Iterator[str]:
    """A row for each tolerance."""
    yield "| `rtol` | chains | within `rtol`, % | without warning, % | contacts, % | estimate holds, % | contacts, % |"
    yield "|---|---|---|---|---|---|---|"
    for rtol in TOLERANCES:
        rows = np.array([row for rows in found for row in rows if row[0] == rtol])
        within, quiet = rows[:, 1] <= rtol, rows[:, 5] == 0
        shares = within, within[quiet], rows[:, 2], rows[:, 4] <= 1, rows[:, 3]
        yield f"| {rtol:.0e} | {len(rows)} | " + " | ".join(f"{100 * np.mean(share):.1f}" for share in shares) + " |"


def main() -> None:
    """Check all chains, print the table and write it into the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, help="number of chains; leaves the page as it is")
    parser.add_argument("--processes", type=int, help="by default one for each core")
    options = parser.parse_args()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    found, failed = [], []
    with ProcessPoolExecutor(options.processes) as pool:
        for number, rows in enumerate(pool.map(attempt, range(options.count or COUNT))):
            if isinstance(rows, str):
                failed.append(rows)
            else:
                found.append(rows)
            if (number + 1) % PROGRESS == 0:
                print(f"{number + 1} chains", *table(found), sep="\n", flush=True)
    text = "\n".join(table(found))
    print("\n".join([text, *failed]))
    if not options.count:
        begin = "<!-- table: random chains -->\n"
        before, rest = PAGE.read_text().split(begin)
        PAGE.write_text(f"{before}{begin}{text}\n{END}{rest.partition(END)[2]}")


if __name__ == "__main__":
    main()
