"""Points of a sweep: from their numbers to lines of the journal. This is what runs in the workers."""

from __future__ import annotations

import hashlib
import json
import pickle
import platform
import signal
import threading
import time
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from attrs import define, field

import shockwave
from shockwave.chain.chain import Scales
from shockwave.errors import FileAccessError, ShockwaveError
from shockwave.files import read_bytes
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import simulate_many
from shockwave.options import SimulateOptions
from shockwave.registry import load
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_family import Family
from shockwave.scenario.scene_hash import Normaliser
from shockwave.scenario.sweep import Sweep
from shockwave.simulation.backend import lack
from shockwave.studies.comparison import beside
from shockwave.sweep.columns import Answer, Read, reads, row

__all__ = [
    "Done",
    "Order",
    "Points",
    "Refused",
    "check",
    "do",
    "let_through",
    "line_of",
    "ready",
    "told",
    "understood",
    "versions_of",
]

_encoded = json.JSONEncoder(allow_nan=False).encode
_OWN = ("shockwave", "python", "numpy", "backend")
_FILE = "shock.parameters.file"
# Most bytes of a record that are hashed; the reader of records has its own limit.
_MOST_RECORD = 2**28
# Seconds after which a worker answers, whatever is left of its batch; points that it runs side by side: first, at most.
_SLICE, _FEW, _MANY = 1.0, 8, 128


def let_through(error: BaseException) -> None:
    """Raise the user's interrupt again. Whatever else the code of a plugin raises costs its point alone."""
    interruptible = threading.current_thread() is threading.main_thread()
    interruptible = interruptible and signal.getsignal(signal.SIGINT) is not signal.SIG_IGN
    if interruptible and isinstance(error, KeyboardInterrupt):
        raise error


def told(error: BaseException) -> str:
    """What is said of an error, whoever wrote it."""
    try:
        return str(error) if isinstance(error, ShockwaveError) else f"{type(error).__name__}: {error}"
    except BaseException as other:
        let_through(other)
        return type(error).__name__


def versions_of(plugins: Sequence[str]) -> dict[str, str]:
    """Versions, here, of what results depend on: shockwave, Python, NumPy, SciPy, and distributions of plugins.

    Which code steps chains is one of them.
    """
    own = (shockwave.__version__, platform.python_version(), np.__version__, "numpy" if lack() else "compiled")
    found = dict(zip(_OWN, own, strict=True))
    for name in ("scipy", *plugins):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def line_of(index: int, key: str, status: str, rest: str) -> str:
    """A line of the journal."""
    return f'{{"index": {index}, "key": "{key}", "status": "{status}", {rest}}}\n'


