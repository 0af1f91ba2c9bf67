"""Evaluation of the points of a sweep: scenes, results and entries of the journal, in the batches of the workers."""

from __future__ import annotations

import hashlib
import json
import pickle
import platform
import threading
import time
from collections.abc import Sequence
from importlib import metadata
from typing import Any

import numpy as np
from attrs import evolve

import shockwave
from shockwave.base.errors import Fault, NotCoveredError, UsageError, message_of
from shockwave.base.files import read_bytes
from shockwave.base.quantities import VERDICT, Quantity
from shockwave.engine.backend import lack
from shockwave.prediction.outcome import Outcome
from shockwave.registry.registry import load, plugins
from shockwave.scenario.block_keys import BLOCKS, MATERIALS, WALLS
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_hash import normalise
from shockwave.scenario.sweep_block import Sweep
from shockwave.scenario.variations import Family
from shockwave.scene.chain import Scales
from shockwave.simulation.simulate import simulate_scenes
from shockwave.simulation.simulation_result import Simulation
from shockwave.sweep.columns import Answer, chain_columns, column_of, columns_of, find_requested_columns, row
from shockwave.sweep.definition import SweepDefinition
from shockwave.sweep.journal import Entry

# Largest record that is hashed [bytes]; the reader of records has its own limit.
_MOST_RECORD = 2**28
# Exceptions of a plugin that let only its point fail.
_POINT_ERRORS = (Exception, SystemExit)
#: Time after which a worker returns the finished points of its batch [s].
SLICE = 0.5
# Most points that a worker evaluates in one call.
_MOST_TOGETHER = 1024
#: Largest ratio of the numbers of points of two consecutive calls.
GROWTH = 4


class Points:
    """All points of a sweep.

    Parameters
    ----------
    scenario : Scenario
        A scenario with a sweep.
    """

    def __init__(self, scenario: Scenario) -> None:
        assert scenario.sweep is not None
        self.scenario, self.sweep = scenario, scenario.sweep
        block = scenario.document.data.get("simulate") if scenario.document else None
        #: Whether all waves are measured, or the leading wave only.
        self.train = isinstance(block, dict) and block.get("waves") == "train"
        #: Whether scenes may have features beyond a shock on equal granules, so that forces at contacts are measured.
        names = [name for axis in self.sweep.axes for name in axis.names]
        finite = scenario.chain.granules is not None or "chain.granules" in names
        self.chains = _has_features(scenario, finite) or any(_is_feature(name, finite) for name in names)
        *columns, remarks = self._chain_columns() or columns_of(self.sweep.run, self.train, finite)
        with scenario.scene.locate_errors():
            columns += find_requested_columns(scenario, tuple(columns))
        self._columns = (*columns, *(() if scenario.limit is None else VERDICT), remarks)
        self._family = Family(scenario)
        self.definition = SweepDefinition(
            name=scenario.name,
            run=self.sweep.run,
            axes=self.sweep.axes,
            columns=tuple(map(column_of, self._columns)),
            scenario=json.loads(normalise(scenario)),
            named=_hashes_of_values(scenario, self.sweep),
            versions=_versions_here(scenario, self.sweep),
        )

    def _chain_columns(self) -> tuple[Quantity, ...]:
        """Columns for chains beyond equal granules; none if section 4 alone predicts all points."""
        scenario, run = self.scenario, self.sweep.run
        refusals = _refusals(scenario, self.sweep) if self.chains else []
        by_section4 = run == "predict" and scenario.predictor.model == "section-4"
        if refusals and by_section4:
            raise NotCoveredError(*refusals)
        return chain_columns(scenario, run, section4=not refusals) if self.chains and not by_section4 else ()

    def evaluate(self, indices: Sequence[int]) -> list[Entry]:
        """Evaluate some points, and return their entries of the journal."""
        results: dict[int, Sequence[Any]] = {}
        # scenes with the same options are evaluated in one call
        groups: dict[Any, dict[int, Scenario]] = {}
        for index in indices:
            try:
                scene = self._family.scenario(self.sweep.point(index))
                groups.setdefault((scene.predictor, scene.simulate), {})[index] = scene
            except _POINT_ERRORS as error:
                results[index] = [error]
        for scenes in groups.values():
            results |= zip(scenes, self._evaluate([*scenes.values()]), strict=True)
        return [self._entry(index, results[index]) for index in indices]

    def _entry(self, index: int, parts: Sequence[Any]) -> Entry:
        """Entry of a point with these results, of which the first error counts."""
        try:
            for part in parts:
                if isinstance(part, BaseException):
                    raise part
            return index, "done", json.dumps(row(self._columns, _answer(*parts))), None
        except _POINT_ERRORS as error:
            return index, "failed", None, message_of(error)

    def _evaluate(self, scenes: Sequence[Scenario]) -> list[Sequence[Any]]:
        """Scenes with the same options, their simulations and predictions, or their errors."""
        run, options, predictor = self.sweep.run, scenes[0].simulate, scenes[0].predictor
        cases = [scene.scene for scene in scenes]
        simulated: Any = [None] * len(scenes)
        predicted: Any = simulated
        try:
            if run != "predict":
                waves = options.waves if self.train or self.chains else "primary"
                simulated = simulate_scenes(cases, evolve(options, waves=waves, record=(), interval=None), threads=1)
            if run == "compare":
                predictor = evolve(predictor, model="section-4")
                # the simulation judges a chain that must be elastic
                cases = [evolve(case, chain=evolve(case.chain, elastic_only=False)) for case in cases]
            if run != "simulate":
                predicted = predictor.predict_scenes(cases, evolve(options, waves="primary"), threads=1)
        except _POINT_ERRORS as error:
            # one by one, to find the point that raises the error
            return [[error]] if len(scenes) == 1 else [self._evaluate([scene])[0] for scene in scenes]
        if run == "compare":
            predicted = [None if isinstance(outcome, NotCoveredError) else outcome for outcome in predicted]
        return list(zip(scenes, simulated, predicted, strict=True))


