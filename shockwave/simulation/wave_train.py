"""The wave train, and leading waves that the search does not cover, measured in two runs of the whole chain."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

from attrs import evolve

from shockwave.base.errors import NumericalError
from shockwave.base.text import si
from shockwave.engine.integrator import LONGEST_STEP
from shockwave.engine.peak_log import Peak, PeakLog
from shockwave.engine.scaled_problem import ScaledProblem
from shockwave.engine.search_request import Primary, SearchStatus
from shockwave.scene.chain import Scales
from shockwave.simulation.rebounding_granules import EJECTED, find_rebounding
from shockwave.simulation.result_parts import ContactPeak, Cost, MeasuredWave, Train
from shockwave.simulation.simulation_result import Simulation
from shockwave.simulation.wave_setup import Setup, immeasurable, scale_scene, setup_of
from shockwave.simulation.wave_train_run import ChainRun
from shockwave.simulation.whole_chain import WholeChain

# Tolerance of the second run over that of the first.
_COARSE = 10.0
# Allowed deviation of the peak force of the leading wave from its limit, over the tolerance.
_PRIMARY_DOUBT = 0.2
# The same for later waves.
_LATER_DOUBT = 2.0
# Largest relative deviation of a settled wave, however loose the tolerance.
_MOST_DOUBT = 3e-4
# Least relative deviation that is worth its cost.
_LEAST_DOUBT = 1e-10
# Relative rounding error of a peak force.
_ROUNDING = 1e-12
# Largest relative error estimate that is meaningful.
_UNSETTLED = 0.1
# Least greatest force on an endless chain, over that of the leading wave, that is reported.
_EXCESS = 1.01
# Longest chain: a number of contacts, and a number for each characteristic time of the duration of the shock.
_MOST_CONTACTS = 1000
_MOST_RATE = 10


def train_of(result: Simulation) -> Train:
    """Integrate and measure the train of a result whose leading wave is known."""
    problem, scales = scale_scene(result.scene)
    if result.options.timeout is None and (reason := immeasurable(problem)):
        return _primary_alone(result, f"The train is not integrated, because {reason}.")
    try:
        # the search for the leading wave is more accurate than the runs for all waves
        train, _ = _train(problem, scales, setup_of(result.options), _LATER_DOUBT, result.wave.scaled)
    except NumericalError as error:
        return _primary_alone(result, f"The train could not be measured: {error}.")
    strongest, *others = train.waves
    apart = abs(strongest.peak_force / result.peak_force - 1)
    if apart > 10 * (result.error_estimate + (strongest.error_estimate or _UNSETTLED)):
        warning = (
            f"The strongest wave of the train differs from the leading wave by {apart:.0e}, more than their error"
            " estimates: neither is known to better than this. A smaller rtol may remove the difference."
        )
        return evolve(train, warnings=(*train.warnings, warning))
    primary = evolve(strongest, peak_force=result.peak_force, error_estimate=result.error_estimate)
    return evolve(train, waves=(primary, *others))


def _primary_alone(result: Simulation, reason: str) -> Train:
    """Train with only the leading wave, where the others are not known."""
    return Train(
        waves=(result.primary,),
        recoil_error=result.applied_momentum,
        warnings=(f"{reason} Later waves and rebounding granules are not known.",),
    )


def measure_primary(
    problem: ScaledProblem, scales: Scales, setup: Setup
) -> tuple[Primary, float, Train, tuple[str, ...]]:
    """Leading wave that the search does not find, with its error estimate, the train and warnings."""
    train, fine = _train(problem, scales, setup, _PRIMARY_DOUBT)
    strongest = max(fine.waves, key=lambda wave: wave.peak_force)
    primary = Primary(
        status=SearchStatus.KNOWN,
        peak=strongest.peak_force,
        last=strongest.peak_force,
        contact=strongest.contact,
        time=strongest.arrival_time,
        doubt=0.0,
        speed=strongest.speed or 0.0,
        momentum=strongest.momentum,
        energy=strongest.energy,
        foot=strongest.foot * strongest.peak_force,
        chain_momentum=fine.momentum,
        chain_energy=fine.energy,
        work=fine.work,
        impulse=problem.free(problem.duration)[1],
        free_path=0.0,
        steps=train.cost.steps,
        evaluations=train.cost.force_evaluations,
    )
    warnings: tuple[str, ...] = ()
    if fine.reached_end:
        warnings = (
            "The waves reach the free end before they have settled, so they were measured at contact"
            f" {strongest.contact} of this chain. A longer chain shows the settled waves.",
        )
    error = train.waves[0].error_estimate
    return primary, 1.0 if error is None else error, train, warnings


def _train(
    problem: ScaledProblem, scales: Scales, setup: Setup, share: float, primary: Primary | None = None
) -> tuple[Train, ChainRun]:
    """Measure the train; return it and the first run. A second, coarser run of half the time shows the step errors.

    ``share`` is the allowed deviation of the leading wave from its limit, over the tolerance, and ``primary`` the wave
    if it is known.
    """
    begin = time.perf_counter()
    most = int((_MOST_CONTACTS + _MOST_RATE * problem.duration) * problem.wave.spread**2)
    most_doubt = _MOST_DOUBT if setup.method.adaptive else max(_MOST_DOUBT, setup.rtol)
    first, later = (max(min(each * setup.rtol, most_doubt), _LEAST_DOUBT) for each in (share, _LATER_DOUBT))
    arguments = (setup.options.wave_threshold, first, later, most)
    fine = ChainRun(problem, setup.integrator(), *arguments, "wave train, run 1 of 2", primary).finish()
    if not fine.waves:
        raise NumericalError(
            f"no wave formed within {most} contacts: the shock is too slow for its peak force"
            " (shorten the shock, or increase its peak force)"
        )
    traced = fine.log.trace([(wave.contact, wave.arrival_time) for wave in fine.waves], fine.compared[0])
    coarse = WholeChain(problem, setup.integrator(_COARSE), kept=False)
    difference = _repeat(fine, coarse, traced)
    waves = _waves(fine, traced, coarse.log, scales)
    ejected = EJECTED * waves[0].granule_velocity
    recoil = sum(fine.recoils)
    error = abs(difference) * fine.measured / fine.compared[0]
    error += fine.unfinished_recoil + fine.integrator.tolerance * fine.momentum
    unit = scales.velocity
    train = Train(
        waves=waves,
        recoil_momentum=recoil * scales.momentum,
        recoil_error=error * scales.momentum,
        recoil_velocities=tuple(u * unit for u in fine.recoils if -u * unit > ejected),
        spall_velocities=None if fine.spalls is None else tuple(u * unit for u in fine.spalls),
        greatest_force=_greatest(fine, coarse.log, scales),
        cost=Cost(
            steps=fine.steps + coarse.steps,
            force_evaluations=fine.integrator.evaluations + coarse.integrator.evaluations,
            seconds=time.perf_counter() - begin,
        ),
        warnings=tuple(_warn_incomplete(fine, waves, setup.options.wave_threshold, scales)),
    )
    return train, fine


def _repeat(fine: ChainRun, coarse: WholeChain, traced: list[Peak]) -> float:
    """Repeat a run with larger steps, as far as its waves are compared; the difference of the rebounding velocities."""
    slowest = EJECTED * max(wave.granule_velocity for wave in fine.waves)
    (compared, then), difference = fine.compared, 0.0
    # granules of a finite chain may collide until the end
    end = fine.end if fine.problem.granules else max(compared, *(peak.time + LONGEST_STEP for peak in traced))
    for until, granules in sorted([(compared, 0), *fine.shortened, (end, 0)]):
        if until > end:
            break
        stretch = coarse.advance_to(until, "wave train, run 2 of 2", end)
        if granules:
            coarse.shorten(granules)
        elif until == compared:
            difference = sum(find_rebounding(then, slowest)[0]) - sum(find_rebounding(stretch.v[-1], slowest)[0])
    return difference


def _warn_incomplete(
    fine: ChainRun, waves: tuple[MeasuredWave, ...], threshold: float, scales: Scales
) -> Iterator[str]:
    """Warnings of waves that may be missing, and of forces after the end of the run."""
    settled = fine.settled and all(wave.error_estimate is not None for wave in waves)
    if not (fine.reached_end or settled):
        yield (
            "The granules behind the last wave were still moving when it was measured, so waves near the threshold may"
            " be missing or inaccurate. A higher wave_threshold excludes them."
        )
    if fine.unfollowed_force > threshold * fine.log.top().force:
        bound = si(fine.unfollowed_force * scales.contact_force, "N")
        yield f"Granules may collide after the end of the run, with forces below {bound}."
    if fine.unread:
        yield f"Waves that could not be measured and are left out: {fine.unread}."


def _greatest(fine: ChainRun, coarse: PeakLog, scales: Scales) -> ContactPeak | None:
    """Greatest contact force of the fine run, in SI units, with an error estimate like that of a wave.

    It is None on an endless chain if it hardly exceeds the leading wave, whose limit may be farther on.
    """
    top = fine.log.top()
    if fine.problem.granules is None and top.force <= _EXCESS * max(wave.peak_force for wave in fine.waves):
        return None
    error = abs(coarse.top().force / top.force - 1) + _energy_error(fine) + fine.integrator.tolerance
    return ContactPeak(
        contact=top.contact,
        peak_force=top.force * scales.contact_force,
        time=top.time * scales.time,
        error_estimate=error,
    )


def _energy_error(fine: ChainRun) -> float:
    """Relative error of a peak force, which scales as a power of the energy, from the energy defect."""
    # the defect shows errors of both runs, as at a contact that opens
    exponent = fine.problem.exponent
    return exponent / (exponent + 1) * abs(fine.energy / fine.work - 1) if fine.work else 0.0


def _waves(fine: ChainRun, traced: list[Peak], coarse: PeakLog, scales: Scales) -> tuple[MeasuredWave, ...]:
    """Waves of the fine run, strongest first, in SI units.

    The error estimate of each is the sum of the difference of the two runs at an earlier peak of the wave, ``traced``,
    in proportion to the time, its own bound, the energy defect, and the tolerance of a step.
    """
    waves = []
    strongest = max(wave.peak_force for wave in fine.waves)
    for wave, peak in zip(fine.waves, traced, strict=True):
        same = coarse.nearest(peak.contact, peak.time)
        difference = 1.0 if same is None else abs(same.force / peak.force - 1) * wave.arrival_time / peak.time
        # errors of a step are larger relative to weak waves; the difference may vanish by chance
        step = fine.integrator.tolerance * math.sqrt(strongest / wave.peak_force)
        error = difference + (wave.error_estimate or 0.0) + _energy_error(fine) + step + _ROUNDING
        waves.append(wave.in_si(scales, error if error < _UNSETTLED else None))
    return tuple(sorted(waves, key=lambda wave: -wave.peak_force))
