"""Text of the result of a simulation of a chain beyond equal spheres."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeVar

from shockwave.measurement.chain_result import ChainResult, SegmentEnergy
from shockwave.measurement.contact_peaks import ContactPeak
from shockwave.text import facts, is_wide, limits, notes, si, strong, table

_Item = TypeVar("_Item")
_CONTACTS = ("contact", "greatest force", "time", "error")
_SEGMENTS = ("granules", "energy", "share")
# Most rows of a table that is not wide.
_MOST_ROWS = 16
_TIME_DIGITS = 5
_ENERGY_DIGITS = 4


def chain_text(result: ChainResult) -> str:
    """The greatest force with its place, time and error, the force on the wall, the contacts, balances and cost."""
    name = f"{result.scenario}: " if result.scenario else ""
    lines = [
        strong(f"{name}{chain_lead(result)}"),
        *limits(chain_limits(result)),
        *facts(chain_answer(result)),
        "",
        contact_table(result),
        "",
        *facts([*chain_details(result), *result.scene.facts()]),
        *notes(result.scene.notes),
    ]
    return "\n".join(lines)


def chain_lead(result: ChainResult) -> str:
    """Greatest force with its contact, time and error estimate."""
    top = result.greatest_force
    return (
        f"greatest force {_force(top)} {_place(result, top.contact)}, {si(top.time, 's', _TIME_DIGITS)}, "
        f"estimated error {top.error_estimate:.0e}"
    )


def chain_limits(result: ChainResult) -> list[str]:
    """Warnings that limit the answer; notes on a record do not."""
    return [warning for warning in result.all_warnings if warning not in result.scene.notes]


def chain_answer(result: ChainResult) -> Iterator[tuple[str, str]]:
    """Labels and texts of the force on the wall, the granules that fly off, the striker and the energies."""
    wall = result.transmitted
    if wall is not None:
        force = si(wall.peak_force, "N", error=wall.error_estimate)
        at = f" at {si(wall.time, 's', _TIME_DIGITS)}, estimated error {wall.error_estimate:.0e}"
        yield "wall force", force + (at if wall.peak_force else "")
        yield "wall impulse", si(wall.impulse, "N s")
    if result.restitution is not None:
        yield "restitution", f"{result.restitution:.5g} (of the striker)"
    if result.recoil_velocities is not None:
        count = len(result.recoil_velocities)
        fastest = f", the first at {si(-result.recoil_velocities[0], 'm/s', 4)}" if count else ""
        yield "rebounding", f"granules that fly backwards: {count}{fastest}"
    if result.spall_velocities is not None:
        count = len(result.spall_velocities)
        fastest = f", the last granule at {si(result.spall_velocities[0], 'm/s', 4)}" if count else ""
        yield "free end", f"granules that fly off: {count}{fastest}"
    if result.yielding is not None:
        ratio = result.yielding.peak_ratio
        force = si(result.yielding.first_yield_force, "N", 4)
        yield "first yield", f"at {force}; the greatest ratio of a peak force to it is {ratio:.4g}"
    arrival = "does not reach the end" if result.arrival_time is None else f"arrives at {_time(result.arrival_time)}"
    yield "simulated", f"to {_time(result.end)}; the leading wave {arrival}"


def contact_table(result: ChainResult) -> str:
    """A row for each reported contact, or for some on a screen that is not wide; then the energies of the segments."""
    peaks = result.contacts
    shown = chosen(peaks)
    lines = [table(_CONTACTS, [_row(result, peak) for peak in shown])]
    if len(shown) < len(peaks):
        lines.append(f"  ({len(shown)} of {len(peaks)} contacts; --wide shows all)")
    if len(result.segments) > 1 or result.end_energy is not None:
        lines += ["", _segment_table(result)]
    return "\n".join(lines)


def _segment_table(result: ChainResult) -> str:
    shown = chosen(result.segments)
    energies = [(span(segment), segment.energy) for segment in shown]
    if result.end_energy is not None:
        energies.append(("wall", result.end_energy))
    rows = [
        (name, si(energy, "J", _ENERGY_DIGITS), f"{energy / result.applied_energy:.1%}") for name, energy in energies
    ]
    lines = [table(_SEGMENTS, rows)]
    if len(shown) < len(result.segments):
        lines.append(f"  ({len(shown)} of {len(result.segments)} segments; --wide shows all)")
    return "\n".join(lines)


def span(segment: SegmentEnergy) -> str:
    """Numbers of the granules of a segment."""
    return f"{segment.first}" if segment.first == segment.last else f"{segment.first} to {segment.last}"


def chain_balances(result: ChainResult) -> Iterator[tuple[str, str]]:
    """Labels and texts of momentum and energy."""
    yield "applied", f"momentum {si(result.applied_momentum, 'N s')}, energy {si(result.applied_energy, 'J')}"
    if result.dissipated_energy:
        share = result.dissipated_energy / result.applied_energy
        yield "dissipated", f"{si(result.dissipated_energy, 'J')} ({share:.1%})"
    balance = f"momentum {result.momentum_defect:.0e}, energy {result.energy_defect:.0e} (relative defects)"
    yield "balance", balance


def chain_details(result: ChainResult) -> Iterator[tuple[str, str]]:
    """Labels and texts of the balances, the histories and the cost."""
    yield from chain_balances(result)
    if result.recording is not None:
        times = result.recording.times
        yield "recorded", f"{', '.join(result.options.record)}: {len(times)} samples to {si(times[-1], 's')}"
    cost = result.cost
    yield "method", f"{result.integrator} ({result.backend})"
    yield "cost", f"{cost.steps} steps, {cost.force_evaluations} force evaluations, {cost.seconds:.2g} s"


def chosen(items: Sequence[_Item]) -> Sequence[_Item]:
    """All items on a wide screen, else the first, the last, and evenly chosen ones between them."""
    last = len(items) - 1
    if is_wide() or last < _MOST_ROWS:
        return items
    return [items[round(row * last / (_MOST_ROWS - 1))] for row in range(_MOST_ROWS)]


def _row(result: ChainResult, peak: ContactPeak) -> tuple[str, ...]:
    if not peak.peak_force:
        return (_name(result, peak.contact), "stays open", "-", "-")
    return (_name(result, peak.contact), _force(peak), _time(peak.time), f"{peak.error_estimate:.0e}")


def _name(result: ChainResult, contact: int) -> str:
    return f"{contact} (wall)" if result.transmitted and contact == result.contact_count - 1 else str(contact)


def _place(result: ChainResult, contact: int) -> str:
    at_wall = result.transmitted is not None and contact == result.contact_count - 1
    return "on the wall" if at_wall else f"at contact {contact}"


def _force(peak: ContactPeak) -> str:
    return si(peak.peak_force, "N", error=peak.error_estimate)


def _time(time: float) -> str:
    return si(time, "s", _TIME_DIGITS)
