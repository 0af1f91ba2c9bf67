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
    varying : set of str
        Kinds whose warnings differ in numbers.
    """

    count: int = 0
    groups: dict[str, tuple[str, list[int]]] = field(factory=dict)
    varying: set[str] = field(factory=set)

    def add(self, warnings: Iterable[str]) -> None:
        """Add the warnings of the next scene."""
        for kind, warning in {kind_of(warning): warning for warning in warnings}.items():
            first, places = self.groups.setdefault(kind, (warning, []))
            places.append(self.count)
            if warning != first:
                self.varying.add(kind)
        self.count += 1

    def sentences(self, scenes: str = "scenes", besides: Iterable[str] = (), numbered: bool = False) -> tuple[str, ...]:
        """First warning of each kind, the most frequent first, with the number of scenes that have one.

        It is marked as the first where the numbers in the others differ.

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
        joined: dict[tuple[object, ...], list[str]] = {}
        for kind in (kind for kind in self.groups if kind not in others):
            joined.setdefault(tuple(self.groups[kind][1]) if numbered else (kind,), []).append(kind)
        sentences = []
        for kinds in sorted(joined.values(), key=lambda kinds: -len(self.groups[kinds[0]][1])):
            places = self.groups[kinds[0]][1]
            shown = ", ".join([*map(str, places[:_MOST_LISTED]), *["..."] * (len(places) > _MOST_LISTED)])
            numbers = f" ({shown})" if numbered else ""
            share = f"{len(places)} of {self.count} {scenes}{numbers}"
            where = f"all {scenes}" if len(places) == self.count else share
            here = ", here the first" if self.varying.intersection(kinds) else ""
            sentences.append(f"In {where}{here}: {' '.join(self.groups[kind][0] for kind in kinds)}")
        return tuple(sentences)


def kind_of(warning: str) -> str:
    """A warning without its numbers, in which those of several scenes differ."""
    return _NUMBER.sub("", warning)
