"""Sweeps: the block of a scenario that stands for many scenes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Literal

import numpy as np
from attrs import define, evolve, field, frozen

from shockwave.chain.material import Material
from shockwave.errors import InvalidValueError, PluginError, UnknownNameError
from shockwave.fields import Quantity, text_of
from shockwave.registry import find, load
from shockwave.scenario.fault_collector import FaultCollector
from shockwave.scenario.keys import BLOCKS, Key, keys_of
from shockwave.scenario.variable import Variable, variable
from shockwave.scenario.yaml_document import Document, Steps

__all__ = ["SWEEP", "Axis", "Run", "Sweep", "beginnings", "first", "read"]

Run = Literal["predict", "simulate", "compare"]
_MOST_POINTS = 10**7
_MOST_VALUES = 10**6
# So many points, out of all, are tried until one has a scene.
_MOST_TRIES = 100
_LENGTH = Quantity("", "number of values", at_least=1, at_most=_MOST_VALUES, whole=True)
_SPACINGS: dict[str, Callable[[float, float, int], np.ndarray]] = {"linspace": np.linspace, "logspace": np.geomspace}
_VALUES = "must be a list of values, or a mapping {linspace: [first, last, number]} or {logspace: ...}"

#: Keys of the block.
SWEEP = (
    Key("run", annotation=Run, meaning="what is done at every point; left out, what the scenario has a block for"),
    Key("grid", meaning="dotted names and their values: every value with every other"),
    Key("zip", meaning="dotted names and as many values each: the first with the first, and so on"),
    Key("points", meaning="a list of mappings of dotted names to one value each"),
)


@frozen
class Axis:
    """Variables that go through their values together.

    Attributes
    ----------
    variables : tuple of Variable
        One, unless it comes from ``zip`` or ``points``.
    values : tuple of tuple
        For each position the values of the variables, numbers in SI units.
    """

    variables: tuple[Variable, ...]
    values: tuple[tuple[Any, ...], ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Dotted names of the variables."""
        return tuple(variable.name for variable in self.variables)

    def __len__(self) -> int:
        return len(self.values)


