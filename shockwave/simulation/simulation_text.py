"""Text of the result of a simulation."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from shockwave.base.quantities import unit_of
from shockwave.base.result_tables import evenly
from shockwave.base.text import (
    Detail,
    brief,
    detail,
    facts,
    is_wide,
    notes,
    percent,
    round_digits,
    si,
    significant_digits,
    strong,
    table,
)
from shockwave.scene.force_limit import verdict_facts
from shockwave.scene.yielding import law_facts
from shockwave.simulation.result_parts import ContactPeak, MeasuredWave, Passage, SegmentEnergy, Transmitted
from shockwave.simulation.simulation_result import Simulation

_Item = TypeVar("_Item")
_CONTACTS = ("contact", "greatest force", "time", "error")
_ENERGIES = ("granules", "energy", "share")
# Largest number of rows of a table that is not wide; of more, those next to each end, and some between them.
_MOST_ROWS = 50
_AT_ENDS = 10
_BETWEEN = 12
# Digits of the times of peaks on chains without a steady leading wave.
_PEAK_TIME_DIGITS = 5
_SENSORS = ("sensor", "first peak", "time", "arrival", "width", "impulse", "speed")
_SPARE_SENSORS = ("time", "impulse")
_SPEEDS = "(speed: from the preceding sensor of its kind; none if merged or at an end)"
_WAVES = ("peak force", "error", "momentum", "energy", "speed", "width", "arrival", "contact", "residual")
_SPARE_WAVES = ("contact", "energy", "width", "residual")
_PASSAGES = ("contact", "arrival", "peak force", "error", "from")
# Least relative error that the digits of figures other than forces show: five digits.
_FINEST = 1e-4
_TIME_DIGITS = 4
# Later waves in the short text.
_FEW = 3


def simulation_text(result: Simulation) -> str:
    """The first number with its error estimate, waves or forces; on request balances, cost and scene."""
    return brief(head(result), result.warnings, lines(result), sensor_lines(result))


def head(result: Simulation) -> list[str]:
    """Lines of the peak force or the greatest force, the verdict, and the error of the law of the contacts."""
    name = f"{result.scenario}: " if result.scenario else ""
    return [strong(f"{name}{lead_text(result)}"), *facts([*verdict_facts(result), *law_facts(result.chain)])]


def lines(result: Simulation) -> list[str]:
    """Lines of waves and rebounding granules, or of the forces; on request balances, cost and scene."""
    return _lines_of_forces(result) if result.wave is None else _lines_of_waves(result)


def sensor_lines(result: Simulation) -> list[str]:
    """A row for each requested sensor, below the motion of a movable end."""
    if not result.sensors:
        return []
    place, peak, *others = _SENSORS
    peak = "peak - static" if result.chain.precompression or result.chain.gravity else peak
    rows = table((place, peak, *others), map(_sensor_row, result.sensors), _SPARE_SENSORS)
    is_partial = any(pulse.arrival is not None and pulse.speed is None for pulse in result.sensors[1:])
    return [*facts(_motion(result)), *rows.split("\n"), *[f"  {_SPEEDS}"] * is_partial]


def _lines_of_waves(result: Simulation) -> list[str]:
    leading = [("leading wave", peak_text(result))] if greatest_text(result) else []
    parts = facts([*leading, *answer(result)])
    if detail() >= Detail.EXPLAIN:
        parts += ["", wave_tables(result)]
    if detail() is Detail.VERBOSE:
        parts += ["", *facts([*details(result), *result.scene.summary().lines]), *notes(result.scene.notes)]
    elif detail() is Detail.SHORT and result.passages:
        parts += ["", *passage_table(result).split("\n")]
    return parts


def _lines_of_forces(result: Simulation) -> list[str]:
    parts = facts(answer(result))
    if detail() >= Detail.EXPLAIN or result.options.contacts:
        contacts = _short_table(_CONTACTS, result.contacts, lambda peak: _row(peak, place_of(result, peak.contact)))
        parts += ["", *contacts.split("\n")]
    if detail() is Detail.VERBOSE:
        parts += [*_energies(result), "", *facts([*details(result), *result.scene.summary().lines])]
        parts += notes(result.scene.notes)
    return parts


def lead_text(result: Simulation) -> str:
    """Peak force of the leading wave, or the greatest contact force of a finite chain if that differs."""
    if result.wave is None:
        top = result.greatest_force
        force, time, error = _row(top, "")[1:]
        place = place_of(result, top.contact)
        where = f"on the {result.chain.end_word}" if "(" in place else f"at contact {place}"
        return f"greatest force {force} {where}, {time}, estimated error {error}"
    return f"greatest force {greatest_text(result)}" if greatest_text(result) else f"peak force {peak_text(result)}"


def greatest_text(result: Simulation) -> str:
    """Greatest contact force of a finite chain with contact and time, if it is not the leading wave's; else empty."""
    return "" if result.chain.granules is None else _different(result)


