"""The primary at any contact: from the exact wave beyond where it was read, from the chain before."""

from __future__ import annotations

import numpy as np
from attrs import evolve

from shockwave.chain.solitary_wave import SPEED
from shockwave.errors import InvalidValueError, NumericalError
from shockwave.measurement.peaks import PeakLog
from shockwave.measurement.plan import Plan, plan_of, scaled
from shockwave.measurement.result import Passage, SimulationResult
from shockwave.simulation.march import Stretch, march
from shockwave.simulation.primary import find_primaries
from shockwave.simulation.problem import ChainProblem

# By how much a peak nears its limit from contact to contact, at least.
_FALL = 0.98**0.25
# A free end is felt so many contacts away, and followed up to one so far behind where the wave was read.
_REACH = 8
_FARTHEST = 2000


def passage_at(result: SimulationResult, contact: int) -> Passage:
    """See `SimulationResult.passage`."""
    contact = check_contact(result, contact)
    found, granules = result.found, result.chain.granules
    feels_end = granules is not None and (result.was_measured or contact > granules - 2 - _REACH)
    beyond = contact - found.contact
    exact = beyond >= 0 and not feels_end
    if exact:
        # Slope and origin of the path of the exact wave: its speed scales as the sixth root of the peak force.
        time, force = found.time + beyond / (SPEED * found.peak ** (1 / 6)), found.peak
        # what the peak lacked of its limit where it was read, and how that falls off at the slowest
        left = abs(found.last / found.peak - 1) * _FALL**beyond
    else:
        time, force = _integrated(result, contact, feels_end)
        left = 0.0
    return Passage(
        contact=contact,
        arrival_time=time * result.scales.time,
        peak_force=force * result.scales.force,
        exact=exact,
        error_estimate=result.error_estimate + left,
    )


def check_contact(result: SimulationResult, contact: int) -> int:
    """The number of a contact of this chain."""
    granules = result.chain.granules
    whole = isinstance(contact, int | np.integer) and not isinstance(contact, bool)
    if not whole or contact < 0 or (granules is not None and contact > granules - 2):
        most = "" if granules is None else f" and at most {granules - 2}, the last of this chain"
        raise InvalidValueError.of("contact", f"must be a whole number of at least 0{most} (got {contact!r})")
    return int(contact)


def _integrated(result: SimulationResult, contact: int, feels_end: bool) -> tuple[float, float]:
    """Time and force of the peak, from the chain integrated up to there once more."""
    plan = plan_of(result.options)
    problem, _ = scaled(result.shock, result.chain)
    if plan.search is not None and not feels_end:
        # as if the chain had no end: the front does not feel it before it is there
        request = plan.request(evolve(problem, granules=None), contacts=(contact,))
        (primary,) = find_primaries([request], plan.search, plan.compiled)
        found = [(passage.time, passage.force) for passage in primary.passages]
    elif contact - result.found.contact > _FARTHEST:
        raise NumericalError(f"contact {contact} feels a free end too far away to be integrated (ask for one before)")
    else:
        found = _marched(problem, plan, contact)
    if not found:
        raise NumericalError(f"the front has no peak of its own at contact {contact}: the force still rises there")
    return found[0]


def _marched(problem: ChainProblem, plan: Plan, contact: int) -> list[tuple[float, float]]:
    log = PeakLog()
    for span in march(problem, plan.integrator()):
        log.observe(Stretch.of(span))
        if contact in log.peaks or max(log.peaks, default=0) > contact + 8:
            break
    return [(peak.time, peak.force) for peak in log.peaks.get(contact, ())]
