"""The leading wave at any contact, by another integration of the chain where it has not settled."""

from __future__ import annotations

import math
from collections.abc import Iterable

from attrs import evolve

from shockwave.base.errors import NumericalError
from shockwave.engine.nystroem_integrators import Nystroem
from shockwave.engine.scaled_problem import ScaledProblem
from shockwave.engine.time_limit import expired
from shockwave.engine.wave_search import find_primaries
from shockwave.scene.solitary_wave import wave_law
from shockwave.simulation.recording import check_contact
from shockwave.simulation.result_parts import Passage
from shockwave.simulation.simulation_result import Simulation
from shockwave.simulation.wave_setup import Setup, scale_scene, setup_of
from shockwave.simulation.whole_chain import WholeChain

# Slowest decrease, from contact to contact, of the deviation of a peak from its limit.
_DECREASE = 0.98**0.25
# Distance in contacts at which a free end affects a wave.
_REACH = 8
# Largest number of runs for passages.
_RUNS = 5
# Number of contacts on both sides of a passage whose differences of two runs count.
_NEIGHBOURS = 2
# Relative rounding error of a passage.
_ROUNDING = 2e-13


def passages_at(result: Simulation, contacts: Iterable[int]) -> list[Passage | NumericalError]:
    """Compute `Simulation.passage` at several contacts; the error where there is none."""
    numbers = [check_contact(result.chain, contact) for contact in contacts]
    primary, granules, setup = result.wave.scaled, result.chain.count, setup_of(result.options)
    # contacts that the free end does not affect before the front arrives
    last = math.inf if granules is None else -1 if result.measured is not None else granules - 2 - _REACH
    wave = wave_law(result.chain.exponent)
    passages: dict[int, Passage] = {}
    for contact in numbers:
        if primary.contact <= contact <= last:
            beyond = contact - primary.contact
            time = primary.time + beyond / (wave.speed * primary.peak**wave.of_speed)
            # The deviation from the limit where the peak was measured decreases at least by this factor per contact.
            error = result.error_estimate + abs(primary.last / primary.peak - 1) * _DECREASE**beyond
            passages[contact] = Passage.of(result.wave.scales, contact, time, primary.peak, error, exact=True)
    near = [contact for contact in numbers if contact <= last and contact not in passages]
    if near and setup.search is not None:
        _integrate(result, passages, near, setup.search)
    enough = max(setup.rtol, result.error_estimate)
    missed = [each for each in numbers if each not in passages or passages[each].error_estimate > enough]
    if missed:
        _integrate(result, passages, missed)
    reason = "the time limit was reached" if expired() else "the force still rises there (request a later contact)"
    return [
        passages[each]
        if each in passages
        else NumericalError(f"the leading wave has no peak at contact {each}: {reason}")
        for each in numbers
    ]


def _integrate(
    result: Simulation, passages: dict[int, Passage], contacts: list[int], search: type[Nystroem] | None = None
) -> None:
    """Add passages from integrations of the chain up to the last contact, with smaller and smaller tolerances.

    The errors follow from the differences of two runs, there and at neighbouring contacts, since they may vanish by
    chance at one of them.
    """
    problem, setup = scale_scene(result.scene)[0], setup_of(result.options)
    missed, coarse = contacts, _peaks(problem, setup, contacts, search, 0)[0]
    for decades in range(1, _RUNS if setup.method.adaptive else 2):
        fine, tolerance = _peaks(problem, setup, missed, search, decades)
        changes = {
            contact: max(abs(value / before - 1) for value, before in zip(peak, coarse[contact], strict=True))
            for contact, peak in fine.items()
            if contact in coarse
        }
        for contact in [contact for contact in missed if contact in changes]:
            near = range(contact - _NEIGHBOURS, contact + _NEIGHBOURS + 1)
            error = max(changes.get(each, 0.0) for each in near) + tolerance + problem.path.error + _ROUNDING
            if contact not in passages or error < passages[contact].error_estimate:
                passages[contact] = Passage.of(result.wave.scales, contact, *fine[contact], error)
        missed = [each for each in missed if each not in passages or passages[each].error_estimate > setup.rtol]
        if not missed:
            break
        coarse = fine


def _peaks(
    problem: ScaledProblem, setup: Setup, contacts: list[int], search: type[Nystroem] | None, decades: int
) -> tuple[dict[int, tuple[float, float]], float]:
    """Time and force of the first peak at contacts and their neighbours, by a run with a tolerance smaller by decades.

    Also returns the tolerance of a step, 0 for a method with a fixed step.
    """
    last = math.inf if problem.granules is None else problem.granules - 2
    near = {contact + shift for contact in contacts for shift in range(-_NEIGHBOURS, _NEIGHBOURS + 1)}
    numbers = sorted(contact for contact in near if 0 <= contact <= last)
    if search is not None:
        # as in an endless chain, since the free end does not affect the front before it arrives
        request = setup.request(evolve(problem, granules=None), decades, contacts=tuple(numbers))
        (primary,) = find_primaries([request], search, setup.compiled)
        return {peak.contact: (peak.time, peak.force) for peak in primary.passages}, request.tolerance
    integrator = setup.integrator(10.0 ** (1 - decades))
    whole = WholeChain(problem, integrator, kept=False)
    while whole.log.front <= numbers[-1] + _REACH and any(not [*whole.log.at(each)] for each in numbers):
        whole.advance_to(whole.now + 1.0, "passage", numbers[-1])
    peaks = [peak for contact in numbers for peak in [*whole.log.at(contact)][-1:]]
    tolerance = integrator.tolerance if setup.method.adaptive else 0.0
    return {peak.contact: (peak.time, peak.force) for peak in peaks}, tolerance
