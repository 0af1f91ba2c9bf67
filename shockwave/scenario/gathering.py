"""Gathering: parts of a scenario are built one by one, and the faults of all are kept."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

from attrs import define

from shockwave.errors import (
    Fault,
    FileAccessError,
    InvalidValueError,
    PluginError,
    ScenarioError,
    ShockwaveError,
    UnknownNameError,
)
from shockwave.scenario.blocks import keys_of
from shockwave.scenario.values import Wrong, structure
from shockwave.scenario.yaml_document import MOST_FAULTS, Document, Steps, dotted

__all__ = ["Gathering"]

_STEP = re.compile(r"([^.\[\]]+)|\[([0-9]{1,9})\]")


@define(eq=False)
class Gathering:
    """Builds parts of the scenario in ``document`` and keeps their ``faults``.

    ``access`` is the error of another file that the scenario names and that cannot be read; ``plugin`` says that one
    of the faults is a plugin's.
    """

    document: Document
    faults: list[Fault]
    access: FileAccessError | None = None
    plugin: bool = False

    # ---------------------------------------------------------------- faults

    def add(self, path: Steps, problem: str, at_key: bool = False) -> None:
        """Add the fault at ``path`` of the document, unless reading it has found that value at fault."""
        if any(path[:end] in self.document.unreadable for end in range(len(path) + 1)):
            return
        self.faults.append(Fault(dotted(path), problem, self.document.locate(path, at_key)))

    def blame(self, path: Steps, error: ShockwaveError) -> None:
        """Add what was wrong with a name at ``path``: unknown, or a plugin's whose fault it is."""
        self.plugin |= error.exit_code == PluginError.exit_code
        self.add(path, str(error))

    def report(self, path: Steps, wrongs: Sequence[Wrong]) -> None:
        for wrong in wrongs:
            self.add((*path, *wrong.path), wrong.problem, wrong.at_key)

    def finish(self) -> None:
        """Raise what was found, in the order of the file, each once."""
        if not self.faults:
            return
        if self.access is not None and len(self.faults) == 1:
            raise FileAccessError(str(self.faults[0])) from self.access
        faults = sorted(dict.fromkeys(self.faults), key=self._order)
        if len(faults) > MOST_FAULTS:
            rest = Fault("", f"and {len(faults) - MOST_FAULTS} more faults", self.document.name)
            faults = [*faults[:MOST_FAULTS], rest]
        if self.plugin:
            raise PluginError("\n".join(map(str, faults)), faults)
        raise ScenarioError(faults)

    def _order(self, fault: Fault) -> tuple[bool, int, int]:
        name, _, place = fault.location.partition(f"{self.document.name}:")
        line, _, column = place.partition(":")
        here = not name and line.isdecimal() and column.isdecimal()
        return (False, int(line), int(column)) if here else (True, 0, 0)

    # ---------------------------------------------------------------- building

    def build(
        self,
        make: Callable[..., Any],
        values: Mapping[str, Any],
        where: Callable[[Steps], Steps],
        spare: Collection[str] = (),
    ) -> Any:
        """What ``make`` makes of ``values``, or None, with the faults it finds; ``where`` places them.

        Constructors stop at the first fault. A value at fault that they can spare is therefore left out, and the
        rest tried again.
        """
        left, sound = dict(values), True
        while True:
            try:
                made = make(**left)
            except UnknownNameError as error:
                self.plugin |= error.exit_code == PluginError.exit_code
                found: tuple[Fault, ...] = (Fault(error.kind, str(error)),)
            except PluginError as error:
                self.blame(where(()), error)
                return None
            except InvalidValueError as error:
                found = error.faults
            except ArithmeticError as error:
                found = (Fault("", f"must be values whose products a floating-point number can hold (got {error})"),)
            else:
                return made if sound else None
            sound = False
            for fault in found:
                path = where(_steps(fault.path))
                if fault.location:  # in a record, a file of its own
                    self.faults.append(fault)
                else:
                    self.add(path, fault.problem, at_key=not self.document.holds(path))
            named = {step for fault in found for step in _steps(fault.path)[:1]}
            dropped = named & left.keys() & set(spare)
            if not dropped:
                return None
            left = {name: value for name, value in left.items() if name not in dropped}

    def options(self, block: str, data: Mapping[str, Any], cls: type) -> Any:
        """The object of a block whose keys are the arguments of ``cls``."""
        keys = keys_of(cls)
        spare = {key.name for key in keys if not key.required}
        given = data.get(block)
        values, wrongs = structure(given, keys)
        self.report((block,), wrongs)
        if wrongs and isinstance(given, dict) and len(spare) == len(keys):
            # What the constructor has to say about the other values is told as well.
            bad = {wrong.path[0] for wrong in wrongs if wrong.path}
            values, _ = structure({name: value for name, value in given.items() if name not in bad}, keys)
        elif wrongs:
            return None
        made = self.build(cls, values, lambda steps: (block, *steps), spare)
        return None if wrongs else made


def _steps(path: str) -> Steps:
    """The steps of a path that a constructor reports, such as ``times[3]``."""
    return tuple(int(index) if index else name for name, index in _STEP.findall(path))
