"""Motion of a movable end of a chain, with bounds of what follows the simulated time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from attrs import frozen

from shockwave.base.text import si
from shockwave.engine.mixed_chain_problem import Motion
from shockwave.scene.chain_end import Wall
from shockwave.scene.force_limit import LeavingForce
from shockwave.simulation.contact_setup import ChainSetup
from shockwave.simulation.convergence_runs import Runs
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
        return cls(wall, runs, _structure(runs), _later_force(runs.case, runs.motion))

    def leaving(self, arrived: bool) -> LeavingForce | None:
        """The force on the ground, if there is a spring or a dashpot; ``arrived``: whether the wave has arrived."""
        return self.structure.leaving(arrived, self.later) if self.wall.stiffness or self.wall.damping else None

    def warnings(self) -> Iterator[str]:
        """Note on a wall that is integrated as a fixed one; warning of a greater spring force later."""
        if not self.runs.case.assembly.movable_end:
            yield "The wall is integrated as a fixed one: its spring or dashpot holds it to rtol/100 of the overlap."
        leaving = self.leaving(True)
        if leaving and leaving.high is not None and self.later > leaving.high and self.runs.motion.arrival is not None:
            most = f", to at most {si(self.later, 'N', 3)}" if self.later < math.inf else ""
            rate = math.sqrt(self.wall.stiffness / (self.wall.mass or 1.0))
            period = f"; half a period of wall and spring is {si(math.pi / rate, 's', 2)}" if rate else ""
            yield f"The spring force may still grow after the simulated time{most}{period} {self.runs.case.advice}."


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


def _later_force(case: ChainSetup, motion: Motion) -> float:
    """Bound of the spring force after the end of the simulated time [N]; infinite where none is known.

    The greatest k x + c v for an energy E = k x^2/2 + M v^2/2 is sqrt(2 E (k + c^2/M)). Bodies that fly away from the
    wall bring none.
    """
    assembly, force, x, v = case.assembly, case.assembly.force, motion.x, motion.v
    if not assembly.movable_end:
        return 0.0
    if assembly.law is not None or assembly.weight or (force is not None and motion.end < force.duration):
        return math.inf
    gaps = x[1:] - x[:-1] - assembly.overlaps
    away = (gaps >= 0) & (v[:-1] <= v[1:]) & (v[:-1] <= 0) & (not assembly.static_forces.any())
    first = int(np.argmin(np.append(away, False)))
    energy = math.fsum(motion.kinetic[first:]) + math.fsum(motion.potential) + motion.end_energy
    stiffness = assembly.end_stiffness + assembly.end_damping**2 * float(assembly.inverse_masses[-1])
    return float(case.scales.force * math.sqrt(2 * energy * stiffness))