@define(eq=False)
class Points:
    """All points of the sweep in ``scenario``.

    Parameters
    ----------
    scenario : Scenario
        With a sweep.
    versions : mapping
        Of what results depend on; part of the keys of the points.
    train : bool
        Whether all waves are measured where the scene asks for them, or the primary alone.
    named : mapping, optional
        What names of materials and files stand for, as hashes; left out, what they stand for here.
    """

    scenario: Scenario
    versions: Mapping[str, str]
    train: bool
    named: Mapping[str, str] = field(default=None)
    sweep: Sweep = field(init=False)
    columns: tuple[Read, ...] = field(init=False)
    _family: Family = field(init=False)
    _normaliser: Normaliser = field(init=False, factory=Normaliser)
    _base: Any = field(init=False)

    def __attrs_post_init__(self) -> None:
        assert self.scenario.sweep is not None
        self.sweep = self.scenario.sweep
        self.columns = reads(self.sweep.run, self.train)
        if self.named is None:
            self.named = self._named()
        self._family = Family(self.scenario)
        about = {"run": self.sweep.run, "train": self.train, "versions": dict(self.versions)}
        self._base = hashlib.sha256(json.dumps(about, sort_keys=True).encode())

    def scene(self, index: int) -> Scenario:
        """The scene of a point; see `Family.scenario` for what is raised."""
        return self._family.scenario(self.sweep.point(index))

    def key(self, index: int) -> str:
        """The hash of the normalised scene of a point and of versions; of its values where there is no scene."""
        try:
            return self._key_of(index, self.scene(index))
        except BaseException as error:
            let_through(error)
            return self.key_of_values(index)

    def _key_of(self, index: int, scene: Scenario) -> str:
        try:
            return self._key(self._normaliser.text(scene))
        except BaseException as error:  # a profile that has no text, for an attribute that is infinite, say
            let_through(error)
            return self.key_of_values(index)

    def key_of_values(self, index: int) -> str:
        """The hash of the values of a point and of versions, for which no scene is made."""
        return self._key(json.dumps(self.sweep.point(index), sort_keys=True, default=repr))

    def _key(self, text: str) -> str:
        digest = self._base.copy()
        digest.update(text.encode())
        found: str = digest.hexdigest()
        return found

    def _named(self) -> dict[str, str]:
        """What names of materials and files stand for here, as hashes."""
        found: dict[str, str] = {}
        for axis in self.sweep.axes:
            for at, name in enumerate(axis.names):
                for word in {values[at] for values in axis.values if isinstance(values[at], str)}:
                    if name == "chain.material":
                        found[f"material {word}"] = _hash(repr(load("materials", word)).encode())
                    elif name == _FILE:
                        found[f"file {word}"] = self._content(word)
        if (own := self._file) is not None:
            found[f"file {own}"] = self._content(own)
        return found

    @property
    def _file(self) -> str | None:
        """The file that the document names."""
        data = self.scenario.document.data if self.scenario.document is not None else {}
        name = (data.get("shock", {}).get("parameters") or {}).get("file")
        return name if isinstance(name, str) else None

    def _content(self, name: str) -> str:
        folder = self.scenario.path.parent if self.scenario.path is not None else Path()
        try:
            return _hash(read_bytes(folder / name, _MOST_RECORD))
        except FileAccessError:  # its points will fail, and say so
            return ""

    def _check_file(self, index: int, seen: dict[str, str]) -> None:
        """Refuse a point whose file is not what the client has read: workers have disks of their own."""
        name = self.sweep.point(index).get(_FILE, self._file)
        if not isinstance(name, str) or f"file {name}" not in self.named:
            return
        if name not in seen:
            seen[name] = self._content(name)
        if seen[name] != self.named[f"file {name}"]:
            raise FileAccessError(f"{name}: must be as the client has read it (got another content; copy it anew)")

    def lines(self, indices: Sequence[int]) -> tuple[str, int]:
        """Lines of the journal for some points, and how many of these failed."""
        scenes: dict[int, Scenario] = {}
        found: dict[int, SimulationResult | BaseException] = {}
        seen: dict[str, str] = {}
        for index in indices:
            try:
                if self.named:
                    self._check_file(index, seen)
                scenes[index] = self.scene(index)
            except BaseException as error:
                let_through(error)
                found[index] = error
        if self.sweep.run != "predict":
            found |= self._simulated(scenes)
        lines = [self._line(index, scenes.get(index), found.get(index)) for index in indices]
        return "".join(line for line, _ in lines), sum(failed for _, failed in lines)

    def _line(self, index: int, scene: Scenario | None, found: Any) -> tuple[str, bool]:
        """The line of a point, and whether it failed; ``found`` is its result, if it is simulated, or its error."""
        key = self.key_of_values(index) if scene is None else self._key_of(index, scene)
        problem = found
        if scene is not None and not isinstance(found, BaseException):
            try:
                values = row(self.columns, _answer(self.sweep.run, scene, found))
                return line_of(index, key, "done", f'"values": {_encoded(values)}'), False
            except BaseException as error:
                let_through(error)
                problem = error
        return line_of(index, key, "failed", f'"error": {json.dumps(told(problem))}'), True

    def _simulated(self, scenes: Mapping[int, Scenario]) -> dict[int, SimulationResult | BaseException]:
        """Results by the numbers of the points; scenes that ask for the same run side by side."""
        asked: dict[SimulateOptions, list[int]] = {}
        for index, scene in scenes.items():
            asked.setdefault(scene.simulate, []).append(index)
        found: dict[int, SimulationResult | BaseException] = {}
        for options, indices in asked.items():
            try:
                found |= zip(indices, self._many(options, [scenes[index] for index in indices]), strict=True)
            except BaseException as fault:  # of one of them: which one shows when they run one by one
                let_through(fault)
                for index in indices:
                    try:
                        (found[index],) = self._many(options, [scenes[index]])
                    except BaseException as error:
                        let_through(error)
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
    natural = Scales.of(scene.chain, scene.shock.peak_force).time
    times = scene.shock.rise_time / natural, scene.shock.duration / natural
    predicted = scene.predictor.predict(scene.shock, scene.chain) if run != "simulate" else None
    if simulated is None:
        return Answer(*times, predicted)
    compared = beside(predicted, simulated, scene.predictor.equal_tolerance) if predicted is not None else None
    return Answer(*times, predicted, simulated, None if compared else simulated.primary, compared)


