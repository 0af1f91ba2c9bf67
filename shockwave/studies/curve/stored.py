"""Curves as JSON, with where they come from."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

import shockwave
from shockwave.errors import InvalidValueError
from shockwave.fields import text_of
from shockwave.files import parse_json, read_bytes, write_file
from shockwave.studies.curve.build import Built
from shockwave.studies.curve.series import Piece, Series
from shockwave.studies.curve.shape import Shape

if TYPE_CHECKING:
    from shockwave.studies.curve.universal import UniversalCurve

__all__ = ["from_dict", "read", "to_dict", "versions", "write"]

_FORMAT, _VERSION = "shockwave universal curve", 1
# Largest file [bytes]; a curve takes some tens of thousands.
_MOST_BYTES = 2**24


def versions() -> tuple[tuple[str, str], ...]:
    """Of the programs that make a curve now."""
    return (("shockwave", shockwave.__version__), ("numpy", np.__version__))


def to_dict(curve: UniversalCurve) -> dict[str, Any]:
    """A curve as JSON holds it: floats keep all their digits there."""
    shape, pieces = curve.shape, () if curve.series is None else curve.series.pieces
    return {
        "format": _FORMAT,
        "version": _VERSION,
        "made_with": dict(curve.versions),
        "profile": {"class": shape.kind, "parameters": dict(shape.parameters)},
        "duration_ratio": shape.duration_ratio,
        "area": shape.area,
        "centroid": shape.centroid,
        "correction": shape.correction,
        "rtol": curve.rtol,
        "longest": curve.longest,
        "simulations": curve.simulations,
        "short": {"second_correction": curve.second_correction, "end": curve.short_end, "error": curve.short_error},
        "pieces": [
            {"begin": piece.begin, "end": piece.end, "error": piece.error, "coefficients": list(piece.coefficients)}
            for piece in pieces
        ],
    }


class _Reader:
    """Reads a document; what does not fit is told by its path."""

    def __init__(self, value: Any, path: str = "") -> None:
        self.value, self.path = value, path

    def __getitem__(self, key: str) -> _Reader:
        path = f"{self.path}.{key}" if self.path else key
        if not isinstance(self.value, dict) or key not in self.value:
            raise InvalidValueError.of(path, "must be there (got nothing; is this the file of a curve?)")
        return _Reader(self.value[key], path)

    def fault(self, rule: str) -> InvalidValueError:
        return InvalidValueError.of(self.path or "document", f"must be {rule} (got {text_of(self.value)})")

    def number(self, above: float = -math.inf) -> float:
        if isinstance(self.value, bool) or not isinstance(self.value, int | float):
            raise self.fault("a finite number")
        try:
            number = float(self.value)
        except OverflowError:  # a large whole number
            number = math.inf
        if not (math.isfinite(number) and number > above):
            raise self.fault("a finite number" + (f" > {above:g}" if above > -math.inf else ""))
        return number

    def whole(self) -> int:
        if isinstance(self.value, bool) or not isinstance(self.value, int) or self.value < 0:
            raise self.fault("a whole number >= 0")
        return self.value

    def mapping(self, of: Callable[[Any], bool] = lambda value: True) -> dict[str, Any]:
        if not isinstance(self.value, dict) or not all(of(value) for value in self.value.values()):
            raise self.fault("a mapping")
        return dict(self.value)

    def text(self) -> str:
        if not isinstance(self.value, str):
            raise self.fault("a text")
        return self.value

    def items(self) -> list[_Reader]:
        if not isinstance(self.value, list):
            raise self.fault("a list")
        return [_Reader(value, f"{self.path}[{index}]") for index, value in enumerate(self.value)]


def from_dict(document: Any) -> tuple[Shape, float, float, Built, tuple[tuple[str, str], ...]]:
    """The parts of a curve: shape, rtol, longest, what simulation gave, versions."""
    read = _Reader(document)
    shape, made_with = _shape(read)
    short, longest = read["short"], read["longest"].number(0.0)
    found = Built(
        second_correction=short["second_correction"].number(),
        short_end=short["end"].number(),
        short_error=short["error"].number(0.0),
        series=_series(read["pieces"], short["end"].number(), math.log(longest)),
        simulations=read["simulations"].whole(),
    )
    return shape, read["rtol"].number(0.0), longest, found, made_with


def _shape(read: _Reader) -> tuple[Shape, tuple[tuple[str, str], ...]]:
    """Shape in a document, and the versions of the packages that made it."""
    if read["format"].value != _FORMAT:
        raise read["format"].fault(repr(_FORMAT))
    if read["version"].value != _VERSION:
        raise read["version"].fault(f"{_VERSION}, which this shockwave reads")
    shape = Shape(
        kind=read["profile"]["class"].text(),
        parameters=read["profile"]["parameters"].mapping(),
        duration_ratio=read["duration_ratio"].number(1.0),
        area=read["area"].number(0.0),
        centroid=read["centroid"].number(0.0),
        correction=read["correction"].number(0.0),
    )
    made_with = read["made_with"].mapping(lambda value: isinstance(value, str))
    return shape, tuple(made_with.items())


def _series(read: _Reader, begin: float, end: float) -> Series | None:
    pieces = []
    at = begin
    for item in read.items():
        if item["begin"].number() != at:
            raise item["begin"].fault(f"{at!r}, where the one before ends")
        coefficients = tuple(value.number() for value in item["coefficients"].items())
        if not coefficients:
            raise item["coefficients"].fault("one number or more")
        pieces.append(Piece(at, item["end"].number(at), coefficients, item["error"].number()))
        at = pieces[-1].end
    if at < end:
        raise InvalidValueError.of(read.path, f"must reach ln of longest, {end!r} (got {at!r})")
    return Series(tuple(pieces)) if pieces else None


def write(file: str | os.PathLike[str], document: dict[str, Any]) -> None:
    """Write ``document`` to ``file``."""
    write_file(file, json.dumps(document, indent=1, allow_nan=False) + "\n")


def read(file: str | os.PathLike[str]) -> Any:
    """The document in ``file``."""
    return parse_json(read_bytes(file, _MOST_BYTES), os.fspath(file))