@frozen
class Sweep:
    """Many scenes: the product of axes, of which the last one is gone through first.

    Attributes
    ----------
    run : "predict", "simulate" or "compare"
        What is done at every point.
    axes : tuple of Axis
        In the order of the file.
    """

    run: Run
    axes: tuple[Axis, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of values along the axes."""
        return tuple(len(axis) for axis in self.axes)

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Of all axes."""
        return tuple(variable for axis in self.axes for variable in axis.variables)

    def __len__(self) -> int:
        return math.prod(self.shape)

    def point(self, index: int) -> dict[str, Any]:
        """Dotted names and values of a point, counted from 0."""
        places = []
        for length in reversed(self.shape):
            index, place = divmod(index, length)
            places.append(place)
        pairs = zip(self.axes, reversed(places), strict=True)
        return {name: value for axis, at in pairs for name, value in zip(axis.names, axis.values[at], strict=True)}


# ---------------------------------------------------------------- the block


def read(collector: FaultCollector, data: Mapping[str, Any]) -> Sweep | None:
    """The block ``sweep`` of the document ``data``, whose faults ``collector`` gets; None if there are any."""
    given = data["sweep"]
    before = len(collector.faults)
    values, _ = collector.values(("sweep",), given, SWEEP)
    if not isinstance(given, dict):
        return None
    reading = _Reading(collector, data, [name for of, name in _named(given) if of == "shock.profile"])
    parts = {"grid": reading.grid, "zip": reading.zip, "points": reading.points}
    axes = [axis for part in given if part in parts for axis in parts[part](given[part])]
    count = math.prod(len(axis) for axis in axes)
    if len(collector.faults) > before or any(path[:1] == ("sweep",) for path in collector.document.unreadable):
        return None
    if not axes or count > _MOST_POINTS:
        problem = f"must have a grid, a zip or points, of 1 to {_MOST_POINTS:g} scenes in all"
        reading.add((), f"{problem} (got {count if axes else 'nothing'})")
        return None
    return Sweep(values.get("run") or _run(data), tuple(axes))


def _run(data: Mapping[str, Any]) -> Run:
    """What the scenario has a block for: one of the two, or else both side by side."""
    predict, simulate = (data.get(name) is not None for name in ("predict", "simulate"))
    return "compare" if predict == simulate else "predict" if predict else "simulate"


def _named(block: Any) -> Iterator[tuple[str, Any]]:
    """Every name in the block with every value, whether there is such a thing or not."""
    parts = [block.get("grid"), block.get("zip"), *_listed(block.get("points"))] if isinstance(block, dict) else []
    for part in parts:
        for name, values in part.items() if isinstance(part, dict) else ():
            yield from ((name, value) for value in _listed(values))


def _listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


@define
class _Reading:
    """Reads the parts of the block; what is wrong with them goes to ``collector``."""

    collector: FaultCollector
    data: Mapping[str, Any]
    profiles: list[Any]
    _seen: set[str] = field(factory=set)

    def add(self, steps: Steps, problem: str, at_key: bool = False) -> None:
        """Add a fault below the block."""
        self.collector.add(("sweep", *steps), problem, at_key)

    def grid(self, given: Any) -> list[Axis]:
        """An axis for each name."""
        pairs = self._pairs("grid", given)
        return [Axis((of,), tuple((value,) for value in values)) for of, values in pairs]

    def zip(self, given: Any) -> list[Axis]:
        """One axis for all names."""
        pairs = self._pairs("zip", given)
        lengths = {of.name: len(values) for of, values in pairs}
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{length} of {name}" for name, length in lengths.items())
            self.add(("zip",), f"must have as many values of each (got {listed})")
        elif pairs:
            variables, columns = zip(*pairs, strict=True)
            return [Axis(variables, tuple(zip(*columns, strict=True)))]
        return []

    def points(self, given: Any) -> list[Axis]:
        """One axis of points."""
        if not isinstance(given, list) or not given or not all(isinstance(point, dict) and point for point in given):
            self.add(("points",), f"must be a list of mappings of dotted names to values (got {text_of(given)})")
            return []
        found = {name: self._variable(("points", 0), name) for name in given[0]}
        variables = [of for of in found.values() if of is not None]
        rows: list[tuple[Any, ...]] = []
        for index, point in enumerate(given):
            if point.keys() == found.keys():
                rows.append(tuple(self._value(("points", index, of.name), of, point[of.name]) for of in variables))
            else:
                rule = f"must give {', '.join(found)}, as the first point does"
                self.add(("points", index), f"{rule} (got {', '.join(point)})")
        return [Axis(tuple(variables), tuple(rows))]

    def _pairs(self, part: str, given: Any) -> list[tuple[Variable, tuple[Any, ...]]]:
        if not isinstance(given, dict) or not given:
            self.add((part,), f"must be a mapping of dotted names to values (got {text_of(given)})")
            return []
        found = ((name, self._variable((part,), name), values) for name, values in given.items())
        return [(of, self._values((part, name), of, values)) for name, of, values in found if of is not None]

    def _variable(self, steps: Steps, name: str) -> Variable | None:
        try:
            found = variable(name, self.data, self.profiles)
        except InvalidValueError as error:
            self.add((*steps, name), error.faults[0].problem, at_key=True)
            return None
        if name in self._seen:
            self.add((*steps, name), "must be varied once (got it again; delete one)", at_key=True)
            return None
        self._seen.add(name)
        return found

    def _values(self, steps: Steps, of: Variable, given: Any) -> tuple[Any, ...]:
        """The values that ``given`` stands for; none if something is wrong with them."""
        if isinstance(given, list):
            if not given or len(given) > _MOST_VALUES:
                self.add(steps, f"must be 1 to {_MOST_VALUES} values (got {len(given)})")
            return tuple(self._value((*steps, index), of, one) for index, one in enumerate(given))
        kind = next(iter(given)) if isinstance(given, dict) and len(given) == 1 else None
        parts = given[kind] if kind in _SPACINGS else None
        if kind is None or not isinstance(parts, list) or len(parts) != 3:
            self.add(steps, f"{_VALUES} (got {text_of(given)})")
            return ()
        if of.unit is None:
            self.add(steps, f"must be a list, as not every value of it is a number (got {text_of(given)})")
            return ()
        return self._spaced((*steps, kind), kind, of, parts)

    def _value(self, steps: Steps, of: Variable, given: Any) -> Any:
        if of.name == "chain.material" and not isinstance(given, str):
            self.collector.values(("sweep", *steps), given, keys_of(Material))
            return given
        try:
            if of.key.kind and isinstance(given, str):
                find(of.key.kind, given)
            return of.value(given)
        except InvalidValueError as error:
            for fault in error.faults:
                self.add(steps, fault.problem)
        except UnknownNameError as error:
            self.collector.blame(("sweep", *steps), error)
        return None

    def _spaced(self, steps: Steps, kind: str, of: Variable, parts: list[Any]) -> tuple[Any, ...]:
        for index in range(2):
            if parts[index] is None:
                self.add((*steps, index), "must be a number (got nothing)")
        first, last = (self._value((*steps, index), of, parts[index]) for index in range(2))
        if problem := _LENGTH.problem(parts[2]):
            self.add((*steps, 2), problem)
            return ()
        if first is None or last is None:
            return ()
        if kind == "logspace" and not first * last > 0:
            self.add(steps, f"must have ends of the same sign, other than 0 (got {text_of(parts)}; use linspace)")
            return ()
        # where both ends are in its range, so is what is between
        found: list[float] = _SPACINGS[kind](first, last, int(parts[2])).tolist()
        if not of.whole:
            return tuple(found)
        if any(value != int(value) for value in found):
            self.add(steps, f"must give whole numbers (got {text_of(parts)}; list them)")
        return tuple(int(value) for value in found)


# ---------------------------------------------------------------- the first scene


def beginnings(sweep: Sweep | None) -> range:
    """The points to begin with, one after the other until one has a scene."""
    count = len(sweep) if sweep is not None else 1
    return range(0, count, -(-count // _MOST_TRIES))


def first(document: Document, sweep: Sweep | None, index: int = 0) -> Document:
    """One of the scenes that the document stands for, as one that stands for itself."""
    rest = {name: value for name, value in document.data.items() if name not in ("sweep", "uncertainty")}
    if sweep is None:
        # what a sweep with faults would have brought is not missing
        brought = {tuple(str(name).split(".")) for name, _ in _named(document.data.get("sweep"))}
        return evolve(document, data=rest, unreadable=document.unreadable | brought)
    document = evolve(document, data=rest)
    # a material first, for what is swept of it
    pairs = sorted(sweep.point(index).items(), key=lambda pair: pair[0].count("."))
    values: dict[Steps, Any] = {tuple(name.split(".")): value for name, value in pairs}
    made = _material(document, values)
    return document.having(made | values | made, document.place(("sweep",), key=True))


def _material(document: Document, values: Mapping[Steps, Any]) -> dict[Steps, Any]:
    """The material as a mapping with a place for ``values``, if it is called by its name and some are of it."""
    path: Steps = ("chain", "material")
    chain = document.data.get("chain")
    given = values.get(path, chain.get("material") if isinstance(chain, dict) else None)
    if not isinstance(given, str) or not any(path == steps[:2] and len(steps) > 2 for steps in values):
        return {}
    try:
        material = load("materials", given)
    except (PluginError, UnknownNameError):  # reported where the material is built
        return {}
    return {path: {key.name: getattr(material, key.name) for key in BLOCKS["chain.material"]}}
