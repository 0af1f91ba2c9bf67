"""Direct simulation, from shocks and a chain to results with error estimates."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from threading import Event
from typing import Any, NamedTuple

from shockwave.chain.chain import Chain, Scales
from shockwave.errors import InvalidValueError, NumericalError, ShockwaveError
from shockwave.measurement.result import SimulationResult, Train
from shockwave.measurement.simulation_setup import Setup, immeasurable, scaled, setup_of
from shockwave.options import Backend, Recorded, SimulateOptions, Waves
from shockwave.profiles.shock import Shock
from shockwave.simulation.primary_search import find_primaries
from shockwave.simulation.problem import ChainProblem, Primary, Request, Status
from shockwave.simulation.time_limit import expired, time_limit

__all__ = ["immeasurable", "scaled", "setup_of", "simulate", "simulate_many", "simulate_with"]

# Shocks in a share of the work of a thread, and the fewest worth one.
_SHARE = 128
_FEWEST = 16
# An error estimate above this is none.
_UNSETTLED = 0.1
# Error of a peak force: so many energy defects (1.7 would follow from F ~ E^(3/5), were all of it the primary's),
# and a share of the step tolerance; measured on 400 shocks, 98 % are covered.
_DEFECTS = 2.0
_TOLERANCE_SHARE = 0.3
# Rounding, and the relative rounding of a double.
_ROUNDING = 2e-13
_EPSILON = 2e-16
# A search that misses its tolerance is repeated with one that is tighter by a decade, at most so often. One that comes to
# no end is repeated with more work, then also with looser tolerances, up to this one. It has come to none where another
# wave may still outgrow the primary by more than this share.
_REPEATS = 2
_LOOSEST = 1e-4
_OUTGROWN = 1e-3
# Longer shocks, in characteristic times, are not measured on the whole chain where the search has failed: its waves
# are nearly alike, and could not be separated there either.
_WORTHWHILE = 60.0

_Outcome = SimulationResult | ShockwaveError


def simulate(
    shock: Shock,
    chain: Chain,
    rtol: float | None = None,
    integrator: str | None = None,
    wave_threshold: float = 5e-3,
    *,
    step: float | None = None,
    waves: Waves = "train",
    backend: Backend = "auto",
    contacts: Iterable[int] = (),
    record: Iterable[Recorded] = (),
    interval: float | None = None,
    until: float | None = None,
    timeout: float | None = None,
) -> SimulationResult:
    """Integrate eq. (1) and measure the waves that come out.

    The primary is followed until the limit of its peak force along the chain is accurate to ``rtol``; that is the
    result. The other waves and the recoil are integrated when the result is first asked for them.

    Parameters
    ----------
    shock : Shock
        Profile, peak force, rise time.
    chain : Chain
        Material, radius, and the number of granules or None.
    rtol, integrator, wave_threshold, step, waves, backend, contacts, record, interval, until, timeout
        As of `SimulateOptions`.

    Returns
    -------
    SimulationResult
        In SI units.

    Raises
    ------
    InvalidValueError, UnknownNameError
        When a setting is out of range, or of no use to the method, or a name unknown.
    NumericalError
        When the integrator fails, no wave leaves the loaded end, the shock is too long, or the time is up.
    """
    options = SimulateOptions(
        integrator=integrator,
        rtol=rtol,
        step=step,
        wave_threshold=wave_threshold,
        waves=waves,
        backend=backend,
        contacts=contacts,
        record=record,
        interval=interval,
        until=until,
        timeout=timeout,
    )
    return simulate_with(options, shock, chain)


def simulate_with(options: SimulateOptions, shock: Shock, chain: Chain) -> SimulationResult:
    """As `simulate`, with the options in one object, such as that of a scenario."""
    (result,) = _simulate([(shock, chain)], setup_of(options))
    if isinstance(result, ShockwaveError):
        raise result
    return result


def simulate_many(
    shocks: Iterable[Shock],
    chain: Chain | Sequence[Chain],
    rtol: float | None = None,
    integrator: str | None = None,
    wave_threshold: float = 5e-3,
    *,
    step: float | None = None,
    waves: Waves = "train",
    backend: Backend = "auto",
    threads: int | None = None,
) -> list[_Outcome]:
    """As `simulate` for many shocks, side by side: eight at a time in a core, on every core.

    Parameters
    ----------
    shocks : iterable of Shock
        The shocks.
    chain : Chain or sequence of Chain
        One for all of them, or one each.
    rtol, integrator, wave_threshold, step, waves, backend
        As of `simulate`.
    threads : int, optional
        How many share the work of the compiled code; left out, one for each core.

    Returns
    -------
    list
        In the order of the shocks. In place of a result that could not be computed stands the error.
    """
    options = SimulateOptions(
        integrator=integrator, rtol=rtol, step=step, wave_threshold=wave_threshold, waves=waves, backend=backend
    )
    setup = setup_of(options)
    shocks = list(shocks)
    chains = [chain] * len(shocks) if isinstance(chain, Chain) else list(chain)
    if len(chains) != len(shocks):
        raise InvalidValueError.of("chain", f"must be one, or one for each shock (got {len(chains)})")
    if threads is None:
        threads = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    scenes = list(zip(shocks, chains, strict=True))
    if setup.compiled is None or threads < 2 or len(scenes) < 2 * _FEWEST:
        return _simulate(scenes, setup)
    # Each thread does all of its share: while one is in the compiled code, which needs no lock, another prepares.
    size = max(_FEWEST, min(_SHARE, -(-len(scenes) // threads)))
    shares = [scenes[begin : begin + size] for begin in range(0, len(scenes), size)]
    interrupted = Event()
    with ThreadPoolExecutor(threads) as pool:
        futures = [pool.submit(_simulate, share, setup, interrupted) for share in shares]
        try:
            return [result for future in futures for result in future.result()]
        finally:  # nothing is left to do, but after Ctrl-C
            interrupted.set()
            pool.shutdown(cancel_futures=True)


def _simulate(
    scenes: Sequence[tuple[Shock, Chain]], setup: Setup, interrupted: Event | None = None
) -> list[_Outcome]:
    with time_limit(setup.options.timeout, interrupted):
        return _simulate_all(scenes, setup)


def _simulate_all(scenes: Sequence[tuple[Shock, Chain]], setup: Setup) -> list[_Outcome]:
    begin = time.perf_counter()
    results: dict[int, _Outcome] = {}
    known: dict[int, tuple[ChainProblem, Scales]] = {}
    for index, (shock, chain) in enumerate(scenes):
        try:
            known[index] = scaled(shock, chain)
        except ShockwaveError as error:
            results[index] = error
    answers = _search({index: problem for index, (problem, _) in known.items()}, setup)
    seconds = (time.perf_counter() - begin) / max(len(scenes), 1)
    for index, (problem, scales) in known.items():
        begin = time.perf_counter()
        shock, chain = scenes[index]
        try:
            answer = answers.get(index) or _measured(problem, scales, setup)
        except ShockwaveError as error:
            results[index] = error
            continue
        results[index] = SimulationResult(
            shock=shock,
            chain=chain,
            options=setup.options,
            scales=scales,
            found=answer.primary,
            error_estimate=answer.error_estimate,
            warnings=(*shock.profile.notes, *answer.warnings, *_missed(setup.options, answer.error_estimate)),
            seconds=seconds + time.perf_counter() - begin,
            on_demand=_on_demand,
            measured=answer.train,
        )
    return [results[index] for index in range(len(scenes))]


def _missed(options: SimulateOptions, error_estimate: float) -> list[str]:
    """A warning where the peak force of the primary does not meet the tolerance, or the step is too coarse."""
    if options.rtol is not None and error_estimate > options.rtol:
        reached = f"the primary's peak force is accurate to {error_estimate:.1e}"
        return [f"the tolerance was not met: {reached}, {options.rtol:.1e} was asked for"]
    if options.rtol is None and error_estimate > _UNSETTLED:
        return [f"the step is too coarse for {options.integrator} (got {options.step:g}; give a smaller one)"]
    return []


class _Answer(NamedTuple):
    """A primary and its error estimate; where the whole chain was measured, the train and warnings."""

    primary: Primary
    error_estimate: float
    train: Train | None = None
    warnings: tuple[str, ...] = ()


def _search(problems: dict[int, ChainProblem], setup: Setup) -> dict[int, _Answer]:
    """The primaries that the search finds, under the keys of their problems; of several, those of the least error."""
    found: dict[int, _Answer] = {}
    if setup.search is None:
        return found
    left = dict.fromkeys(problems, 0)
    unknown: dict[int, Primary] = {}
    repeats = 0
    while left and not expired():
        requests = [setup.request(problems[key], decades, patient=repeats > 0) for key, decades in left.items()]
        primaries = find_primaries(requests, setup.search, setup.compiled)
        asked, left = left, {}
        for (key, decades), request, primary in zip(asked.items(), requests, primaries, strict=True):
            if primary.status in (Status.KNOWN, Status.TOO_LONG) and primary.doubt < 1:
                error = _error(primary, request)
                if key not in found or error < found[key].error_estimate:
                    found[key] = _Answer(primary, error)
                if primary.doubt < _OUTGROWN:
                    if found[key].error_estimate > setup.rtol and 0 <= decades < _REPEATS:
                        left[key] = decades + 1
                    continue
            elif primary.status not in (Status.TOO_LONG, Status.FAILED):
                continue
            unknown[key] = primary
            if setup.rtol * 10.0 ** (repeats - decades) <= _LOOSEST or not repeats:
                left[key] = decades - repeats
        repeats += 1
    for key, primary in unknown.items():
        if problems[key].duration > _WORTHWHILE and primary.impulse and primary.peak:
            found.setdefault(key, _Answer(primary, 1.0))
    return found


def _measured(problem: ChainProblem, scales: Scales, setup: Setup) -> _Answer:
    """A primary that the search has not found, measured on the whole chain."""
    from shockwave.measurement.train import measure_primary

    if expired():
        raise NumericalError("the time limit was reached before the primary was known (allow more, or loosen rtol)")
    if setup.search is not None and problem.granules is None and problem.duration > _WORTHWHILE:
        lasts = f"the shock lasts {problem.duration:.3g} characteristic times of its wave"
        raise NumericalError(f"the primary was not known within the work allowed: {lasts} (shorten it)")
    return _Answer(*measure_primary(problem, scales, setup))


def _error(primary: Primary, request: Request) -> float:
    """Relative error estimate of the peak force."""
    # positions of the first granule are differences of the free-particle displacement and what the chain does to it
    rounding = _ROUNDING + _EPSILON * primary.free_path
    control = _DEFECTS * primary.energy_defect + _TOLERANCE_SHARE * request.tolerance
    return primary.doubt + control + request.problem.path.error + rounding


def _on_demand(part: str, result: SimulationResult, *arguments: Any) -> Any:
    """Integrate what few results need, by modules that are imported when it is looked at."""
    from shockwave.measurement.histories import passage_at, record
    from shockwave.measurement.train import train_of

    functions: dict[str, Callable[..., Any]] = {"train": train_of, "passage": passage_at, "recording": record}
    allowed = result.options.timeout
    with time_limit(None if allowed is None else allowed - result.seconds):
        return functions[part](result, *arguments)
