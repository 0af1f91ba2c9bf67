"""Parts of a result that need another integration: the leading wave at any contact, and histories of the chain."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from attrs import evolve

from shockwave.chain.solitary_wave import wave_law
from shockwave.errors import NumericalError
from shockwave.measurement.course import Course
from shockwave.measurement.measured_wave import Passage
from shockwave.measurement.recording import AFTER, Recording, checked_contact, reported_contacts, sample_times
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulation_setup import scaled, setup_of
from shockwave.progress import progressed
from shockwave.quadrature import FloatArray
from shockwave.simulation.march import Span, march
from shockwave.simulation.primary_search import find_primaries
from shockwave.simulation.problem import contact_energies, contact_forces

# Slowest decrease, from contact to contact, of the deviation of a peak from its limit.
_DECREASE = 0.98**0.25
# Distance in contacts at which a free end affects a wave.
_REACH = 8


# ---------------------------------------------------------------- passages of the leading wave


def passage_at(result: SimulationResult, contact: int) -> Passage:
    """Compute a `SimulationResult.passage`."""
    contact = checked_contact(result.chain, contact)
    found, granules = result.found, result.chain.count
    feels_end = granules is not None and (result.measured is not None or contact > granules - 2 - _REACH)
    beyond = contact - found.contact
    exact = beyond >= 0 and not feels_end
    error = result.error_estimate
    if exact:
        wave = wave_law(result.chain.exponent)
        time, force = found.time + beyond / (wave.speed * found.peak**wave.of_speed), found.peak
        # The deviation from the limit where the peak was measured decreases at least by this factor per contact.
        error += abs(found.last / found.peak - 1) * _DECREASE**beyond
    else:
        time, force = _integrated(result, contact, feels_end)
    return Passage(
        contact=contact,
        arrival_time=time * result.scales.time,
        peak_force=force * result.scales.contact_force,
        exact=exact,
        error_estimate=error,
    )


def _integrated(result: SimulationResult, contact: int, feels_end: bool) -> tuple[float, float]:
    """Time and force of the peak, from another integration of the chain up to the contact."""
    setup = setup_of(result.options)
    problem, _ = scaled(result.shock, result.chain)
    if setup.search is not None and not feels_end:
        # as in an endless chain, since the free end does not affect the front before it arrives
        request = setup.request(evolve(problem, granules=None), contacts=(contact,))
        (primary,) = find_primaries([request], setup.search, setup.compiled)
        found = [(passage.time, passage.force) for passage in primary.passages]
    else:
        course = Course.of(problem, setup.integrator(), kept=False)
        course.advance_to(0.0, "passage", contact)
        while not (found := [(peak.time, peak.force) for peak in course.log.at(contact)]):
            if course.log.front > contact + _REACH:
                break
            course.advance_to(course.now + 1.0, "passage", contact)
    if not found:
        raise NumericalError(
            f"the leading wave has no peak at contact {contact}: the force still rises there (request a later contact)"
        )
    return found[0]


# ---------------------------------------------------------------- histories


def record(result: SimulationResult) -> Recording:
    """Compute the histories that ``result.options`` request, by another integration of the chain.

    Raises
    ------
    InvalidValueError
        If the histories have too many values.
    """
    options, scales = result.options, result.scales
    until = _end(result) / scales.time
    times = sample_times(options, scales, until, result.primary.contact + until)
    spans = march(scaled(result.shock, result.chain)[0], setup_of(options).integrator())
    x, v = _states(spans, times.tolist())
    kept: dict[str, FloatArray] = {}
    contacts = options.contacts if result.chain.count is None else reported_contacts(options, result.chain.count - 1)
    if "forces" in options.record:
        forces = contact_forces(x, result.chain.exponent)
        at = [forces[contact] if contact < len(forces) else 0 * times for contact in contacts]
        kept["forces"] = scales.contact_force * np.array(at).T
    if "field" in options.record:
        moved = 1 + max(np.flatnonzero(x.any(axis=1)), default=-1)
        kept["displacements"] = scales.energy / scales.force * x[:moved].T
        kept["velocities"] = scales.velocity * v[:moved].T
    if "energies" in options.record:
        kept["kinetic_energy"] = scales.energy * 0.5 * np.sum(v * v, axis=0)
        kept["contact_energy"] = scales.energy * np.sum(contact_energies(x, result.chain.exponent), axis=0)
    return Recording(times=np.asarray(times * scales.time), contacts=contacts, **kept)


def _end(result: SimulationResult) -> float:
    """End of the histories [s]."""
    options = result.options
    if options.until is not None:
        return options.until
    last = result.passage(max(options.contacts)) if options.contacts else result.primary
    return last.arrival_time + AFTER * result.scales.time


def _states(spans: Iterator[Span], times: list[float]) -> tuple[FloatArray, FloatArray]:
    """Positions and velocities, shape (granules, times) each, at these times, the first of which is 0."""
    states = [(np.zeros(0), np.zeros(0))]
    span = next(spans)
    for time in times[1:]:
        while time > span.end:
            span = next(spans)
            progressed("histories", len(states), len(times))
        states.append((span.x1, span.v1) if time == span.end else span.at(time))
    progressed("histories", len(times), len(times))
    # The window grows with the front; granules ahead of it are at rest.
    x, v = np.zeros((2, max(2, len(span.x1)), len(times)))
    for index, (positions, velocities) in enumerate(states):
        x[: len(positions), index], v[: len(positions), index] = positions, velocities
    return x, v
