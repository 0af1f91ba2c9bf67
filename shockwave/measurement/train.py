"""The whole train, and the primaries that the search does not cover: measured on two runs of the chain."""

from __future__ import annotations

import time

from attrs import evolve

from shockwave.chain.chain import Scales
from shockwave.errors import NumericalError
from shockwave.measurement.chain_run import EJECTED, ChainRun
from shockwave.measurement.result import Cost, MeasuredWave, SimulationResult, Train
from shockwave.measurement.simulation_setup import Setup, immeasurable, scaled, setup_of
from shockwave.simulation.problem import ChainProblem, Primary, Status
from shockwave.text import si

# The second run is so many times as loose.
_COARSE = 10.0
# Shares of the tolerance that the approach to the limit may use up.
_PRIMARY_DOUBT = 0.2
_LATER_DOUBT = 2.0
# However loose the tolerance, a wave that has not settled to this is not yet itself; nor is it worth more than this.
_MOST_DOUBT = 3e-4
_LEAST_DOUBT = 1e-10
_ROUNDING = 1e-12
# An error estimate above this is none.
_UNSETTLED = 0.1
# The longest chain: so many contacts, and so many for each unit of time that the force lasts.
_MOST_CONTACTS = 1000
_MOST_RATE = 10


def train_of(result: SimulationResult) -> Train:
    """All waves of a result whose primary is known."""
    problem, scales = scaled(result.shock, result.chain)
    if result.options.timeout is None and (reason := immeasurable(problem)):
        return _primary_alone(result, f"{reason}: the train is not integrated (a timeout tries it all the same)")
    try:
        train, _ = _train(problem, scales, setup_of(result.options))
    except NumericalError as error:
        return _primary_alone(result, f"the train could not be measured: {error}")
    strongest, *others = train.waves
    apart = abs(strongest.peak_force / result.peak_force - 1)
    if apart > 10 * (result.error_estimate + (strongest.error_estimate or _UNSETTLED)):
        warning = f"the strongest wave of the train differs by {apart:.0e} from the primary: trust neither further"
        return evolve(train, warnings=(*train.warnings, warning))
    # The search for the primary knows it better than the runs for all waves do.
    primary = evolve(strongest, peak_force=result.peak_force, error_estimate=result.error_estimate)
    return evolve(train, waves=(primary, *others))


def _primary_alone(result: SimulationResult, reason: str) -> Train:
    """The primary alone, where the train is not known."""
    return Train(
        waves=(result.primary,),
        recoil_error=result.applied_momentum,
        warnings=(f"{reason}; neither later waves nor the recoil are known",),
    )


def measure_primary(
    problem: ChainProblem, scales: Scales, setup: Setup
) -> tuple[Primary, float, Train, tuple[str, ...]]:
    """The primary that the search does not find, its error estimate, the train and warnings."""
    train, fine = _train(problem, scales, setup)
    strongest = max(fine.waves, key=lambda wave: wave.peak_force)
    primary = Primary(
        status=Status.KNOWN,
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
        top = fine.log.top()
        warnings = (
            "the waves reach the free end before they are known to be steady: they are read at contact"
            f" {strongest.contact} of this chain; its greatest contact force is"
            f" {si(top.force * scales.force, 'N')}, at contact {top.contact}",
        )
    error = train.waves[0].error_estimate
    return primary, 1.0 if error is None else error, train, warnings


def _train(problem: ChainProblem, scales: Scales, setup: Setup) -> tuple[Train, ChainRun]:
    """The train from a fine and a coarse run, and the fine run."""
    begin = time.perf_counter()
    most = int(_MOST_CONTACTS + _MOST_RATE * problem.duration)
    first, later = (max(min(share * setup.rtol, _MOST_DOUBT), _LEAST_DOUBT) for share in (_PRIMARY_DOUBT, _LATER_DOUBT))
    fine, coarse = (
        ChainRun(problem, setup.integrator(factor), setup.options.wave_threshold, first, later, most).finished()
        for factor in (1.0, _COARSE)
    )
    if not fine.waves or not coarse.waves:
        raise NumericalError(
            f"no wave was found within {most} contacts: the shock is too slow for its peak force"
            " (shorten it, or raise the peak force)"
        )
    waves = _waves(fine, coarse, scales)
    ejected = EJECTED * waves[0].granule_velocity
    recoil = sum(fine.recoils)
    error = abs(recoil - sum(coarse.recoils)) + fine.unfinished_recoil
    velocities = [velocity * scales.velocity for velocity in fine.recoils]
    warnings: tuple[str, ...] = ()
    settled = fine.settled and all(wave.error_estimate is not None for wave in waves)
    if not (fine.reached_end or settled):
        warnings = (
            "the tail had not come to rest when the last wave was read: waves near the threshold may lack or change"
            " (a higher wave_threshold leaves them out)",
        )
    train = Train(
        waves=waves,
        recoil_momentum=recoil * scales.momentum,
        recoil_error=error * scales.momentum,
        recoil_velocities=tuple(velocity for velocity in velocities if -velocity > ejected),
        spall_velocities=None if fine.spalls is None else tuple(u * scales.velocity for u in fine.spalls),
        cost=Cost(
            steps=fine.steps + coarse.steps,
            force_evaluations=fine.integrator.evaluations + coarse.integrator.evaluations,
            seconds=time.perf_counter() - begin,
        ),
        warnings=warnings,
    )
    return train, fine


def _waves(fine: ChainRun, coarse: ChainRun, scales: Scales) -> tuple[MeasuredWave, ...]:
    """Strongest first; the error of each: difference of the two runs, its own bound, and the energy gone astray."""
    # Peak force scales as the 3/5 power of energy. The defect sees what both runs may miss: a contact that opens.
    astray = 0.6 * abs(fine.energy / fine.work - 1) if fine.work else 0.0
    waves = []
    for wave in fine.waves:
        difference = min(abs(other.peak_force / wave.peak_force - 1) for other in coarse.waves)
        error = difference + (wave.error_estimate or 0.0) + astray + _ROUNDING
        waves.append(wave.in_si(scales, error if error < _UNSETTLED else None))
    return tuple(sorted(waves, key=lambda wave: -wave.peak_force))
