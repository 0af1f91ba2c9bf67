"""Loader of scenario files: a shock, a chain and settings, or a report of all errors."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from attrs import define, evolve

from shockwave import __version__
from shockwave.base.errors import (
    Fault,
    FileAccessError,
    InvalidValueError,
    PluginError,
    ScenarioError,
    ShockwaveError,
    Steps,
    below,
)
from shockwave.base.quantity_fields import listed, text_of
from shockwave.base.units import to_si
from shockwave.prediction.predictor import Predictor
from shockwave.registry.registry import blame, find, load
from shockwave.scenario.block_keys import (
    BLOCKS,
    CHAIN,
    RECORD,
    SCENARIO,
    VERSIONS,
    Key,
    has_chain_blocks,
    keys_of,
    parameters_of,
    shock_keys,
)
from shockwave.scenario.scenario import Published, Scenario
from shockwave.scenario.sweep_block import Sweep, beginnings, first, names
from shockwave.scenario.sweep_block import read as read_sweep
from shockwave.scenario.uncertainty_block import read as read_spreads
from shockwave.scenario.value_conversion import Parser, converted, items, material, names_files, structure, values_of
from shockwave.scenario.yaml_document import Document, read_document
from shockwave.scene.chain import Chain
from shockwave.scene.force_limit import Limit
from shockwave.scene.scene import faults_of, uniform_of
from shockwave.scene.shock import Shock
from shockwave.scene.simulate_options import SimulateOptions

_PARAMETERS: Steps = ("shock", "parameters")
# Errors that are listed; the number of the others is stated.
_MOST_FAULTS = 100
_MOST_TRIED = 3000  # errors after which no further point of a sweep is tried: so many are not due to its values
_SIZES = ("peak_force", "rise_time", "duration")


def load_scenario(path: str | os.PathLike[str]) -> Scenario:
    """Load the scenario in a file.

    Parameters
    ----------
    path : path-like
        A YAML file; messages use this name. Files that it names are searched in its folder.

    Raises
    ------
    FileAccessError
        When the file, or the record that it names, cannot be read.
    ScenarioError
        When it is not valid; all errors are listed, in the order of the file.
    PluginError
        When a plugin that it uses is faulty.
    """
    return scenario_of(read_document(path), Path(path))


def scenario_of(document: Document, path: Path | None, tries: slice = slice(None)) -> Scenario:
    """Scenario that ``document`` describes; see `load_scenario`.

    For a sweep it is the first valid scene among ``tries`` of `beginnings`; if there is none, the reported errors are
    those of the first of them.
    """
    token = names_files.set(document.names_files)
    try:
        return _scenario_of(document, path, tries)
    finally:
        names_files.reset(token)


def _scenario_of(document: Document, path: Path | None, tries: slice) -> Scenario:
    sweep = None
    varied: set[Steps] = set()
    faults = document.faults
    if document.data.get("sweep") is not None:
        try:
            with below("sweep"):
                sweep = read_sweep(document.data)
        except InvalidValueError as error:
            faults = [*faults, *map(document.place, error.faults)]
            varied = names(document.data["sweep"])
    problems: list[ShockwaveError] = []
    for index in beginnings(sweep)[tries]:
        loading = _Loading(first(document, sweep, index), [*faults], path, varied)
        try:
            return loading.scenario(document, sweep)
        except ShockwaveError as error:
            problems.append(error)
            if len(loading.faults) * len(problems) > _MOST_TRIED:
                break
    raise problems.pop(0)  # a list that held it would be a cycle with its traceback


def _version(given: Any) -> int:
    if type(given) is not int or given not in VERSIONS:  # True and 1.0 are equal to 1
        newer = "; a newer shockwave may read it" if type(given) is int and given > VERSIONS[-1] else ""
        raise ValueError(f"must be {listed(VERSIONS)} for shockwave {__version__} (got {text_of(given)}{newer})")
    return given


def _requires(given: Any) -> list[str]:
    """Names of installed distributions."""
    from importlib.metadata import PackageNotFoundError, version

    def installed(name: str) -> str:
        try:
            version(name)
        except (PackageNotFoundError, ValueError):
            problem = f"must be an installed distribution (got {text_of(name)}; install it if you trust it)"
            raise ValueError(problem) from None
        return name

    return items(converted(_KEYS["requires"], given) or (), installed)


def _chain(given: Any) -> Chain:
    parsers: dict[str, Parser] = {"material": material}
    if has_chain_blocks({"chain": given}):
        from shockwave.scenario import chain_blocks  # not needed for equal granules

        parsers |= chain_blocks.PARSERS
    return Chain(**structure(given, CHAIN, parsers))


def _impact(given: Any) -> Any:
    from shockwave.scenario.chain_blocks import impact  # not needed for a shock

    return impact(given)


def _optional(cls: Any, given: Any) -> Any:
    """Instance of ``cls`` from a block, or None without one."""
    return None if given is None else cls(**structure(given, keys_of(cls)))


_KEYS = {key.name: key for key in SCENARIO}
#: Key of the document -> its parser.
_PARSERS: Mapping[str, Parser] = {
    "version": _version,
    "requires": _requires,
    "chain": _chain,
    "impact": _impact,
    "limit": partial(_optional, Limit),
    "published": partial(_optional, Published),
}


@define(eq=False)
class _Loading:
    """Builds the parts of the scene in ``document``, each as far as possible, and collects all ``faults``.

    Values at the paths ``varied`` come from a sweep with errors, and are not reported as missing.
    """

    document: Document
    faults: list[Fault]
    path: Path | None
    varied: Collection[Steps] = ()

    # ---------------------------------------------------------------- faults

    def add(self, *faults: Fault) -> None:
        """Add faults, with their places in the document."""
        for fault in faults:
            diameter = (*fault.steps[:-1], "diameter")
            # a radius from a diameter
            if fault.steps[-1:] == ("radius",) and fault.steps not in self.document.values | self.document.keys:
                fault = evolve(fault, steps=diameter) if diameter in self.document.keys else fault
            if fault.steps not in self.varied:
                self.faults.append(self.document.place(fault))

    def finish(self) -> None:
        """Raise all faults, in the order of the file and without repetition."""
        if not self.faults:
            return
        faults = sorted(dict.fromkeys(self.faults), key=self._order)
        exit_codes = {fault.exit_code for fault in faults}
        if len(faults) > _MOST_FAULTS:
            rest = Fault((), f"and {len(faults) - _MOST_FAULTS} more errors", self.document.name)
            faults = [*faults[:_MOST_FAULTS], rest]
        if PluginError.exit_code in exit_codes:
            raise PluginError(*faults)
        raise (FileAccessError if exit_codes == {FileAccessError.exit_code} else ScenarioError)(*faults)

    def _order(self, fault: Fault) -> tuple[float, ...]:
        """Line and column of ``fault``; faults in another file come last."""
        name, _, place = fault.location.partition(f"{self.document.name}:")
        return tuple(map(int, place.split(":"))) if place and not name else (float("inf"),)

    # ---------------------------------------------------------------- blocks

    def values(
        self, path: Steps, given: Any, keys: Sequence[Key], parsers: Mapping[str, Parser] | None = None
    ) -> tuple[dict[str, Any], bool]:
        """Valid values of the block at ``path``, and whether the block has no errors."""
        values, faults = values_of(given, keys, parsers)
        for fault in faults:
            self.add(fault.below(*path))
        return values, not faults

    def settings(self, name: str, given: Any, cls: type) -> Any:
        """Instance of ``cls`` from the ``name`` block, whose keys are its arguments; None if the block has errors."""
        if name == "predict" and isinstance(given, dict) and "rtol" in given:
            problem = f"must be left out (got {text_of(given['rtol'])}; simulate.rtol is the tolerance of all forces)"
            self.add(Fault((name, "rtol"), problem, at_key=True))
            given = {key: value for key, value in given.items() if key != "rtol"}
        values, valid = self.values((name,), given, BLOCKS[name])
        # Errors that the constructor finds in the other values are reported as well.
        settings = self.build(cls, values, (name,))
        return settings if valid else None

    def build(
        self,
        make: Callable[..., Any],
        values: Mapping[str, Any],
        path: Steps,
        elsewhere: Mapping[Steps, Steps] | None = None,
        owner: Any = Scenario,
    ) -> Any:
        """Return ``make(**values)``, or None if it raises an error, which is added to the faults.

        Faults are located below ``path``, except those of arguments with another place in ``elsewhere``, where an empty
        path stands for all arguments. An unexpected exception counts as an error of the plugin that defines ``owner``.
        """
        try:
            with blame("profiles", owner):
                return make(**values)
        except (InvalidValueError, PluginError, FileAccessError) as error:
            for fault in error.faults:
                argument = fault.steps[:1]
                place = (elsewhere or {}).get(argument, (*path, *argument))
                # one with a place is in a record, a file of its own
                self.add(fault if fault.location else evolve(fault, steps=(*place, *fault.steps[1:])))
        return None

    # ---------------------------------------------------------------- scene

    def scenario(self, whole: Document, sweep: Sweep | None) -> Scenario:
        """Scenario of one scene of ``sweep``; ``whole`` is the document with all of its blocks."""
        data, _ = self.values((), self.document.data, SCENARIO, _PARSERS)
        spreads = whole.data.get("uncertainty")
        parts = {
            "name": data.get("name") or (self.path.stem if self.path is not None else self.document.name),
            "shock": self._shock(data["shock"]) if "shock" in data else None,
            **{name: data.get(name) for name in ("impact", "chain", "limit", "published")},
            "predictor": self.settings("predict", data.get("predict"), Predictor),
            "simulate": self.settings("simulate", data.get("simulate"), SimulateOptions),
            "uncertainty": self.build(read_spreads, {"given": spreads, "data": self.document.data}, ("uncertainty",)),
        }
        self._together(parts["chain"], parts["impact"], parts["simulate"])
        self.finish()
        return Scenario(path=self.path, sweep=sweep, document=self.document, **parts)

    def _together(self, chain: Any, impact: Any, simulate: Any) -> None:
        """Add the faults of a chain under a shock or an impact, and of options that do not fit the chain."""
        if not isinstance(chain, Chain):
            return
        options = simulate or SimulateOptions()
        faults = faults_of(chain, impact)
        known = not faults
        if options.integrator is not None and known and (impact is not None or uniform_of(chain) is None):
            reason = load("integrators", options.integrator).refusal(chain.is_damped)
            faults = [Fault("simulate.integrator", reason)] if reason else []
        if chain.count is not None and known:
            last = chain.count + (impact is not None) + (chain.end is not None) - 2
            for index, contact in enumerate(self.document.data["simulate"]["contacts"] if options.contacts else ()):
                if to_si(contact, "") > last:  # it may be text
                    problem = f"must be at most {last}, the last contact of this chain (got {contact})"
                    faults.append(Fault(("simulate", "contacts", index), problem))
        elif known and "forces" in options.record and not options.contacts:
            faults.append(Fault("simulate.contacts", "must be given if record includes forces (got none)"))
        self.add(*faults)

    def _shock(self, data: Any) -> Any:
        given = data if isinstance(data, dict) else {}
        cls = None
        with suppress(LookupError):  # an unknown name is reported with the keys of the block
            if isinstance(name := given.get("profile"), str):
                cls = self.build(load, {"kind": "profiles", "name": name}, ("shock", "profile"))
        values, valid = self.values(("shock",), data, shock_keys(cls))
        if cls is None:
            return None
        valid = self._two_times(cls, values) and valid
        # The profile is built even if another key has an error, so that errors of its constructor are reported too.
        profile = self._profile(cls, given, values)
        if profile is None or not valid:
            return None
        sizes: dict[str, Any] = {key: values[key] for key in _SIZES if key in values}
        make = Shock.of_duration if "duration" in sizes else Shock
        return self.build(make, {"profile": profile, **sizes}, ("shock",), {(): ("shock", "profile")}, cls)

    def _two_times(self, cls: Any, values: dict[str, Any]) -> bool:
        """Replace a duration beside a rise time by their ratio; false, with a fault, if the profile refuses it."""
        if not {"rise_time", "duration"} <= values.keys() or "duration_ratio" in values:
            return True
        own = [key.spec for key in keys_of(cls) if key.name == "duration_ratio"]
        ratio = values.pop("duration") / values["rise_time"]
        problem: str | None = "must be left out if rise_time is given, because the profile has its own duration ratio"
        if own:
            problem = own[0].problem(ratio) if own[0] is not None else None
        if problem:
            self.add(Fault(("shock", "duration"), f"over rise_time {problem}" if own else problem))
        elif own:
            values["duration_ratio"] = ratio
        return not problem

    def _profile(self, cls: Any, given: Mapping[str, Any], shock: Mapping[str, Any]) -> Any:
        """Profile of the ``given`` block with the valid values ``shock``; None if the profile has errors."""
        name = find("profiles", given["profile"]).name
        values, valid = self.values(_PARAMETERS, given.get("parameters"), parameters_of(name, cls))
        own = [key for key in keys_of(cls) if key.name == "duration_ratio"]
        if "duration_ratio" not in shock:
            # a wrong or missing one is reported with the keys of the block
            valid = valid and "duration_ratio" not in given and not any(key.required for key in own)
        elif own:
            values["duration_ratio"] = shock["duration_ratio"]
        else:
            problem = f"must be left out, because profile {name!r} has its own (got {shock['duration_ratio']:g})"
            self.add(Fault(("shock", "duration_ratio"), problem))
            valid = False
        if not valid:
            return None
        make: Callable[..., Any] = cls
        places: dict[Steps, Steps] = {("duration_ratio",): ("shock", "duration_ratio")}
        if name == RECORD and "file" in values:
            values["path"] = self._file(values.pop("file"))
            if values["path"] is None:
                return None
            make = cls.from_file
            places[()] = (*_PARAMETERS, "file")
        elif name == RECORD:
            for key in values.keys() - {key.name for key in keys_of(cls)}:
                problem = f"must be left out without file (got {text_of(values.pop(key))})"
                self.add(Fault((*_PARAMETERS, key), problem, at_key=True))
        return self.build(make, values, _PARAMETERS, places, cls)

    def _file(self, name: str) -> Path | None:
        """File ``name`` in the scenario's folder or below it; None, with a fault, if it is elsewhere."""
        folder = self.path.parent if self.path is not None else Path()
        file = folder / name
        # an absolute name may lead elsewhere, too; Path.resolve raises an error for a link to itself
        if name.strip() and Path(os.path.realpath(file)).is_relative_to(os.path.realpath(folder)):
            return file
        problem = f"must be a file in the scenario's folder or below it (got {text_of(name)}; copy it there)"
        self.add(Fault((*_PARAMETERS, "file"), problem))
        return None
