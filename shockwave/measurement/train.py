"""The whole train, and whatever the search for the primary does not cover: measured on two runs of the chain."""

from __future__ import annotations

import time
from collections.abc import Callable

from attrs import evolve

from shockwave.chain.chain import Chain, Scales
from shockwave.errors import NumericalError
from shockwave.measurement.result import Cost, MeasuredWave, SimulationResult, Train
from shockwave.measurement.run import EJECTED, Demand, Run, run
from shockwave.measurement.simulate import MEASURABLE, Plan, plan_of, scaled
from shockwave.profiles.shock import Shock
from shockwave.simulation.integrator import Integrator
from shockwave.simulation.nystroem import Nystroem
from shockwave.simulation.primary_request import KNOWN, Primary
from shockwave.simulation.problem import ChainProblem
from shockwave.text import si

__all__ = ["measured", "methods_of", "train_of"]

# Tolerance of a step in the two runs, over the relative error asked of the primary: ours, and that of other methods,
# whose step errors add up to more.
_FINE, _OTHERS = 0.1, 3e-4
_COARSE = 10.0
# Below this tolerance step control gains nothing: rounding is all that is left.
_LEAST_TOLERANCE = 1e-13
# Shares of the tolerance that the approach to the limit may use up.
_PRIMARY_DOUBT = 0.2
_LATER_DOUBT = 2.0
# However loose the tolerance, a wave that has not settled to this is not yet itself; nor is it worth more than this.
_MOST_DOUBT, _LEAST_DOUBT = 3e-4, 1e-10
_ROUNDING = 1e-12
# An error estimate above this is none.
_UNSETTLED = 0.1
# The longest chain: so many contacts, and so many for each unit of time that the force lasts.
_MOST_CONTACTS = 1000
_MOST_RATE = 10
# Share of the recoil that may be held by granules that still meet, before it is told.
_UNFINISHED = 0.01
# What stands for the relative error of a method of fixed step, which is asked for none.
_FIXED_RTOL = 1e-5


def train_of(result: SimulationResult) -> Train:
    """All waves of a result whose primary is known."""
    plan = plan_of(result.options)
    problem = scaled(result.shock, result.chain)[0]
    if problem.duration > MEASURABLE:
        return _too_long(result, problem)
    train, _, _ = _train(problem, result.scales, plan)
    strongest, *others = train.waves
    apart = abs(strongest.peak_force / result.peak_force - 1)
    warnings = train.warnings
    if apart > 10 * (result.error_estimate + (strongest.error_estimate or _UNSETTLED)):
        warning = f"the strongest wave of the train is {apart:.0e} off the primary as it was found alone: trust neither"
        return evolve(train, warnings=(*warnings, f"{warning} further than that"))
    # The search for the primary knows it better than the runs for all waves do.
    primary = evolve(strongest, peak_force=result.peak_force, error_estimate=result.error_estimate)
    return evolve(train, waves=(primary, *others), warnings=warnings)


def _too_long(result: SimulationResult, problem: ChainProblem) -> Train:
    """The primary alone, of a shock whose train nobody would wait for."""
    return Train(
        waves=(result.primary,),
        recoil_momentum=0.0,
        recoil_error=result.applied_momentum,
        recoil_velocities=(),
        spall_velocities=None,
        cost=Cost(steps=0, force_evaluations=0, seconds=0.0),
        warnings=(
            f"the shock lasts {problem.duration:.3g} natural times of its wave: beyond {MEASURABLE:g} the train is not"
            " integrated, and neither later waves nor the recoil are known",
        ),
    )


def measured(shock: Shock, chain: Chain, problem: ChainProblem, scales: Scales, plan: Plan) -> SimulationResult:
    """The result where the search for the primary does not help: other methods, chains too short for a limit."""
    begin = time.perf_counter()
    train, fine, notes = _train(problem, scales, plan)
    primary = train.waves[0]
    strongest = max(fine.waves, key=lambda wave: wave.peak_force)
    books = fine.books
    found = Primary(
        status=KNOWN,
        peak=strongest.peak_force,
        last=strongest.peak_force,
        contact=strongest.contact,
        time=strongest.time,
        doubt=0.0,
        speed=strongest.speed or 0.0,
        momentum=strongest.momentum,
        energy=strongest.energy,
        foot=strongest.foot * strongest.peak_force,
        chain_momentum=books.momentum,
        chain_energy=books.energy,
        work=books.held,
        impulse=books.impulse,
        free_path=0.0,
        steps=train.cost.steps,
        evaluations=train.cost.force_evaluations,
    )
    error_estimate = 1.0 if primary.error_estimate is None else primary.error_estimate
    warnings = [*shock.profile.notes, *notes, *plan.missed(error_estimate)]
    if plan.options.rtol is None and error_estimate > _UNSETTLED:
        got = f"got {plan.options.step:g}; give a smaller one"
        warnings.append(f"the step is too coarse for {plan.options.integrator} ({got})")
    return SimulationResult(
        shock=shock,
        chain=chain,
        options=plan.options,
        scales=scales,
        found=found,
        error_estimate=error_estimate,
        notes=tuple(warnings),
        seconds=time.perf_counter() - begin,
        measured=train,
    )


