"""Modes of elastic-plastic contacts in a chain of mixed granules, with NumPy.

Each contact has a mode, which is fixed within a step, so that its force is smooth there: loading along one part of the
curve, or unloading and reloading. Steps end where a mode does. A contact that has not flowed yet loads along Hertz's
law like one that flows there: only its unloading differs. The compiled code implements the same algorithm.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import IntEnum
from itertools import pairwise

import numpy as np

from shockwave.base.numerics import FloatArray
from shockwave.engine.chain_arrays import LARGEST, Job
from shockwave.engine.chain_forces import FASTEST, FINER, KINK_SHARE, MIN_STEP, PARTS, SHARP, Contacts, End
from shockwave.engine.chain_peaks import NUDGE, Overlap, first_negative, vanish

#: Rows of the table of a chain with such contacts: properties, state, and constants within a step.
ROWS = (
    *("softness", "curvature", "rate", "slowness", "curves", "wider", "virgin", "start", "first", "cap", "full"),
    *("a", "b", "level", "slope", "yield_force", "unit"),
    *("mode", "reached", "force", "left", "limit", "offset", "tangent", "curved", "ended"),
)

# A flowing contact outrun below this many times the speed at which its strength grows was outrun at that speed.
_BEGINNING = 2.0


class Mode(IntEnum):
    """What the force of a contact follows: Hertz's law; unloading; loading between; full plasticity; a constant."""

    CAPPED = 0
    ELASTIC = 1
    MIDDLE = 2
    FULL = 3
    PLATEAU = 4


