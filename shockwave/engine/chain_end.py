"""Greatest displacement, acceleration and spring force of a movable end, with NumPy."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np

from shockwave.base.numerics import FloatArray
from shockwave.engine.chain_forces import Contacts, End
from shockwave.engine.chain_peaks import MOST_TURNS, NEAR
from shockwave.engine.cubic_interpolation import around_tops, top_between


class EndExtremes:
    """Greatest magnitudes and their times, which are those of a `Job`."""

    def __init__(self, contacts: Contacts) -> None:
        self.contacts, self.best = contacts, contacts.job.progress.extremes
        self.first = max(contacts.bodies - len(contacts.job.method.nodes) - 3, 0)

    def read(self, end: End, size: float) -> FloatArray:
        """Displacement, acceleration and spring force, and their changes in a step of this size, shape (2, 3)."""
        contacts, v, a = self.contacts, float(end.v[-2]), float(end.a[-2])
        spring = contacts.end_stiffness * v + contacts.end_damping * a
        jerk = float(contacts.inverse[-1]) * (float(end.slope[-2]) - spring)
        return np.array([[end.x[-2], a, end.f[-2]], [size * v, size * jerk, size * spring]])

    def update(self, start: End, finish: End, step: tuple[float, float], attempt: Callable[..., Any]) -> None:
        """Compare with the motion within a step with this time and size; ``attempt`` makes a part of it."""
        contacts, (time, size) = self.contacts, step
        if len(start.d) < contacts.bodies or math.isinf(self.best[0, 0]):  # there is none
            return
        before, after = self.read(start, size), self.read(finish, size)
        for i, side in product(range(3), (-1, 1)):
            values, rates = (side * np.array([[end[row, i]] for end in (before, after)]) for row in (0, 1))
            self.raise_to(i, float(values[0, 0]), time)
            self.raise_to(i, float(values[1, 0]), time + size)
            low, high, most = around_tops(values, rates)
            if not (low[2, 0] > 0 >= high[2, 0] and most[0] > max(self.best[0, i], values.max())):
                continue
            around, value, share, last = [low[:, 0].tolist(), high[:, 0].tolist()], 0.0, 0.0, -1.0
            for _ in range(MOST_TURNS):
                if abs(share - last) < NEAR:
                    break
                last, share = share, top_between(*around)
                at = time + share * size
                x, v, _impulses = attempt(start, share * size, at, self.first, contacts.bodies)
                value, rate = (side * self.read(contacts.end_of(x, v, at, contacts.bodies), size)[:, i]).tolist()
                around[rate <= 0] = [share, value, rate]
            self.raise_to(i, value, time + top_between(*around) * size)

    def raise_to(self, i: int, value: float, time: float) -> None:
        """Replace a smaller magnitude."""
        if value > self.best[0, i]:
            self.best[:, i] = value, time
