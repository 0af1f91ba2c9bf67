"""Loading: from a scenario file to a shock, a chain, and what is asked about them, or to all its faults."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from attrs import define, evolve, field, frozen

from shockwave import OWN_DISTRIBUTION
from shockwave.chain.chain import Chain
from shockwave.chain.material import Material
from shockwave.errors import (
    Fault,
    FileAccessError,
    PluginError,
    ShockwaveError,
    UnknownNameError,
)
from shockwave.fields import text_of
from shockwave.options import SimulateOptions
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.shock import Shock
from shockwave.registry import DISABLE, find, load, plugins, same_distribution
from shockwave.scenario.blocks import (
    CHAIN,
    RECORD,
    SCENARIO,
    Published,
    keys_of,
    parameters_of,
    profile_class,
    shock_keys,
)
from shockwave.scenario.gathering import Gathering
from shockwave.scenario.sweep import Sweep, beginnings, first, read
from shockwave.scenario.uncertainty import Spread
from shockwave.scenario.uncertainty import read as read_spreads
from shockwave.scenario.values import missing, structure
from shockwave.scenario.yaml_document import Document, Steps, read_document

__all__ = ["DISTRIBUTION", "Published", "Scenario", "load_scenario", "scenario_of"]

DISTRIBUTION = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9._-]{0,100}[A-Za-z0-9])?")


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
    sweep : Sweep or None
        The scenes that it stands for; shock, chain and settings are then those of the first that can be.
    uncertainty : tuple of Spread
        How well values are known; none where nothing is said of it.
    document : Document or None
        What it was read from, without the blocks ``sweep`` and ``uncertainty``.
    """

    name: str
    path: Path | None
    shock: Shock
    chain: Chain
    predictor: Predictor
    simulate: SimulateOptions
    published: Published | None = None
    sweep: Sweep | None = None
    uncertainty: tuple[Spread, ...] = ()
    document: Document | None = field(default=None, eq=False, repr=False)

    @property
    def files(self) -> tuple[Path, ...]:
        """Files that the scenario was read from: its own and that of its record."""
        if self.path is None or self.document is None:
            return ()
        shock = self.document.data["shock"]
        record = (shock.get("parameters") or {}).get("file") if shock["profile"] == RECORD else None
        return (self.path, self.path.parent / record) if record else (self.path,)


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
    loading = _Loading(document, list(faults), path=path)
    sweep = read(loading, document.data) if document.data.get("sweep") is not None else None
    problem: BaseException | None = None
    for index in beginnings(sweep)[tries]:
        try:
            return _scene(loading, first(document, sweep, index), sweep)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # of a plugin, maybe
            problem = problem or error
            loading = _Loading(document, list(faults), path=path)
    assert problem is not None
    raise problem


def _scene(loading: _Loading, document: Document, sweep: Sweep | None) -> Scenario:
    """The scenario of a document without a sweep, one scene of ``sweep``."""
    spread = loading.document.data.get("uncertainty")
    loading.document = document
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
        "published": loading.published(data),
    }
    loading.requires(data.get("requires"))
    uncertainty = loading.uncertainty(spread) if spread is not None else ()
    loading.finish()
    return Scenario(path=loading.path, sweep=sweep, uncertainty=uncertainty, document=document, **parts)


def _without_empty(data: Mapping[str, Any]) -> dict[str, Any]:
    """``data`` without the optional blocks that hold nothing, all of whose keys may be commented out."""
    spare = [key.name for key in SCENARIO if not key.required and key.annotation is not str]
    return {name: value for name, value in data.items() if value is not None or name not in spare}


