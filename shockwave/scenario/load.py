"""Loading: from a scenario file to a shock, a chain, and what is asked about them, or to all its faults."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from attrs import Factory, define, evolve, frozen

from shockwave.chain.chain import Chain
from shockwave.chain.material import Material
from shockwave.document.reader import MOST_FAULTS, Document, Steps, dotted, read_document
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
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.shock import Shock
from shockwave.registry import find, load
from shockwave.scenario.blocks import (
    CHAIN,
    RECORD,
    SCENARIO,
    SHOCK,
    Key,
    Published,
    SimulateOptions,
    keys_of,
    parameters_of,
)
from shockwave.scenario.values import Wrong, missing, structure

__all__ = ["Published", "Scenario", "SimulateOptions", "load_scenario", "scenario_of"]

_DISTRIBUTION = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9._-]{0,100}[A-Za-z0-9])?")
_STEP = re.compile(r"([^.\[\]]+)|\[([0-9]{1,9})\]")
_SWEEP = (
    "must be left out: a scenario with a sweep stands for many, and this version runs single scenes only"
    " (got a sweep; remove the block)"
)


@frozen(kw_only=True)
class Scenario:
    """One scene, and what is asked about it.

    Attributes
    ----------
    name : str
        What it is called: the file's name without its suffix, unless it says otherwise.
    path : pathlib.Path or None
        The file.
    shock : Shock
        Profile, peak force, rise time.
    chain : Chain
        Material, radius, number of granules.
    predictor : Predictor
        As the block ``predict`` wants it.
    simulate : SimulateOptions
        As the block ``simulate`` wants it.
    published : Published or None
        Figures of a source for the same scene.
    """

    name: str
    path: Path | None
    shock: Shock
    chain: Chain
    predictor: Predictor
    simulate: SimulateOptions
    published: Published | None = None


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
    faults: list[Fault] = []
    return scenario_of(read_document(path, faults), Path(path), faults)


def scenario_of(document: Document, path: Path | None, faults: Sequence[Fault] = ()) -> Scenario:
    """The scenario that ``document`` describes; see `load_scenario`.

    ``faults`` are those that reading it has found.
    """
    loading = _Loading(document, path, list(faults))
    data, wrongs = structure(_without_empty(document.data), SCENARIO)
    loading.report((), wrongs)
    # What is wrong at the top must not hide what is wrong in a block.
    data = {**document.data, **data}
    parts = {
        "name": loading.name(data.get("name")),
        "shock": loading.shock(data.get("shock")),
        "chain": loading.chain(data.get("chain")),
        "predictor": loading.options("predict", data, Predictor),
        "simulate": loading.options("simulate", data, SimulateOptions),
        "published": loading.options("published", data, Published) if data.get("published") is not None else None,
    }
    loading.requires(data.get("requires"))
    if "sweep" in data:
        loading.add(("sweep",), _SWEEP, at_key=True)
    loading.finish()
    return Scenario(path=path, **parts)


def _without_empty(data: Mapping[str, Any]) -> dict[str, Any]:
    """``data`` without the optional blocks that hold nothing, all of whose keys may be commented out."""
    needed = [key.name for key in SCENARIO if key.required or key.annotation is str]
    return {name: value for name, value in data.items() if value is not None or name in needed}


@define(eq=False)
class _Loading:
    """Builds the parts of a scenario one by one, each as far as it can, and gathers the faults of all."""

    document: Document
    path: Path | None
    faults: list[Fault]
    access: FileAccessError | None = None
    _reported: set[tuple[str, str]] = Factory(set)

    # ---------------------------------------------------------------- faults

    def add(self, path: Steps, problem: str, at_key: bool = False) -> None:
        """Add the fault at ``path`` of the document, unless reading it has found that value at fault."""
        if any(path[:end] in self.document.unreadable for end in range(len(path) + 1)):
            return
        self.faults.append(Fault(dotted(path), problem, self.document.locate(path, at_key)))

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
        raise ScenarioError(faults)

    def _order(self, fault: Fault) -> tuple[bool, int, int]:
        name, _, place = fault.location.partition(f"{self.document.name}:")
        line, _, column = place.partition(":")
        here = not name and line.isdecimal() and column.isdecimal()
        return (False, int(line), int(column)) if here else (True, 0, 0)

    # ---------------------------------------------------------------- building

    def build(
        self, make: Callable[..., Any], values: Mapping[str, Any], keys: Sequence[Key], where: Callable[[Steps], Steps]
    ) -> Any:
        """What ``make`` makes of ``values``, or None, with the faults it finds; ``where`` places them.

        Constructors stop at the first fault. An optional value at fault is therefore left out and the rest
        tried again.
        """
        left, sound = dict(values), True
        while True:
            try:
                made = make(**left)
            except UnknownNameError as error:
                found: tuple[Fault, ...] = (Fault(error.kind, str(error)),)
            except InvalidValueError as error:
                found = error.faults
            except ArithmeticError as error:
                found = (Fault("", f"must be values whose products a floating-point number can hold (got {error})"),)
            else:
                return made if sound else None
            sound = False
            named = set()
            for fault in found:
                steps = _steps(fault.path)
                named.update(steps[:1])
                if fault.location:  # in another file, a record
                    self.faults.append(fault)
                else:
                    self.add(where(steps), fault.problem, at_key=bool(steps) and steps[0] not in values)
            if not (named := {key.name for key in keys if not key.required} & named & left.keys()):
                return None
            left = {name: value for name, value in left.items() if name not in named}

    def options(self, block: str, data: Mapping[str, Any], cls: type) -> Any:
        """The object of a block whose keys are the arguments of ``cls``."""
        keys = keys_of(cls)
        values, wrongs = structure(data.get(block), keys)
        self.report((block,), wrongs)
        return None if wrongs else self.build(cls, values, keys, lambda steps: (block, *steps))

    # ---------------------------------------------------------------- blocks

    def name(self, given: Any) -> str:
        if isinstance(given, str):
            if not given.strip() or "\n" in given:
                self.add(("name",), f"must be a line of text (got {text_of(given)})")
            return given
        return self.path.stem if self.path is not None else self.document.name

    def requires(self, given: Any) -> None:
        from importlib.metadata import PackageNotFoundError, version

        for index, name in enumerate(given if isinstance(given, list) else ()):
            if not isinstance(name, str):
                continue  # reported by its type
            if not _DISTRIBUTION.fullmatch(name):
                self.add(("requires", index), f"must be the name of a distribution (got {text_of(name)})")
                continue
            try:
                version(name)
            except PackageNotFoundError:
                problem = f"must be installed (got nothing of this name; install it with pip install {name})"
                self.add(("requires", index), problem)

    def chain(self, data: Any) -> Chain | None:
        if data is None and "chain" not in self.document.data:
            return None  # reported as missing
        values, wrongs = structure(data, CHAIN)
        self.report(("chain",), wrongs)
        given = data if isinstance(data, dict) else {}
        sizes = [name for name in given if name in ("diameter", "radius")]
        if isinstance(data, dict | None) and not sizes:
            self.report(("chain",), [missing(("diameter",), "give a diameter or a radius")])
        elif len(sizes) == 2:
            problem = "must be given once, as a diameter or as a radius (got both; delete one)"
            self.add(("chain", sizes[1]), problem, at_key=True)
        material = self.material(given["material"]) if given.get("material") is not None else None
        if wrongs or len(sizes) != 1 or material is None:
            return None
        values["material"] = material
        if "diameter" in values:
            values["radius"] = values.pop("diameter") / 2
        size = sizes[0]
        chain: Chain | None = self.build(
            Chain, values, CHAIN, lambda steps: ("chain", *(size if step == "radius" else step for step in steps))
        )
        return chain

    def material(self, data: Any) -> Material | None:
        path = ("chain", "material")
        if not isinstance(data, str):
            keys = keys_of(Material)
            values, wrongs = structure(data, keys)
            self.report(path, wrongs)
            made = None if wrongs else self.build(Material, values, keys, lambda steps: (*path, *steps))
            return made if isinstance(made, Material) else None
        try:
            material = load("materials", data)
        except UnknownNameError as error:
            self.add(path, str(error))
            return None
        if not isinstance(material, Material):
            owner = find("materials", data).distribution
            raise PluginError(f"material {data!r} of {owner}: must be a Material (got {text_of(material)})")
        return material

    # ---------------------------------------------------------------- shock

    def shock(self, data: Any) -> Shock | None:
        if data is None and "shock" not in self.document.data:
            return None
        given = data if isinstance(data, dict) else {}
        cls = self._profile_class(given.get("profile"))
        keys = _shock_keys(cls)
        values, wrongs = structure(data, keys)
        self.report(("shock",), wrongs)
        if cls is None:
            return None
        allowed = parameters_of(cls)
        parameters, more = structure(given.get("parameters"), allowed)
        self.report(("shock", "parameters"), more)
        bad = {wrong.path[0] for wrong in wrongs if wrong.path}
        if more or "duration_ratio" in bad:
            return None
        ratio = {"duration_ratio": given["duration_ratio"]} if "duration_ratio" in given else {}
        ratio = structure(ratio, [key for key in keys if key.name == "duration_ratio"])[0]
        profile = self._profile(given["profile"], cls, {**parameters, **ratio})
        if profile is None or wrongs:
            return None
        sizes = {name: values[name] for name in ("peak_force", "rise_time") if name in values}
        with _blame(given["profile"]):
            shock: Shock | None = self.build(
                Shock, {"profile": profile, **sizes}, SHOCK, lambda steps: ("shock", *steps)
            )
        return shock
