"""Changes of a scenario by options of the command line, such as ``--set shock.peak_force='60 N'``."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from attrs import evolve, frozen

from shockwave.base.errors import Fault, Steps, UsageError, dotted_name, hint_of, steps_of
from shockwave.base.quantity_fields import text_of
from shockwave.scenario.sweep_block import varied_paths, vary_document
from shockwave.scenario.yaml_document import Document, parse_value

#: The option that changes a value by its path.
SET = "--set"
# Blocks whose keys are dotted names, and such a name.
_OF_NAMES = re.compile(r"(sweep\.(?:grid|zip|points\[\d+\])|uncertainty)\.(.+)")
_SWEPT = "must not be varied by the sweep (got both; give other values with --set sweep=...)"


@frozen
class Change:
    """A value that ``option`` puts at a path of a scenario; None deletes the key there."""

    option: str
    steps: Steps
    value: Any

    @classmethod
    def of(cls, option: str, path: str, text: str) -> Change:
        """The change to a value that is written as in a scenario; raises a `UsageError` if it is not YAML."""
        block, name = match.groups() if (match := _OF_NAMES.fullmatch(path)) else (path, None)
        steps = steps_of(block)
        if not steps or dotted_name(steps) != block:
            rule = "must be PATH=VALUE with a path such as chain.granules[2].diameter"
            raise UsageError(f"{option}: {rule} (got {text_of(path)})")
        return cls(option, (*steps, name) if name else steps, parse_value(text, f"{option} {path}"))


def apply_changes(document: Document, changes: Iterable[Change]) -> Document:
    """The document after all changes, made one after the other; their errors are located at their options."""
    # a sweep that is replaced or deleted varies nothing more
    for change in sorted(changes, key=lambda change: change.steps != ("sweep",)):
        steps, option, before = change.steps, change.option, {*document.keys}
        swept = steps in varied_paths(document.data.get("sweep"))
        document = vary_document(document, {steps: change.value}, option)
        if problem := _SWEPT if swept else _problem(document.data, change, before):
            document.faults.append(Fault(steps, problem, option, exit_code=UsageError.exit_code))
        for places in (document.keys, document.values):
            for path in [path for path in places if path[: len(steps)] == steps != path]:
                del places[path]  # place of a part of the old value
        blocks = {steps[:end] for end in range(1, len(steps))}
        document.keys.update(dict.fromkeys(blocks - before, option))
        document = evolve(document, source=document.data)
    return document


def _problem(data: Any, change: Change, keys: set[Steps]) -> str:
    """Reason why ``data`` could not be changed; ``keys`` are the paths that existed before."""
    steps = change.steps
    if change.value is None:
        missing = steps not in keys and change.option.startswith(SET)
        return (
            f"must be in the scenario to be deleted ({hint_of(dotted_name(steps), [*map(dotted_name, keys)])})"
            * missing
        )
    for depth, step in enumerate(steps):
        kind: Any = list if isinstance(step, int) else dict
        above = dotted_name(steps[:depth])
        if not isinstance(data, kind):
            word = "list" if kind is list else "mapping"
            return f"must be below a {word} (got {text_of(data)} at {above})"
        if isinstance(step, int) and step >= len(data):
            return f"must be an item of {above}, a list of {len(data)} counted from 0 (got {step})"
        data = data[step]
    return ""
