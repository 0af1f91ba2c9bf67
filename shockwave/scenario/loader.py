"""The loader: from a scenario file to a shock, a chain, and what is asked about them, or to all its faults."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from attrs import define, evolve

from shockwave.chain.chain import Chain
from shockwave.chain.material import Material
from shockwave.errors import Fault, FileAccessError, PluginError, UnknownNameError
from shockwave.fields import text_of
from shockwave.options import SimulateOptions
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.shock import Shock
from shockwave.registry import DISABLE, blame, load, plugins, same_distribution
from shockwave.scenario.fault_collector import FaultCollector
from shockwave.scenario.keys import BLOCKS, CHAIN, RECORD, SCENARIO, keys_of, parameters_of, shock_keys
from shockwave.scenario.scenario import Published, Scenario
from shockwave.scenario.sweep import Sweep, beginnings, first, read
from shockwave.scenario.uncertainty import read as read_spreads
from shockwave.scenario.value_conversion import missing
from shockwave.scenario.yaml_document import Document, Steps, read_document

DISTRIBUTION = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9._-]{0,100}[A-Za-z0-9])?")
_PARAMETERS: Steps = ("shock", "parameters")
_FILE: Steps = (*_PARAMETERS, "file")


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


def scenario_of(
    document: Document, path: Path | None, faults: Sequence[Fault] = (), tries: slice = slice(None)
) -> Scenario:
    """The scenario that ``document`` describes; see `load_scenario`.

    ``faults`` are those that reading it has found. Of a sweep it is the first scene that can be, out of ``tries`` of
    `beginnings`; if there is none, the faults are those of the first try.
    """
    collector = FaultCollector(document, list(faults))
    sweep = read(collector, document.data) if document.data.get("sweep") is not None else None
    problem: BaseException | None = None
    for index in beginnings(sweep)[tries]:
        scene = first(document, sweep, index)
        try:
            loading = _Loading(scene, list(collector.faults), plugin=collector.plugin, path=path)
            return loading.scenario(document, sweep)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # of a plugin, maybe
            problem = problem or error
    assert problem is not None
    raise problem


@define(eq=False)
class _Loading(FaultCollector):
    """Builds the parts of a scenario, each as far as it can be, whatever is wrong with the others.

    ``document`` is that of one scene.
    """

    path: Path | None = None

    def scenario(self, whole: Document, sweep: Sweep | None) -> Scenario:
        """The scenario of one scene of ``sweep``, which the document ``whole`` holds."""
        data, _ = self.values((), self.document.data, SCENARIO)
        parts = {
            "name": self._name(data.get("name")),
            "shock": self._shock(data.get("shock")) if "shock" in data else None,
            "chain": self._chain(data.get("chain")) if "chain" in data else None,
            "predictor": self.block(("predict",), data.get("predict"), Predictor, BLOCKS["predict"]),
            "simulate": self.block(("simulate",), data.get("simulate"), SimulateOptions, BLOCKS["simulate"]),
            "published": None,
        }
        if data.get("published") is not None:
            parts["published"] = self.block(("published",), data["published"], Published, keys_of(Published))
        self._requires(data.get("requires"))
        spreads = whole.data.get("uncertainty")
        uncertainty = read_spreads(spreads, self.document.data, self._add_to_uncertainty) if spreads is not None else ()
        self.finish()
        return Scenario(path=self.path, sweep=sweep, uncertainty=uncertainty, document=self.document, **parts)

    def _name(self, given: str | None) -> str:
        if given is None:
            return self.path.stem if self.path is not None else self.document.name
        if not given.strip() or "\n" in given:
            self.add(("name",), f"must be a line of text (got {text_of(given)})")
        return given

    def _add_to_uncertainty(self, steps: Steps, problem: str, at_key: bool) -> None:
        self.add(("uncertainty", *steps), problem, at_key)

    def _requires(self, given: Any) -> None:
        from importlib.metadata import PackageNotFoundError, distribution

        for index, name in enumerate(given or ()):
            path: Steps = ("requires", index)
            try:
                if not DISTRIBUTION.fullmatch(name):
                    self.add(path, f"must be the name of a distribution, without a version (got {text_of(name)})")
                elif distribution(name).entry_points.select(group="shockwave"):
                    self._check_usable(path, name)
            except PackageNotFoundError:
                remedy = "install it if you trust it: an index may hold another of that name"
                self.add(path, f"must be installed (got nothing of the name {name}; {remedy})")

    def _check_usable(self, path: Steps, name: str) -> None:
        """Whether the plugin that the scenario requires can be used."""
        for plugin in plugins():
            if same_distribution(plugin.distribution, name) and not plugin.entries:
                if plugin.disabled:
                    self.add(path, f"must be in use (got {name}, disabled by {DISABLE} or --no-plugins)")
                else:
                    self.blame(path, PluginError(f"must be a plugin that works (got {plugin.problem})"))

    # ---------------------------------------------------------------- chain

    def _chain(self, data: Any) -> Chain | None:
        values, sound = self.values(("chain",), data, CHAIN)
        given = data if isinstance(data, dict) else {}
        sizes = [name for name in given if name in ("diameter", "radius")]
        if isinstance(data, dict | None) and not sizes:
            self.report(("chain",), [missing(("diameter",), "give a diameter or a radius")])
        elif len(sizes) == 2:
            problem = "must be given once, as a diameter or as a radius (got both; delete one)"
            self.add(("chain", sizes[1]), problem, at_key=True)
        material = self._material(values["material"]) if "material" in values else None
        if not sound or len(sizes) != 1 or material is None:
            return None
        if "diameter" in values:
            values["radius"] = values.pop("diameter") / 2
        chain: Chain | None = self.build(
            Chain, values | {"material": material}, ("chain",), {"radius": ("chain", sizes[0])}
        )
        return chain

    def _material(self, data: Any) -> Any:
        path: Steps = ("chain", "material")
        if isinstance(data, str):
            return self._loaded(path, "materials", data)
        if isinstance(data, dict | None):
            return self.block(path, data, Material, keys_of(Material))
        self.add(path, f"must be a name of the material library, or a mapping (got {text_of(data)})")
        return None

    def _loaded(self, path: Steps, kind: str, name: str) -> Any:
        """What is registered as ``name``, or None."""
        try:
            return load(kind, name)
        except PluginError as error:
            self.blame(path, error)
        except UnknownNameError:
            pass  # reported with the keys of the block
        return None

    # ---------------------------------------------------------------- shock

    def _shock(self, data: Any) -> Shock | None:
        given = data if isinstance(data, dict) else {}
        name = given.get("profile")
        cls = self._loaded(("shock", "profile"), "profiles", name) if isinstance(name, str) else None
        keys = shock_keys(cls)
        if "duration" in given:
            keys = tuple(evolve(key, required=key.required and key.name != "rise_time") for key in keys)
            if "rise_time" in given:
                problem = "must be left out where rise_time is given (got both; delete one)"
                self.add(("shock", "duration"), problem, at_key=True)
        values, sound = self.values(("shock",), data, keys)
        if cls is None:
            return None
        # The profile is built even where another key is at fault, for what its constructor has to say.
        profile = self._profile(str(name), cls, given, values)
        if profile is None or not sound or {"duration", "rise_time"} <= values.keys():
            return None
        sizes = {key: values[key] for key in ("peak_force", "rise_time", "duration") if key in values}
        make = _guarded(cls, Shock.of_duration if "duration" in sizes else Shock)
        shock: Shock | None = self.build(make, sizes | {"profile": profile}, ("shock",), {"": ("shock", "profile")})
        return shock

    def _profile(
        self, name: str, cls: type[ShockProfile], given: Mapping[str, Any], shock: Mapping[str, Any]
    ) -> ShockProfile | None:
        """The profile of a block, of whose values ``shock`` are sound."""
        keys = keys_of(cls)
        values, sound = self.values(_PARAMETERS, given.get("parameters"), parameters_of(name, cls))
        if "duration_ratio" in shock:
            values["duration_ratio"] = shock["duration_ratio"]
        if not sound or ("duration_ratio" in given and "duration_ratio" not in shock):
            return None
        if "duration_ratio" in values and all(key.name != "duration_ratio" for key in keys):
            problem = f"must be left out, as profile {name!r} has its own (got {values['duration_ratio']:g})"
            self.add(("shock", "duration_ratio"), problem)
            return None
        make: Callable[..., Any] = cls
        if name == RECORD:
            record = self._record(cls, values)
            if record is None:
                return None
            make, values = record
        elif not all(key.name in values for key in keys if key.required):
            return None  # reported as missing
        elsewhere: dict[str, Steps] = {"duration_ratio": ("shock", "duration_ratio")}
        try:
            profile: ShockProfile | None = self.build(_guarded(cls, make), values, _PARAMETERS, elsewhere)
        except FileAccessError as error:
            self.access = error
            self.add(_FILE, str(error))
            return None
        return profile

    def _record(self, cls: Any, values: dict[str, Any]) -> tuple[Callable[..., Any], dict[str, Any]] | None:
        """What makes a record, and of what: its file, or its samples."""
        samples = [name for name in ("times", "forces") if name in values]
        if "file" not in values:
            if len(samples) == 2:
                return cls, values
            lacking = [name for name in ("times", "forces") if name not in samples]
            purpose = f"give {' and '.join(lacking)}, or a file"
            self.report(_PARAMETERS, [missing((lacking[0] if samples else "file",), purpose)])
            return None
        if samples:
            self.add(_FILE, f"must be left out where {samples[0]} are given (got both)", at_key=True)
            return None
        file = self._file(values.pop("file"))
        return (cls.from_file, {"path": file, **values}) if file is not None else None

    def _file(self, name: str) -> Path | None:
        """The file called ``name`` in the scenario's folder, or below it."""
        folder = self.path.parent if self.path is not None else Path()
        try:
            inside = not Path(name).is_absolute() and (folder / name).resolve().is_relative_to(folder.resolve())
        except (OSError, RuntimeError, ValueError) as error:  # a loop of links, a name that is too long
            self.add(_FILE, f"must be the name of a file (got {text_of(name)}; {text_of(str(error))})")
            return None
        if not inside or not name.strip():
            problem = f"must be a file in the scenario's folder or below it (got {text_of(name)}; copy it there)"
            self.add(_FILE, problem)
            return None
        return folder / name


def _guarded(cls: type[ShockProfile], make: Callable[..., Any]) -> Callable[..., Any]:
    """``make``, of which whatever it raises but does not mean for the user is the fault of who wrote ``cls``."""

    def made(**values: Any) -> Any:
        with blame("profiles", cls):
            return make(**values)

    return made
