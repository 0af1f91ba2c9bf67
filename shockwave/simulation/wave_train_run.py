"""A run of the whole chain, from the beginning of the shock until all waves have been measured."""

from __future__ import annotations

import math

import numpy as np
from attrs import define, evolve, field

from shockwave.base.numerics import FloatArray
from shockwave.base.progress import report_progress
from shockwave.engine.integrator import Integrator
from shockwave.engine.peak_log import Peak, PeakLog
from shockwave.engine.scaled_problem import ScaledProblem, chain_energy
from shockwave.engine.search_request import Primary
from shockwave.engine.stretch import Stretch, free_granules
from shockwave.scene.chain import HERTZ
from shockwave.simulation.rebounding_granules import EJECTED, count_departed, find_rebounding
from shockwave.simulation.result_parts import MeasuredWave
from shockwave.simulation.travelling_waves import PASSING, Outlook, distance_from_limit, passage_time
from shockwave.simulation.wave_properties import Probe, Transit, measure_wave
from shockwave.simulation.whole_chain import WholeChain

# Interval at which the waves are examined, in characteristic times.
_INTERVAL = 12.0
# Its least share of the time.
_SHARE = 0.25
# Time for which steps are kept, in passage times of the weakest wave: from before until after a wave has passed.
_KEPT = 3.2
# Contacts that the front may pass before waves other than the leading one are measured even if they have not settled:
# a constant, and a number for each characteristic time of the duration of the shock.
_BUDGET = 160.0
_BUDGET_RATE = 6.0
# Time after which the leading wave is found to have settled here, over that of the search for it.
_LATER = 1.15
# Scatter of peak forces over the error tolerance of a step.
_NOISE = 30.0
# Distance in granules at which a free end affects a wave.
_REACH = 8
# Largest number of steps after the shock in which the granules of a finite chain can separate: a constant, and a number
# for each granule.
_PARTING = 500
_PARTING_RATE = 20
# Number of granules of a short chain, and the smallest relative velocity in it that is followed to a collision, over
# the largest velocity: slower granules would travel so far that rounding affects their overlaps.
_SHORT = 50
_SLOWEST = 1e-6
# Contributions to the error of the rebound momentum, checked by research/check/check_estimates.py: its change over the
# last third of the time after the shock, the momentum that other granules carry backwards, and the momentum of the
# granules behind the waves, some of which rebound late.
_LATE = 1 / 3
_CHANGE_SHARE = 2.0
_BACKWARD_SHARE = 4.0
_REMAINING_SHARE = 3e-3
# Contributions to the error of a wave that has not settled, checked by research/check/check_estimates.py: its
# enlargement, and the share of the motion that faster waves have left ahead, which it will meet, over the 5/6 power of
# its peak force.
_UNSETTLED = 2.0
_AHEAD_SHARE = 0.07
# Fraction of the time after the shock at which another run is compared with this one, at the earliest.
_COMPARED = 0.45
# Largest distance in granules to a free end up to which waves are followed after they have been measured.
_FARTHEST = 2000


