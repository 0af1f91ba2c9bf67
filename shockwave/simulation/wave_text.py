"""Text of a simulation's result."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from shockwave.base.text import Detail, brief, detail, facts, notes, rounded, si, significant_digits, strong, table
from shockwave.scene.force_limit import verdict_facts
from shockwave.simulation.measured_wave import MeasuredWave, Passage
from shockwave.simulation.wave_result import SimulationResult

if TYPE_CHECKING:
    from shockwave.simulation.contact_result import ChainResult

_WAVES = ("peak force", "error", "momentum", "energy", "speed", "width", "arrival", "contact", "residual")
_SPARE_WAVES = ("contact", "energy", "width", "residual")
_PASSAGES = ("contact", "arrival", "peak force", "error", "from")
# Least relative error that the digits of figures other than forces show: five digits.
_FINEST = 1e-4
_TIME_DIGITS = 4
# Later waves in the short text.
_FEW = 3


def result_text(result: SimulationResult) -> str:
    """The peak force with its error estimate, waves and rebounding granules; on request balances, cost and scene."""
    return brief(result_head(result), result_limits(result), result_lines(result))


def result_head(result: SimulationResult) -> list[str]:
    """Lines of the peak force and the verdict."""
    name = f"{result.scenario}: " if result.scenario else ""
    return [strong(f"{name}{lead_text(result)}"), *facts(verdict_facts(result))]


def result_lines(result: SimulationResult) -> list[str]:
    """Lines of waves and rebounding granules; on request balances, cost and scene."""
    leading = [("leading wave", peak_text(result))] if greatest_text(result) else []
    lines = facts([*leading, *result_answer(result)])
    if detail() >= Detail.EXPLAIN:
        lines += ["", wave_tables(result)]
    if detail() is Detail.VERBOSE:
        lines += ["", *facts([*result_details(result), *result.scene.summary().facts()]), *notes(result.scene.notes)]
    elif detail() is Detail.SHORT and result.passages:
        lines += ["", *passage_table(result).split("\n")]
    return lines


def lead_text(result: SimulationResult) -> str:
    """Peak force of the leading wave, or the greatest contact force of a finite chain if that differs."""
    return f"greatest force {greatest_text(result)}" if greatest_text(result) else f"peak force {peak_text(result)}"


def greatest_text(result: SimulationResult) -> str:
    """Greatest contact force of a finite chain with contact and time, if it is not the leading wave's; else empty."""
    return "" if result.chain.granules is None else _different(result)


def _different(result: SimulationResult) -> str:
    """Greatest contact force with contact and time; empty if it is not known or agrees with the leading wave.

    It is smaller only if the simulated time is too short for the leading wave.
    """
    top = result.greatest_force if result.options.waves == "train" else None
    error = 0.0 if top is None else top.error_estimate
    if top is None or abs(top.peak_force / result.peak_force - 1) <= error + result.error_estimate:
        return ""
    force, time = si(top.peak_force, "N", error=error), si(top.time, "s", _TIME_DIGITS)
    return f"{force} at contact {top.contact}, {time}, estimated error {error:.0e}"


def peak_text(result: SimulationResult) -> str:
    """The peak force of the leading wave with its error estimate."""
    error = result.error_estimate
    accuracy = f"estimated relative error {error:.0e}" if error < 1 else "error not known"
    return f"{si(result.peak_force, 'N', error=error)}, {accuracy}"


def result_limits(result: SimulationResult | ChainResult) -> list[str]:
    """Warnings that limit the answer; notes on a record do not."""
    return [warning for warning in result.all_warnings if warning not in result.scene.notes]


def result_answer(result: SimulationResult) -> Iterator[tuple[str, str]]:
    """Labels and texts of amplification, waves, rebounding granules and the free end."""
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


def _rebound(result: SimulationResult) -> str:
    momentum, error = result.recoil_momentum, result.recoil_error
    if error < abs(momentum):
        return f"{si(momentum, 'N s', error=error / abs(momentum))} +- {si(error, 'N s', 1)}"
    return f"below {si(error, 'N s', 1)}" if error else "0 N s"


def wave_tables(result: SimulationResult) -> str:
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


def passage_table(result: SimulationResult) -> str:
    """A row for each requested contact."""
    return table(_PASSAGES, map(_passage_row, result.passages))


def result_details(result: SimulationResult) -> Iterator[tuple[str, str]]:
    """Labels and texts of the balances, the histories and the cost."""
    yield "applied momentum", si(result.applied_momentum, "N s")
    if result.yielding is not None:
        yield from result.yielding.facts()
    yield "balance", balance_text(result)
    yield from work_details(result)


def balance_text(result: SimulationResult | ChainResult) -> str:
    """The defects of momentum and energy."""
    return f"momentum {result.momentum_defect:.0e}, energy {result.energy_defect:.0e} (relative defects)"


def work_details(result: SimulationResult | ChainResult) -> Iterator[tuple[str, str]]:
    """Labels and texts of the histories and the cost."""
    if result.recording is not None:
        times = result.recording.times
        yield "recorded", f"{', '.join(result.options.record)}: {len(times)} samples to {si(times[-1], 's')}"
    cost = result.cost
    yield "method", f"{result.integrator} ({result.backend})"
    yield "cost", f"{cost.steps} steps, {cost.force_evaluations} force evaluations, {rounded(cost.seconds)} s"


def _wave_row(wave: MeasuredWave) -> tuple[str, ...]:
    error = wave.error_estimate
    # what neighbours leave at a wave's ends is an error of its other figures
    others = 1.0 if error is None else max(error, wave.foot)
    return (
        si(wave.peak_force, "N", error=0.3 if error is None else error),
        "not settled" if error is None else f"{error:.0e}",
        _figure(wave.momentum, "N s", others),
        _figure(wave.energy, "J", others),
        "-" if wave.speed is None else _figure(wave.speed, "m/s", others),
        _figure(wave.width, "s", others),
        _figure(wave.arrival_time, "s", others),
        str(wave.contact),
        f"{wave.foot:.0e}",
    )


def _figure(value: float, unit: str, error: float) -> str:
    return si(value, unit, error=max(error, _FINEST))


def _passage_row(passage: Passage) -> tuple[str, ...]:
    error = passage.error_estimate
    return (
        str(passage.contact),
        si(passage.arrival_time, "s", error=error),
        si(passage.peak_force, "N", error=error),
        f"{error:.0e}",
        "exact wave" if passage.exact else "integrated",
    )
