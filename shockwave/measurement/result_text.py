"""A simulation's result in words and tables."""

from __future__ import annotations

import math
from collections.abc import Iterator

from shockwave.measurement.result import MeasuredWave, SimulationResult
from shockwave.text import indent, notes, si, table

__all__ = ["result_text"]

_WAVES = ("peak force", "rel. error", "momentum", "energy", "speed", "width", "foot", "contact", "arrival")
_PASSAGES = ("contact", "arrival", "peak force", "rel. error", "from")


def result_text(result: SimulationResult) -> str:
    """What ``print`` shows."""
    lines = [*_head(result), *_ends(result), *_foot(result)]
    return "\n".join(lines + notes(result.all_warnings))


def _head(result: SimulationResult) -> Iterator[str]:
    yield f"simulation by {result.integrator} ({result.backend})" + (
        f" of {result.scenario}" if result.scenario else ""
    )
    yield from result.scene.lines()
    digits = min(max(8, 2 - math.floor(math.log10(result.error_estimate))), 15)
    known = (
        f"within {result.error_estimate:.0e} relative" if result.error_estimate < 1 else "(how far off is not known)"
    )
    yield (
        f"  peak force        {si(result.peak_force, 'N', digits)} {known}, "
        f"{result.amplification:.{digits}g} times the shock's"
    )
    yield (
        f"  applied momentum  {si(result.applied_momentum, 'N s')}, momentum defect {result.momentum_defect:.0e}, "
        f"energy defect {result.energy_defect:.0e}"
    )


def _ends(result: SimulationResult) -> Iterator[str]:
    if result.options.waves == "train":
        train = result.train
        yield (
            f"  recoil            {si(train.recoil_momentum, 'N s')} within {si(train.recoil_error, 'N s', 1)}, "
            f"ejected granules: {result.ejected_granules}"
        )
        if train.spall_velocities is not None:
            shown = ", ".join(si(velocity, "m/s") for velocity in train.spall_velocities[:3])
            yield f"  free end          granules that fly off: {len(train.spall_velocities)}" + (
                f", at {shown}{' ...' if len(train.spall_velocities) > 3 else ''}" if shown else ""
            )


def _foot(result: SimulationResult) -> Iterator[str]:
    # integrates the train, whose cost belongs to the line before
    waves = [wave for wave in result.waves if wave.error_estimate is not None] or list(result.waves[:1])
    unsettled = len(result.waves) - len(waves)
    cost = result.cost
    yield (f"  cost              {cost.steps} steps, {cost.force_evaluations} force evaluations, {cost.seconds:.2g} s")
    yield ""
    yield indent(table(_WAVES, (_row(wave) for wave in waves)))
    if unsettled:
        yield f"  and {unsettled} more that had not settled: their figures mean little, and are left to the JSON output"
    yield f"  (waves above {result.wave_threshold:g} of the primary; contacts are counted from 0;"
    yield "  rel. error: of the peak force; foot: force left between a wave and its neighbours over its peak,"
    yield "  an error of the other figures)"
    if result.passages:
        rows = (
            (
                str(passage.contact),
                si(passage.arrival_time, "s", 8),
                si(passage.peak_force, "N", 8),
                f"{passage.error_estimate:.0e}",
                "exact wave" if passage.exact else "integrated",
            )
            for passage in result.passages
        )
        yield ""
        yield indent(table(_PASSAGES, rows))
    if result.recording is not None:
        yield ""
        yield f"  recorded          {result.recording.summary}"


def _row(wave: MeasuredWave) -> tuple[str, ...]:
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
