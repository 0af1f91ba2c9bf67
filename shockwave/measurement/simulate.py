"""Direct simulation, from shocks and a chain to results with error estimates."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from threading import Event
from typing import TYPE_CHECKING, Any, TypeAlias, cast

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.yielding import beyond_elastic
from shockwave.errors import InvalidValueError, NumericalError, ShockwaveError
from shockwave.measurement.leading_wave import LONGEST_MEASURED, Answer, search
from shockwave.measurement.recording import check_requests
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulation_setup import Setup, immeasurable, scaled, setup_of
from shockwave.options import Backend, SimulateOptions, Waves
from shockwave.plausibility import unusual_warnings
from shockwave.profiles.power_law import Powers
from shockwave.profiles.shock import Shock
from shockwave.progress import progressed
from shockwave.scene_summary import check_scene, scenes_of
from shockwave.simulation.problem import ChainProblem, prepare
from shockwave.simulation.time_limit import expired, time_limit

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from shockwave.chain.impact import Impact

__all__ = ["equal_granules", "immeasurable", "scaled", "setup_of", "simulate", "simulate_many", "simulate_with"]

# Largest number of shocks that one of several threads takes at a time: more would leave threads idle at the end.
_SHARE = 128
# The same for a single thread, unless some are records, whose tables would need much memory.
_SHARE_ALONE = 512
# Least number of shocks for a thread.
_FEWEST = 16
# Largest relative error estimate that is meaningful.
_UNSETTLED = 0.1
# A `ChainResult` for a chain beyond equal spheres; typed so that other callers need not distinguish the two.
_Result: TypeAlias = SimulationResult | Any
_Outcome: TypeAlias = _Result | ShockwaveError


def simulate(shock: Shock | Impact, chain: Chain, rtol: float | None = None, **options: Any) -> _Result:
    """Simulate with ``rtol`` and other `SimulateOptions`; see `simulate_with`."""
    return simulate_with(SimulateOptions(rtol=rtol, **options), shock, chain)


def simulate_with(options: SimulateOptions, shock: Shock | Impact, chain: Chain) -> _Result:
    """Simulate with the options in one object, such as that of a scenario.

    Returns
    -------
    SimulationResult or ChainResult
        Result in SI units; a `ChainResult` for a chain with features beyond equal spheres and free ends.

    Raises
    ------
    InvalidValueError, UnknownNameError
        If a setting is out of range or not used by the method, or a name is unknown.
    NumericalError
        If the integrator fails, no wave forms, the shock is too long, or the time limit is reached. Warnings
        of unusual values, a possible cause, are notes of this error.
    """
    (result,) = _simulate([(shock, chain)], setup_of(options))
    if isinstance(result, NumericalError):
        for warning in unusual_warnings(shock, chain):
            result.add_note(warning)
    if isinstance(result, ShockwaveError):
        raise result
    return result


def simulate_many(
    shocks: Iterable[Shock | Impact],
    chain: Chain | Sequence[Chain],
    rtol: float | None = None,
    integrator: str | None = None,
    wave_threshold: float = 5e-3,
    *,
    step: float | None = None,
    waves: Waves = "train",
    backend: Backend = "auto",
    contacts: Iterable[int] = (),
    until: float | None = None,
    threads: int | None = None,
) -> list[_Outcome]:
    """Simulate many shocks in parallel: eight at a time on each core, on all cores.

    Parameters
    ----------
    shocks : iterable of Shock or Impact
        The shocks or strikers.
    chain : Chain or sequence of Chain
        One chain for all shocks, or one for each shock.
    rtol, integrator, wave_threshold, step, waves, backend, contacts, until
        As in `SimulateOptions`.
    threads : int, optional
        Number of threads that run the compiled code. By default one for each core.

    Returns
    -------
    list of SimulationResult, ChainResult or ShockwaveError
        Results in the order of the shocks; the error for a shock whose simulation failed.

    Raises
    ------
    InvalidValueError, UnknownNameError
        If a setting is out of range, the number of chains differs from that of the shocks, or a name is unknown.
    """
    options = SimulateOptions(
        integrator=integrator,
        rtol=rtol,
        step=step,
        wave_threshold=wave_threshold,
        waves=waves,
        backend=backend,
        contacts=contacts,
        until=until,
    )
    setup = setup_of(options)
    scenes: Sequence[tuple[Shock | Impact, Chain]] = scenes_of(shocks, chain, "simulate")
    if threads is not None and threads < 1:
        raise InvalidValueError.of("threads", f"must be a whole number >= 1 (got {threads!r})")
    if threads is None:
        threads = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    threads = 1 if len(scenes) < 2 * _FEWEST else threads
    small = threads == 1 and not any(_is_record(shock) for shock, _ in scenes)
    size = max(_FEWEST, min(_SHARE_ALONE if small else _SHARE, -(-len(scenes) // threads)))
    if setup.compiled is None:
        threads = size = 1
    shares = [scenes[begin : begin + size] for begin in range(0, len(scenes), size)]
    results: list[_Outcome] = []
    interrupted = Event()
    progressed("simulations", 0, len(scenes))
    # A thread does all the work for its share: while it runs the compiled code, which releases the global interpreter
    # lock, another thread prepares its problems.
    with _pool(threads) as pool:
        try:
            for share in (pool.map if pool else map)(lambda share: _simulate(share, setup, interrupted), shares):
                results += share
                progressed("simulations", len(results), len(scenes))
        finally:  # after Ctrl-C the other threads stop as well
            interrupted.set()
    return results


def _is_record(shock: object) -> bool:
    return isinstance(shock, Shock) and shock.profile.recorded_peak_force is not None


def _pool(threads: int) -> AbstractContextManager[Executor | None]:
    if threads == 1:
        return nullcontext()
    from concurrent.futures import ThreadPoolExecutor  # a single simulation does not need it

    return ThreadPoolExecutor(threads)


def _simulate(
    scenes: Sequence[tuple[Shock | Impact, Chain]], setup: Setup, interrupted: Event | None = None
) -> list[_Outcome]:
    with time_limit(setup.options.timeout, interrupted):
        return _simulate_all(scenes, setup)


def _simulate_all(scenes: Sequence[tuple[Shock | Impact, Chain]], setup: Setup) -> list[_Outcome]:
    begin = time.perf_counter()
    results: dict[int, _Outcome] = {}
    known: dict[int, tuple[ChainProblem, Scales]] = {}
    scenes = list(scenes)
    for index, (shock, chain) in enumerate(scenes):
        try:
            equal = equal_granules(shock, chain)
            if equal is None:
                continue
            scenes[index] = shock, equal
            problem, scales = scaled(cast(Shock, shock), equal)
            check_requests(setup.options, equal, scales)
            if not isinstance(problem.profile, Powers):  # those of power laws are computed together
                _ = problem.path  # an error of the profile is that of its own shock only
            known[index] = problem, scales
        except ShockwaveError as error:
            results[index] = error
    if len(known) > 1:
        prepare([problem for problem, _ in known.values()])
    answers = search({index: problem for index, (problem, _) in known.items()}, setup)
    seconds = (time.perf_counter() - begin) / max(len(scenes), 1)
    for index, (problem, scales) in known.items():
        shock, chain = cast("tuple[Shock, Chain]", scenes[index])
        answer, own = answers.get(index), seconds
        if answer is None:
            begin = time.perf_counter()
            try:
                answer = _measured(problem, scales, setup)
            except ShockwaveError as error:
                results[index] = error
                continue
            own += time.perf_counter() - begin
        result = SimulationResult(
            shock=shock,
            chain=chain,
            options=setup.options,
            scales=scales,
            found=answer.primary,
            error_estimate=answer.error_estimate,
            search_warnings=answer.warnings + _missed(setup.options, answer),
            seconds=own,
            on_demand=_on_demand,
            measured=answer.train,
        )
        results[index] = beyond_elastic(chain, partial(getattr, result, "yielding")) or result
    for index in set(range(len(scenes))).difference(results):
        # a shock on equal granules does not need them
        from shockwave.chain.impact import Impact
        from shockwave.measurement.chain_simulation import simulate_chain

        try:
            if not isinstance(scenes[index][0], Shock | Impact):
                check_scene(*scenes[index])
            results[index] = simulate_chain(setup.given, *scenes[index])
        except ShockwaveError as error:
            results[index] = error
    return [results[index] for index in range(len(scenes))]


def equal_granules(excitation: object, chain: Chain) -> Chain | None:
    """The chain as equal granules with free ends; None if the scene has further features.

    An endless chain keeps its contact law.
    """
    if not isinstance(chain, Chain) or (chain.is_uniform and isinstance(excitation, Shock)):
        return chain
    from shockwave.chain.coverage import reduced

    return reduced(chain) if isinstance(excitation, Shock) else None


def _missed(options: SimulateOptions, answer: Answer) -> tuple[str, ...]:
    """Warning if the peak force of the leading wave does not meet the tolerance, or the step is too large."""
    error = answer.error_estimate
    if error <= (_UNSETTLED if options.rtol is None else options.rtol):
        return ()
    if options.rtol is None:
        step = f"The step of {options.step:g} is too large for {options.integrator}: the result is not accurate"
        return (f"{step}. A smaller step reduces the error.",)
    reached = f"the relative error of the peak force is estimated as {error:.1e}, not {options.rtol:.1e}"
    advice = "A smaller rtol may reduce it."
    if answer.train is None:
        advice = "Smaller steps did not reduce it further."
        if answer.primary.doubt > error / 2:
            advice = (
                "A wave behind it may still exceed it, and following both takes too long for any rtol: shorten the"
                " shock, or take the range of the estimate of a prediction."
            )
    return (f"The tolerance was not met: {reached}. {advice}",)


def _measured(problem: ChainProblem, scales: Scales, setup: Setup) -> Answer:
    """The leading wave that the search has not found, measured on the whole chain."""
    from shockwave.measurement.train import measure_primary

    if expired():
        raise NumericalError("the time limit was reached before the leading wave was known (increase timeout or rtol)")
    if setup.search is not None and problem.granules is None and problem.duration > LONGEST_MEASURED:
        lasts = f"the shock lasts {problem.duration:.3g} characteristic times of its wave"
        raise NumericalError(f"the leading wave could not be found: {lasts} (shorten it)")
    if problem.granules is not None and setup.options.timeout is None and (reason := immeasurable(problem)):
        raise NumericalError(f"the waves reach the free end before they have settled, and {reason}")
    return Answer(*measure_primary(problem, scales, setup))


def _on_demand(part: str, result: SimulationResult, *arguments: Any) -> Any:
    """Compute a part of a result that is rarely needed, by modules that are imported only then."""
    from shockwave.measurement.histories import passage_at, record
    from shockwave.measurement.train import train_of

    functions: dict[str, Callable[..., Any]] = {"train": train_of, "passage": passage_at, "recording": record}
    if part == "contacts":
        from shockwave.measurement.chain_simulation import contact_peaks

        functions[part] = contact_peaks
    allowed = result.options.timeout
    with time_limit(None if allowed is None else allowed - result.seconds):
        return functions[part](result, *arguments)