def _different(result: Simulation) -> str:
    """Greatest contact force with contact and time; empty if it is not known or agrees with the leading wave.

    It is smaller only if the simulated time is too short for the leading wave.
    """
    top = result.greatest_force if result.options.waves == "train" else None
    error = 0.0 if top is None else top.error_estimate
    if top is None or abs(top.peak_force / result.peak_force - 1) <= error + result.error_estimate:
        return ""
    force, time = si(top.peak_force, "N", error=error), si(top.time, "s", _TIME_DIGITS)
    return f"{force} at contact {top.contact}, {time}, estimated error {error:.0e}"


def peak_text(result: Simulation) -> str:
    """The peak force of the leading wave with its error estimate."""
    error = result.error_estimate
    accuracy = f"estimated relative error {error:.0e}" if error < 1 else "error not known"
    return f"{si(result.peak_force, 'N', error=error)}, {accuracy}"


def answer(result: Simulation) -> Iterator[tuple[str, str]]:
    """Labels and texts of waves, or of forces on wall and striker; of rebounding granules and the free end."""
    return _answer_of_forces(result) if result.wave is None else _answer_of_waves(result)


def _answer_of_waves(result: Simulation) -> Iterator[tuple[str, str]]:
    digits = significant_digits(result.amplification, result.error_estimate)
    yield "amplification", f"{result.amplification:.{digits}g} times the shock's peak force"
    if result.options.waves != "train":
        return
    if result.chain.granules is None and (greatest := _different(result)):
        yield "greatest force", greatest
    count = len(result.waves)
    threshold = f"above {result.options.wave_threshold:g} of the leading wave"
    counted = f"{count} {'wave' if count == 1 else 'waves'} {threshold}"
    later = [si(wave.peak_force, "N", error=wave.error_estimate) for wave in result.waves[1:] if wave.error_estimate]
    counted += f"; the next {', '.join(later[:_FEW])}" if later else ""
    yield "waves", counted if result.train.is_integrated else "only the leading wave is known"
    ejected = result.ejected_granules
    granules = f"{ejected} granule" if ejected == 1 else f"{ejected} granules"
    known = result.recoil_error < result.applied_momentum
    yield "rebounding", f"{granules} ejected, momentum {_rebound(result)}" if known else "not known"
    spalls = result.spall_velocities
    if spalls is not None:
        fastest = f", the last granule at {si(spalls[0], 'm/s')}" if spalls else ""
        yield "free end", f"granules that fly off: {len(spalls)}{fastest}"


def _answer_of_forces(result: Simulation) -> Iterator[tuple[str, str]]:
    if result.transmitted is not None:
        force, time, error = _row(result.transmitted, "")[1:]
        text = f"{force} at {time}, estimated error {error}" if result.transmitted.peak_force else force
        yield f"{result.chain.end_word} force", text
        yield f"{result.chain.end_word} impulse", impulse_text(result.transmitted)
    if not result.sensors:
        yield from _motion(result)
    if result.restitution is not None:
        yield "restitution", f"{result.restitution:.5g} (of the striker)"
    if result.recoil_velocities is not None:
        yield "rebounding", f"granules that move backwards: {_speeds(result.recoil_velocities, 'the first')}"
    if result.spall_velocities is not None:
        yield "free end", f"granules that fly off: {_speeds(result.spall_velocities, 'the last granule')}"
    if result.yielding is not None:
        yield from result.yielding.facts()
    if result.chain.is_plastic:
        yield "plastic flow", _flow(result)
    arrival = result.arrival_time
    wave = "does not reach the end" if arrival is None else f"arrives at {si(arrival, 's', _PEAK_TIME_DIGITS)}"
    wave = "" if result.chain.count is None else f"; the leading wave {wave}"
    yield "simulated", f"to {si(result.end, 's', _PEAK_TIME_DIGITS)}{wave}"


