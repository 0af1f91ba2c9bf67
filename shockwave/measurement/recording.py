"""Histories of the chain, kept only when they are asked for."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from shockwave.errors import InvalidValueError
from shockwave.measurement.plan import plan_of, scaled
from shockwave.measurement.primary_passages import check_contact
from shockwave.measurement.result import Recording, SimulationResult
from shockwave.quadrature import FloatArray
from shockwave.simulation.march import Span, march
from shockwave.simulation.problem import contact_forces, overlaps

__all__ = ["Recording", "record"]

# Samples to a characteristic time of the wave, and such times after the passage of the last contact.
_SAMPLES = 10
_AFTER = 5.0
_MOST_NUMBERS = 20_000_000


def record(result: SimulationResult) -> Recording:
    """The histories that ``result.options`` ask for; the chain is integrated once more.

    Raises
    ------
    InvalidValueError
        When the chain has no such contact, or the histories would not fit into memory.
    """
    options, scales = result.options, result.scales
    for contact in options.contacts:
        check_contact(result, contact)
    until = _end(result)
    interval = 1 / _SAMPLES if options.interval is None else options.interval / scales.time
    count = int(until / interval * (1 + 1e-12)) + 1
    granules = result.primary.contact + until
    width = len(options.contacts) + 2 + (2 * granules if "field" in options.record else 0)
    if count * width > _MOST_NUMBERS:
        got = f"got {interval * scales.time:g} s for {until * scales.time:g} s; or give an earlier until"
        problem = f"must be longer, for the histories would have {count} samples ({got})"
        raise InvalidValueError.of("interval", problem)
    times = interval * np.arange(count)
    spans = march(scaled(result.shock, result.chain)[0], plan_of(options).integrator())
    states = _states(spans, times.tolist())
    rows = [_row(x, v, options.contacts, options.record) for x, v in states]
    units = {
        "forces": scales.force,
        "displacements": scales.energy / scales.force,
        "velocities": scales.velocity,
        "kinetic_energy": scales.energy,
        "contact_energy": scales.energy,
    }
    histories = {name: _history([row[name] for row in rows]) * units[name] for name in rows[0]}
    return Recording(times=np.asarray(times * scales.time), contacts=options.contacts, **histories)


def _end(result: SimulationResult) -> float:
    if result.options.until is not None:
        return result.options.until / result.scales.time
    contacts = result.options.contacts
    read = result.passage(max(contacts)).arrival_time if contacts else result.primary.arrival_time
    return read / result.scales.time + _AFTER


def _states(spans: Iterator[Span], times: list[float]) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Positions and velocities at these times, the first of which is 0."""
    yield np.zeros(2), np.zeros(2)
    span = next(spans)
    for time in times[1:]:
        while time > span.end:
            span = next(spans)
        yield (span.x1, span.v1) if time == span.end else span.at(time)


def _row(x: FloatArray, v: FloatArray, contacts: tuple[int, ...], asked: tuple[str, ...]) -> dict[str, Any]:
    """Quantities of a state that are kept, in scaled units."""
    force = contact_forces(x)
    row: dict[str, Any] = {}
    if "forces" in asked:
        row["forces"] = np.array([force[i] if i < len(force) else 0.0 for i in contacts])
    if "field" in asked:
        # granules that have not moved yet are left out
        row["displacements"] = np.trim_zeros(x, "b")
        row["velocities"] = np.trim_zeros(v, "b")
    if "energies" in asked:
        row["kinetic_energy"] = 0.5 * float(np.sum(v * v))
        row["contact_energy"] = 0.4 * float(np.sum(force * np.maximum(overlaps(x), 0.0)))
    return row


def _history(rows: list[Any]) -> FloatArray:
    """All rows as one array; shorter ones are filled up with granules at rest."""
    if np.ndim(rows[0]) == 0:
        return np.array(rows)
    filled = np.zeros((len(rows), max(map(len, rows))))
    for index, row in enumerate(rows):
        filled[index, : len(row)] = row
    return filled
