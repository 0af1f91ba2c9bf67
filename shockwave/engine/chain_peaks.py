"""The overlap of a contact within a step as a polynomial, and the time at which the slope of its force vanishes."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from attrs import frozen

from shockwave.engine.chain_forces import Contacts, End

#: Largest number of iterations of a search for a maximum.
MOST_TURNS = 30
#: Error of the time of a maximum, relative to the step, that a last correction removes.
NEAR = 1e-5
#: First change of that time in the search, relative to the step.
NUDGE = 1e-3


@frozen(eq=False)
class Overlap:
    """Change of the overlap of contact j within a step of a ``size``.

    The polynomial of degree 5 with the ``coefficients`` has the overlap and its derivatives at both ends of the step.
    """

    contacts: Contacts
    j: int
    time: float
    size: float
    start: End
    finish: End
    coefficients: tuple[float, ...]

    @classmethod
    def between(cls, contacts: Contacts, start: End, finish: End, time: float, size: float, j: int) -> Overlap:
        """The polynomial of a step that begins at ``time``."""
        ends = (start, time), (finish, time + size)
        a0, a1 = (size * size * float(contacts.closing_accelerations(end.a[j : j + 2], at, j)[0]) for end, at in ends)
        w0 = size * float(start.w[j])
        u = float(finish.u[j]) - float(start.u[j]) - w0 - a0 / 2
        w, a = size * float(finish.w[j]) - w0 - a0, a1 - a0
        higher = 10 * u - 4 * w + a / 2, -15 * u + 7 * w - a, 6 * u - 3 * w + a / 2
        return cls(contacts, j, time, size, start, finish, (float(start.u[j]), w0, a0 / 2, *higher))

    def change(self, s: float) -> float:
        """Change of the overlap at a fraction ``s`` of the step."""
        c = self.coefficients
        return c[0] + s * (c[1] + s * (c[2] + s * (c[3] + s * (c[4] + s * c[5]))))

    def motion(self, s: float) -> tuple[float, float, float]:
        """Overlap, closing velocity and acceleration at a fraction ``s`` of the step."""
        c, size = self.coefficients, self.size
        a = 2 * c[2] + s * (6 * c[3] + s * (12 * c[4] + s * 20 * c[5]))
        return self.change(s) + float(self.contacts.base[self.j]), self.closing_velocity(s) / size, a / (size * size)

    def closing_velocity(self, s: float) -> float:
        """Closing velocity at a fraction ``s`` of the step, in units of it."""
        c = self.coefficients
        return c[1] + s * (2 * c[2] + s * (3 * c[3] + s * (4 * c[4] + s * 5 * c[5])))

    def slope(self, s: float) -> float:
        """Change of the force per step at a fraction ``s`` of it."""
        d, w, a = np.array(self.motion(s))[:, None]
        return self.size * float(self.contacts.rates(d, w, a, self.j)[0])


def vanish(value: Callable[[float], float], low: float, high: float, at: float) -> tuple[float, float]:
    """Fraction of the step at which a number vanishes, and its derivative there.

    It is positive at ``low`` and not at ``high``; ``at`` is a first estimate.
    """
    bend = last = before = 0.0
    for turn in range(MOST_TURNS):
        here = value(at)
        low, high = (at, high) if here > 0 else (low, at)
        if turn and at != before:
            bend = (here - last) / (at - before)
        following = at - here / bend if bend < 0 else at + NUDGE * (1 if here > 0 else -1)
        if not low < following < high or (turn and not bend < 0):
            following = 0.5 * (low + high)
        if turn and abs(following - at) < NEAR:
            return following, bend
        before, last, at = at, here, following
    return at, bend


def first_negative(b: list[float], value: Callable[[float], float], low: float, high: float) -> float:
    """First place between low and high where a polynomial with these Bernstein coefficients is negative.

    The polynomial is divided in halves until it changes its sign once, as the ``value`` does; the result is 2 if it is
    not negative.
    """
    changes = (b[0] < 0) + sum((before < 0) != (after < 0) for before, after in pairwise(b))
    if not changes:
        return 2.0
    if b[0] > 0 and changes == 1:
        return vanish(value, low, high, low + (high - low) * (b[0] / (b[0] - b[-1])))[0]
    if high - low < NEAR:
        return low
    middle, left, right = 0.5 * (low + high), [], list(b)
    for count in range(len(b), 0, -1):
        left.append(right[0])
        for k in range(count - 1):
            right[k] = 0.5 * (right[k] + right[k + 1])
    at = first_negative(left, value, low, middle)
    return at if at <= 1 else first_negative(right, value, middle, high)
