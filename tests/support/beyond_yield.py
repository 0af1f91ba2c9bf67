"""Shipped examples with forces beyond first yield at elastic contacts."""

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from shockwave.scene.yielding import BEYOND

#: Files whose results warn of forces beyond first yield, and why.
BEYOND_YIELD = {
    "docs/plasticity.md": "compares plastic flow with elastic contacts",
    "profiles/validation/damped.yaml": "problem of the benchmarks, in which numerical methods are compared",
    "profiles/validation/layers.yaml": "compared with a program that has elastic contacts only",
}


def warns_beyond_yield(warnings: Iterable[str]) -> bool:
    """Whether one of the texts has the warning of forces beyond first yield."""
    return any(BEYOND in warning for warning in warnings)


def warnings_of(values: Iterable[Any]) -> Iterator[str]:
    """Warnings of the results among ``values`` and in their lists, tuples and mappings."""
    for value in values:
        if isinstance(value, dict | list | tuple):
            yield from warnings_of(value.values() if isinstance(value, dict) else value)
        elif isinstance(warnings := getattr(value, "warnings", None), tuple):
            yield from warnings


def notes_of_sweeps(folder: Path) -> list[str]:
    """Warnings of the points of all sweeps in a folder."""
    lines = [line for file in folder.glob("*/results.jsonl") for line in file.read_text("utf-8").splitlines()]
    return [json.dumps(json.loads(line).get("notes", "")) for line in lines]