def _motion(result: Simulation) -> Iterator[tuple[str, str]]:
    """Labels and texts of the greatest motion and force of a movable end: above the sensors, if there are any."""
    return result.structure.facts() if result.structure else iter(())


def dissipated_text(result: Simulation) -> str:
    """The dissipated energy, and its parts if there are several."""
    whole = result.dissipated.energy
    parts = {name: getattr(result.dissipated, name) for name in ("plastic", "damping", "end", "bar")}
    shown = ", ".join(f"{name} {si(value, 'J')}" for name, value in parts.items() if value)
    each = f": {shown}" if "," in shown else f", all {shown.split()[0]}"
    return f"{si(whole, 'J')} ({percent(whole / result.applied_energy)}){each}"


def _rebound(result: Simulation) -> str:
    momentum, error = result.recoil_momentum, result.recoil_error
    if error < abs(momentum):
        return f"{si(momentum, 'N s', error=error / abs(momentum))} +- {si(error, 'N s', 1)}"
    return f"below {si(error, 'N s', 1)}" if error else "0 N s"


def wave_tables(result: Simulation) -> str:
    """A row for each wave that has separated; below, the leading wave at the requested contacts."""
    waves = [wave for wave in result.waves if wave.error_estimate is not None] or list(result.waves[:1])
    unsettled = len(result.waves) - len(waves)
    parts = [table(_WAVES, map(_wave_row, waves), _SPARE_WAVES)]
    if unsettled:
        have = "wave that has" if unsettled == 1 else "waves that have"
        parts.append(f"  and {unsettled} {have} not separated; --json lists them")
    if result.passages:
        parts += ["", passage_table(result)]
    return "\n".join(parts)


def passage_table(result: Simulation) -> str:
    """A row for each requested contact."""
    return table(_PASSAGES, map(_passage_row, result.passages))


def details(result: Simulation) -> Iterator[tuple[str, str]]:
    """Labels and texts of the balances, the histories and the cost."""
    yield from balances(result)
    if result.recording is not None:
        times, sensors = result.recording.times, [sensor.name for sensor in result.options.sensors]
        yield (
            "recorded",
            f"{', '.join([*result.options.record, *sensors])}: {len(times)} samples to {si(times[-1], 's')}",
        )
    cost = result.cost
    yield "method", f"{result.integrator} ({result.backend})"
    yield "cost", f"{cost.steps} steps, {cost.force_evaluations} force evaluations, {round_digits(cost.seconds)} s"


def balances(result: Simulation) -> Iterator[tuple[str, str]]:
    """Labels and texts of momentum, energy and their balances."""
    momentum = si(result.applied_momentum, "N s")
    if result.wave is None:
        yield "applied", f"momentum {momentum}, energy {si(result.applied_energy, 'J')}"
    else:
        yield "applied momentum", momentum
        if result.yielding is not None:
            yield from result.yielding.facts()
    if result.dissipated is not None and result.dissipated.energy:
        yield "dissipated", dissipated_text(result)
    yield "balance", balance_text(result)


def balance_text(result: Simulation) -> str:
    """The defects of momentum and energy."""
    return f"momentum {result.momentum_defect:.0e}, energy {result.energy_defect:.0e} (relative defects)"


def _wave_row(wave: MeasuredWave) -> tuple[str, ...]:
    error = wave.error_estimate
    # what neighbours leave at a wave's ends is an error of its other figures
    others = 1.0 if error is None else max(error, wave.foot)
    return (
        si(wave.peak_force, "N", error=0.3 if error is None else error),
        "not settled" if error is None else f"{error:.0e}",
        *(_figure(wave, name, others) for name in ("momentum", "energy", "speed", "width", "arrival_time")),
        str(wave.contact),
        f"{wave.foot:.0e}",
    )


