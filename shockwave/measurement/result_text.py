"""A simulation's result as text for people."""

from __future__ import annotations

import math
from collections.abc import Iterator

from shockwave.measurement.result import MeasuredWave, Passage, SimulationResult
from shockwave.text import notes, si, table

_WAVES = ("peak force", "rel. error", "momentum", "energy", "speed", "width", "foot", "contact", "arrival")
_PASSAGES = ("contact", "arrival", "peak force", "rel. error", "from")


def result_text(result: SimulationResult) -> str:
    """The text that ``print`` shows."""
    lines = [*_primary(result), *_ends(result), *_waves(result)]
    return "\n".join(lines + notes(result.all_warnings))


def _primary(result: SimulationResult) -> Iterator[str]:
    of = f" of {result.scenario}" if result.scenario else ""
    yield f"simulation by {result.integrator} ({result.backend}){of}"
    yield from result.scene.lines()
    error = result.error_estimate
    digits = min(max(8, 2 - math.floor(math.log10(error))), 15)
    within = f"within {error:.0e} relative" if error < 1 else "(error unknown)"
    times = f"{result.amplification:.{digits}g} times the shock's"
    yield f"  peak force        {si(result.peak_force, 'N', digits)} {within}, {times}"
    defects = f"momentum defect {result.momentum_defect:.0e}, energy defect {result.energy_defect:.0e}"
    yield f"  applied momentum  {si(result.applied_momentum, 'N s')}, {defects}"


def _ends(result: SimulationResult) -> Iterator[str]:
    if result.options.waves != "train":
        return
    within = f"within {si(result.recoil_error, 'N s', 1)}, ejected granules: {result.ejected_granules}"
    yield f"  recoil            {si(result.recoil_momentum, 'N s')} {within}"
    spalls = result.spall_velocities
    if spalls is not None:
        fastest = f", the last one at {si(spalls[0], 'm/s')}" if spalls else ""
        yield f"  free end          granules that fly off: {len(spalls)}{fastest}"


def _waves(result: SimulationResult) -> Iterator[str]:
    # integrates the train, whose cost belongs to the line before
    waves = [wave for wave in result.waves if wave.error_estimate is not None] or list(result.waves[:1])
    unsettled = len(result.waves) - len(waves)
    cost = result.cost
    yield f"  cost              {cost.steps} steps, {cost.force_evaluations} force evaluations, {cost.seconds:.2g} s"
    yield ""
    yield table(_WAVES, map(_wave_row, waves))
    if unsettled:
        yield f"  and {unsettled} more that had not settled, in the JSON output alone"
    yield f"  (waves above {result.options.wave_threshold:g} of the primary; contacts are counted from 0;"
    yield "  rel. error: of the peak force; foot: force left between a wave and its neighbours over its peak,"
    yield "  an error of the other figures)"
    if result.passages:
        yield ""
        yield table(_PASSAGES, map(_passage_row, result.passages))
    if result.recording is not None:
        times = result.recording.times
        yield ""
        yield f"  recorded          {', '.join(result.options.record)}: {len(times)} samples to {si(times[-1], 's')}"


def _wave_row(wave: MeasuredWave) -> tuple[str, ...]:
    return (
        si(wave.peak_force, "N", 8),
        "not settled" if wave.error_estimate is None else f"{wave.error_estimate:.0e}",
        si(wave.momentum, "N s"),
        si(wave.energy, "J"),
        "-" if wave.speed is None else si(wave.speed, "m/s"),
        si(wave.width, "s"),
        f"{wave.foot:.0e}",
        str(wave.contact),
        si(wave.arrival_time, "s"),
    )


def _passage_row(passage: Passage) -> tuple[str, ...]:
    return (
        str(passage.contact),
        si(passage.arrival_time, "s", 8),
        si(passage.peak_force, "N", 8),
        f"{passage.error_estimate:.0e}",
        "exact wave" if passage.exact else "integrated",
    )
