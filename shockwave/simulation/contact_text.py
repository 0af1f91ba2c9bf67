"""Text of the result of a simulation of a chain beyond equal spheres."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from shockwave.base.result_tables import evenly
from shockwave.base.text import Detail, brief, detail, facts, is_wide, notes, si, significant_digits, strong, table
from shockwave.scene.force_limit import verdict_facts
from shockwave.simulation.contact_peaks import ContactPeak
from shockwave.simulation.contact_result import ChainResult, SegmentEnergy, Transmitted
from shockwave.simulation.wave_text import balance_text, result_limits, work_details

_Item = TypeVar("_Item")
_CONTACTS = ("contact", "greatest force", "time", "error")
_ENERGIES = ("granules", "energy", "share")
# Largest number of rows of a table that is not wide.
_MOST_ROWS = 16
_TIME_DIGITS = 5


def chain_text(result: ChainResult) -> str:
    """The greatest force with its contact, time and error, the force on the wall; on request everything."""
    return brief(chain_head(result), result_limits(result), chain_lines(result))


def chain_head(result: ChainResult) -> list[str]:
    """Lines of the greatest force and the verdict."""
    name = f"{result.scenario}: " if result.scenario else ""
    return [strong(f"{name}{chain_lead(result)}"), *facts(verdict_facts(result))]


def chain_lines(result: ChainResult) -> list[str]:
    """Lines of the force on the wall, the striker and other results; on request everything."""
    lines = facts(chain_answer(result))
    if detail() >= Detail.EXPLAIN or result.options.contacts:
        contacts = _shortened(_CONTACTS, result.contacts, lambda peak: _row(peak, place_of(result, peak.contact)))
        lines += ["", *contacts.split("\n")]
    if detail() is Detail.VERBOSE:
        lines += [*_energies(result), ""]
        lines += facts([*chain_balances(result), *work_details(result), *result.scene.summary().facts()])
        lines += notes(result.scene.notes)
    return lines


def chain_lead(result: ChainResult) -> str:
    """Greatest force with its contact, time and error estimate."""
    top = result.greatest_force
    force, time, error = _row(top, "")[1:]
    place = place_of(result, top.contact)
    where = "on the wall" if "wall" in place else f"at contact {place}"
    return f"greatest force {force} {where}, {time}, estimated error {error}"


def chain_answer(result: ChainResult) -> Iterator[tuple[str, str]]:
    """Labels and texts of the force on the wall, the striker, the granules that fly off, and the simulated time."""
    if result.transmitted is not None:
        force, time, error = _row(result.transmitted, "")[1:]
        yield "wall force", f"{force} at {time}, estimated error {error}" if result.transmitted.peak_force else force
        yield "wall impulse", impulse_text(result.transmitted)
    if result.restitution is not None:
        yield "restitution", f"{result.restitution:.5g} (of the striker)"
    if result.recoil_velocities is not None:
        yield "rebounding", f"granules that move backwards: {_speeds(result.recoil_velocities, 'the first')}"
    if result.spall_velocities is not None:
        yield "free end", f"granules that fly off: {_speeds(result.spall_velocities, 'the last granule')}"
    if result.yielding is not None:
        yield from result.yielding.facts()
    arrival = result.arrival_time
    wave = "does not reach the end" if arrival is None else f"arrives at {si(arrival, 's', _TIME_DIGITS)}"
    wave = "" if result.contact_count is None else f"; the leading wave {wave}"
    yield "simulated", f"to {si(result.end, 's', _TIME_DIGITS)}{wave}"


def impulse_text(wall: Transmitted) -> str:
    """The impulse on a wall, to five digits or to those that its error supports."""
    return si(wall.impulse, "N s", min(5, significant_digits(wall.impulse, wall.impulse_error)))


def chain_balances(result: ChainResult) -> Iterator[tuple[str, str]]:
    """Labels and texts of momentum, energy and their balances."""
    yield "applied", f"momentum {si(result.applied_momentum, 'N s')}, energy {si(result.applied_energy, 'J')}"
    if result.dissipated_energy:
        share = result.dissipated_energy / result.applied_energy
        yield "dissipated", f"{si(result.dissipated_energy, 'J')} ({share:.1%})"
    yield "balance", balance_text(result)


def place_of(result: ChainResult, contact: int) -> str:
    """The number of a contact, marked if it is with the wall."""
    return f"{contact} (wall)" if result.transmitted and contact + 1 == result.contact_count else str(contact)


def span(segment: SegmentEnergy) -> str:
    """Numbers of the granules of a segment."""
    return f"{segment.first}" if segment.first == segment.last else f"{segment.first} to {segment.last}"


def chosen(items: Sequence[_Item]) -> Sequence[_Item]:
    """All items on a wide screen, otherwise the first, the last, and evenly spaced ones between them."""
    if is_wide():
        return items
    return [items[index] for index in evenly(len(items), _MOST_ROWS)]


def _shortened(header: Sequence[str], items: Sequence[_Item], row: Callable[[_Item], Sequence[str]]) -> str:
    """A table of the `chosen` items, and their number if some are omitted."""
    shown = chosen(items)
    note = f"\n  ({len(shown)} of {len(items)} rows; --wide shows all)" if len(shown) < len(items) else ""
    return table(header, map(row, shown)) + note


def _row(peak: ContactPeak, place: str) -> tuple[str, ...]:
    if not peak.peak_force:
        return place, "no force", "-", "-"
    force = si(peak.peak_force, "N", error=peak.error_estimate)
    return place, force, si(peak.time, "s", _TIME_DIGITS), f"{peak.error_estimate:.0e}"


def _energies(result: ChainResult) -> list[str]:
    """A table of the segments and a movable wall, if there are several of them."""
    parts = [(span(segment), segment.energy) for segment in result.segments]
    if result.end_energy is not None:
        parts.append(("wall", result.end_energy))
    if len(parts) == 1:
        return []
    whole = result.applied_energy
    return ["", _shortened(_ENERGIES, parts, lambda part: (part[0], si(part[1], "J", 4), f"{part[1] / whole:.1%}"))]


def _speeds(velocities: Sequence[float], which: str) -> str:
    return f"{len(velocities)}, {which} at {si(abs(velocities[0]), 'm/s', 4)}" if velocities else "0"