@define(eq=False)
class _Loading(Gathering):
    """Builds the parts of a scenario, each as far as it can be, whatever is wrong with the others."""

    path: Path | None = None

    def name(self, given: Any) -> str:
        if isinstance(given, str):
            if not given.strip() or "\n" in given:
                self.add(("name",), f"must be a line of text (got {text_of(given)})")
            return given
        return self.path.stem if self.path is not None else self.document.name

    def published(self, data: Mapping[str, Any]) -> Published | None:
        given = data.get("published") is not None
        made: Published | None = self.options("published", data, Published) if given else None
        return made

    def uncertainty(self, given: Any) -> tuple[Spread, ...]:
        def add(steps: Steps, problem: str, at_key: bool) -> None:
            self.add(("uncertainty", *steps), problem, at_key)

        return read_spreads(given, self.document.data, add)

    def requires(self, given: Any) -> None:
        from importlib.metadata import PackageNotFoundError, distribution

        for index, name in enumerate(given if isinstance(given, list) else ()):
            if not isinstance(name, str):
                continue  # reported by its type
            path: Steps = ("requires", index)
            if not DISTRIBUTION.fullmatch(name):
                self.add(path, f"must be the name of a distribution, without a version (got {text_of(name)})")
                continue
            try:
                points = distribution(name).entry_points
            except PackageNotFoundError:
                remedy = "install it if you trust it: an index may hold another of that name"
                self.add(path, f"must be installed (got nothing of the name {name}; {remedy})")
                continue
            if points.select(group="shockwave"):
                self._usable(path, name)

    def _usable(self, path: Steps, name: str) -> None:
        """Whether the plugin that the scenario requires can be used."""
        for plugin in plugins():
            if same_distribution(plugin.distribution, name) and not plugin.entries:
                if plugin.disabled:
                    self.add(path, f"must be in use (got {name}, disabled by {DISABLE} or --no-plugins)")
                else:
                    self.blame(path, PluginError(f"must be a plugin that works (got {plugin.problem})"))

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
        material = self.material(given["material"]) if "material" in given else None
        if wrongs or len(sizes) != 1 or material is None:
            return None
        values["material"] = material
        if "diameter" in values:
            values["radius"] = values.pop("diameter") / 2

        def where(steps: Steps) -> Steps:
            return ("chain", *(sizes[0] if step == "radius" else step for step in steps))

        chain: Chain | None = self.build(Chain, values, where)
        return chain

    def material(self, data: Any) -> Material | None:
        path = ("chain", "material")
        if not isinstance(data, str | dict | None):
            self.add(path, f"must be a name of the material library, or a mapping (got {text_of(data)})")
            return None
        if not isinstance(data, str):
            keys = keys_of(Material)
            values, wrongs = structure(data, keys)
            self.report(path, wrongs)
            made = None if wrongs else self.build(Material, values, lambda steps: (*path, *steps))
            return made if isinstance(made, Material) else None
        try:
            material: Material = load("materials", data)
        except (UnknownNameError, PluginError) as error:
            self.blame(path, error)
            return None
        return material

    # ---------------------------------------------------------------- shock

    def shock(self, data: Any) -> Shock | None:
        if data is None and "shock" not in self.document.data:
            return None
        given = data if isinstance(data, dict) else {}
        cls = self._profile_class(given.get("profile"))
        keys = shock_keys(cls)
        if "duration" in given:
            keys = tuple(evolve(key, required=key.required and key.name != "rise_time") for key in keys)
        values, wrongs = structure(data, keys)
        self.report(("shock",), wrongs)
        if "duration" in given and "rise_time" in given:
            problem = "must be left out where rise_time is given (got both; delete one)"
            self.add(("shock", "duration"), problem, at_key=True)
            return None
        if cls is None:
            return None
        name = given["profile"]
        parameters, more = structure(given.get("parameters"), parameters_of(name, cls))
        self.report(("shock", "parameters"), more)
        if more or any(wrong.path[:1] == ("duration_ratio",) for wrong in wrongs):
            return None
        # The profile is built even where another key is at fault, for what its constructor has to say.
        ratio = {key: given[key] for key in ("duration_ratio",) if key in given}
        parameters |= structure(ratio, [key for key in keys if key.name in ratio])[0]
        profile = self._profile(name, cls, parameters)
        if profile is None or wrongs:
            return None
        sizes: dict[str, Any] = {key: values[key] for key in ("peak_force", "rise_time", "duration") if key in values}
        kind = Shock.of_duration if "duration" in sizes else Shock

        def make(**sizes: float) -> Shock:
            with _blame(name):
                return kind(profile=profile, **sizes)

        shock: Shock | None = self.build(make, sizes, lambda steps: ("shock", *(steps or ("profile",))))
        return shock

    def _profile_class(self, name: Any) -> type[ShockProfile] | None:
        if not isinstance(name, str):
            return None
        try:
            return profile_class(name)
        except (UnknownNameError, PluginError) as error:
            self.blame(("shock", "profile"), error)
            return None

    def _profile(self, name: str, cls: type[ShockProfile], values: dict[str, Any]) -> ShockProfile | None:
        keys = keys_of(cls)
        if "duration_ratio" in values and all(key.name != "duration_ratio" for key in keys):
            problem = f"must be left out, as profile {name!r} has its own (got {values['duration_ratio']:g})"
            self.add(("shock", "duration_ratio"), problem)
            return None
        make: Callable[..., Any] = cls
        inside: Steps = ()
        if name == RECORD:
            record = self._record(values)
            if record is None:
                return None
            make, values = record
            inside = ("file",) if "path" in values else ()

        def where(steps: Steps) -> Steps:
            own = steps[:1] == ("duration_ratio",)
            return ("shock", *steps) if own else ("shock", "parameters", *(inside or steps))

        def guarded(**values: Any) -> Any:
            with _blame(name):
                return make(**values)

        try:
            profile: ShockProfile | None = self.build(
                guarded, values, where, [key.name for key in keys if not key.required]
            )
        except FileAccessError as error:
            self.access = error
            self.add(where(()), str(error))
            return None
        return profile

    def _record(self, values: dict[str, Any]) -> tuple[Callable[..., Any], dict[str, Any]] | None:
        """What makes a record, and of what: its file, or its samples."""
        from shockwave.profiles.tabulated import Tabulated

        path = ("shock", "parameters")
        samples = [name for name in ("times", "forces") if name in values]
        if "file" not in values:
            if len(samples) == 2:
                return Tabulated, values
            lacking = [name for name in ("times", "forces") if name not in samples]
            purpose = f"give {' and '.join(lacking)}, or a file"
            self.report(path, [missing((lacking[0] if samples else "file",), purpose)])
            return None
        if samples:
            self.add((*path, "file"), f"must be left out where {samples[0]} are given (got both)", at_key=True)
            return None
        file = self._file((*path, "file"), values["file"])
        rest = {name: value for name, value in values.items() if name != "file"}
        return (Tabulated.from_file, {"path": file, **rest}) if file is not None else None

    def _file(self, path: Steps, name: str) -> Path | None:
        """The file called ``name`` in the scenario's folder, or below it."""
        folder = self.path.parent if self.path is not None else Path()
        file = folder / name
        try:
            inside = not Path(name).is_absolute() and file.resolve().is_relative_to(folder.resolve())
        except (OSError, RuntimeError, ValueError) as error:  # a loop of links, a name that is too long
            self.add(path, f"must be the name of a file (got {text_of(name)}; {text_of(str(error))})")
            return None
        if not inside or not name.strip():
            problem = f"must be a file in the scenario's folder or below it (got {text_of(name)}; copy it there)"
            self.add(path, problem)
            return None
        return file


@contextmanager
def _blame(name: str) -> Iterator[None]:
    """Whatever a profile raises other than what is meant for the user is the fault of who wrote it."""
    try:
        yield
    except ShockwaveError:
        raise
    except (Exception, SystemExit) as error:
        owner = find("profiles", name).distribution
        if owner == OWN_DISTRIBUTION:
            raise
        got = f"got {type(error).__name__}: {text_of(str(error), 200)}"
        problem = f"must raise InvalidValueError for values that it does not take ({got})"
        raise PluginError(f"profile {name!r} of {owner}: {problem}") from error
