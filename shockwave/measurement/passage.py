"""The primary at any contact: from the exact wave beyond where it was read, from the chain before."""

from __future__ import annotations

import numpy as np
from attrs import evolve

from shockwave.chain.solitary_wave import SPEED
from shockwave.errors import InvalidValueError, NumericalError
from shockwave.measurement.peaks import PeakLog
from shockwave.measurement.result import Passage, SimulationResult
from shockwave.measurement.simulate import Plan, plan_of, scaled
from shockwave.simulation.march import Stretch, march
from shockwave.simulation.nystroem import Nystroem
from shockwave.simulation.primary import find_primaries
from shockwave.simulation.problem import ChainProblem

__all__ = ["checked", "passage"]

# By how much a peak nears its limit from contact to contact, at least.
_FALL = 0.98**0.25
# A free end is felt so many contacts away, and followed up to one so far behind where the wave was read.
_REACH, _FARTHEST = 8, 2000


def passage(result: SimulationResult, contact: int) -> Passage:
    """See `SimulationResult.passage`."""
    contact = checked(result, contact)
    found, scales = result.found, result.scales
    limited = result.chain.granules is None or not result.was_measured
    if contact >= found.contact and limited and not _feels_the_end(result, contact):
        # Slope and origin of the path of the exact wave: its speed goes with the sixth root of the peak force.
        speed = SPEED * found.peak ** (1 / 6)
        time = found.time + (contact - found.contact) / speed
        # what the peak lacked of its limit where it was read, and how that falls off at the slowest
        left = abs(found.last / found.peak - 1) * _FALL ** (contact - found.contact)
        return Passage(
            contact=contact,
            arrival_time=time * scales.time,
            peak_force=result.peak_force,
            exact=True,
            error_estimate=result.error_estimate + left,
        )
    plan = plan_of(result.options)
    problem = scaled(result.shock, result.chain)[0]
    if plan.search is not None and limited and not _feels_the_end(result, contact):
        time, force = _searched(problem, plan, plan.search, contact)
    elif contact - found.contact > _FARTHEST:
        raise NumericalError(
            f"contact {contact} feels a free end too far away to be integrated (ask for one before it)"
        )
    else:
        time, force = _marched(problem, plan, contact)
    return Passage(
        contact=contact,
        arrival_time=time * scales.time,
        peak_force=force * scales.force,
        exact=False,
        error_estimate=result.error_estimate,
    )


def _feels_the_end(result: SimulationResult, contact: int) -> bool:
    granules = result.chain.granules
    return granules is not None and contact > granules - 2 - _REACH


def checked(result: SimulationResult, contact: int) -> int:
    granules = result.chain.granules
    last = None if granules is None else granules - 2
    whole = isinstance(contact, int | np.integer) and not isinstance(contact, bool)
    if not whole or contact < 0 or (last is not None and contact > last):
        most = "" if last is None else f" and at most {last}, the last of this chain"
        raise InvalidValueError.of("contact", f"must be a whole number of at least 0{most} (got {contact!r})")
    return int(contact)


def _searched(problem: ChainProblem, plan: Plan, method: type[Nystroem], contact: int) -> tuple[float, float]:
    """By the search for the primary, which reads the front wherever it is asked to."""
    # as if the chain had no end: the front does not feel it before it is there
    endless = evolve(problem, granules=None)
    request = plan.request(endless, contacts=(contact,))
    (primary,) = find_primaries([request], method, plan.compiled)
    for found in primary.passages:
        return found.time, found.force
    raise _no_peak(contact)


def _marched(problem: ChainProblem, plan: Plan, contact: int) -> tuple[float, float]:
    from shockwave.measurement.train import methods_of

    log = PeakLog()
    for span in march(problem, methods_of(plan)(1.0)):
        log.observe(Stretch.of(span))
        if contact in log.peaks:
            return log.peaks[contact][0].time, log.peaks[contact][0].force
        if max(log.peaks, default=0) > contact + 8:
            break
    raise _no_peak(contact)


def _no_peak(contact: int) -> NumericalError:
    return NumericalError(f"the front has no peak of its own at contact {contact}: the force still rises there")