class Plasticity:
    """The modes of the contacts of a run with NumPy."""

    def __init__(self, contacts: Contacts, job: Job) -> None:
        self.chain, self.job, self.rows = contacts, job, job.plastic[:, :-1]
        rows = dict(zip(ROWS, self.rows, strict=True))
        self.softness, self.curvature, self.rate, self.slowness = (rows[name] for name in ROWS[:4])
        self.curves, self.wider, self.virgin, self.start, self.first = (rows[name] for name in ROWS[4:9])
        self.cap, self.full, self.a, self.b, self.level, self.slope = (rows[name] for name in ROWS[9:15])
        self.yields, self.unit, self.mode, self.reached, self.force = (rows[name] for name in ROWS[15:20])
        self.left, self.limit, self.offset, self.tangent, self.curved, self.ended = (rows[name] for name in ROWS[20:])
        self.pieces = job.curves
        self.elastic = np.where(np.array(ROWS) == "limit", LARGEST, 0.0)

    # ---------------------------------------------------------------- forces

    def stiffest(self, force: float) -> FloatArray:
        """Largest stiffness k of each contact at forces up to this one, or as now."""
        yields = self.softness > 0
        reached = np.maximum(force, np.where(yields, self.yields, 1.0))
        depths = self.depth(reached)
        softest = reached / np.where(yields, depths * np.sqrt(depths), 1.0)
        return np.asarray(np.where(yields, np.maximum(softest, self.chain.k), self.chain.k))

    def faster(self, j: int, w: float) -> float:
        """Increase of the strength by a closing velocity, in pieces of the curves."""
        times = w * float(self.slowness[j])
        return float(self.rate[j]) * min(math.log(times), FASTEST) if self.rate[j] != 0 and times > 1 else 0.0

    def load(self, j: int, mode: int, motion: tuple[float, float, float], faster: float) -> tuple[float, float]:
        """Force of loading in a mode, and its time derivative while a contact flows, from its overlap, w and w'."""
        d, w, a = motion
        if mode == Mode.PLATEAU:
            return float(self.force[j]), 0.0
        if mode == Mode.CAPPED:
            return float(self.virgin[j]) * (d * math.sqrt(d)), 0.0
        if faster == 0:
            if mode == Mode.FULL:
                return float(self.level[j] + self.slope[j] * d), float(w * self.slope[j])
            level, slope, log = float(self.a[j]), float(self.b[j]), math.log(d)
            return d * (level + slope * log), w * (level + slope * (1 + log))
        share, piece = faster % 1.0, self.pieces[int(self.curves[j]) + int(faster)]
        *others, (level, slope) = piece[:, 2:].tolist() if mode == Mode.FULL else piece[:, :2].tolist()
        levels = slopes = 0.0
        for first, second in reversed(others):
            levels, slopes = levels * share + level, slopes * share + slope
            level, slope = level * share + first, slope * share + second
        curvature, unit = float(self.curvature[j]), float(self.unit[j])
        e, stretch, grows = d * curvature, w * curvature, float(self.rate[j]) * a / w
        if mode == Mode.FULL:
            return unit * (level + slope * e), unit * (slope * stretch + (levels + slopes * e) * grows)
        log = math.log(e)
        rate = (level + slope * (1 + log)) * stretch + e * (levels + slopes * log) * grows
        return unit * (e * (level + slope * log)), unit * rate

    def flow_force(self, j: int, u: float, d: float, w: float) -> float:
        """Force of a contact that flows along a curve minus the static one, from the change ``u`` of its overlap.

        Ahead of a wave the difference of both forces is rounding error.
        """
        mode, faster, base = int(self.mode[j]), self.faster(j, w), float(self.chain.base[j])
        if mode == Mode.MIDDLE and faster == 0 and self.cap[j] < base <= self.full[j]:
            slope = float(self.b[j])
            return u * (float(self.a[j]) + slope * math.log(d)) + base * slope * math.log1p(u / base)
        return self.load(j, mode, (d, w, 0.0), faster)[0] - float(self.chain.static[j])

    def forces(self, f: FloatArray, motion: Sequence[FloatArray], low: int) -> None:
        """Replace the forces minus static ones of contacts that flow along a curve.

        The ``motion``: changes of the overlaps, overlaps, and closing velocities.
        """
        for i in np.flatnonzero(self.curved[low : low + len(f)] > 0).tolist():
            j, (u, d, w) = low + i, (float(values[i]) for values in motion)
            f[i] = self.flow_force(j, u, d, w)

    def add_losses(self, start: End, finish: End, span: tuple[float, float], stages: FloatArray) -> None:
        """Add the work of rate-dependent plastic flow, from the time and size of a step and the forces at its stages.

        The velocities there are less accurate than those of the polynomial of the overlap.
        """
        method = self.job.method
        for j in np.flatnonzero(self.curved > 1).tolist():
            overlap = Overlap.between(self.chain, start, finish, *span, j)
            forces = (stages[: len(method.nodes), j + 1] + self.chain.static[j]).tolist()
            for node, weight, force in zip(method.nodes.tolist(), method.weights[1].tolist(), forces, strict=True):
                self.job.losses[j] += weight * force * overlap.closing_velocity(node)

    def rates(self, slope: FloatArray, motion: Sequence[FloatArray], low: int) -> None:
        """Replace the time derivatives of the forces of contacts that flow; ``motion``: overlaps, w and w'."""
        for i in np.flatnonzero(self.mode[low : low + len(slope)] > Mode.ELASTIC).tolist():
            j, (d, w, a) = low + i, (float(values[i]) for values in motion)
            slope[i] = self.load(j, int(self.mode[j]), (d, w, a), self.faster(j, w))[1]

    def stored_energy(self, j: int, d: float) -> float:
        """Energy that a contact releases, or has taken up since zero overlap; zero where that is integrated."""
        mode = int(self.mode[j])
        if mode <= Mode.ELASTIC:
            depth = max(d - float(self.left[j]) if mode == Mode.ELASTIC else d, 0.0)
            return 0.4 * float(self.chain.k[j]) * (depth * depth * math.sqrt(depth))
        if mode == Mode.PLATEAU:
            return float(self.force[j]) * d
        if self.rate[j] != 0:
            return 0.0
        if mode == Mode.MIDDLE:
            return 0.5 * d * d * float(self.a[j] + self.b[j] * (math.log(d) - 0.5))
        return d * float(self.level[j] + 0.5 * self.slope[j] * d)

    def released_energies(self, d: FloatArray, forces: FloatArray) -> FloatArray:
        """Energies that all contacts release from their overlaps, less residual ones, and forces on."""
        depths = np.maximum(d, 0.0)
        flows = (self.mode > Mode.ELASTIC) | ((self.mode == Mode.CAPPED) & (d > self.first))
        depths[flows] = self.depth(forces)[flows]
        return np.asarray(0.4 * forces * depths)

    # ---------------------------------------------------------------- modes

    def region(
        self, j: int, motion: tuple[float, float, float], flow: tuple[float, float] | None = None
    ) -> tuple[Mode, float, float, float]:
        """Part of the loading curve and, for a rate-dependent contact, force, its time derivative and its excess.

        Force and derivative are those of the ``flow`` at one end of a step if it is in that part. The excess is that
        over Hertz's force.
        """
        d, w, _a = motion
        if not d > self.cap[j]:
            return Mode.CAPPED, *self.load(j, Mode.CAPPED, motion, 0.0), 0.0
        faster = self.faster(j, w)
        mode = Mode.FULL if d > self.full[j] + self.wider[j] * faster else Mode.MIDDLE
        if self.rate[j] == 0:
            return mode, 0.0, 0.0, 0.0
        force, rate = flow if flow and mode == self.mode[j] else self.load(j, mode, motion, faster)
        hertz, growth = float(self.virgin[j]) * (d * math.sqrt(d)), 1 + faster / FINER
        if mode == Mode.MIDDLE and not (d > self.first[j] * (growth * growth) and force < hertz):
            return Mode.CAPPED, hertz, rate, force - hertz
        return mode, force, rate, force - hertz

    def next_mode(
        self, j: int, motion: tuple[float, float, float], flow: tuple[float, float] | None = None
    ) -> tuple[int, float]:
        """Mode of a contact at an overlap, closing velocity and acceleration; a number that falls to zero at its end.

        The ``flow`` is that at one end of a step.
        """
        (d, w, a), mode = motion, int(self.mode[j])
        if (mode == Mode.CAPPED and not d > self.first[j]) or (mode == Mode.ELASTIC and not w > 0):
            return mode, 0.0
        if mode != Mode.ELASTIC and w < 0:
            return Mode.ELASTIC, 0.0
        d += float(self.left[j]) if mode == Mode.ELASTIC else 0.0
        following, force, slope, excess = self.region(j, (d, w, a), flow)
        if self.rate[j] == 0:
            return following, 0.0
        margin = excess if mode == Mode.CAPPED else float(self.force[j]) - force if mode == Mode.PLATEAU else slope
        if mode in (Mode.ELASTIC, Mode.PLATEAU) and not force > self.force[j]:
            return Mode.PLATEAU, margin
        if mode == Mode.ELASTIC:
            depth = d - float(self.left[j])
            margin = force - float(self.chain.k[j]) * (depth * math.sqrt(depth))
            if margin > 0:
                return mode, margin
        if following == Mode.CAPPED:
            return following, margin
        force = 2 * max(force, float(self.force[j])) + float(self.yields[j])
        # faster loading outruns the stiffer unloading, which has the slope 1.5 sqrt(force/softness) w
        if slope > 0 and slope * slope * self.softness[j] > 2.25 * force * (w * w):
            return Mode.ELASTIC, margin
        return following if mode == Mode.PLATEAU or not slope < 0 else Mode.PLATEAU, margin

    def change_modes(self, start: End, time: float) -> bool:
        """Change the modes that end at the beginning of a step; whether there are any."""
        contacts, changed = self.chain.contacts, False
        n = min(len(start.d), contacts)
        for j in np.flatnonzero(start.u[:n] > self.limit[:n]).tolist():
            a = float(self.chain.closing_accelerations(start.a[j : j + 2], time, j)[0])
            force, slope = float(start.f[j + 1] + self.chain.static[j]), float(start.slope[j])
            following, _margin = self.next_mode(j, (float(start.d[j]), float(start.w[j]), a), (force, slope))
            if following != self.mode[j]:
                corner = force - slope * (time - float(self.ended[j]))
                elastic = self.mode[j] <= Mode.ELASTIC
                self.change_mode(j, following, (float(start.d[j]), float(start.w[j]), a), force, corner)
                changed, peak, best = True, float(self.force[j] - self.chain.static[j]), self.job.peaks[:, j]
                if following == Mode.PLATEAU and elastic and peak > best[0]:
                    best[:] = peak, self.ended[j]
            elif self.curved[j] > 1:
                self.force[j] = max(float(self.force[j]), force)
            elif following == Mode.ELASTIC and not start.w[j] > 0:  # it has turned at the limit
                self.limit[j] = start.u[j]
        return changed

    def plateau(self, j: int, motion: tuple[float, float, float], force: float, corner: float) -> float:
        """Force of the plateau that begins where unloading or Hertz's law meets falling loading, or this falls.

        The step has ended slightly later than the ``corner``.
        """
        mode = int(self.mode[j])
        if mode > Mode.ELASTIC:
            return max(float(self.force[j]), force)
        if mode == Mode.ELASTIC and not self.region(j, motion)[1] > self.force[j]:
            return float(self.force[j])
        return corner

    def change_mode(
        self, j: int, following: int, motion: tuple[float, float, float], force: float, corner: float = 0.0
    ) -> None:
        """Change the mode of a contact, from its motion, its force, and that where the mode has ended."""
        mode, (d, w, a), chain = int(self.mode[j]), motion, self.chain
        d += float(self.left[j]) if mode == Mode.ELASTIC else 0.0
        self.job.losses[j] += self.stored_energy(j, d)
        if following == Mode.ELASTIC:
            # the contact has turned just before
            self.reached[j] = reached = d + (min(0.5 * w * w / -a, NUDGE * d) if a < 0 else 0.0)
            if mode != Mode.PLATEAU:
                flows = self.curved[j] > 1
                if flows and 0 < w * self.slowness[j] < _BEGINNING:  # outrun where the strength began to grow
                    force = min(force, self.load(j, mode, (d, w, a), 0.0)[0])
                slow = self.load(j, mode, (reached, w, a), 0.0)[0]
                self.force[j] = max(float(self.force[j]), force) if flows else slow
            depth = float(self.depth(self.force)[j])
            chain.k[j] = self.force[j] / (depth * math.sqrt(depth))
            self.left[j] = reached - depth
        else:
            meets = following == Mode.PLATEAU
            self.force[j] = self.plateau(j, (d, w, a), force, corner) if meets else max(float(self.force[j]), force)
            chain.k[j] = self.virgin[j] if following == Mode.CAPPED else 0.0
        self.mode[j] = following
        self.set_constants(j)
        self.job.losses[j] -= self.stored_energy(j, d)

    def depth(self, forces: FloatArray) -> FloatArray:
        """Overlaps above the residual ones where unloading from these forces begins."""
        return np.asarray(forces * np.sqrt(self.softness / np.maximum(2 * forces + self.yields, 1e-300)))

    def set_constants(self, j: int) -> None:
        """Set what the forces need of the mode of a contact, of which k is known."""
        chain, mode, rate = self.chain, int(self.mode[j]), int(self.rate[j] != 0)
        smooth = mode <= Mode.ELASTIC
        start = float(self.start[j]) - (float(self.left[j]) if mode == Mode.ELASTIC else 0.0)
        base = chain.base[j] = max(start, 0.0)
        chain.gap[j], chain.root[j] = min(start, 0.0), math.sqrt(base)
        self.curved[j] = 1 + rate if mode == Mode.MIDDLE or (mode == Mode.FULL and rate) else 0
        self.tangent[j] = self.slope[j] if mode == Mode.FULL and not rate else 0.0
        level = self.force[j] if mode == Mode.PLATEAU else self.level[j]
        flow = level + self.tangent[j] * base
        self.offset[j] = (chain.k[j] * (base * chain.root[j]) if smooth else flow) - chain.static[j]
        if self.curved[j] > 0:
            self.offset[j] = 0.0
        # of the change of the overlap, which is exact ahead of a wave
        end = self.first[j] if mode == Mode.CAPPED else self.reached[j] - self.left[j]
        self.limit[j] = end - base if smooth else -LARGEST

    # ---------------------------------------------------------------- ends of modes within a step

    def end_of_modes(self, start: End, finish: End, time: float, size: float, share: float) -> float:
        """Fraction of the step at which it should end because a mode does; ``share`` if it need not."""
        n = min(len(start.d), self.chain.contacts)
        fastest = np.maximum(np.abs(start.w[:n]), np.abs(finish.w[:n]))
        near = np.maximum(start.u[:n], finish.u[:n]) + 2 * size * fastest > self.limit[:n]
        for j in np.flatnonzero(near).tolist():
            overlap = Overlap.between(self.chain, start, finish, time, size, j)
            at = self.leaves(overlap)
            self.ended[j] = time + min(at, 1.0) * size
            if at >= share:
                continue
            force = max(float(start.f[j + 1]), float(finish.f[j + 1]))
            late = self.delay(j, force, *overlap.motion(at)[1:])
            cut = at + 0.5 * late / size
            least = MIN_STEP * max(time, self.chain.first)
            if (1 - at) * size > late and cut < share and at * size + 0.5 * late > least:
                share = cut
        return share

    def turns(self, start: End, time: float) -> float:
        """Least size of a step that ends after a contact turns, of those whose flow does not depend on the rate."""
        size, slope = math.inf, np.concatenate(([0.0], start.slope, [0.0]))
        for j in np.flatnonzero((self.mode > Mode.ELASTIC) & (self.curved <= 1)).tolist():
            w, a = float(start.w[j]), float(self.chain.closing_accelerations(start.a[j : j + 2], time, j)[0])
            jerks = self.chain.mobile[j : j + 2] * (slope[j : j + 2] - slope[j + 1 : j + 3])
            last = math.sqrt(max(a * a - 2 * float(jerks[0] - jerks[1]) * w, 0.0))
            if w > 0 > a and last > 0:
                size = min(size, 2 * w / (last - a) + 0.5 * self.delay(j, float(start.f[j + 1]), 0.0, last))
        return size

    def delay(self, j: int, force: float, w: float, a: float) -> float:
        """Time after the end of a mode in which the impulse that a step misses is small; force less the static one."""
        force, least = force + float(self.chain.static[j]), float(self.yields[j])
        stiffness = 1.5 * math.sqrt((2 * max(force, least) + least) / float(self.softness[j]))
        most = KINK_SHARE * float(self.chain.allowed_impulses(j + 1)[j])
        late = math.sqrt(most / (stiffness * abs(w))) if w else math.inf
        late = min(late, math.cbrt(most / (stiffness * abs(a)))) if a else late
        return late * (SHARP if self.rate[j] else 1.0)

    def leaves(self, overlap: Overlap) -> float:
        """Fraction of the step at which the mode of a contact ends; 2 if it does not."""
        j, c = overlap.j, overlap.coefficients
        mode, rate, base = int(self.mode[j]), self.rate[j] != 0, float(self.chain.base[j])
        b = [c[0], c[0] + c[1] / 5, c[0] + (4 * c[1] + c[2]) / 10, c[0] + (6 * c[1] + 3 * c[2] + c[3]) / 10]
        b += [c[0] + (4 * c[1] + 3 * c[2] + 2 * c[3] + c[4]) / 5, c[0] + c[1] + c[2] + c[3] + c[4] + c[5]]
        at = passes = 2.0
        end = self.cap[j] - base if mode == Mode.CAPPED else self.full[j] - base
        end = float(self.limit[j] if mode == Mode.ELASTIC else end)
        if mode != Mode.ELASTIC:
            slopes = [after - before for before, after in pairwise(b)]
            at = first_negative(slopes, overlap.closing_velocity, 0.0, 1.0)
            if mode == Mode.CAPPED and at <= 1 and not overlap.change(at) > self.limit[j]:
                at = 2.0
        if mode == Mode.ELASTIC or (not rate and mode != Mode.FULL):
            passes = first_negative([end - each for each in b], lambda s: end - overlap.change(s), 0.0, 1.0)
        if not rate:
            return min(at, passes)
        if mode == Mode.ELASTIC:
            if passes > 1:
                return 2.0
            turns = overlap.closing_velocity(1.0) <= 0
            return self.mode_ends(
                overlap, passes, vanish(overlap.closing_velocity, passes, 1.0, 0.5 * (passes + 1))[0] if turns else 1.0
            )
        if mode == Mode.CAPPED and max(b) <= end:
            return at
        return min(self.mode_ends(overlap, 0.0, min(at, 1.0)), at)

    def mode_ends(self, overlap: Overlap, low: float, high: float) -> float:
        """Where between low and high the mode of a contact with rate ends; 2 if it does not."""
        j, start, finish = overlap.j, overlap.start, overlap.finish
        force, first, last = (
            float(finish.f[j + 1] + self.chain.static[j]),
            float(start.slope[j]),
            float(finish.slope[j]),
        )

        def keeps(s: float) -> float:
            d, w, a = overlap.motion(s)
            following, margin = self.next_mode(j, (d, max(w, 0.0), a), (force, last) if s == 1 else None)
            if following == self.mode[j]:
                return margin if margin > 0 else 1.0
            return margin if margin < 0 else -1.0

        # a force of flow that rises steadily falls nowhere within the step
        parts = 1 if self.curved[j] > 1 and first < 2 * last and last < 2 * first else PARTS
        before, about = low, (float(self.ended[j]) - overlap.time) / overlap.size
        for i in range(1, parts + 1):
            at = low + i * ((high - low) / parts)
            if keeps(at) < 0:
                return vanish(keeps, before, at, about if before < about < at else 0.5 * (before + at))[0]
            before = at
        return 2.0