def _train(problem: ChainProblem, scales: Scales, plan: Plan) -> tuple[Train, Run, list[str]]:
    """The train from a fine and a coarse run; the fine run; and what there is to say about the primary."""
    begin = time.perf_counter()
    rtol = plan.options.rtol or _FIXED_RTOL
    most = int(_MOST_CONTACTS + _MOST_RATE * problem.duration)
    primary, later = (max(min(share * rtol, _MOST_DOUBT), _LEAST_DOUBT) for share in (_PRIMARY_DOUBT, _LATER_DOUBT))
    demand = Demand(plan.options.wave_threshold, primary, later, most)
    make = methods_of(plan)
    fine, coarse = (run(problem, make(factor), demand) for factor in (1.0, _COARSE))
    if not fine.waves or not coarse.waves:
        raise NumericalError(
            f"no wave was found within {most} contacts: the shock is too slow for its peak force"
            " (shorten it, or raise the peak force)"
        )
    waves = _waves(fine, coarse, scales)
    fastest = waves[0].granule_velocity
    recoils, coarse_recoil = fine.recoils, sum(coarse.recoils)
    train = Train(
        waves=waves,
        recoil_momentum=sum(recoils) * scales.momentum,
        recoil_error=(abs(sum(recoils) - coarse_recoil) + fine.unfinished_recoil) * scales.momentum,
        recoil_velocities=tuple(u * scales.velocity for u in recoils if -u * scales.velocity > EJECTED * fastest),
        spall_velocities=None if fine.spalls is None else tuple(u * scales.velocity for u in fine.spalls),
        cost=Cost(
            steps=fine.steps + coarse.steps,
            force_evaluations=fine.evaluations + coarse.evaluations,
            seconds=time.perf_counter() - begin,
        ),
        warnings=(*_warnings(fine, waves), *_about_recoil(fine)),
    )
    return train, fine, _about_the_end(fine, waves, scales)


def methods_of(plan: Plan) -> Callable[[float], Integrator]:
    """What makes the method, its steps ``factor`` times as loose."""
    method = plan.method
    if not method.adaptive:
        size = plan.options.step or 0.0
        # a step twice as long tells more than ten times would: the method may not be stable there
        return lambda factor: method(size=size if factor == 1.0 else 2 * size)
    share = _FINE if plan.search is not None else _OTHERS
    tolerance = share * (plan.options.rtol or _FIXED_RTOL)

    def make(factor: float) -> Integrator:
        allowed = max(tolerance, _LEAST_TOLERANCE) * factor
        if issubclass(method, Nystroem):
            return method(tolerance=allowed, compiled=plan.compiled)
        return method(tolerance=allowed)

    return make


def _waves(fine: Run, coarse: Run, scales: Scales) -> tuple[MeasuredWave, ...]:
    """Strongest first; the error of each: difference of the two runs, its own doubt, and the energy gone astray."""
    # Peak force goes with the 3/5 power of energy. The defect sees what both runs may miss: a contact that opens.
    astray = 0.6 * abs(fine.books.energy / fine.books.held - 1) if fine.books.held else 0.0
    waves = []
    for wave, doubt in zip(fine.waves, fine.doubts, strict=True):
        difference = min(abs(other.peak_force / wave.peak_force - 1) for other in coarse.waves)
        error = difference + doubt + astray + _ROUNDING
        waves.append(
            MeasuredWave(
                peak_force=wave.peak_force * scales.force,
                momentum=wave.momentum * scales.momentum,
                energy=wave.energy * scales.energy,
                speed=None if wave.speed is None else wave.speed * scales.wave_speed,
                width=wave.width * scales.time,
                granule_velocity=wave.granule_velocity * scales.velocity,
                contact=wave.contact,
                arrival_time=wave.time * scales.time,
                error_estimate=error if error < _UNSETTLED else None,
                foot=wave.foot,
            )
        )
    return tuple(sorted(waves, key=lambda wave: -wave.peak_force))


def _about_the_end(fine: Run, waves: tuple[MeasuredWave, ...], scales: Scales) -> list[str]:
    if not fine.reached_end:
        return []
    top = fine.strongest
    return [
        "the waves reach the free end before they are known to be steady: they are read at contact"
        f" {waves[0].contact} of this chain; its greatest contact force is"
        f" {si(top.force * scales.force, 'N')}, at contact {top.contact}"
    ]


def _about_recoil(fine: Run) -> list[str]:
    if fine.unfinished_recoil <= _UNFINISHED * abs(sum(fine.recoils)):
        return []
    return [
        "granules thrown back had not all come apart when the last wave was read: the velocities of the later ones"
        " may still change"
    ]


def _warnings(fine: Run, waves: tuple[MeasuredWave, ...]) -> list[str]:
    if fine.reached_end or (fine.settled and all(wave.error_estimate is not None for wave in waves)):
        return []
    return [
        "the tail had not come to rest when the last wave was read: waves near the threshold may lack or change"
        " (a higher wave_threshold leaves them out)"
    ]