# ---------------------------------------------------------------- in a worker


class Order(NamedTuple):
    """What a worker must know of a sweep: what it is known by, and all the rest, for one that does not know it."""

    name: str
    content: bytes | None

    @classmethod
    def of(cls, points: Points) -> Order:
        """The order to run ``points``.

        Raises
        ------
        Exception
            Whatever pickle raises for a scene made in Python that has something that cannot be sent.
        """
        content = pickle.dumps((points.scenario, dict(points.versions), points.train, points.named))
        return cls(_hash(content), content)


class Done(NamedTuple):
    """The first points of a batch, which were run: lines of the journal, how many failed, how many seconds it took."""

    lines: str
    failed: int
    seconds: float


class Refused(NamedTuple):
    """Why a worker does not take part."""

    reason: str


# Of each thread: what a sweep keeps between batches is not made for several at once.
_known = threading.local()


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def ready() -> None:
    """Do nothing: whoever answers is there."""


def do(order: Order, indices: Sequence[int]) -> Done | Refused | None:
    """Run the first of some points, for about a second; None if the sweep is not known here, and must be sent whole.

    How long points take may change from one to the next, and what is not answered can be lost.
    """
    if getattr(_known, "name", None) != order.name:
        if order.content is None:
            return None
        made = understood(order.content)
        if isinstance(made, Refused):
            return made
        _known.name, _known.points = order.name, made
    begin = before = now = time.perf_counter()
    texts, failed, at, size = [], 0, 0, _FEW
    while at < len(indices) and now - begin < _SLICE:
        text, bad = _known.points.lines(indices[at : at + size])
        texts.append(text)
        failed += bad
        at += size
        before, now = now, time.perf_counter()
        size = max(1, min(4 * size, _MANY, int(size * _SLICE / 4 / max(now - before, 1e-9))))
    return Done("".join(texts), failed, now - begin)


def check(order: Order) -> str | None:
    """Why this worker must not take part; None if it may."""
    made = understood(order.content or b"")
    return made.reason if isinstance(made, Refused) else None


def understood(content: bytes) -> Points | Refused:
    """The points that an order tells of, if this worker has all that they need, in the same versions."""
    try:
        scenario, versions, train, named = pickle.loads(content)
    except BaseException as error:
        let_through(error)
        got = f"got {told(error)}; install there what is installed here"
        return Refused(f"workers must be able to read the scenario ({got})")
    here = versions_of([name for name in versions if name not in (*_OWN, "scipy")])
    if here == versions:
        return Points(scenario, versions, train, named)
    differ = ", ".join(f"{name} {here[name]}, not {versions[name]}" for name in here if here[name] != versions[name])
    return Refused(f"workers must have the versions of the client (got a worker with {differ}; install the same)")
