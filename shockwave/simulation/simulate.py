"""Direct simulation, from shocks and a chain to results with error estimates."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from threading import Event
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from attrs import frozen

from shockwave.base.errors import NumericalError, ShockwaveError, detach, refuse
from shockwave.base.progress import report_progress
from shockwave.base.text import function_at
from shockwave.engine.scaled_problem import ScaledProblem
from shockwave.engine.time_limit import expired, time_limit
from shockwave.profiles.power_law import Powers
from shockwave.scene.chain import Chain, Scales
from shockwave.scene.plausibility import unusual_warnings
from shockwave.scene.scene import Excitation, Scene, scenes_of
from shockwave.scene.shock import Shock
from shockwave.scene.simulate_options import SimulateOptions, options_of
from shockwave.scene.yielding import beyond_elastic, warn_other_law
from shockwave.simulation.leading_wave import LONGEST_MEASURED, Answer, search
from shockwave.simulation.recording import check_requests
from shockwave.simulation.result_parts import Cost, LeadingWave
from shockwave.simulation.simulation_result import Simulation
from shockwave.simulation.wave_setup import UNSETTLED, Setup, immeasurable, scale_scene, setup_of, warn_step

if TYPE_CHECKING:
    from concurrent.futures import Executor
    from typing import Unpack

    from shockwave.arguments import SimulateArguments
    from shockwave.base.quantity_fields import Number
    from shockwave.simulation.contact_setup import ChainSetup

# Largest number of shocks that one of several threads takes at a time: more would leave threads idle at the end.
_SHARE = 128
# The same for a single thread, unless some are records, whose tables would need much memory.
_SHARE_ALONE = 512
# Least number of shocks for a thread.
_FEWEST = 16
_Outcome: TypeAlias = Simulation | ShockwaveError


def simulate(shock: Excitation, chain: Chain, rtol: float | None = None, **options: Any) -> Simulation:
    """Simulate a shock or a striker on a chain with ``rtol`` and other `SimulateOptions`; see `simulate_scene`."""
    return simulate_scene(Scene(excitation=shock, chain=chain), SimulateOptions(rtol=rtol, **options))


def simulate_scene(scene: Scene, options: SimulateOptions) -> Simulation:
    """Simulate a scene.

    Returns
    -------
    Simulation
        Result in SI units.

    Raises
    ------
    InvalidValueError, UnknownNameError
        If a setting is out of range or not used by the method, or a name is unknown.
    NumericalError
        If the integrator fails, no wave forms, the shock is too long, or the time limit is reached. Warnings
        of unusual values, a possible cause, are notes of this error.
    """
    (result,) = run_jobs([job_of(options, scene)], options)
    if isinstance(result, NumericalError):
        for warning in unusual_warnings(scene.excitation, scene.line):
            result.add_note(warning)
    if isinstance(result, ShockwaveError):
        raise result
    return result


def simulate_many(
    shocks: Iterable[Excitation],
    chain: Chain | Sequence[Chain],
    rtol: Number | None = None,
    *,
    threads: int | None = None,
    **options: Unpack[SimulateArguments],
) -> list[Simulation | ShockwaveError]:
    """Simulate many shocks in parallel: eight at a time on each core, on all cores.

    Parameters
    ----------
    shocks : iterable of Shock or Impact
        The shocks or strikers.
    chain : Chain or sequence of Chain
        One chain for all shocks, or one for each shock.
    rtol : float, optional
        Relative error of the peak force, 1e-13 to 1e-2. Default: 1e-6.
    threads : int, optional
        Number of threads that run the compiled code. By default one for each core.
    **options
        Other options of `shockwave.simulate`; ``timeout`` is the maximum computing time of one scene [s].

    Returns
    -------
    list of Simulation or ShockwaveError
        Results in the order of the shocks; the error for a shock whose simulation failed.

    Raises
    ------
    InvalidValueError, UnknownNameError
        If a setting is out of range, the number of chains differs from that of the shocks, or a name is unknown.

    Examples
    --------
    >>> import shockwave as sw
    >>> chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
    >>> profile = sw.Triangular(duration_ratio=3)
    >>> shocks = [
    ...     sw.Shock(profile=profile, peak_force=force, rise_time=2e-5)
    ...     for force in (10, 20)
    ... ]
    >>> [f"{result.peak_force:.3f} N" for result in sw.simulate_many(shocks, chain)]
    ['8.671 N', '19.110 N']
    """
    all_options = options_of({"rtol": rtol, **options}, "threads")
    setup_of(all_options)
    return simulate_scenes(scenes_of(shocks, chain, "simulate", threads), all_options, threads)


def simulate_scenes(
    scenes: Iterable[Scene | ShockwaveError], options: SimulateOptions, threads: int | None = None
) -> list[_Outcome]:
    """Simulate many scenes in parallel; see `simulate_many`. Errors among the scenes are passed on."""
    jobs: list[Job | ShockwaveError] = []
    for scene in scenes:
        try:
            jobs.append(job_of(options, scene) if isinstance(scene, Scene) else scene)
        except ShockwaveError as error:
            jobs.append(detach(error))
    return run_jobs(jobs, options, threads)


# ---------------------------------------------------------------- jobs


class Job(NamedTuple):
    """A valid scene that is ready to run.

    Attributes
    ----------
    scene : Scene
        Shock or impact, and chain.
    problem, scales : ScaledProblem, Scales or None
        The scaled problem of a shock on equal granules.
    case : ChainSetup or None
        The setup of another finite chain.
    refusal : NumericalError or None
        Reason why the scene cannot be simulated.
    """

    scene: Scene
    problem: ScaledProblem | None = None
    scales: Scales | None = None
    case: ChainSetup | None = None
    refusal: NumericalError | None = None


def job_of(options: SimulateOptions, scene: Scene) -> Job:
    """Check a scene and options, and scale the problem; nothing is integrated.

    Raises
    ------
    InvalidValueError, UnknownNameError
        If a value is out of range, or the integrator cannot step the chain.
    PluginError
        If the profile violates its contract.
    """
    if options.sensors:
        from shockwave.scene.sensors import sensor_faults  # most simulations have none

        refuse(sensor_faults(options.sensors, scene.chain, scene.impact is not None))
    if scene.shock is None or scene.uniform is None:
        from shockwave.simulation.contact_setup import check_setup  # a shock on equal granules does not need it

        return Job(scene, case=check_setup(options, scene))
    try:
        problem, scales = scale_scene(scene)
    except NumericalError as error:
        return Job(scene, refusal=detach(error))
    check_requests(options, scene.shock, scene.uniform, scales)
    if not isinstance(problem.profile, Powers):  # those of power laws are computed together
        _ = problem.path
    return Job(scene, problem, scales)


def run_jobs(
    jobs: Sequence[Job | ShockwaveError],
    options: SimulateOptions,
    threads: int | None = None,
    patience: float | None = None,
) -> list[_Outcome]:
    """Run jobs with the ``options`` that they were made with; errors among them are passed on.

    ``patience`` is the maximum computing time of a scene by compiled code [s] if the options have no ``timeout``.
    """
    setup = setup_of(options)
    if threads is None:
        threads = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    threads = 1 if len(jobs) < 2 * _FEWEST or setup.compiled is None else threads
    small = threads == 1 and not any(isinstance(job, Job) and _is_record(job.scene.shock) for job in jobs)
    size = max(_FEWEST, min(_SHARE_ALONE if small else _SHARE, -(-len(jobs) // threads)))
    if setup.compiled is None:
        size = 1
    interrupted = Event()
    limit = options.timeout or (None if setup.compiled is None else patience)
    allowed = partial(time_limit, interrupted=interrupted)
    results: list[_Outcome] = []
    many = len(jobs) > 1
    if many:
        report_progress("simulations", 0, len(jobs))
    # A thread does all the work for its share: while it runs the compiled code, which releases the global interpreter
    # lock, another thread prepares its problems.
    with _pool(threads) as pool:
        try:
            shares = [jobs[begin : begin + size] for begin in range(0, len(jobs), size)]
            for share in (pool.map if pool else map)(lambda share: _run(share, setup, limit, allowed), shares):
                results += share
                if many:
                    report_progress("simulations", len(results), len(jobs))
        finally:  # after Ctrl-C the other threads stop as well
            interrupted.set()
    return results


def _is_record(shock: Shock | None) -> bool:
    return shock is not None and shock.profile.recorded_peak_force is not None


def _pool(threads: int) -> AbstractContextManager[Executor | None]:
    if threads == 1:
        return nullcontext()
    from concurrent.futures import ThreadPoolExecutor  # a single simulation does not need it

    return ThreadPoolExecutor(threads)


def _run(
    jobs: Sequence[Job | ShockwaveError],
    setup: Setup,
    limit: float | None,
    allowed: Callable[[float | None], AbstractContextManager[None]],
) -> list[_Outcome]:
    """Run a share of the jobs; ``limit`` is the time limit of each [s], which ``allowed`` sets."""
    begin = time.perf_counter()
    problems = {index: job.problem for index, job in enumerate(jobs) if isinstance(job, Job) and job.problem}
    with allowed(limit):
        answers = search(problems, setup)
    spent = time.perf_counter() - begin
    alone = len(jobs) == 1
    late = limit is not None and spent > limit and not alone  # together, not each of them
    results: list[_Outcome] = []
    for index, job in enumerate(jobs):
        if isinstance(job, ShockwaveError):
            results.append(job)
            continue
        begin, answer = time.perf_counter() - spent / len(jobs), answers.get(index)
        try:
            with allowed(limit if limit is None or not alone else max(limit - spent, 0.0)):
                if late and index in problems and (answer is None or answer.error_estimate > setup.rtol):
                    answer = search({0: problems[index]}, setup).get(0)
                results.append(_result(job, setup, answer, begin, limit))
        except ShockwaveError as error:
            results.append(detach(error))
    return results


def _result(job: Job, setup: Setup, answer: Answer | None, begin: float, limit: float | None) -> Simulation:
    """Result of a job that began at this time, from the ``answer`` of the search, if it has found one."""
    if job.refusal is not None:
        raise job.refusal
    computation = Computation(limit)
    if job.problem is None or job.scales is None:
        from shockwave.simulation.contact_forces import simulate_chain  # equal granules do not need it

        return simulate_chain(setup.given, job.scene, computation, job.case)
    answer = answer or _measure(job.problem, job.scales, setup)
    wave, scales = answer.primary, job.scales
    spent = time.perf_counter() - begin
    result = Simulation(
        scene=job.scene,
        options=setup.options,
        integrator=str(setup.options.integrator),
        backend=setup.options.backend,
        wave=LeadingWave(scaled=wave, scales=scales, error_estimate=answer.error_estimate),
        applied_momentum=wave.impulse * scales.momentum,
        momentum_defect=wave.momentum_defect,
        energy_defect=wave.energy_defect,
        characteristic_time=scales.time,
        run_cost=Cost(steps=int(wave.steps), force_evaluations=int(wave.evaluations), seconds=spent),
        run_warnings=(*answer.warnings, *_warn_missed(setup.options, answer), *warn_other_law(job.scene.chain)),
        computation=computation,
        measured=answer.train,
    )
    if error := beyond_elastic(job.scene.chain, partial(getattr, result, "yielding")):
        raise error
    return result


def _warn_missed(options: SimulateOptions, answer: Answer) -> tuple[str, ...]:
    """Warning if the peak force of the leading wave does not meet the tolerance, or the step is too large."""
    error = answer.error_estimate
    if error <= (UNSETTLED if options.rtol is None else options.rtol):
        return ()
    if options.rtol is None:
        return (warn_step(options),)
    reached = f"the relative error of the peak force is estimated as {error:.1e}, not {options.rtol:.1e}"
    advice = "A smaller rtol may reduce it."
    if answer.train is None:
        advice = "Smaller steps did not reduce it further."
        if answer.primary.doubt > error / 2:
            advice = (
                "A wave behind it may still exceed it, and following both takes too long for any rtol: shorten the"
                " shock."
            )
    return (f"The tolerance was not met: {reached}. {advice}",)


def _measure(problem: ScaledProblem, scales: Scales, setup: Setup) -> Answer:
    """The leading wave that the search has not found, measured on the whole chain."""
    from shockwave.simulation.wave_train import measure_primary

    if expired():
        raise NumericalError("the time limit was reached before the leading wave was known (increase timeout or rtol)")
    if setup.search is not None and problem.granules is None and problem.duration > LONGEST_MEASURED:
        lasts = f"the shock lasts {problem.duration:.3g} characteristic times of its wave"
        raise NumericalError(f"the leading wave could not be found: {lasts} (shorten it)")
    if problem.granules is not None and setup.options.timeout is None and (reason := immeasurable(problem)):
        raise NumericalError(f"the waves reach the free end before they have settled, and {reason}")
    return Answer(*measure_primary(problem, scales, setup))


# ---------------------------------------------------------------- parts that are computed later

# Functions of a result that compute its parts, by their names.
_PARTS = {
    "train": "shockwave.simulation.wave_train:train_of",
    "passages": "shockwave.simulation.wave_passages:passages_at",
    "forces": "shockwave.simulation.contact_forces:forces_of",
    "recording": "shockwave.simulation.chain_histories:record_chain",
    "value_with_yield": "shockwave.simulation.yield_advice:value_with_yield",
    "first_pulses": "shockwave.simulation.first_pulse_search:first_pulses",
}


@frozen
class Computation:
    """Computes the parts of results that are rarely needed, by modules that are imported then.

    ``limit`` is the time limit of the whole scene [s].
    """

    limit: float | None

    def __call__(self, part: str, result: Any, *arguments: Any) -> Any:
        """A part of a `Simulation` by its function."""
        with time_limit(None if self.limit is None else self.limit - result.run_cost.seconds):
            return function_at(_PARTS[part])(result, *arguments)
