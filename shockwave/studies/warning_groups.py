"""Warnings of many simulations, grouped by kind."""

from __future__ import annotations

import re
from collections.abc import Iterable

from attrs import define, field

# A number, in which warnings of a kind differ, with its unit.
_NUMBER = re.compile(r"\d[\d.e+-]*( [a-zA-Z/]+)?")
# Most numbers of scenes in a sentence.
_MOST_LISTED = 5


@define
class WarningGroups:
    """Warnings of scenes that are added one after the other.

    Attributes
    ----------
    count : int
        Number of scenes.
    groups : dict
        First warning of each kind, and the numbers of the scenes that have one.
    """

    count: int = 0
    groups: dict[str, tuple[str, list[int]]] = field(factory=dict)

    def add(self, warnings: Iterable[str]) -> None:
        """Add the warnings of the next scene."""
        for kind, warning in {kind_of(warning): warning for warning in warnings}.items():
            self.groups.setdefault(kind, (warning, []))[1].append(self.count)
        self.count += 1

    def sentences(self, scenes: str = "scenes", besides: Iterable[str] = (), numbered: bool = False) -> tuple[str, ...]:
        """First warning of each kind, the most frequent first, with the number of scenes that have one.

        Parameters
        ----------
        scenes : str
            Name of the scenes.
        besides : iterable of str
            Warnings whose kinds are left out.
        numbered : bool
            Whether the first numbers of the scenes are stated; warnings of the same scenes are then joined.
        """
        others = set(map(kind_of, besides))
        groups = [group for kind, group in self.groups.items() if kind not in others]
        sentences = []
        if numbered:
            joined: dict[tuple[int, ...], list[str]] = {}
            for first, places in groups:
                joined.setdefault(tuple(places), []).append(first)
            groups = [(" ".join(warnings), list(places)) for places, warnings in joined.items()]
        for first, places in sorted(groups, key=lambda group: -len(group[1])):
            shown = ", ".join([*map(str, places[:_MOST_LISTED]), *["..."] * (len(places) > _MOST_LISTED)])
            numbers = f" ({shown})" if numbered else ""
            share = f"{len(places)} of {self.count} {scenes}{numbers}"
            sentences.append(f"In {f'all {scenes}' if len(places) == self.count else share}: {first}")
        return tuple(sentences)


def kind_of(warning: str) -> str:
    """A warning without its numbers, in which those of several scenes differ."""
    return _NUMBER.sub("", warning)
