"""The path of a granule that moves as prescribed, in scaled units, as that of a free granule under a force."""

from __future__ import annotations

from typing import Any

from attrs import frozen

from shockwave.engine.scaled_problem import ChainProblem
from shockwave.profiles.free_path import FreePath
from shockwave.scene.chain import Scales
from shockwave.scene.motion import Motion

# Degree of the polynomials of the displacement.
_DEGREE = 4


@frozen(eq=False)
class _Shape:
    """What a `ChainProblem` reads of a profile: knots in units of half the duration, and their path."""

    duration_ratio: float
    breakpoints: tuple[float, ...]
    path: FreePath

    def free_path(self) -> FreePath:
        return self.path


def problem_of(motion: Motion, scales: Scales) -> ChainProblem:
    """The acceleration of a motion, beyond its first velocity, as a force on a granule of unit mass."""
    course, speed, half = motion.course, motion.top_speed, motion.duration / 2
    first, edges = float(course(0.0, 1)), course.x / half
    path = FreePath.of_polynomials(
        edges,
        lambda s: (course(s * half) - first * s * half) / (speed * half),
        lambda s: (course(s * half, 1) - first) / speed,
        _DEGREE,
    )
    shape: Any = _Shape(2.0, tuple(edges.tolist()), path)
    time = half / scales.time
    return ChainProblem(shape, time, speed / scales.velocity / time)
