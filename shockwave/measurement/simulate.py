"""Direct simulation, from shocks and a chain to results with error estimates."""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from types import ModuleType

from attrs import evolve, frozen

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.errors import InvalidValueError, NumericalError, ShockwaveError
from shockwave.measurement.result import SimulationResult
from shockwave.options import Backend, Recorded, SimulateOptions, Waves
from shockwave.profiles.shock import Shock
from shockwave.registry import load
from shockwave.simulation.backend import chosen
from shockwave.simulation.integrator import Integrator
from shockwave.simulation.nystroem import Nystroem
from shockwave.simulation.primary import find_primaries
from shockwave.simulation.primary_request import KNOWN, TOO_LONG, Primary, Request
from shockwave.simulation.problem import ChainProblem

__all__ = ["MEASURABLE", "Plan", "plan_of", "scaled", "simulate", "simulate_many", "simulate_with"]

_RTOL, _STEP = 1e-6, 0.02
# Below this tolerance the method of high order takes fewer evaluations.
_HIGH_ORDER = 1e-7
# Shares of the tolerance, and how much of it a loose one may be at most: waves must still be told from noise.
_DOUBT, _MOST_DOUBT, _LOOSEST_STEP = 0.5, 3e-5, 2e-4
# The first waves of a longer shock are nearly alike, and part slowly: no looser search tells them from one another.
_LONG, _LONG_RTOL = 10.0, 1e-6
# Below this step control gains nothing: rounding is all that is left.
_TIGHTEST_STEP = 3e-15
# What a peak force errs by: so many energy defects (1.7 would follow from F ~ E^(3/5), were all of it the primary's),
# and a share of the step tolerance; measured on 400 shocks, 98 % are covered.
_DEFECTS, _TOLERANCE_SHARE = 2.0, 0.3
_ROUNDING, _EPSILON = 2e-13, 2e-16
# A search that misses its tolerance is repeated with a tighter one.
_TIGHTER, _REPEATS, _PATIENCE = 0.1, 2, 10.0
_DIGITS = 13
# Shocks in a share of the work of a thread, and the fewest worth one.
_SHARE, _FEWEST = 128, 16
#: The longest shock, in natural times of its wave: the work grows with the square.
_LONGEST = 2e4
# Longer ones, in the same unit, are not measured on the whole chain where the search has failed: its waves are nearly
# alike, and would not be told from one another there either.
_WORTHWHILE = 60.0
#: The train of longer ones is not integrated: it would take hours.
MEASURABLE = 300.0


@frozen
class Plan:
    """Options with everything settled: the method, and the code that steps it."""

    options: SimulateOptions
    method: type[Integrator]
    compiled: ModuleType | None

    @property
    def search(self) -> type[Nystroem] | None:
        """The method, if the search for the primary knows it."""
        return self.method if issubclass(self.method, Nystroem) else None

    def missed(self, error_estimate: float) -> list[str]:
        """What there is to say where the peak force of the primary is not known to what was asked for."""
        rtol = self.options.rtol
        if rtol is None or error_estimate <= rtol:
            return []
        return [
            f"the tolerance was not met: the primary's peak force is known to {error_estimate:.1e},"
            f" {rtol:.1e} was asked for"
        ]

    def request(self, problem: ChainProblem, repeats: int = 0, contacts: tuple[int, ...] = ()) -> Request:
        """What is asked of the search for the primary; tighter if it is repeated."""
        rtol = self.options.rtol or _RTOL
        tighter = _TIGHTER**repeats
        if problem.duration >= _LONG:
            rtol = min(rtol, _LONG_RTOL)
            # Such a primary is judged late, when it changes by no more than step errors make of it.
            tighter *= _TIGHTER if problem.rises_again else 1.0
        caution: float = getattr(self.method, "caution", 1.0)
        return Request(
            problem,
            tolerance=max(min(caution * rtol, _LOOSEST_STEP) * tighter, _TIGHTEST_STEP),
            doubt=max(min(_DOUBT * rtol, _MOST_DOUBT) * max(tighter, 0.3), 2e-14),
            contacts=contacts,
            patience=_PATIENCE if repeats else 1.0,
        )


