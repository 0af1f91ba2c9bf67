"""The loader: a scenario file to a shock, a chain and settings, or to all its errors."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from attrs import define

from shockwave.chain.chain import Chain
from shockwave.chain.material import Material
from shockwave.errors import (
    Fault,
    FileAccessError,
    InvalidValueError,
    PluginError,
    ScenarioError,
    ShockwaveError,
    UnknownNameError,
)
from shockwave.fields import text_of
from shockwave.options import SimulateOptions
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.shock import Shock
from shockwave.registry import blame, load
from shockwave.scenario.block_keys import BLOCKS, CHAIN, RECORD, SCENARIO, Key, keys_of, parameters_of, shock_keys
from shockwave.scenario.scenario import Published, Scenario
from shockwave.scenario.sweep_block import Sweep, beginnings, first, names
from shockwave.scenario.sweep_block import read as read_sweep
from shockwave.scenario.uncertainty import Spread
from shockwave.scenario.uncertainty import read as read_spreads
from shockwave.scenario.value_conversion import Wrong, WrongsError, structure
from shockwave.scenario.yaml_document import Document, Steps, read_document

_PARAMETERS: Steps = ("shock", "parameters")
_STEP = re.compile(r"([^.\[\]]+)|\[([0-9]{1,9})\]")
_MOST_FAULTS = 100
_SIZES = ("peak_force", "rise_time", "duration")


def load_scenario(path: str | os.PathLike[str]) -> Scenario:
    """The scenario in a file.

    Parameters
    ----------
    path : path-like
        A YAML file; messages call it by this name. Files that it names are looked for in its folder.

    Raises
    ------
    FileAccessError
        When it, or the record that it names, cannot be read.
    ScenarioError
        When it is not valid; every fault is listed, in the order of the file.
    PluginError
        When a plugin that it names is at fault.
    """
    return scenario_of(read_document(path), Path(path))


def scenario_of(document: Document, path: Path | None, tries: slice = slice(None)) -> Scenario:
    """The scenario that ``document`` describes; see `load_scenario`.

    Of a sweep it is the first scene that can be, out of ``tries`` of `beginnings`; if there is none, the faults are
    those of the first try.
    """
    sweep = None
    brought: set[Steps] = set()
    wrongs: Sequence[Wrong] = ()
    if document.data.get("sweep") is not None:
        try:
            sweep = read_sweep(document.data)
        except WrongsError as error:
            wrongs = error.wrongs
            brought = names(document.data["sweep"])
    problem: ShockwaveError | None = None
    for index in beginnings(sweep)[tries]:
        loading = _Loading(first(document, sweep, index), list(document.faults), path, brought)
        loading.report(("sweep",), wrongs)
        try:
            return loading.scenario(document, sweep)
        except ShockwaveError as error:
            problem = problem or error
    assert problem is not None
    raise problem


@define(eq=False)
class _Loading:
    """Builds the parts of the scene in ``document``, each as far as it can be, and keeps all ``faults``.

    A sweep with faults would have ``brought`` some values: they are not missing. ``access`` is the error of another
    file that the scenario names and that cannot be read; ``plugin`` says that one of the faults is a plugin's.
    """

    document: Document
    faults: list[Fault]
    path: Path | None
    brought: Collection[Steps] = ()
    access: FileAccessError | None = None
    plugin: bool = False

    # ---------------------------------------------------------------- faults

    def add(self, path: Steps, problem: object, at_key: bool = False) -> None:
        """Add the fault at ``path`` of the document."""
        self.plugin |= getattr(problem, "exit_code", 0) == PluginError.exit_code
        if path not in self.brought:
            self.faults.append(self.document.fault(path, str(problem), at_key))

    def report(self, path: Steps, wrongs: Sequence[Wrong]) -> None:
        """Add the errors of the block at ``path``."""
        for wrong in wrongs:
            self.add((*path, *wrong.path), wrong.problem, wrong.at_key)

    def finish(self) -> None:
        """Raise what was found, in the order of the file, each once."""
        if not self.faults:
            return
        if self.access is not None and len(self.faults) == 1:
            raise FileAccessError(str(self.faults[0])) from self.access
        faults = sorted(dict.fromkeys(self.faults), key=self._order)
        if len(faults) > _MOST_FAULTS:
            rest = Fault("", f"and {len(faults) - _MOST_FAULTS} more faults", self.document.name)
            faults = [*faults[:_MOST_FAULTS], rest]
        if self.plugin:
            raise PluginError("\n".join(map(str, faults)), faults)
        raise ScenarioError(faults)

    def _order(self, fault: Fault) -> tuple[float, ...]:
        """Line and column; those of another file last."""
        name, _, place = fault.location.partition(f"{self.document.name}:")
        return tuple(map(int, place.split(":"))) if place and not name else (float("inf"),)

    # ---------------------------------------------------------------- blocks

    def values(self, path: Steps, given: Any, keys: Sequence[Key]) -> tuple[dict[str, Any], bool]:
        """The sound values of the block at ``path``, and whether nothing is wrong with it."""
        try:
            return structure(given, keys), True
        except WrongsError as error:
            self.report(path, error.wrongs)
            return error.sound, False

    def block(self, name: str, given: Any, cls: type) -> Any:
        """The object of the block ``name`` whose keys are arguments of ``cls``; None where something is wrong."""
        path = tuple(name.split("."))
        keys = BLOCKS[name] if name in ("predict", "simulate") else keys_of(cls)
        values, sound = self.values(path, given, keys)
        if not {key.name for key in keys if key.required} <= values.keys():
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
        owner: Any = Scenario,
    ) -> Any:
        """The object that ``make`` makes of ``values``, or None, with the faults it finds.

        They are below ``path``, but for arguments that are given ``elsewhere``; an empty name stands for all of them.
        Whatever else it raises is the fault of who wrote ``owner``.
        """
        elsewhere = elsewhere or {}
        try:
            with blame("profiles", owner):
                return make(**values)
        except PluginError as error:
            self.add(elsewhere.get("", path), error)
        except FileAccessError as error:
            self.access = error
            self.add((*path, "file"), error)
        except InvalidValueError as error:
            for fault in error.faults:
                self._place(fault, path, elsewhere)
        return None

    def _place(self, fault: Fault, path: Steps, elsewhere: Mapping[str, Steps]) -> None:
        """Add a fault that a constructor has found at a path such as ``times[3]``."""
        if fault.location:  # in a record, a file of its own
            self.faults.append(fault)
            return
        steps = [int(index) if index else name for name, index in _STEP.findall(fault.path)]
        below = elsewhere.get(str(steps[0]), (*path, steps[0])) if steps else path
        place = (*below, *steps[1:])
        self.add(place, fault.problem, at_key=place not in self.document.values)

    # ---------------------------------------------------------------- scene

    def scenario(self, whole: Document, sweep: Sweep | None) -> Scenario:
        """The scenario of one scene of ``sweep``, which the document ``whole`` holds."""
        data, _ = self.values((), self.document.data, SCENARIO)
        published = data.get("published")
        parts = {
            "name": data.get("name") or (self.path.stem if self.path is not None else self.document.name),
            "shock": self._shock(data["shock"]) if "shock" in data else None,
            "chain": self._chain(data["chain"]) if "chain" in data else None,
            "predictor": self.block("predict", data.get("predict"), Predictor),
            "simulate": self.block("simulate", data.get("simulate"), SimulateOptions),
            "published": None if published is None else self.block("published", published, Published),
            "uncertainty": self._uncertainty(whole.data.get("uncertainty")),
        }
        self._requires(data.get("requires"))
        self.finish()
        return Scenario(path=self.path, sweep=sweep, document=self.document, **parts)

    def _uncertainty(self, given: Any) -> tuple[Spread, ...]:
        try:
            return read_spreads(given, self.document.data) if given is not None else ()
        except WrongsError as error:
            self.report(("uncertainty",), error.wrongs)
            return ()

    def _requires(self, given: Any) -> None:
        from importlib.metadata import PackageNotFoundError, version

        for index, name in enumerate(given or ()):
            try:
                version(name)
            except (PackageNotFoundError, ValueError):
                self.add(("requires", index), f"must be installed (got {text_of(name)}; install it if you trust it)")

    # ---------------------------------------------------------------- chain

    def _chain(self, data: Any) -> Any:
        values, sound = self.values(("chain",), data, CHAIN)
        material = self._material(values["material"]) if "material" in values else None
        if not sound or material is None:
            return None
        values["material"] = material
        elsewhere = {"radius": ("chain", "diameter")} if "diameter" in values else {}
        if "diameter" in values:
            values["radius"] = values.pop("diameter") / 2
        return self.build(Chain, values, ("chain",), elsewhere)

    def _material(self, data: Any) -> Any:
        if isinstance(data, str):
            return self._loaded("materials", data, ("chain", "material"))
        return self.block("chain.material", data, Material)

    def _loaded(self, kind: str, name: Any, path: Steps) -> Any:
        with suppress(UnknownNameError):  # reported with the keys of its block
            return self.build(load, {"kind": kind, "name": name}, path) if isinstance(name, str) else None
        return None

    # ---------------------------------------------------------------- shock

    def _shock(self, data: Any) -> Any:
        given = data if isinstance(data, dict) else {}
        cls = self._loaded("profiles", given.get("profile"), ("shock", "profile"))
        values, sound = self.values(("shock",), data, shock_keys(cls))
        if cls is None:
            return None
        # The profile is built even where another key is at fault, for what its constructor has to say.
        profile = self._profile(cls, given, values)
        if profile is None or not sound:
            return None
        sizes: dict[str, Any] = {key: values[key] for key in _SIZES if key in values}
        make = Shock.of_duration if "duration" in sizes else Shock
        return self.build(make, {"profile": profile, **sizes}, ("shock",), {"": ("shock", "profile")}, cls)

    def _profile(self, cls: Any, given: Mapping[str, Any], shock: Mapping[str, Any]) -> Any:
        """The profile of a block, of whose values ``shock`` are sound; None where something is wrong with it."""
        name = given["profile"]
        values, sound = self.values(_PARAMETERS, given.get("parameters"), parameters_of(name, cls))
        own = [key for key in keys_of(cls) if key.name == "duration_ratio"]
        if "duration_ratio" not in shock:
            # one that is wrong, or missing, is reported with the keys of the block
            sound = sound and "duration_ratio" not in given and not any(key.required for key in own)
        elif own:
            values["duration_ratio"] = shock["duration_ratio"]
        else:
            problem = f"must be left out, as profile {name!r} has its own (got {shock['duration_ratio']:g})"
            self.add(("shock", "duration_ratio"), problem)
            sound = False
        if not sound:
            return None
        make: Callable[..., Any] = cls
        if name == RECORD and "file" in values:
            values["path"] = self._file(values.pop("file"))
            if values["path"] is None:
                return None
            make = cls.from_file
        return self.build(make, values, _PARAMETERS, {"duration_ratio": ("shock", "duration_ratio")}, cls)

    def _file(self, name: str) -> Path | None:
        """The file called ``name`` in the scenario's folder, or below it."""
        folder = self.path.parent if self.path is not None else Path()
        file = folder / name
        # an absolute name leads elsewhere too
        if name.strip() and file.resolve().is_relative_to(folder.resolve()):
            return file
        problem = f"must be a file in the scenario's folder or below it (got {text_of(name)}; copy it there)"
        self.add((*_PARAMETERS, "file"), problem)
        return None
