"""Scenes that differ from a scenario in some parameters, and their simulations."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from attrs import evolve

from shockwave.base.errors import Fault, InvalidValueError, NumericalError, ShockwaveError, below, locate, steps_of
from shockwave.base.quantity_fields import Declaration, text_of
from shockwave.prediction.predictor import Predictor
from shockwave.registry.registry import entries, entry_of, find
from shockwave.scenario.block_keys import WALLS
from shockwave.scenario.dotted_names import Variable, variable
from shockwave.scenario.scenario import Scenario, SceneArgument, scenario_alone
from shockwave.scenario.uncertainty_block import ends_of
from shockwave.scene.chain import Chain, Scales
from shockwave.scene.impact import Impact
from shockwave.scene.motion import Motion
from shockwave.scene.scene import Scene
from shockwave.scene.shock import Shock
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation.simulate import simulate_scenes

# Longest duration of a shock on equal granules [characteristic times]: a longer one takes more than a second.
_LONGEST = 1000.0
# Beginnings of the names of parameters that can vary.
VARIED = ("chain.", "shock.", "impact.", "motion.")
# Beginnings of those that only a scenario file gives a value.
_OF_FILES = ("chain.granules[", "chain.end.", "chain.damping.", "chain.contact.")
# Blocks with the keys of a record file.
_OF_RECORDS = ("shock.parameters", "motion")
# Names of values -> attributes; a diameter is stored as a radius.
_ATTRIBUTES = {"diameter": "radius", "wall": "material", "from": "first", "to": "last"}

#: Seed of random numbers.
SEED = Declaration("", "seed", at_least=0, at_most=2**63 - 1, whole=True)
#: Relative error.
RTOL = Declaration("", "relative error allowed", at_least=1e-7, at_most=1e-2)


def scenario_of(scene: SceneArgument, chain: Chain | None) -> Scenario:
    """The given scenario, or one of a shock or an impact on a chain; equal granules are given by their number.

    Raises
    ------
    InvalidValueError
        If neither is given, or the scenario stands for a sweep.
    ShockwaveError
        As `load_scenario`.
    """
    if isinstance(scene, Shock | Impact | Motion) and isinstance(chain, Chain):
        parts: dict[str, Any] = {type(scene).__name__.lower(): scene, "chain": chain}
        scenario = Scenario(name="", path=None, predictor=Predictor(), simulate=SimulateOptions(), **parts)
    else:
        scenario = scenario_alone(scene, chain)
    return evolve(scenario, chain=scenario.scene.line)


def data_of(scenario: Scenario) -> Mapping[str, Any]:
    """The content of the document; without a document, the name of the profile only."""
    if scenario.document is not None:
        return scenario.document.data
    if scenario.impact is not None or scenario.motion is not None:
        return {"motion" if scenario.impact is None else "impact": {}}
    entry = entry_of("profiles", type(scenario.shock.profile))
    return {"shock": {"profile": entry and entry.name}}


def check_parameter(name: object, scenario: Scenario, kind: str) -> None:
    """Raise an `InvalidValueError` for a parameter that a scene made in Python does not have; ``kind`` is its place."""
    if scenario.document is not None:
        return
    if str(name).startswith(_OF_FILES):
        rule = "must be a value of the shock, the impact or the chain itself in a scene made in Python"
        raise InvalidValueError.of(kind, f"{rule} (got {name}; load a scenario from a file)")
    if scenario.impact is not None and str(name).startswith("shock."):
        raise InvalidValueError.of(kind, f"must be a parameter of the chain or the impact (got {name})")


def find_parameter(name: str, scenario: Scenario) -> Variable:
    """The parameter of the chain, the shock or the impact with this dotted name.

    Raises
    ------
    InvalidValueError
        If there is none.
    """
    check_parameter(name, scenario, "vary")
    with below("vary"):
        return variable(name, data_of(scenario), lambda other: other.startswith(VARIED))


def interval(parameter: Variable, ends: Sequence[Any] | None) -> tuple[float, float]:
    """Ends of the interval of a number.

    Raises
    ------
    InvalidValueError
        If they are not given, or not two values in ascending order.
    """
    if ends is None:
        problem = f"must be the lower and the upper end of the interval of {parameter.name} (got nothing)"
        raise InvalidValueError.of("between", problem)
    with locate(lambda fault: Fault("between", f"{fault.problem} for {parameter.name}")):
        low, high = ends_of(parameter, ends)
        return low, high


def materials_of(materials: Any) -> tuple[str, ...]:
    """Names of materials, one or several; by default, of all materials of the library.

    Raises
    ------
    InvalidValueError, UnknownNameError
        If there are none, one is not a name, or a name is unknown.
    """
    if materials is None:
        return tuple(entry.name for entry in entries("materials"))
    names = (materials,) if isinstance(materials, str) else tuple(materials) if isinstance(materials, Iterable) else ()
    if not names or not all(isinstance(name, str) for name in names):
        raise InvalidValueError.of("among", f"must be names of materials, such as ['ptfe'] (got {text_of(materials)})")
    for name in names:
        if name.lower() not in WALLS:
            find("materials", name)
    return tuple(dict.fromkeys(names))


def value_of(scenario: Scenario, name: str) -> float:
    """Value of the parameter ``name`` in the scenario, in SI units.

    Raises
    ------
    InvalidValueError
        If the scenario gives no value, as for the mass of a fixed wall.
    """
    path = name.replace("shock.duration_ratio", "shock.profile.duration_ratio")
    value: Any = scenario
    for step in steps_of(path.replace("shock.parameters", "shock.profile")):
        attribute = step if isinstance(step, int) or name.startswith("shock.") else _ATTRIBUTES.get(step, step)
        value = value[attribute] if isinstance(attribute, int) else getattr(value, attribute, None)
        if value is None:  # a segment or a striker without a size or a material of its own
            value = getattr(scenario.chain, str(attribute), None)
    block, _, key = name.rpartition(".")
    if value is None and block in _OF_RECORDS and scenario.document is not None:
        # the keys of a record file, which its profile or motion does not have
        content: Any = data_of(scenario)
        for step in block.split("."):
            content = content.get(step) or {}
        number = content.get(key)
        value = None if number is None else find_parameter(name, scenario).convert(number)
    if value is None:
        problem = "must have a value in the scenario (got none; state it there)"
        raise InvalidValueError.of(("uncertainty", name), problem)
    return float(value) * (2 if attribute != step == "diameter" or ".diameter." in name else 1)


# ---------------------------------------------------------------- simulations


def simulate_all(scenes: Sequence[Scenario], options: SimulateOptions, rtol: float, longest: float) -> list[Any]:
    """Results of scenes; arguments as for `simulate_each`.

    Raises
    ------
    InvalidValueError
        If a scene is not valid, such as a chain that must be elastic with forces beyond first yield.
    NumericalError
        If a simulation fails.
    """
    results = simulate_each(scenes, options, rtol, longest)
    failures = [result for result in results if isinstance(result, ShockwaveError)]
    if failures and isinstance(failures[0], InvalidValueError):
        raise failures[0]
    if failures:
        raise NumericalError(f"{len(failures)} of {len(results)} simulations failed; the first: {failures[0]}")
    return results


def simulate_each(
    scenes: Sequence[Scenario | ShockwaveError], options: SimulateOptions, rtol: float, longest: float = _LONGEST
) -> list[Any]:
    """Results of scenes that differ in shock, impact and chain, or their errors; errors among the scenes are passed on.

    A shock on equal granules that is longer than ``longest`` [characteristic times] is an error. Of the ``options``,
    the backend, the contacts, the sensors and the simulated time apply.
    """
    parts = {name: getattr(options, name) for name in ("backend", "contacts", "sensors", "until")}
    settings = SimulateOptions(rtol=rtol, waves="primary", **parts)
    return list(simulate_scenes([_short_scene(scene, longest) for scene in scenes], settings))


def _short_scene(scenario: Scenario | ShockwaveError, longest: float) -> Scene | ShockwaveError:
    """The scene of a scenario; the error of a shock on equal granules that lasts too long."""
    if isinstance(scenario, ShockwaveError):
        return scenario
    if scenario.scene.uniform is None:
        return scenario.scene
    duration = scenario.shock.duration / Scales.of(scenario.chain, scenario.shock.peak_force).time
    if duration <= longest:
        return scenario.scene
    remedy = "shorten the shock, or soften or enlarge the granules"
    problem = f"must last at most {longest:g} characteristic times (got {duration:.4g}; {remedy})"
    return InvalidValueError.of("shock", problem)