@lru_cache(maxsize=64)
def plan_of(options: SimulateOptions) -> Plan:
    """Settle what ``options`` leave open.

    Raises
    ------
    InvalidValueError
        When a setting is given that the method has no use for, or the backend is not there.
    """
    name = options.integrator
    if name is None:
        tight = options.rtol is not None and options.rtol < _HIGH_ORDER
        name = "rkn1210" if tight else "rkn86"
    method: type[Integrator] = load("integrators", name)
    ours = issubclass(method, Nystroem)
    options.check(name, ["rtol" if method.adaptive else "step", *(["backend"] if ours else [])])
    rtol, step = options.rtol, options.step
    if method.adaptive:
        rtol = _RTOL if rtol is None else rtol
    else:
        step = _STEP if step is None else step
    compiled = chosen(options.backend) if ours else None
    settled = evolve(
        options, integrator=name, rtol=rtol, step=step, backend="numpy" if compiled is None else "compiled"
    )
    return Plan(settled, method, compiled)


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
) -> SimulationResult:
    """Integrate eq. (1) and measure the waves that come out.

    The primary is followed until the limit of its peak force along the chain is known to ``rtol``; that is the
    result. The other waves and the recoil are integrated when the result is first asked for them.

    Parameters
    ----------
    shock : Shock
        Profile, peak force, rise time.
    chain : Chain
        Material, radius, and the number of granules or None.
    rtol, integrator, wave_threshold, step, waves, backend, contacts, record, interval, until
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
        When the integrator fails, no wave leaves the loaded end, or the shock is too long.
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
    )
    return simulate_with(options, shock, chain)


def simulate_with(options: SimulateOptions, shock: Shock, chain: Chain) -> SimulationResult:
    """As `simulate`, with the options in one object, such as that of a scenario."""
    (result,) = _simulate([(shock, chain)], plan_of(options))
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
) -> list[SimulationResult | ShockwaveError]:
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
        In the order of the shocks. In place of a result that cannot be had stands the error that says why.
    """
    options = SimulateOptions(
        integrator=integrator, rtol=rtol, step=step, wave_threshold=wave_threshold, waves=waves, backend=backend
    )
    shocks = list(shocks)
    chains = [chain] * len(shocks) if isinstance(chain, Chain) else list(chain)
    if len(chains) != len(shocks):
        raise InvalidValueError.of("chain", f"must be one, or one for each shock (got {len(chains)})")
    if threads is None:
        threads = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    scenes, plan = list(zip(shocks, chains, strict=True)), plan_of(options)
    if plan.compiled is None or threads < 2 or len(scenes) < 2 * _FEWEST:
        return _simulate(scenes, plan)
    # Each thread does all of its share: while one is in the compiled code, which needs no lock, another prepares.
    size = max(_FEWEST, min(_SHARE, -(-len(scenes) // threads)))
    shares = [scenes[begin : begin + size] for begin in range(0, len(scenes), size)]
    with ThreadPoolExecutor(threads) as pool:
        return [result for results in pool.map(lambda share: _simulate(share, plan), shares) for result in results]


def _simulate(scenes: Sequence[tuple[Shock, Chain]], plan: Plan) -> list[SimulationResult | ShockwaveError]:
    begin = time.perf_counter()
    results: list[SimulationResult | ShockwaveError | None] = [None] * len(scenes)
    known: dict[int, tuple[ChainProblem, Scales]] = {}
    for index, (shock, chain) in enumerate(scenes):
        try:
            known[index] = scaled(shock, chain)
        except ShockwaveError as error:
            results[index] = error
    found = _search(known, plan, plan.search) if plan.search is not None else {}
    seconds = (time.perf_counter() - begin) / max(len(scenes), 1)
    for index, (problem, scales) in known.items():
        shock, chain = scenes[index]
        try:
            if index in found:
                primary, error_estimate = found[index]
                results[index] = _result(shock, chain, scales, plan, primary, error_estimate, seconds)
            else:
                from shockwave.measurement.train import measured

                results[index] = measured(shock, chain, problem, scales, plan)
        except ShockwaveError as error:
            results[index] = error
    return results  # type: ignore[return-value]


def scaled(shock: Shock, chain: Chain) -> tuple[ChainProblem, Scales]:
    """The problem in units of the wave to come: of F0, or of what a short shock makes of it if that is less."""
    if not (isinstance(shock, Shock) and isinstance(chain, Chain)):
        got = f"got {type(shock).__name__} and {type(chain).__name__}"
        raise InvalidValueError.of("shock", f"must be a Shock, and the chain a Chain ({got})")
    natural = Scales.of(chain, shock.peak_force)
    # One number governs everything. Its last digits are the rounding of units: cut off, so that the same scene
    # in other units, or scaled to another chain, is the same problem to the last bit.
    ratio = float(f"{natural.rise_time(shock.rise_time):.{_DIGITS}g}")
    strength = ratio * shock.profile.areas().total / MOMENTUM
    force = min(1.0, strength**1.2)
    scales = natural if force == 1.0 else Scales.of(chain, shock.peak_force * force)
    problem = ChainProblem(shock.profile, ratio * force ** (1 / 6), 1 / force, chain.granules)
    if problem.duration > _LONGEST:
        raise NumericalError(
            f"the shock lasts {problem.duration:.3g} natural times of its wave, {_LONGEST:g} is the most:"
            " so slow a force is a matter of statics (shorten it, or soften the granules)"
        )
    return problem, scales


def _search(
    scaled: dict[int, tuple[ChainProblem, Scales]], plan: Plan, method: type[Nystroem]
) -> dict[int, tuple[Primary, float]]:
    """The primaries that the search finds, each with its error estimate; again and tighter where it was missed."""
    found: dict[int, tuple[Primary, float]] = {}
    lost: set[int] = set()
    left = list(scaled)
    rtol = plan.options.rtol or _RTOL
    for repeats in range(1 + _REPEATS):
        requests = [plan.request(scaled[index][0], repeats) for index in left]
        primaries = find_primaries(requests, method, plan.compiled)
        for index, request, primary in zip(tuple(left), requests, primaries, strict=True):
            if primary.status == KNOWN:
                error = _error(primary, request.tolerance, request.problem)
                if index not in found or error < found[index][1]:
                    found[index] = primary, error
            elif index in lost or primary.status != TOO_LONG:
                left.remove(index)
                if primary.status == TOO_LONG and request.problem.duration > _WORTHWHILE:
                    found[index] = primary, 1.0
            else:
                lost.add(index)
        left = [index for index in left if index not in found or found[index][1] > rtol]
        if not left:
            break
    return found


def _error(primary: Primary, tolerance: float, problem: ChainProblem) -> float:
    """Relative error estimate of the peak force."""
    # positions of the first granule are differences of the free path and what the chain does to it
    rounding = _ROUNDING + _EPSILON * primary.free_path
    control = _DEFECTS * primary.energy_defect + _TOLERANCE_SHARE * tolerance
    return primary.doubt + control + problem.path.error + rounding


def _result(
    shock: Shock, chain: Chain, scales: Scales, plan: Plan, primary: Primary, error_estimate: float, seconds: float
) -> SimulationResult:
    return SimulationResult(
        shock=shock,
        chain=chain,
        options=plan.options,
        scales=scales,
        found=primary,
        error_estimate=error_estimate,
        notes=(*shock.profile.notes, *plan.missed(error_estimate)),
        seconds=seconds,
    )
