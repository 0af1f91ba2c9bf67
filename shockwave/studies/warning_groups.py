"""Warnings of many simulations, grouped by kind."""

from __future__ import annotations

import re
from collections.abc import Iterable

from attrs import define, field

# A number, in which warnings of a kind differ, with its unit, and the place of first yield, which differs too.
_NUMBER = re.compile(r"(\d+(?:\.\d+)?(?:e[-+]?\d+)?)(?: ([a-zA-Z/]+))?")
_PLACE = re.compile(r"(?<=first yield), at contact .*?\)(?=\.)|(?<=at contact )\d+")
_UNIT = re.compile("([pnumkMG]?)(?:N|s|J|m|m/s|Pa|Hz)")
_FACTORS = {"p": 1e-12, "n": 1e-9, "u": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3, "M": 1e6, "G": 1e9}
# Most numbers of scenes in a sentence.
_MOST_LISTED = 5


@define
class _Group:
    """Warnings of one kind: that with the greatest value, its values and scene, and the scenes that have one."""

    warning: str
    values: tuple[float, ...]
    greatest: int
    places: list[int] = field(factory=list)
    varies: bool = False


@define
class WarningGroups:
    """Warnings of scenes that are added one after the other.

    Attributes
    ----------
    count : int
        Number of scenes.
    groups : dict
        The group of each kind of warning.
    """

    count: int = 0
    groups: dict[str, _Group] = field(factory=dict)

    def add(self, warnings: Iterable[str], number: int | None = None) -> None:
        """Add the warnings of the next scene; ``number`` is by default the number of scenes added before."""
        number = self.count if number is None else number
        for kind, warning in {kind_of_warning(warning): warning for warning in warnings}.items():
            values = _values_of(warning)
            group = self.groups.setdefault(kind, _Group(warning, values, number))
            group.places.append(number)
            group.varies |= values != group.values
            if values > group.values:
                group.warning, group.values, group.greatest = warning, values, number
        self.count += 1

    def sentences(self, scenes: str = "scenes", besides: Iterable[str] = (), numbered: bool = False) -> tuple[str, ...]:
        """Warning of each kind with the greatest value, the most frequent first, with the number of scenes.

        It is marked as the greatest where the numbers in the others differ.

        Parameters
        ----------
        scenes : str
            Name of the scenes.
        besides : iterable of str
            Warnings whose kinds are left out.
        numbered : bool
            Whether the first numbers of the scenes are stated; warnings of the same scenes are then joined.
        """
        others = set(map(kind_of_warning, besides))
        entries: list[tuple[list[str], _Group]] = []
        latest: dict[object, tuple[list[str], _Group]] = {}
        for kind, group in self.groups.items():
            key = tuple(group.places) if numbered else kind
            entry = latest.get(key)
            if kind in others:
                continue
            if entry is None or (group.varies and not (entry[1].varies and entry[1].greatest == group.greatest)):
                entry = latest[key] = ([], group)
                entries.append(entry)
            entry[0].append(group.warning)
        sentences = []
        for warnings, group in sorted(entries, key=lambda each: -len(each[1].places)):
            places = group.places
            shown = ", ".join([*map(str, places[:_MOST_LISTED]), *["..."] * (len(places) > _MOST_LISTED)])
            share = f"{len(places)} of {self.count} {scenes}{f' ({shown})' if numbered else ''}"
            where = f"all {scenes}" if len(places) == self.count else share
            if group.varies:
                where += (
                    f", greatest at {scenes.removesuffix('s')} {group.greatest}" if numbered else ", here the greatest"
                )
            sentences.append(f"In {where}: {' '.join(warnings)}")
        return tuple(sentences)


def kind_of_warning(warning: str) -> str:
    """A warning without its numbers and the place of first yield, in which those of several scenes differ."""
    return _NUMBER.sub("", _PLACE.sub("", warning))


def _values_of(warning: str) -> tuple[float, ...]:
    """The numbers in a warning, in SI units."""
    units = ((float(number), _UNIT.fullmatch(word)) for number, word in _NUMBER.findall(_PLACE.sub("", warning)))
    return tuple(number * (_FACTORS[unit[1]] if unit else 1.0) for number, unit in units)
