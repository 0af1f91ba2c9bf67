"""Tests of the errors: they are values, and the place of a fault is a path."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import shockwave as sw
from shockwave.base.errors import Fault, ShockwaveError, below, locate
from shockwave.registry.registry import find

SCENARIO = """\
chain: {material: ptfe, diameter: 0 mm}
shock: {profile: triangle, peak_force: 1 m}
"""
GAP = sw.Chain(material="ptfe", radius=0.01, granules=[sw.Segment(count=2, gap=1e-5), sw.Segment(count=3)])


def _scenario(folder: Path) -> None:
    (folder / "scene.yaml").write_text(SCENARIO)
    sw.load_scenario(folder / "scene.yaml")


def _failed(error: ShockwaveError) -> Callable[[Path], None]:
    def fail(_: Path) -> None:
        raise error

    return fail


#: Class -> a use that raises such an error.
RAISED: dict[type[ShockwaveError], Callable[[Path], Any]] = {
    sw.ShockwaveError: _failed(sw.ShockwaveError("it failed")),
    sw.NumericalError: _failed(sw.NumericalError("the integrator failed")),
    sw.UsageError: _failed(sw.UsageError("--at: must be NAME=VALUE (got 'x')")),
    sw.InvalidValueError: lambda _: sw.Material(name="x", youngs_modulus="1 m", poisson_ratio=0.3, density=1000.0),
    sw.NotCoveredError: lambda _: sw.predict(sw.Impact(velocity=1.0), GAP, model="section-4"),
    sw.ScenarioError: _scenario,
    sw.UnknownNameError: lambda _: find("materials", "unobtainium"),
    sw.PluginError: _failed(sw.PluginError(Fault("chain.damping.model", "must not raise", "scene.yaml:1:1"))),
    sw.FileAccessError: lambda folder: sw.load_scenario(folder / "nowhere.yaml"),
}
TWINS: dict[str, Callable[[ShockwaveError], ShockwaveError]] = {
    "pickle": lambda error: pickle.loads(pickle.dumps(error)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}


def _classes(cls: type[ShockwaveError]) -> Iterator[type[ShockwaveError]]:
    yield cls
    for each in cls.__subclasses__():
        yield from _classes(each)


def test_every_public_error_is_tested_here() -> None:
    assert {cls for cls in _classes(ShockwaveError) if getattr(sw, cls.__name__, None) is cls} == RAISED.keys()


@pytest.mark.parametrize("twin", TWINS)
@pytest.mark.parametrize("cls", RAISED, ids=lambda cls: cls.__name__)
def test_an_error_pickles_copies_and_compares_by_value(tmp_path: Path, cls: type[ShockwaveError], twin: str) -> None:
    with pytest.raises(cls) as caught:
        RAISED[cls](tmp_path)
    error = copy.deepcopy(caught.value)
    error.add_note("a warning of the scene")
    again = TWINS[twin](error)
    assert type(again) is type(error) is cls
    assert again == error
    assert hash(again) == hash(error)
    assert (str(again), again.faults, again.__notes__) == (str(error), error.faults, error.__notes__)
    assert str(error) == "\n".join(map(str, error.faults))
    assert cls(*error.args) != error  # without the note
    assert cls(*error.args, "and another problem") != cls(*error.args)
    assert all(other(*error.args) != cls(*error.args) for other in RAISED if other is not cls)


def test_a_dotted_name_is_the_path_of_a_fault() -> None:
    fault = Fault("chain.granules[1].cell[0].gap", "must be 0")
    assert fault.steps == ("chain", "granules", 1, "cell", 0, "gap")
    assert fault == Fault(fault.steps, "must be 0")
    assert str(fault) == "chain.granules[1].cell[0].gap: must be 0"


def test_a_key_with_dots_is_one_step_of_a_path() -> None:
    with pytest.raises(sw.InvalidValueError) as caught, below("uncertainty"):
        raise sw.InvalidValueError(Fault(("chain.diameter", "sd"), "must be > 0 m"))
    assert str(caught.value) == "uncertainty.'chain.diameter'.sd: must be > 0 m"


def test_notes_of_an_error_stay_with_its_places() -> None:
    error = sw.InvalidValueError.of("chain.radius", "must be > 0 m")
    error.add_note("a warning of the scene")
    with pytest.raises(sw.InvalidValueError) as caught, locate(lambda fault: fault.below("scenes", 3)):
        raise error
    assert str(caught.value) == "scenes[3].chain.radius: must be > 0 m"
    assert caught.value.__notes__ == error.__notes__