@define(eq=False)
class ChainRun:
    """A run and its results, in scaled units.

    Attributes
    ----------
    wave_threshold : float
        Least peak force of a wave, over that of the leading wave.
    primary_doubt, later_doubt : float
        Allowed relative deviation of a peak force from its limit, for the leading wave and for later waves; that of
        weak later waves may be larger.
    most_contacts : int
        Largest number of contacts that the front passes.
    label : str
        Name of the run in reports of progress.
    leading : Primary or None
        Leading wave, if it is known. The waves are not examined before it is expected to settle.
    waves : tuple of MeasuredWave
        Waves in the order of their arrival. Their ``error_estimate`` bounds the relative deviation of the peak force
        from its limit along the chain. At the end of a finite chain the peak itself is the result, and the estimate is
        the error tolerance of a step.
    unread : int
        Number of waves that could not be measured, since none of their peaks was found where they had passed.
    recoils : tuple of float
        Velocities of the rebounding granules, first granule first.
    unfinished_recoil : float
        Bound on the momentum that the rebounding granules may still gain or lose.
    spalls : tuple of float or None
        Velocities of the granules that leave the free end faster than `EJECTED` times the granules in the waves, last
        granule first; None if the waves were not followed to the free end.
    momentum, energy : float
        Momentum and energy of the chain when the waves are measured.
    work : float
        Energy of the chain at the end of the force; later changes are errors of the integration.
    settled : bool
        False if the allowed number of contacts was passed before all waves had settled.
    unfollowed_force : float
        Bound on the contact forces of collisions in a finite chain after the end of the run.
    log, steps : PeakLog, int
        The peaks of all contacts, and the number of steps.
    shortened : tuple of (float, int)
        Times at which the foremost waves were removed, and the numbers of granules that were left.
    measured, end : float
        Times at which the waves and the rebounding granules were known, and at which the run ended.
    """

    problem: ScaledProblem
    integrator: Integrator
    wave_threshold: float
    primary_doubt: float
    later_doubt: float
    most_contacts: int
    label: str = "wave train"
    leading: Primary | None = None
    waves: tuple[MeasuredWave, ...] = ()
    unread: int = 0
    recoils: tuple[float, ...] = ()
    unfinished_recoil: float = 0.0
    spalls: tuple[float, ...] | None = None
    momentum: float = 0.0
    energy: float = 0.0
    work: float = 0.0
    settled: bool = True
    unfollowed_force: float = 0.0
    shortened: tuple[tuple[float, int], ...] = ()
    measured: float = 0.0
    end: float = 0.0
    _whole: WholeChain = field(init=False)
    _driven_steps: int = 0
    _free_end: Probe | None = None
    _recent: list[tuple[Stretch, float]] = field(factory=list)
    _transits: list[Transit] = field(factory=list)
    _ready: dict[int, tuple[Peak, float]] = field(factory=dict)
    _rearmost: int = 0
    _removed: int = 0
    _lead: Peak = field(init=False)
    _wait: float = 0.0
    _left: float = math.inf
    _velocities: list[tuple[float, FloatArray]] = field(factory=list)

    def __attrs_post_init__(self) -> None:
        self._whole = WholeChain(self.problem, self.integrator)
        if self.problem.granules is not None:
            last = self.problem.granules - 2
            self._free_end = Probe(max(last - _REACH, last // 2))

    @property
    def log(self) -> PeakLog:
        return self._whole.log

    @property
    def steps(self) -> int:
        return self._whole.steps

    def finish(self) -> ChainRun:
        """Integrate until all waves are known and, in a finite chain, until they have left the chain.

        Raises
        ------
        NumericalError
            If the integrator fails.
        """
        stretch = self._advance(self.problem.duration)
        self.work = chain_energy(stretch.x[-1], stretch.v[-1], self.problem.exponent)
        self._driven_steps = self.steps
        if self._expected > stretch.end:
            stretch = self._advance(self._expected)
        while not self._has_seen_all(stretch):
            interval = max(_INTERVAL, _SHARE * stretch.end, self._wait)
            stretch = self._advance(stretch.end + min(interval, self._left))
        # Rounding errors grow when weak waves collide, so everything but the spall is measured now.
        x, v = stretch.x[-1], stretch.v[-1]
        if self._free_end is not None and self.reached_end:
            self._transits = self._at_end(self._free_end)
        # two heads may belong to the same wave where it has passed
        transits = {(each.peak.contact, each.peak.time): each for each in self._transits}
        # the compiled code reads waves of Hertz's law
        compiled = getattr(self.integrator, "compiled", None) if self.problem.exponent == HERTZ else None
        self.waves = tuple(measure_wave(each, self.problem, compiled) for each in transits.values())
        self.measured = stretch.end
        self._keep_velocities(self.problem.duration + _COMPARED * (self.measured - self.problem.duration))
        self.momentum += float(np.sum(v))
        self.energy += chain_energy(x, v, self.problem.exponent)
        ejected = EJECTED * max((wave.granule_velocity for wave in self.waves), default=0.0)
        self.recoils, loose = find_rebounding(v, ejected)
        since = stretch.end - _LATE * (stretch.end - self.problem.duration)
        earlier = [velocities for time, velocities in self._velocities if since <= time < stretch.end]
        late = [sum(self.recoils), *(sum(find_rebounding(velocities, ejected)[0]) for velocities in earlier)]
        remaining = float(np.abs(v[free_granules(x, v) : self._rearmost]).sum())
        self.unfinished_recoil = (
            _CHANGE_SHARE * float(np.ptp(late)) + _BACKWARD_SHARE * loose + _REMAINING_SHARE * remaining
        )
        granules = self.problem.granules
        if granules is not None and granules - self.log.front <= _FARTHEST:
            while not self._is_spent(stretch):
                stretch = self._advance(stretch.end + _INTERVAL)
            x, v = stretch.x[-1], stretch.v[-1]
            # granules that hardly move relative to one another depart, though some will exchange their velocities
            leaving = v[::-1] if self.unfollowed_force == 0 else v[::-1][: count_departed(x, v)]
            self.spalls = tuple(leaving[leaving > ejected].tolist())
        self.end = stretch.end
        report_progress(self.label, math.ceil(self.end), math.ceil(self.end))
        return self

    @property
    def reached_end(self) -> bool:
        """Whether the free end may affect the front before the waves are known."""
        granules = self.problem.granules
        return granules is not None and self.log.front >= granules - 1 - _REACH

    @property
    def _reach(self) -> int:
        """Distance in granules at which a wave and an end of the chain affect each other."""
        return int(_REACH * self.problem.wave.spread)

    @property
    def compared(self) -> tuple[float, FloatArray]:
        """Time at which a coarser run is compared with this one, and the velocities of the granules.

        The errors of the steps grow in proportion to the time, so that half of the time is sufficient. In a finite
        chain they also grow in collisions, until the end.
        """
        share = _COMPARED if self.problem.granules is None else 1.0
        earliest = min(self.problem.duration + share * (self.measured - self.problem.duration), self.measured)
        return min((each for each in self._velocities if each[0] >= earliest), key=lambda each: each[0])

    @property
    def _budget(self) -> float:
        """Number of contacts that the front may pass before waves that have not settled are measured, too."""
        return (_BUDGET + _BUDGET_RATE * self.problem.duration) * self.problem.wave.spread**2

    @property
    def _expected(self) -> float:
        """Time at which the leading wave of an endless chain is expected to have settled; 0 if it is not known."""
        leading = self.leading
        if leading is None or self.problem.granules is not None or leading.contact > self._budget:
            return 0.0
        return _LATER * leading.time + passage_time(self.problem.wave, leading.peak)

    @property
    def _kept(self) -> float:
        """Time for which steps are kept: from before the weakest wave has passed until after it has."""
        return _KEPT * passage_time(self.problem.wave, self.wave_threshold * self.log.strongest)

    def _advance(self, until: float) -> Stretch:
        """Integrate to ``until``; the last stretch."""
        while True:
            stretch = self._whole.advance(until, 0.0 if self._free_end else max(until - self._kept, 0.0))
            report_progress(self.label, int(stretch.end), None)
            while self._recent and self._recent[0][0].end <= stretch.end - self._kept:
                del self._recent[0]
            self._recent.append((stretch, 0.0))
            if self._free_end is not None:
                self._free_end.observe(stretch)
            if stretch.end >= until:
                return stretch

    def _has_seen_all(self, stretch: Stretch) -> bool:
        """Whether the waves are known after ``stretch``."""
        self._keep_velocities(stretch.end - self._kept / 2)
        self._velocities.append((stretch.end, stretch.v[-1].copy()))
        return self._is_spent(stretch) if self.reached_end else self._judge(stretch)

    def _keep_velocities(self, then: float) -> None:
        """Keep the velocities at the end of the step at ``then``, if they are at hand."""
        for each, _ in self._recent:
            if each.times[0] <= then < each.end:
                row = int(each.times.searchsorted(then))
                self._velocities.append((each.times.item(row), each.v[row].copy()))

    def _judge(self, stretch: Stretch) -> bool:
        """Whether every wave has settled; then they are measured."""
        self._wait, self._left = 0.0, math.inf
        outlook = Outlook(self.log, stretch.end, self.wave_threshold, _NOISE * self.integrator.tolerance)
        if not self._removed:
            if not outlook.heads:
                return False
            self._lead = outlook.heads[0]
        speed = self.problem.wave.speed / self.problem.wave.time(self._lead.force)
        front = self._lead.contact + (stretch.end - self._lead.time) * speed
        budget = self._budget
        if front <= budget:
            self._left = (budget + 1 - front) / speed
        # In order of position: behind a wave that has not settled, a peak can remain constant for a while.
        strong = [wave for wave, head in enumerate(outlook.heads) if head.force >= outlook.least]
        places = dict(enumerate(strong, start=self._removed))
        for place, wave in places.items():
            force = outlook.heads[wave].force
            # The leading wave may use the longest chain; later waves get the length it needed, or the budget.
            most, allowed = float(self.most_contacts), self.primary_doubt
            if force < outlook.strongest:
                # rounding and step errors are larger relative to weak waves
                most, allowed = budget, self.later_doubt * math.sqrt(outlook.strongest / force)
            if place in self._ready or front > most:
                continue
            if not outlook.settled_trail(wave).rows or outlook.bound(wave) > allowed:
                self._wait = outlook.wait(wave, allowed)
                self._shorten(outlook, strong[: place - self._removed], stretch)
                return False
            self._ready[place] = self._read_wave(outlook, place, wave)
        complete = outlook.is_complete(stretch.x[-1], stretch.v[-1])
        self.settled = complete or front <= budget
        if not complete and self.settled:
            self._shorten(outlook, strong, stretch)
            return False
        self._measure(outlook, strong)
        self._rearmost = outlook.heads[strong[-1]].contact if strong else self.log.removed[0]
        return True

    def _shorten(self, outlook: Outlook, settled: list[int], stretch: Stretch) -> None:
        """Measure the foremost waves, which have settled, and remove them, if the chain is at rest behind them."""
        near = self.problem.granules is not None and self.problem.granules - self.log.front <= _FARTHEST
        if not settled or near:
            return
        x, v = stretch.x[-1], stretch.v[-1]
        last = settled[-1]
        begin = outlook.heads[last + 1].contact if last + 1 < len(outlook.heads) else free_granules(x, v)
        end = outlook.heads[last].contact - self._reach
        exponent = self.problem.exponent
        speed, overlap = outlook.least**self.problem.wave.of_momentum, outlook.least ** (1 / exponent)
        motion = np.maximum(np.abs(v[begin:end]) / speed, np.abs(x[begin:end] - x[begin + 1 : end + 1]) / overlap)
        if not motion.size or motion.min() > self.later_doubt:
            return
        granules = begin + int(motion.argmin()) + 1
        self._measure(outlook, settled)
        self._removed += len(settled)
        self.momentum += float(v[granules:].sum())
        self.energy += chain_energy(x, v, exponent) - chain_energy(x[:granules], v[:granules], exponent)
        self.log.removed = (granules - 1, stretch.end, outlook.strongest)
        self.shortened += ((stretch.end, granules),)
        origin = self._whole.shorten(granules)
        self._recent = [(each, before + origin) for each, before in self._recent]

    def _measure(self, outlook: Outlook, waves: list[int]) -> None:
        """Keep what is needed to measure these waves."""
        for place, wave in enumerate(waves, start=self._removed):
            if outlook.settled_trail(wave).rows:
                transit = self._transit(outlook, place, wave)
                if self._transits and place not in self._ready:  # it may gain what the wave ahead loses, as they meet
                    ahead = self._transits[-1]
                    lost = ahead.doubt * ahead.peak.force / transit.peak.force
                    transit = evolve(transit, doubt=max(transit.doubt, lost))
                self._transits.append(transit)
            else:
                self.unread += 1

    def _read_wave(self, outlook: Outlook, place: int, wave: int) -> tuple[Peak, float]:
        """The peak at which a wave is read, and a bound on its distance from the limit."""
        peak, doubt = self.log.peak(outlook.settled_trail(wave).rows[0]), outlook.bound(wave)
        # The first wave meets no other, so that its deviation decreases geometrically. Without a bound a wave may still
        # collide with others.
        if (wave or self._removed) and math.isfinite(doubt):
            head = outlook.heads[wave]
            doubt = distance_from_limit(head, self.log) + abs(head.force / peak.force - 1)
            if place not in self._ready:
                passing = int(PASSING * self.problem.wave.spread)
                ahead = outlook.heads[wave - 1].contact - passing if wave else self.log.removed[0]
                motion = np.abs(self._recent[-1][0].v[-1, head.contact + self._reach : ahead])
                wave_momentum = head.force**self.problem.wave.of_momentum
                doubt = _UNSETTLED * (doubt + _AHEAD_SHARE * float(motion.sum()) / wave_momentum)
        return peak, doubt

    def _transit(self, outlook: Outlook, place: int, wave: int) -> Transit:
        """Where a wave is measured, in general far beyond the contact where it settled."""
        peak, distance = reading = self._read_wave(outlook, place, wave)
        settled, before = self._ready.get(place, reading)
        probe = Probe(peak.contact)
        for stretch, origin in self._recent:
            probe.observe(stretch, origin)
        return probe.transit(peak, self.log, min(distance, before + abs(peak.force / settled.force - 1)))

    def _is_spent(self, stretch: Stretch) -> bool:
        """Whether nothing more can leave a finite chain: its granules move apart, or have had enough steps to."""
        x, v = stretch.x[-1], stretch.v[-1]
        first, last = free_granules(x, v), len(x) - count_departed(x, v)
        self.unfollowed_force = 0.0
        if first >= last:
            return True
        # energy of their relative motion, which bounds the forces of later collisions
        energy = chain_energy(x[first:last], v[first:last] - v[first:last].mean())
        slow = EJECTED if len(x) > _SHORT else _SLOWEST
        if energy < 0.5 * (slow * float(np.abs(v).max())) ** 2:
            return True
        self.unfollowed_force = (2.5 * energy) ** 0.6
        return self.steps - self._driven_steps > _PARTING + _PARTING_RATE * (self.problem.granules or 0)

    def _at_end(self, end: Probe) -> list[Transit]:
        """Waves at the end of a finite chain."""
        peaks = list(self.log.at(end.contact))[::-1]
        least = self.wave_threshold * max((peak.force for peak in peaks), default=0.0)
        # The peak itself is the result. A slow force can limit both runs to the longest step, so that their difference
        # does not show the step error.
        doubt = self.integrator.tolerance
        return [end.transit(peak, self.log, doubt) for peak in peaks if peak.force >= least]
