"""Points of a sweep: their scenes, keys and lines of the journal, and batches of them as workers run them."""

from __future__ import annotations

import hashlib
import json
import pickle
import platform
import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from attrs import define, field

import shockwave
from shockwave.chain.chain import Scales
from shockwave.errors import FileAccessError, ShockwaveError, UsageError
from shockwave.files import read_bytes
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import simulate_many
from shockwave.options import SimulateOptions
from shockwave.registry import entries, find, load
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_family import Family
from shockwave.scenario.scene_hash import normalised
from shockwave.scenario.sweep_block import Sweep
from shockwave.simulation.backend import lack
from shockwave.studies.comparison import beside
from shockwave.sweep.columns import Answer, Read, reads, row
from shockwave.sweep.header import Header, SweepAxis
from shockwave.sweep.journal import line_of

_encoded = json.JSONEncoder(allow_nan=False).encode
_FILE = "shock.parameters.file"
# Most bytes of a record that are hashed; the reader of records has its own limit.
_MOST_RECORD = 2**28
# Raised by the code of a plugin, these cost its point alone.
_POINT_ERRORS = (Exception, SystemExit)
#: Seconds after which a worker answers, whatever is left of its batch.
SLICE = 1.0
# Points that a worker runs side by side: at first, and at most.
_FEW = 8
_MANY = 128


def error_text(error: BaseException) -> str:
    """The message of an error of ours; the type and the message of any other."""
    return str(error) if isinstance(error, ShockwaveError) else f"{type(error).__name__}: {error}"


@define(eq=False)
class Points:
    """All points of the sweep in ``scenario``.

    Parameters
    ----------
    scenario : Scenario
        With a sweep.
    """

    scenario: Scenario
    sweep: Sweep = field(init=False)
    #: Whether all waves are measured where the scene asks for them, or the primary alone.
    train: bool = field(init=False)
    columns: tuple[Read, ...] = field(init=False)
    header: Header = field(init=False)
    _family: Family = field(init=False)

    def __attrs_post_init__(self) -> None:
        assert self.scenario.sweep is not None
        self.sweep = self.scenario.sweep
        given = _document(self.scenario).get("simulate")
        asked = isinstance(given, dict) and given.get("waves") == "train"
        self.train = asked or any(variable.name == "simulate.waves" for variable in self.sweep.variables)
        self.columns = reads(self.sweep.run, self.train)
        self._family = Family(self.scenario)
        axes = (
            SweepAxis(axis.names, tuple(variable.unit for variable in axis.variables), axis.values)
            for axis in self.sweep.axes
        )
        header = Header(
            name=self.scenario.name,
            run=self.sweep.run,
            axes=tuple(axes),
            shape=self.sweep.shape,
            points=len(self.sweep),
            columns=tuple(read.column for read in self.columns),
            scenario=json.loads(normalised(self.scenario)),
            named=_named_here(self.scenario),
            versions=_versions_here(self.scenario),
        )
        self.header = header.keyed()

    @property
    def notes(self) -> list[str]:
        """What of the scenario a sweep leaves out."""
        options = self.scenario.simulate
        given = [name for name in ("contacts", "record") if getattr(options, name)]
        return [f"simulate.{name} is left out: a sweep keeps no passages and no histories" for name in given]

    def scene(self, index: int) -> Scenario:
        """The scene of a point; see `Family.scenario` for what is raised."""
        return self._family.scenario(self.sweep.point(index))

    def key(self, index: int) -> str:
        """The hash of the number of a point and of the sweep."""
        return hashlib.sha256(f"{self.header.key} {index}".encode()).hexdigest()

    def lines(self, indices: Sequence[int]) -> str:
        """Lines of the journal for some points."""
        scenes: dict[int, Scenario] = {}
        found: dict[int, SimulationResult | BaseException] = {}
        for index in indices:
            try:
                scenes[index] = self.scene(index)
            except _POINT_ERRORS as error:
                found[index] = error
        if self.sweep.run != "predict":
            found |= self._simulated(scenes)
        return "".join(self._line(index, scenes.get(index), found.get(index)) for index in indices)

    def _line(self, index: int, scene: Scenario | None, found: SimulationResult | BaseException | None) -> str:
        """The line of a point; ``found`` is its result, if it is simulated, or its error."""
        key = self.key(index)
        try:
            if isinstance(found, BaseException):
                raise found
            assert scene is not None
            values = _encoded(row(self.columns, _answer(self.sweep.run, scene, found)))
        except _POINT_ERRORS as error:
            return line_of(index, key, "failed", f'"error": {json.dumps(error_text(error))}')
        return line_of(index, key, "done", f'"values": {values}')

    def _simulated(self, scenes: Mapping[int, Scenario]) -> dict[int, SimulationResult | BaseException]:
        """Results by the numbers of the points; scenes that ask for the same run side by side."""
        asked: dict[SimulateOptions, list[int]] = {}
        for index, scene in scenes.items():
            asked.setdefault(scene.simulate, []).append(index)
        found: dict[int, SimulationResult | BaseException] = {}
        for options, indices in asked.items():
            try:
                found |= zip(indices, self._many(options, [scenes[index] for index in indices]), strict=True)
            except _POINT_ERRORS:  # of one of them: which one shows when they run one by one
                for index in indices:
                    try:
                        (found[index],) = self._many(options, [scenes[index]])
                    except _POINT_ERRORS as error:
                        found[index] = error
        return found

    def _many(
        self, options: SimulateOptions, scenes: Sequence[Scenario]
    ) -> Sequence[SimulationResult | ShockwaveError]:
        return simulate_many(
            [scene.shock for scene in scenes],
            [scene.chain for scene in scenes],
            options.rtol,
            options.integrator,
            options.wave_threshold,
            step=options.step,
            waves=options.waves if self.train else "primary",
            backend=options.backend,
            threads=1,
        )