def _sensor_row(pulse: Any) -> tuple[str, ...]:
    names = ("peak", "time", "arrival", "width", "impulse", "speed")
    values = [(name, getattr(pulse, name)) for name in names]
    texts = ["-" if value is None else si(value, pulse.units[name], pulse.digits_of(name)) for name, value in values]
    merged = " (merged)" if pulse.merged else ""
    return (pulse.sensor.replace("_", " "), texts[0] + merged, *texts[1:])


def _figure(wave: MeasuredWave, name: str, error: float) -> str:
    value = getattr(wave, name)
    return "-" if value is None else si(value, unit_of(name), error=max(error, _FINEST))


def _passage_row(passage: Passage) -> tuple[str, ...]:
    error = passage.error_estimate
    return (
        str(passage.contact),
        si(passage.arrival_time, "s", error=error),
        si(passage.peak_force, "N", error=error),
        f"{error:.0e}",
        "exact wave" if passage.exact else "integrated",
    )


def impulse_text(wall: Transmitted) -> str:
    """The impulse on a wall, to five digits or to those that its error supports."""
    impulse = si(wall.impulse, "N s", min(5, significant_digits(wall.impulse, wall.impulse_error)))
    return impulse + " beyond the static force" * bool(wall.static_force)


def place_of(result: Simulation, contact: int) -> str:
    """The number of a contact, marked if it is with the wall or the bar."""
    is_at_end = result.chain.end and contact + 1 == result.scene.contact_count
    return f"{contact} ({result.chain.end_word})" if is_at_end else str(contact)


def span(segment: SegmentEnergy) -> str:
    """Numbers of the granules of a segment."""
    return f"{segment.first}" if segment.first == segment.last else f"{segment.first} to {segment.last}"


def choose_items(items: Sequence[_Item]) -> Sequence[_Item]:
    """All items if they are few or the screen is wide, else those next to the ends and evenly spaced ones between."""
    if is_wide() or len(items) <= _MOST_ROWS:
        return items
    between = items[_AT_ENDS:-_AT_ENDS]
    chosen = [between[index] for index in evenly(len(between), _BETWEEN)]
    return [*items[:_AT_ENDS], *chosen, *items[-_AT_ENDS:]]


def _short_table(header: Sequence[str], items: Sequence[_Item], row: Callable[[_Item], Sequence[str]]) -> str:
    """A table of the `choose_items` selection, and their number if some are omitted."""
    shown = choose_items(items)
    note = f"\n  ({len(shown)} of {len(items)} rows; --wide shows all)" if len(shown) < len(items) else ""
    return table(header, map(row, shown)) + note


def _flow(result: Simulation) -> str:
    """Number of yielded contacts, the largest residual overlap among those reported, and the dissipated energy."""
    count = 0 if result.yielding is None else result.yielding.yielded_contacts
    deepest = max(peak.residual_overlap for peak in result.contacts)
    share = result.dissipated.plastic / result.applied_energy
    return f"{count} contacts, residual overlap up to {si(deepest, 'm', 3)}, {percent(share)} of the energy"


def _row(peak: ContactPeak, place: str) -> tuple[str, ...]:
    if not peak.peak_force:
        return place, "no force", "-", "-"
    force = si(peak.peak_force, "N", error=peak.total_error)
    return place, force, si(peak.time, "s", _PEAK_TIME_DIGITS), f"{peak.error_estimate:.0e}"


def _energies(result: Simulation) -> list[str]:
    """A table of the segments and a movable wall, if there are several of them."""
    parts = [(span(segment), segment.energy) for segment in result.segments]
    if result.end_energy is not None:
        parts.append(("wall", result.end_energy))
    if len(parts) == 1:
        return []
    whole = result.applied_energy
    return ["", _short_table(_ENERGIES, parts, lambda part: (part[0], si(part[1], "J", 4), percent(part[1] / whole)))]


def _speeds(velocities: Sequence[float], which: str) -> str:
    return f"{len(velocities)}, {which} at {si(abs(velocities[0]), 'm/s', 4)}" if velocities else "0"
