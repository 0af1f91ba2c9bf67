"""The three conditions (3) on the areas of a shock profile, with their margins."""

from __future__ import annotations

from attrs import frozen

from shockwave.profiles.shock_profile import Areas

#: A condition holds if its margin is at least -TOLERANCE * n: each row of the paper's Table 2 has one margin of zero.
TOLERANCE = 1e-9


@frozen
class Condition:
    """One inequality of (3).

    ``statement`` is the inequality. ``margin`` is the difference of its two sides in units of the rise time, negative
    if the inequality is violated, and zero if the sides are equal within a tolerance of 1e-9 n; then it ``holds``.
    """

    name: str
    statement: str
    margin: float
    holds: bool


def evaluate_conditions(areas: Areas, duration_ratio: float) -> tuple[Condition, ...]:
    """Evaluate the three conditions (3), which include equality, with a tolerance.

    Parameters
    ----------
    areas : Areas
        Areas a1 and a2 of the profile.
    duration_ratio : float
        n, total duration over rise time.
    """
    a1, a2 = areas.rise.value, areas.decay.value
    tolerance = TOLERANCE * duration_ratio + areas.rise.error + areas.decay.error
    margins = (
        ("decay-outweighs-rise", "a2 >= a1", a2 - a1),
        ("steep-rise", "a1 >= 1/2", a1 - 0.5),
        ("slow-decay", "a2 <= (n-1)/2", (duration_ratio - 1) / 2 - a2),
    )
    return tuple(
        Condition(name, text, margin if abs(margin) > tolerance else 0.0, margin >= -tolerance)
        for name, text, margin in margins
    )
