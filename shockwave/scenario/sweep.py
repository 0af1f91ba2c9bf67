"""Sweeps: the block of a scenario that stands for many scenes."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Literal

import numpy as np
from attrs import define, evolve, frozen

from shockwave.chain.material import Material
from shockwave.errors import InvalidValueError, PluginError, UnknownNameError
from shockwave.fields import Quantity, text_of
from shockwave.registry import find, load
from shockwave.scenario.blocks import Key, keys_of
from shockwave.scenario.gathering import Gathering
from shockwave.scenario.values import structure
from shockwave.scenario.variable import Variable, variable
from shockwave.scenario.yaml_document import Document, Steps

__all__ = ["RUNS", "SWEEP", "Axis", "Run", "Sweep", "beginnings", "first", "read"]

Run = Literal["predict", "simulate", "compare"]
RUNS: tuple[Run, ...] = ("predict", "simulate", "compare")
_MOST_POINTS = 10**7
_MOST_VALUES = 10**6
# Points with which a sweep is tried to begin: the first, and others out of all.
_FIRST, _OTHERS = 16, 84
_LENGTH = Quantity("", "number of values", at_least=1, at_most=_MOST_VALUES, whole=True)
_REGISTRIES = {
    "chain.material": "materials",
    "shock.profile": "profiles",
    "predict.model": "models",
    "predict.quadrature": "quadratures",
    "simulate.integrator": "integrators",
}
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


@define
class _Reading:
    """Reads the block and adds what is wrong with it to ``loading``."""

    loading: Gathering
    data: Mapping[str, Any]
    profiles: tuple[Any, ...]
    named: set[str]

    def add(self, steps: Steps, problem: str, at_key: bool = False) -> None:
        self.loading.add(("sweep", *steps), problem, at_key)

    def variable(self, steps: Steps, name: str) -> Variable | None:
        try:
            found = variable(name, self.data, self.profiles)
        except InvalidValueError as error:
            self.add((*steps, name), error.faults[0].problem, at_key=True)
            return None
        if name in self.named:
            self.add((*steps, name), "must be varied once (got it again; delete one)", at_key=True)
            return None
        self.named.add(name)
        return found

    def value(self, steps: Steps, of: Variable, given: Any) -> Any:
        if of.name == "chain.material" and not isinstance(given, str):
            _, wrongs = structure({} if given is None else given, keys_of(Material))
            self.loading.report(("sweep", *steps), wrongs)
            return given
        try:
            if of.name in _REGISTRIES and isinstance(given, str):
                find(_REGISTRIES[of.name], given)
            return of.value(given)
        except InvalidValueError as error:
            for fault in error.faults:
                self.add(steps, fault.problem)
        except UnknownNameError as error:
            self.loading.blame(("sweep", *steps), error)
        return None

    def values(self, steps: Steps, of: Variable, given: Any) -> tuple[Any, ...]:
        """The values that ``given`` stands for; none if something is wrong with them."""
        if isinstance(given, list):
            if not given or len(given) > _MOST_VALUES:
                self.add(steps, f"must be 1 to {_MOST_VALUES} values (got {len(given)})")
            return tuple(self.value((*steps, index), of, one) for index, one in enumerate(given))
        kind = next(iter(given)) if isinstance(given, dict) and len(given) == 1 else None
        parts = given[kind] if kind in _SPACINGS else None
        if kind is None or not isinstance(parts, list) or len(parts) != 3:
            self.add(steps, f"{_VALUES} (got {text_of(given)})")
            return ()
        if of.unit is None:
            self.add(steps, f"must be a list, as not every value of it is a number (got {text_of(given)})")
            return ()
        return self._spaced((*steps, str(kind)), str(kind), of, parts)

    def _spaced(self, steps: Steps, kind: str, of: Variable, parts: list[Any]) -> tuple[Any, ...]:
        for index in range(2):
            if parts[index] is None:
                self.add((*steps, index), "must be a number (got nothing)")
        first, last = (self.value((*steps, index), of, parts[index]) for index in range(2))
        if problem := _LENGTH.problem(parts[2]):
            self.add((*steps, 2), problem)
            return ()
        if first is None or last is None:
            return ()
        if kind == "logspace" and not (first and last and (first > 0) == (last > 0)):
            self.add(steps, f"must have ends of the same sign, other than 0 (got {text_of(parts)}; use linspace)")
            return ()
        # where both ends are in its range, so is what is between
        found: list[float] = _SPACINGS[kind](first, last, int(parts[2])).tolist()
        if not of.whole:
            return tuple(found)
        if any(value != int(value) for value in found):
            self.add(steps, f"must give whole numbers (got {text_of(parts)}; list them)")
        return tuple(int(value) for value in found)

    # ------------------------------------------------------------ parts

    def grid(self, given: Any) -> list[Axis]:
        pairs = self._pairs("grid", given)
        return [Axis((of,), tuple((value,) for value in values)) for of, values in pairs]

    def zip(self, given: Any) -> list[Axis]:
        pairs = self._pairs("zip", given)
        lengths = {of.name: len(values) for of, values in pairs}
        if len(set(lengths.values())) > 1:
            told = ", ".join(f"{length} of {name}" for name, length in lengths.items())
            self.add(("zip",), f"must have as many values of each (got {told})")
            return []
        if not pairs:
            return []
        return [Axis(tuple(of for of, _ in pairs), tuple(zip(*(values for _, values in pairs), strict=True)))]

    def points(self, given: Any) -> list[Axis]:
        sound = isinstance(given, list) and given and all(isinstance(point, dict) and point for point in given)
        if not sound:
            self.add(("points",), f"must be a list of mappings of dotted names to values (got {text_of(given)})")
            return []
        found = {name: self.variable(("points", 0), name) for name in given[0]}
        rows: list[tuple[Any, ...]] = []
        for index, point in enumerate(given):
            if point.keys() != found.keys():
                wanted = ", ".join(found)
                self.add(("points", index), f"must give {wanted}, as the first point does (got {', '.join(point)})")
                continue
            pairs = ((name, of) for name, of in found.items() if of is not None)
            rows.append(tuple(self.value(("points", index, name), of, point[name]) for name, of in pairs))
        return [Axis(tuple(of for of in found.values() if of is not None), tuple(rows))]

    def _pairs(self, part: str, given: Any) -> list[tuple[Variable, tuple[Any, ...]]]:
        if not isinstance(given, dict) or not given:
            self.add((part,), f"must be a mapping of dotted names to values (got {text_of(given)})")
            return []
        found = ((name, self.variable((part,), name), values) for name, values in given.items())
        return [(of, self.values((part, name), of, values)) for name, of, values in found if of is not None]


def read(loading: Gathering, data: Mapping[str, Any]) -> Sweep | None:
    """The block ``sweep`` of the document ``data``, whose faults are added to ``loading``; None if there are any."""
    given = data["sweep"]
    before = len(loading.faults)
    _, wrongs = structure(given, SWEEP)
    loading.report(("sweep",), wrongs)
    if not isinstance(given, dict):
        return None
    reading = _Reading(loading, data, tuple(_profiles(given)), set())
    axes: list[Axis] = []
    for part in given:
        if part in ("grid", "zip", "points"):
            axes += getattr(reading, part)(given[part])
    count = math.prod(len(axis) for axis in axes)
    if len(loading.faults) > before or any(path[:1] == ("sweep",) for path in loading.document.unreadable):
        return None
    if not axes or count > _MOST_POINTS:
        problem = f"must have a grid, a zip or points, of 1 to {_MOST_POINTS:g} scenes in all"
        reading.add((), f"{problem} (got {count if axes else 'nothing'})")
        return None
    return Sweep(given.get("run") or _run(data), tuple(axes))


def beginnings(sweep: Sweep | None) -> list[int]:
    """The points to begin with, one after the other until one has a scene; always the same."""
    if sweep is None:
        return [0]
    count = len(sweep)
    others = random.Random(0).sample(range(count), min(count, _OTHERS))
    return list(dict.fromkeys([*range(min(count, _FIRST)), *others]))


def first(document: Document, sweep: Sweep | None, index: int = 0) -> Document:
    """One of the scenes that the document stands for, as one that stands for itself."""
    rest = {name: value for name, value in document.data.items() if name not in ("sweep", "uncertainty")}
    if sweep is None:
        # what a sweep with faults would have brought is not missing
        brought = {tuple(name.split(".")) for name in _named(document.data.get("sweep"))}
        return evolve(document, data=rest, unreadable=document.unreadable | brought)
    document = evolve(document, data=rest)
    # a material first, for what is swept of it
    pairs = sorted(sweep.point(index).items(), key=lambda pair: pair[0].count("."))
    values: dict[Steps, Any] = {tuple(name.split(".")): value for name, value in pairs}
    made = _material(document, values)
    values = {**made, **values, **made}
    place = document.place(("sweep",), key=True)
    return document.having(values, dict.fromkeys(values, place))


def _material(document: Document, values: Mapping[Steps, Any]) -> dict[Steps, Any]:
    """The material as a mapping with a place for ``values``, if it is called by its name and some are of it."""
    path: Steps = ("chain", "material")
    chain = document.data.get("chain")
    given = values.get(path, chain.get("material") if isinstance(chain, dict) else None)
    if not isinstance(given, str) or not any(path == steps[:2] and len(steps) > 2 for steps in values):
        return {}
    try:
        material = load("materials", given)
    except (PluginError, UnknownNameError):  # told where the material is built
        return {}
    return {path: {name: getattr(material, name) for name in ("youngs_modulus", "poisson_ratio", "density")}}


def _named(given: Any) -> list[str]:
    """All names that the block varies, known or not."""
    blocks = [given.get(part) for part in ("grid", "zip")] if isinstance(given, dict) else []
    points = given.get("points") if isinstance(given, dict) else None
    blocks += points if isinstance(points, list) else []
    return [name for block in blocks if isinstance(block, dict) for name in block if isinstance(name, str)]


def _profiles(given: Mapping[str, Any]) -> Iterator[Any]:
    """All profiles that the block names."""
    name = "shock.profile"
    for part in ("grid", "zip"):
        values = given[part].get(name) if isinstance(given.get(part), dict) else None
        yield from values if isinstance(values, list) else ()
    for point in given["points"] if isinstance(given.get("points"), list) else ():
        if isinstance(point, dict) and name in point:
            yield point[name]


def _run(data: Mapping[str, Any]) -> Run:
    """What the scenario has a block for: one of the two, or else both side by side."""
    given = [name for name in ("predict", "simulate") if data.get(name) is not None]
    return "compare" if len(given) != 1 else "predict" if given == ["predict"] else "simulate"