def _has_features(scenario: Scenario, finite: bool) -> bool:
    """Whether a scene, or one with a number of granules if some are ``finite``, is beyond a shock on equal granules."""
    equal = scenario.scene.uniform
    # only an endless chain keeps its contact law
    return equal is None or (finite and equal.contact is not None)


def _is_feature(name: str, finite: bool) -> bool:
    """Whether a variable is a feature beyond a shock on equal granules, of chains of which some may be ``finite``."""
    if name.startswith("chain.contact.") and not finite:
        return False
    return name.rpartition(".")[0] not in (*BLOCKS, "shock.parameters") or name.endswith(
        (".precompression", ".gravity")
    )


def _refusals(scenario: Scenario, sweep: Sweep) -> list[Fault]:
    """Features for which the prediction refuses all points: those of the first scene that do not vary."""
    names = [name for axis in sweep.axes for name in axis.names]
    try:
        scenario.scene.covered_chain("section 4", laws=True, packings=True)
    except NotCoveredError as error:
        faults = error.with_places(scenario.scene.place_fault).faults
        return [fault for fault in faults if not any(name.startswith(fault.path) for name in names)]
    return []


def _answer(scene: Scenario, simulated: Simulation | None, predicted: Outcome | None) -> Answer:
    if simulated is None and predicted is not None:
        simulated = predicted.simulated
    if _has_features(scene, scene.chain.granules is not None):
        return Answer(predicted=predicted, simulated=simulated)
    characteristic = Scales.of(scene.chain, scene.shock.peak_force).time
    times = scene.shock.rise_time / characteristic, scene.shock.duration / characteristic
    return Answer(*times, predicted, simulated)


# ---------------------------------------------------------------- versions and files on which the results depend


# Kind of the registered object that a variable names.
_KINDS = {f"{block}.{key.name}": key.kind for block, keys in BLOCKS.items() for key in keys if key.kind}


def software() -> dict[str, str]:
    """Versions of the packages of this process on which all results depend, and the backend."""
    return {
        "shockwave": shockwave.__version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": metadata.version("scipy"),
        "backend": "numpy" if lack() else "compiled",
    }


