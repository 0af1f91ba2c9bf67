"""The ``sweep`` block of a scenario, which describes many scenes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from functools import partial, reduce
from operator import getitem
from typing import Any, Literal

import numpy as np
from attrs import evolve, field, frozen

from shockwave.base.errors import Fault, InvalidValueError, PluginError, Steps, UnknownNameError, steps_of
from shockwave.base.quantity_fields import Declaration, text_of, tuple_repr
from shockwave.registry.registry import load
from shockwave.scenario.block_keys import BLOCKS, MATERIALS, Key, keys_of
from shockwave.scenario.dotted_names import Variable, variables
from shockwave.scenario.value_conversion import convert, gather, items, structure
from shockwave.scenario.yaml_document import Document
from shockwave.scene.material import Material

Run = Literal["predict", "simulate", "compare"]
# Scenes of a sweep, and values of all variables: bounds on its memory.
_MOST_POINTS = 10**7
_MOST_VALUES = 10**6
# Number of points that are tried until one gives a valid scene.
_MOST_TRIES = 100
_LENGTH = Key("number", spec=Declaration("", "number of values", at_least=1, at_most=_MOST_VALUES, whole=True))
_SPACINGS: dict[str, Callable[[float, float, int], np.ndarray]] = {"linspace": np.linspace, "logspace": np.geomspace}
_VALUES = "must be a list of values or, for numbers, {linspace: [first, last, number]} or {logspace: ...}"

#: Keys of the block.
SWEEP = (
    Key("run", annotation=Run, meaning="command for every point; if omitted, that of the scenario's block"),
    Key("grid", meaning="dotted names and their values, in all combinations"),
    Key("zip", meaning="dotted names with lists of equal length; values at the same position are used together"),
    Key("points", meaning="a list of mappings of dotted names to one value each"),
    Key("quantities", annotation=list[str], meaning="further columns: names of quantities, or ratios of two"),
)


@frozen
class SweepAxis:
    """Variables that change together.

    Attributes
    ----------
    names : tuple of str
        Dotted names of the variables: one, unless the axis comes from ``zip`` or ``points``.
    units : tuple of str or None
        SI unit of each, empty for a dimensionless number; None if its values are not numbers.
    values : tuple of tuple
        Values of the variables for each position.
    """

    names: tuple[str, ...]
    units: tuple[str | None, ...]
    values: tuple[tuple[Any, ...], ...] = field(repr=tuple_repr)

    def __attrs_post_init__(self) -> None:
        for position in self.values:
            for value, _, unit in zip(position, self.names, self.units, strict=True):
                if unit is not None and not isinstance(value, int | float | None):
                    raise InvalidValueError(f"a value with a unit must be a number (got {text_of(value)})")

    @classmethod
    def of(cls, variables: Iterable[Variable], values: Iterable[tuple[Any, ...]]) -> SweepAxis:
        """The axis of some variables."""
        names, units = zip(*((one.name, one.unit) for one in variables), strict=True)
        return cls(names, units, tuple(values))

    def __len__(self) -> int:
        return len(self.values)

    def along(self, name: str) -> list[Any]:
        """Return the values of the variable ``name``, position by position."""
        at = self.names.index(name)
        return [position[at] for position in self.values]


@frozen
class Sweep:
    """Many scenes: the product of axes, of which the last one varies fastest.

    Attributes
    ----------
    run : "predict", "simulate" or "compare"
        The command that is run at every point.
    axes : tuple of SweepAxis
        In the order of the file.
    quantities : tuple of str
        Names of further columns, or ratios of two.
    """

    run: Run
    axes: tuple[SweepAxis, ...]
    quantities: tuple[str, ...] = ()

    def __attrs_post_init__(self) -> None:
        if not self.axes or not 0 < self.points <= _MOST_POINTS:
            got = "nothing" if not self.axes else self.points if self.points < 10**15 else "more than 1e15"
            problem = f"must have a grid, a zip or points with 1 to {_MOST_POINTS:g} cases in all (got {got})"
            raise InvalidValueError(problem)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(map(len, self.axes))

    @property
    def points(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    def __len__(self) -> int:
        return self.points

    def pairs(self) -> Iterator[tuple[str, Any]]:
        """Dotted name and value of everything that is varied."""
        return ((name, value) for axis in self.axes for name in axis.names for value in axis.along(name))

    def point(self, index: int) -> dict[str, Any]:
        """Values of the variables at a point, counted from 0, by their dotted names."""
        found: dict[str, Any] = {}
        for axis, place in zip(self.axes, np.unravel_index(index, self.shape), strict=True):
            found.update(zip(axis.names, axis.values[place], strict=True))
        return found


# ---------------------------------------------------------------- the block


def read(data: Mapping[str, Any]) -> Sweep:
    """Sweep of the ``sweep`` block of the document ``data``.

    Raises
    ------
    InvalidValueError
        When the block is not valid; it contains all errors.
    """
    content = data["sweep"]
    if not isinstance(content, dict):
        structure(content, SWEEP)  # raises
    varied = list(_list_varied(content))
    count = sum(_count(values) for _, _, values in varied)
    if count > _MOST_VALUES:  # before they are made
        raise InvalidValueError(f"must have at most {_MOST_VALUES} values in all (got {count})")
    by_name = variables(data, [value for _, name, values in varied if name == "shock.profile" for value in values])
    converters = {
        "run": partial(convert, SWEEP[0]),
        "grid": partial(_grid, by_name),
        "zip": partial(_zip, by_name),
        "points": partial(_points, by_name),
        "quantities": partial(convert, SWEEP[-1]),
    }
    blocks = gather(content.items(), converters, _check_repeated(varied))
    run, quantities = blocks.pop("run", None) or _run(data), tuple(blocks.pop("quantities", ()))
    return Sweep(run, tuple(axis for axes in blocks.values() for axis in axes), quantities)


def _run(data: Mapping[str, Any]) -> Run:
    """Command for which the scenario has a block; with both blocks or none, ``compare``."""
    predict, simulate = (data.get(name) is not None for name in ("predict", "simulate"))
    if predict == simulate:
        return "compare"
    return "predict" if predict else "simulate"


def _list_varied(block: Any) -> Iterator[tuple[str, str, list[Any]]]:
    """Part, dotted name and values of everything that a block varies, whether valid or not."""
    for part, content in block.items() if isinstance(block, dict) else ():
        for mapping in content if isinstance(content, list) else [content]:
            for name, values in mapping.items() if isinstance(mapping, dict) else ():
                yield part, name, values if isinstance(values, list) else [values]


def _count(values: list[Any]) -> int:
    """Number of the values of a variable, before they are checked."""
    spacing = next(iter(values[0].values()), None) if len(values) == 1 and isinstance(values[0], dict) else None
    number = spacing[-1] if isinstance(spacing, list) and spacing else None
    return number if type(number) is int and 0 < number <= _MOST_VALUES else len(values)


def _check_repeated(varied: list[tuple[str, str, list[Any]]]) -> Iterator[Fault]:
    """Errors of names that occur in several parts of the block."""
    parts: dict[str, str] = {}
    for part, name, _ in varied:
        first = parts.setdefault(name, part)
        if first != part:
            yield Fault((part, name), f"must be varied once (got it in {first} and {part}; delete one)", at_key=True)


def varied_paths(block: Any) -> set[Steps]:
    """Paths of the values that a block varies, whether valid or not."""
    return {steps_of(name) for _, name, _ in _list_varied(block)}


def _columns(by_name: Mapping[str, Variable], content: Any) -> list[tuple[Variable, list[Any]]]:
    """Variables and their values."""
    if not isinstance(content, dict) or not content:
        raise InvalidValueError(f"must be a mapping of dotted names to values (got {text_of(content)})")
    columns = gather(content.items(), {name: partial(_values, of) for name, of in by_name.items()})
    return [(by_name[name], values) for name, values in columns.items()]


def _grid(available: Mapping[str, Variable], content: Any) -> list[SweepAxis]:
    """An axis for each name."""
    return [SweepAxis.of((of,), zip(values)) for of, values in _columns(available, content)]


def _zip(available: Mapping[str, Variable], content: Any) -> list[SweepAxis]:
    """One axis for all names."""
    variables, columns = zip(*_columns(available, content), strict=True)
    if len({len(values) for values in columns}) > 1:
        counts = ", ".join(f"{len(values)} of {of.name}" for of, values in zip(variables, columns, strict=True))
        raise InvalidValueError(f"must have the same number of values for each name (got {counts})")
    return [SweepAxis.of(variables, zip(*columns, strict=True))]


def _points(by_name: Mapping[str, Variable], content: Any) -> list[SweepAxis]:
    """One axis, on which each point gives a value of every name."""
    if not isinstance(content, list) or not content or not all(isinstance(point, dict) and point for point in content):
        raise InvalidValueError(f"must be a list of mappings of dotted names to values (got {text_of(content)})")
    names = list(content[0])
    converters = {name: partial(_value, of) for name, of in by_name.items()}

    def point(mapping: dict[str, Any]) -> tuple[Any, ...]:
        if mapping.keys() != content[0].keys():
            raise InvalidValueError(f"must give {', '.join(names)}, as the first point does (got {', '.join(mapping)})")
        values_of_point = gather(mapping.items(), converters)
        return tuple(values_of_point[name] for name in names)

    values = items(content, point)
    return [SweepAxis.of((by_name[name] for name in names), values)]


def _values(of: Variable, content: Any) -> list[Any]:
    """Values that the list or the spacing ``content`` describes."""
    if isinstance(content, list):
        if not content or len(content) > _MOST_VALUES:
            raise InvalidValueError(f"must be a list of 1 to {_MOST_VALUES} values (got {len(content)})")
        return items(content, partial(_value, of))
    kind, parts = next(iter(content.items())) if isinstance(content, dict) and len(content) == 1 else (None, None)
    listed = isinstance(parts, list) and len(parts) == 3 and None not in parts
    if kind not in _SPACINGS or not listed or of.unit is None:
        raise InvalidValueError(f"{_VALUES} (got {text_of(content)})")
    return list(gather(content.items(), {kind: partial(_space, of, kind)})[kind])


def _value(of: Variable, content: Any) -> Any:
    """Value of ``of`` in SI units; a material may be a mapping."""
    if of.key.kind == "materials" and isinstance(content, dict):
        return structure(content, keys_of(Material))
    return of.convert(content)


def _space(of: Variable, kind: str, parts: list[Any]) -> list[Any]:
    converters = (of.convert, of.convert, partial(convert, _LENGTH))
    first, last, number = gather(enumerate(parts), dict(enumerate(converters))).values()
    if kind == "logspace" and not first * last > 0:
        raise InvalidValueError(f"must have ends of the same sign, other than 0 (got {text_of(parts)}; use linspace)")
    # values between two valid ends are valid, too
    values: list[Any] = _SPACINGS[kind](first, last, number).tolist()
    if not of.whole:
        return values
    if any(value != int(value) for value in values):
        raise InvalidValueError(f"must give whole numbers (got {text_of(parts)}; list the values)")
    return [int(value) for value in values]


# ---------------------------------------------------------------- the first scene


def points_to_try(sweep: Sweep | None) -> range:
    """Points that are tried in turn until one gives a valid scene."""
    count = len(sweep) if sweep is not None else 1
    return range(0, count, -(-count // _MOST_TRIES))


def document_at(document: Document, sweep: Sweep | None, index: int = 0) -> Document:
    """Document of the single scene at the point ``index`` of the sweep."""
    rest = {name: value for name, value in document.data.items() if name not in ("sweep", "uncertainty")}
    document = evolve(document, data=rest)
    if sweep is None:
        return document
    return vary_document(document, sweep.point(index), document.keys.get(("sweep",)))


def vary_document(document: Document, values: Mapping[Any, Any], place: Any = None) -> Document:
    """The document with other values at their dotted names or paths; ``place`` is the place for errors."""
    changes: dict[Steps, Any] = {steps_of(name): value for name, value in values.items()}
    # the materials first, because their constants may be varied too
    materials = {steps: value for steps, value in changes.items() if steps[-1] in MATERIALS}
    document = document.with_values(materials, place)
    for steps in {steps[:-1]: None for steps in changes if len(steps) > 1 and steps[-2] in MATERIALS}:
        document = document.with_values(_constants(document, steps))
    return document.with_values({steps: value for steps, value in changes.items() if steps not in materials}, place)


def _constants(document: Document, steps: Steps) -> dict[Steps, Any]:
    """Constants of the material at a path of a document; by default that of the chain."""
    constants = _value_at(document.data, steps) or _value_at(document.data, ("chain", "material"))
    if isinstance(constants, str):
        with suppress(PluginError, UnknownNameError):  # reported where the material is built
            material = load("materials", constants)
            constants = {key.name: getattr(material, key.name) for key in BLOCKS["chain.material"]}
    return {steps: constants} if isinstance(constants, dict) else {}


def _value_at(block: Any, steps: Steps) -> Any:
    """Value at a path below ``block``; None if there is none."""
    with suppress(KeyError, IndexError, TypeError):
        return reduce(getitem, steps, block)
    return None
