"""Collects the faults of a document: its parts are built one by one, and all that is wrong is reported together."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from attrs import define

from shockwave.errors import Fault, FileAccessError, InvalidValueError, PluginError, ScenarioError, ShockwaveError
from shockwave.scenario.keys import Key
from shockwave.scenario.value_conversion import MOST_FAULTS, Wrong, structure
from shockwave.scenario.yaml_document import Document, Steps, dotted

_STEP = re.compile(r"([^.\[\]]+)|\[([0-9]{1,9})\]")


@define(eq=False)
class FaultCollector:
    """Builds parts of the scenario in ``document`` and keeps their ``faults``.

    ``access`` is the error of another file that the scenario names and that cannot be read; ``plugin`` says that one
    of the faults is a plugin's.
    """

    document: Document
    faults: list[Fault]
    access: FileAccessError | None = None
    plugin: bool = False

    def add(self, path: Steps, problem: str, at_key: bool = False) -> None:
        """Add the fault at ``path`` of the document, unless reading it has found that value at fault."""
        if not any(path[:end] in self.document.unreadable for end in range(len(path) + 1)):
            self.faults.append(Fault(dotted(path), problem, self.document.locate(path, at_key)))

    def blame(self, path: Steps, error: ShockwaveError) -> None:
        """Add what was wrong with a name at ``path``: unknown, or a plugin's whose fault it is."""
        self.plugin |= error.exit_code == PluginError.exit_code
        self.add(path, str(error))

    def report(self, path: Steps, wrongs: Sequence[Wrong]) -> None:
        """Add what was wrong with the block at ``path``."""
        for wrong in wrongs:
            self.plugin |= wrong.plugin
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

    def _order(self, fault: Fault) -> tuple[float, ...]:
        """Line and column; those of another file last."""
        name, _, place = fault.location.partition(f"{self.document.name}:")
        return tuple(map(int, place.split(":"))) if place and not name else (float("inf"),)

    # ---------------------------------------------------------------- building

    def values(self, path: Steps, given: Any, keys: Sequence[Key]) -> tuple[dict[str, Any], bool]:
        """The sound values of the block at ``path``, and whether nothing is wrong with it."""
        values, wrongs = structure(given, keys)
        self.report(path, wrongs)
        return values, not wrongs

    def block(self, path: Steps, given: Any, cls: type, keys: Sequence[Key]) -> Any:
        """The object of a block whose keys are the arguments of ``cls``; None where something is wrong with it."""
        values, sound = self.values(path, given, keys)
        if not all(key.name in values for key in keys if key.required):
            return None
        # What the constructor has to say about the other values is reported as well.
        made = self.build(cls, values, path)
        return made if sound else None

    def build(
        self,
        make: Callable[..., Any],
        values: Mapping[str, Any],
        path: Steps,
        elsewhere: Mapping[str, Steps] | None = None,
    ) -> Any:
        """What ``make`` makes of ``values``, or None, with the faults it finds.

        They are below ``path``, but for arguments that are given ``elsewhere``; an empty name stands for all of them.
        """
        elsewhere = elsewhere or {}
        try:
            return make(**values)
        except PluginError as error:
            self.blame(elsewhere.get("", path), error)
        except InvalidValueError as error:
            for fault in error.faults:
                self._place(fault, path, elsewhere)
        except ArithmeticError as error:
            self.add(path, f"must be values whose products a floating-point number can hold (got {error})")
        return None

    def _place(self, fault: Fault, path: Steps, elsewhere: Mapping[str, Steps]) -> None:
        """Add a fault that a constructor has found."""
        if fault.location:  # in a record, a file of its own
            self.faults.append(fault)
            return
        first, *more = _steps(fault.path) or ("",)
        below = elsewhere.get(str(first), (*path, first) if first else path)
        self.add((*below, *more), fault.problem, at_key=not self.document.holds((*below, *more)))


def _steps(path: str) -> Steps:
    """The steps of a path that a constructor reports, such as ``times[3]``."""
    return tuple(int(index) if index else name for name, index in _STEP.findall(path))