def _answer(run: str, scene: Scenario, simulated: SimulationResult | None) -> Answer:
    characteristic = Scales.of(scene.chain, scene.shock.peak_force).time
    times = scene.shock.rise_time / characteristic, scene.shock.duration / characteristic
    predicted = scene.predictor.predict(scene.shock, scene.chain) if run != "simulate" else None
    if simulated is None:
        return Answer(*times, predicted)
    compared = beside(predicted, simulated, scene.predictor.equal_tolerance) if predicted is not None else None
    return Answer(*times, predicted, simulated, None if compared else simulated.primary, compared)


# ---------------------------------------------------------------- what a scenario names


def _document(scenario: Scenario) -> Mapping[str, Any]:
    """The document of a scenario; empty for one made in Python."""
    return scenario.document.data if scenario.document is not None else {}


def _words(scenario: Scenario, name: str) -> set[str]:
    """The texts among the values of a variable of the sweep."""
    axes = scenario.sweep.axes if scenario.sweep else ()
    columns = [(axis, axis.names.index(name)) for axis in axes if name in axis.names]
    return {values[at] for axis, at in columns for values in axis.values if isinstance(values[at], str)}


def _versions_here(scenario: Scenario) -> dict[str, str]:
    """Versions, here, of what results depend on: packages, the distributions of plugins, and the code in use."""
    found = {
        "shockwave": shockwave.__version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": metadata.version("scipy"),
        "backend": "numpy" if lack() else "compiled",
    }
    named: dict[str, set[str | None]] = {
        "profiles": {_profile(scenario), *_words(scenario, "shock.profile")},
        "materials": {scenario.chain.material.name, *_words(scenario, "chain.material")},
        "integrators": {scenario.simulate.integrator, *_words(scenario, "simulate.integrator")},
        "models": {scenario.predictor.model, *_words(scenario, "predict.model")},
        "quadratures": {scenario.predictor.quadrature, *_words(scenario, "predict.quadrature")},
    }
    for kind, names in named.items():
        for name in sorted(filter(None, names)):
            # a material of the scenario's own may have any name
            with suppress(ShockwaveError):
                distribution = find(kind, name).distribution
                if distribution != shockwave.OWN_DISTRIBUTION:
                    found[distribution] = metadata.version(distribution)
    return found


def _profile(scenario: Scenario) -> str:
    """The name of the profile; none for a class that is not registered."""
    if scenario.document is not None:
        return str(scenario.document.data["shock"]["profile"])
    cls = type(scenario.shock.profile)
    address = f"{cls.__module__}:{cls.__qualname__}"
    return next((entry.name for entry in entries("profiles") if entry.address == address), "")


def _named_here(scenario: Scenario) -> dict[str, str]:
    """Hashes of the materials and files that a scenario names."""
    materials = sorted(_words(scenario, "chain.material"))
    found = {f"material {name}": _hash(repr(load("materials", name))) for name in materials}
    own = (_document(scenario).get("shock", {}).get("parameters") or {}).get("file")
    files = _words(scenario, _FILE)
    if isinstance(own, str):
        files.add(own)
    return found | {f"file {name}": _file_hash(scenario, name) for name in sorted(files)}


def _file_hash(scenario: Scenario, name: str) -> str:
    folder = scenario.path.parent if scenario.path is not None else Path()
    try:
        return _hash(read_bytes(folder / name, _MOST_RECORD))
    except FileAccessError:  # its points will fail, with this error
        return ""


def _hash(content: str | bytes) -> str:
    return hashlib.sha256(content.encode() if isinstance(content, str) else content).hexdigest()


# ---------------------------------------------------------------- batches, as workers run them


class Done(NamedTuple):
    """The first points of a batch: their lines of the journal, and how many seconds they took."""

    lines: str
    seconds: float


# Of each thread: what a sweep keeps between batches is not made for several at once.
_known = threading.local()


def run_batch(content: bytes, indices: Sequence[int]) -> Done:
    """Run the first of some points of a sweep, for about a second.

    The time that points take may change from one to the next, and what is not answered can be lost.

    Raises
    ------
    UsageError
        When this worker cannot take part.
    """
    if getattr(_known, "content", None) != content:
        _known.points = understood(content)
        _known.content = content
    begin = now = time.perf_counter()
    lines, at, size = "", 0, _FEW
    while at < len(indices) and now - begin < SLICE:
        lines += _known.points.lines(indices[at : at + size])
        at += size
        before, now = now, time.perf_counter()
        fit = int(size * SLICE / 4 / max(now - before, 1e-9))
        size = max(1, min(4 * size, _MANY, fit))
    return Done(lines, now - begin)


def content_of(points: Points) -> bytes:
    """A sweep as workers get it; raises whatever pickle raises for a scene made in Python that cannot be sent."""
    return pickle.dumps((points.scenario, points.header))


def understood(content: bytes) -> Points:
    """The points of a sweep, if this worker has the versions, materials and files of the client.

    Raises
    ------
    UsageError
        When it has not.
    """
    try:
        scenario, header = pickle.loads(content)
    except (Exception, SystemExit) as error:  # of a plugin, maybe
        got = f"got {error_text(error)}; install there what is installed here"
        raise UsageError(f"workers must be able to read the scenario ({got})") from None
    points = Points(scenario)
    here = points.header.versions | points.header.named
    there = header.versions | header.named
    differ = [f"{name} {here.get(name)}, not {there[name]}" for name in there if here.get(name) != there[name]]
    if differ:
        got = f"got a worker with {'; '.join(differ)}; install or copy the same"
        raise UsageError(f"workers must have what the client has ({got})")
    points.header = header
    return points
