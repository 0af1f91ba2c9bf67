"""Motion of a movable end, and the force of its spring."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from attrs import frozen

from shockwave.base.text import round_bound, si
from shockwave.scene.chain_end import Wall
from shockwave.scene.force_limit import GROWTH, LeavingForce
from shockwave.simulation.convergence_runs import Runs
from shockwave.simulation.later_forces import advice, later_spring_force
from shockwave.simulation.result_parts import Structure

_NAMES = ("peak_displacement", "peak_acceleration", "peak_spring_force")


@frozen
class MovableEnd:
    """A movable end, its greatest motion, and a bound of its spring force after the simulated time [N]."""

    wall: Wall
    runs: Runs
    structure: Structure
    later: float

    @classmethod
    def of(cls, runs: Runs) -> MovableEnd | None:
        """The end of a chain; None if it is not movable."""
        wall = runs.case.layout.wall
        if wall is None or wall.mass is None:
            return None
        return cls(wall, runs, _structure(runs), later_spring_force(runs.case, runs.motion))

    def leaving(self, arrived: bool) -> LeavingForce | None:
        """The force on the ground, if there is a spring or a dashpot; ``arrived``: whether the wave has arrived."""
        return self.structure.leaving(arrived, self.later) if self.wall.stiffness or self.wall.damping else None

    def warnings(self) -> Iterator[str]:
        """Note on a wall that is integrated as a fixed one; warning of a greater spring force later."""
        if not self.runs.case.assembly.movable_end:
            yield "The wall is integrated as a fixed one: its motion is below rtol/100 of the overlap."
        leaving = self.leaving(True)
        if leaving and leaving.high is not None and self.later > leaving.high and self.runs.motion.arrival is not None:
            most = f", to at most {si(round_bound(self.later, up=True), 'N', 3)}" if self.later < math.inf else ""
            rate = math.sqrt(self.wall.stiffness / (self.wall.mass or 1.0))
            period = f"; half a period of wall and spring is {si(math.pi / rate, 's', 2)}" if rate else ""
            yield f"{GROWTH} after the simulated time{most}{period} {advice(self.runs.case, self.runs.motion)}."


def _structure(runs: Runs) -> Structure:
    """Motion of a movable end; of one that is integrated as a fixed wall, only the force that it passes on."""
    scales, peak = runs.case.scales, runs.peak(-1)
    if not runs.case.assembly.movable_end:
        force = peak.peak_force - peak.static_force, peak.time, peak.error_estimate
        rows: Any = (None,) * 3, (None,) * 3, force
    else:
        units = scales.energy / scales.force, scales.force / scales.mass, scales.force
        values, times = runs.motion.extremes
        rows = zip((values * units).tolist(), (times * scales.time).tolist(), runs.end_errors.tolist(), strict=True)
    figures: dict[str, Any] = {}
    for name, (value, time, error) in zip(_NAMES, rows, strict=True):
        figures |= {name: value, f"{name}_time": time, f"{name}_error": error}
    return Structure(**figures)
