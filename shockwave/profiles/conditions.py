"""The three conditions (3) on the areas of a shock profile, with their margins."""

from __future__ import annotations

from attrs import frozen

from shockwave.profiles.base import Areas

__all__ = ["TOLERANCE", "Condition", "conditions"]

#: Margins above -TOLERANCE * n count as met: every row of the paper's Table 2 meets one with equality.
TOLERANCE = 1e-9


@frozen
class Condition:
    """One inequality of (3).

    ``margin`` is its left side less its right side, in units of the rise time: negative where it fails,
    up to a tolerance of 1e-9 n. ``statement`` is the inequality.
    """

    name: str
    statement: str
    margin: float
    holds: bool


def conditions(areas: Areas, duration_ratio: float) -> tuple[Condition, ...]:
    """The three conditions (3), inclusive, with a tolerance.

    Parameters
    ----------
    areas : Areas
        a1 and a2 of the profile.
    duration_ratio : float
        n.
    """
    a1, a2 = areas.rise.value, areas.decay.value
    tolerance = TOLERANCE * duration_ratio + areas.rise.error + areas.decay.error
    margins = (
        ("decay-outweighs-rise", "a2 >= a1", a2 - a1),
        ("steep-rise", "a1 >= 1/2", a1 - 0.5),
        ("slow-decay", "a2 <= (n-1)/2", (duration_ratio - 1) / 2 - a2),
    )
    return tuple(Condition(name, text, margin, margin >= -tolerance) for name, text, margin in margins)