def _versions_here(scenario: Scenario, sweep: Sweep) -> dict[str, str]:
    """The software, with the plugins that the sweep uses."""
    versions, objects = software(), _objects(scenario, sweep)
    for plugin in plugins():
        if any(objects & {(kind, entry.name), (kind, entry.address)} for kind, entry in plugin.entries):
            versions[plugin.distribution] = plugin.version
    return versions


def _objects(scenario: Scenario, sweep: Sweep) -> set[tuple[str, Any]]:
    """Kinds and names of the registered objects in use; for a profile also the address of its class."""
    objects: set[tuple[str, Any]] = {
        ("materials", scenario.chain.material.name),
        ("integrators", scenario.simulate.integrator),
        ("quadratures", scenario.predictor.quadrature),
    }
    if scenario.shock is not None:
        cls = type(scenario.shock.profile)
        objects.add(("profiles", f"{cls.__module__}:{cls.__qualname__}"))
        if scenario.document is not None:
            objects.add(("profiles", scenario.document.data["shock"]["profile"]))
    granules: Any = scenario.chain.granules if isinstance(scenario.chain.granules, tuple) else ()
    parts = [scenario.chain, *(segment for part in granules for segment in getattr(part, "cell", (part,)))]
    laws = [law for part in parts for law in (part.damping, part.contact)]
    objects |= {("contacts", f"{type(law).__module__}:{type(law).__qualname__}") for law in laws}
    texts = {(name, value) for name, value in sweep.pairs() if isinstance(value, str)}
    objects |= {(_KINDS[name], value) for name, value in texts if name in _KINDS}
    return objects | {("materials", value) for name, value in texts if name.endswith(MATERIALS)}


def _hashes_of_values(scenario: Scenario, sweep: Sweep) -> dict[str, str]:
    """Hashes of the materials and files among the values of the sweep."""
    hashes = {}
    for name, value in sweep.pairs():
        if name.endswith(MATERIALS) and isinstance(value, str) and value.lower() not in WALLS:
            hashes[f"material {value}"] = _hash(repr(load("materials", value)).encode())
        elif name == "shock.parameters.file":
            hashes[f"file {value}"] = _hash(read_bytes(scenario.folder / value, _MOST_RECORD))
    return hashes


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


# ---------------------------------------------------------------- batches, as workers run them

# Points of the last sweep, for each thread, because they are not safe to share.
_cache = threading.local()


def run_batch(content: bytes, indices: Sequence[int]) -> list[Entry]:
    """Evaluate points of a sweep for about half a second, and return their entries of the journal.

    The remaining points of the batch are sent again by the client.

    Raises
    ------
    UsageError
        If this worker has other versions, materials or files than the client.
    """
    if getattr(_cache, "content", None) != content:
        _cache.points, _cache.content = _receive_points(content), content
    begin = time.perf_counter()
    entries: list[Entry] = []
    size = 1
    while not entries or (len(entries) < len(indices) and time.perf_counter() - begin < SLICE):
        entries += _cache.points.evaluate(indices[len(entries) : len(entries) + size])
        size = min(GROWTH * size, _MOST_TOGETHER)
    return entries


def content_of(points: Points) -> bytes:
    """Serialise a sweep for the workers.

    Raises
    ------
    UsageError
        If a scenario made in Python cannot be serialised.
    """
    try:
        return pickle.dumps((points.scenario, points.definition))
    except Exception as error:  # pickle raises errors of many types
        got = f"got {message_of(error)}; define its profile in a module"
        raise UsageError(f"the scenario must be serialisable for other processes ({got})") from error


def _receive_points(content: bytes) -> Points:
    scenario, definition = pickle.loads(content)
    points = Points(scenario)
    changes = points.definition.differences(definition)
    if changes:
        got = "; ".join(" ".join(change) for change in changes.items())
        remedy = "install the same versions, and copy the same files"
        raise UsageError(f"workers must have the versions and files of the client (got a worker with {got}; {remedy})")
    return points
