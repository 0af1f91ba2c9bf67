"""Scenes that differ from a scenario in some parameters: their simulations, and their leading waves.

For a given shape of the shock, the amplification depends on all other parameters through one number,

    t0/T0 = t0 F0^(1/6) R^(-4/3) rho^(-1/2) (E / (1 - nu^2))^(1/3) times a constant,

so one universal curve covers all such scenes. Scenes with other shapes are simulated.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import attrs
import numpy as np
from attrs import evolve

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.impact import Impact
from shockwave.chain.yielding import require_elastic
from shockwave.errors import InvalidValueError, NumericalError, ShockwaveError
from shockwave.fields import Quantity, text_of
from shockwave.measurement.simulate import equal_granules, simulate_many
from shockwave.options import SimulateOptions
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.registry import entries, entry_of, find
from shockwave.scenario.block_keys import WALLS
from shockwave.scenario.dotted_names import Variable, variable
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_argument import Scene, scenario_alone
from shockwave.scenario.scene_family import Family
from shockwave.scenario.uncertainty import ends_of
from shockwave.scenario.yaml_document import dotted, steps_of
from shockwave.studies.scaling_exponents import POWERS, Exponents
from shockwave.studies.universal_curve import UniversalCurve, cached_curve

# Longest duration of a curve [characteristic times]; doubled as often as a shock requires.
_LONGEST = 50.0
# Longest duration of any curve [characteristic times].
_LIMIT = 1000.0
# Longest duration if each scene is simulated [characteristic times]: thousands of longer simulations take hours.
_LONGEST_SIMULATED = 300.0

# Positive intervals whose ends have a larger ratio are divided logarithmically.
_WIDE = 3.0
# Beginnings of the names of parameters that can vary.
_VARIED = ("chain.", "shock.", "impact.")
# Beginnings of those that only a scenario file gives a value.
_OF_FILES = ("chain.granules[", "chain.end.", "chain.damping.", "chain.contact.")
_OF_SHOCK = "shock.parameters."
# Names of values -> attributes; a diameter is stored as a radius.
_ATTRIBUTES = {"diameter": "radius", "wall": "material", "from": "first", "to": "last"}

#: Seed of random numbers.
SEED = Quantity("", "seed", at_least=0, at_most=2**63 - 1, whole=True)

#: Amplification, peak force of the shock [N] and bound on the relative error, each of shape (n,).
LeadingWaves = tuple[FloatArray, FloatArray, FloatArray]


def scenario_of(scene: Scene, chain: Chain | None) -> Scenario:
    """The given scenario, or one of a shock or an impact on a chain; equal granules are given by their number.

    Raises
    ------
    InvalidValueError
        If neither is given, or the scenario stands for a sweep.
    ShockwaveError
        As `load_scenario`.
    """
    if isinstance(scene, Shock | Impact) and isinstance(chain, Chain):
        given: dict[str, Any] = {"shock" if isinstance(scene, Shock) else "impact": scene, "chain": chain}
        found = Scenario(name="", path=None, predictor=Predictor(), simulate=SimulateOptions(), **given)
    else:
        found = scenario_alone(scene, chain)
    return evolve(found, chain=equal_granules(found.excitation, found.chain) or found.chain)


def is_covered(scenario: Scenario) -> bool:
    """Whether curves cover the scenario: a pushing shock on equal granules with free ends and Hertz's contacts."""
    equal = equal_granules(scenario.excitation, scenario.chain)
    return equal is not None and (equal.contact, equal.packing) == (None, None) and not scenario.shock.profile.pulls


def data_of(scenario: Scenario) -> Mapping[str, Any]:
    """The content of the document; without a document, the name of the profile only."""
    if scenario.document is not None:
        return scenario.document.data
    if scenario.impact is not None:
        return {"impact": {}}
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


def varied(name: str, scenario: Scenario) -> Variable:
    """The parameter of the chain, the shock or the impact with this dotted name.

    Raises
    ------
    InvalidValueError
        If there is none.
    """
    check_parameter(name, scenario, "vary")
    try:
        return variable(name, data_of(scenario), lambda known: known.startswith(_VARIED))
    except InvalidValueError as error:
        raise InvalidValueError.of("vary", error.faults[0].problem) from None


def interval(parameter: Variable, given: Sequence[Any] | None) -> tuple[float, float]:
    """Ends of the interval of a number.

    Raises
    ------
    InvalidValueError
        If they are not given, or not two values in ascending order.
    """
    if given is None:
        problem = f"must be the lower and the upper end of the interval of {parameter.name} (got nothing)"
        raise InvalidValueError.of("between", problem)
    try:
        low, high = ends_of(parameter, given)
    except ValueError as error:
        raise InvalidValueError.of("between", f"{error} for {parameter.name}") from None
    return low, high


def is_wide(ends: tuple[float, float]) -> bool:
    """Whether an interval is divided logarithmically."""
    return ends[0] > 0 and ends[1] > _WIDE * ends[0]


def materials_of(given: Any) -> tuple[str, ...]:
    """Names of materials, one or several; by default, of all materials of the library.

    Raises
    ------
    InvalidValueError, UnknownNameError
        If there are none, one is not a name, or a name is unknown.
    """
    if given is None:
        return tuple(entry.name for entry in entries("materials"))
    names = (given,) if isinstance(given, str) else tuple(given) if isinstance(given, Iterable) else ()
    if not names or not all(isinstance(name, str) for name in names):
        raise InvalidValueError.of("among", f"must be names of materials, such as ['ptfe'] (got {text_of(given)})")
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
    found: Any = scenario
    for step in steps_of(path.replace("shock.parameters", "shock.profile")):
        own = step if isinstance(step, int) or name.startswith("shock.") else _ATTRIBUTES.get(step, step)
        found = found[own] if isinstance(own, int) else getattr(found, own, None)
        if found is None:  # a segment or a striker without a size or a material of its own
            found = getattr(scenario.chain, str(own), None)
    if found is None and name.startswith(_OF_SHOCK) and scenario.document is not None:
        # the parameters of a record file, which its profile does not have
        given = (data_of(scenario)["shock"].get("parameters") or {}).get(name.removeprefix(_OF_SHOCK))
        found = None if given is None else varied(name, scenario).converted(given)
    if found is None:
        raise InvalidValueError.of(
            dotted(("uncertainty", name)), "must have a value in the scenario (got none; state it there)"
        )
    return float(found) * (2 if own != step == "diameter" or ".diameter." in name else 1)


def rise_time_of(scenario: Scenario) -> float:
    """t0/T0 of the scene."""
    return Scales.of(scenario.chain, scenario.shock.peak_force).rise_time(scenario.shock.rise_time)


def duration_of(scenario: Scenario) -> float:
    """n t0/T0 of the scene."""
    return rise_time_of(scenario) * float(scenario.shock.profile.duration_ratio)


def notes_of(scenario: Scenario) -> tuple[str, ...]:
    """Notes on results of curves for the scenario."""
    notes = tuple(scenario.shock.profile.notes)
    if scenario.chain.count is None:
        return notes
    return (*notes, f"the chain of {scenario.chain.count} granules is treated as endless")


# ---------------------------------------------------------------- curves


def curve_of(profile: ShockProfile, rtol: float, duration: float) -> UniversalCurve:
    """The curve of a shape that covers ``duration``, n t0/T0; cached for immutable profiles.

    Raises
    ------
    InvalidValueError
        If ``duration`` exceeds 1000.
    NumericalError
        If a simulation fails, is too slow or has no error estimate.
    """
    if not duration <= _LIMIT:
        remedy = "shorten the shock, or soften or enlarge the granules"
        problem = f"must last at most {_LIMIT:g} characteristic times (got {duration:.4g}; {remedy})"
        raise InvalidValueError.of("shock", problem)
    doublings = max(math.ceil(math.log2(duration / _LONGEST)), 0)
    for longest in (min(_LONGEST * 2**doublings, _LIMIT), max(duration, 1.0)):
        found = cached_curve(profile, rtol, longest)
        if isinstance(found, UniversalCurve):
            return found
    raise NumericalError(str(found))


def exponents_of(scenario: Scenario, curve: UniversalCurve) -> Exponents:
    """Exponents of the scene from the curve of its shape."""
    ratio = rise_time_of(scenario)
    slope = float(curve.slope(ratio))
    return Exponents.of(slope, float(curve.slope_error(ratio)), scenario.chain.material.poisson_ratio)


# ---------------------------------------------------------------- many scenes


def scenes_of(family: Family, values: Mapping[str, FloatArray]) -> list[Scenario]:
    """Scenes of a family, for arrays of shape (n,) by the names of their parameters."""
    rows = zip(*(given.tolist() for given in values.values()), strict=True)
    return [family.scenario(dict(zip(values, row, strict=True))) for row in rows]


def simulations(scenes: Sequence[Scenario], rtol: float) -> list[Any]:
    """Results of scenes that differ in shock, impact and chain.

    Raises
    ------
    InvalidValueError
        If a scene is not valid, such as a chain that must be elastic with forces beyond first yield.
    NumericalError
        If a simulation fails.
    """
    found = simulated(scenes, rtol)
    failed = [result for result in found if isinstance(result, ShockwaveError)]
    if failed and isinstance(failed[0], InvalidValueError):
        raise failed[0]
    if failed:
        raise NumericalError(f"{len(failed)} of {len(found)} simulations failed; the first: {failed[0]}")
    return found


def simulated(scenes: Sequence[Scenario], rtol: float) -> list[Any]:
    """Results of scenes that differ in shock, impact and chain, or their errors."""
    options = scenes[0].simulate
    return simulate_many(
        [scene.excitation for scene in scenes],
        [scene.chain for scene in scenes],
        rtol,
        waves="primary",
        backend=options.backend,
        contacts=options.contacts,
        until=options.until,
    )


def keep_shape(names: Iterable[str]) -> bool:
    """Whether scenes that differ in the parameters ``names`` have the same shape, so that one curve covers them."""
    return POWERS.keys() >= set(names)


def family_of(scenario: Scenario, names: Iterable[str]) -> Family:
    """Scenes with other values of ``names``; by the constructor of the profile if it gives the same as the document."""
    cls: type = type(scenario.shock.profile)
    parameters = {name.rpartition(".")[2] for name in names if name not in POWERS}
    fields = {field.name for field in attrs.fields(cls) if field.init} if attrs.has(cls) else set()
    explicit = {"profile", "peak_force", "rise_time"} <= data_of(scenario)["shock"].keys()
    return Family(evolve(scenario, document=None) if explicit and parameters <= fields else scenario)


def primaries(scenario: Scenario, values: Mapping[str, FloatArray], rtol: float) -> LeadingWaves:
    """Leading waves in scenes that differ from ``scenario`` in ``values``; chains are treated as endless.

    Parameters
    ----------
    scenario : Scenario
        The scenario with all other values.
    values : mapping of str to ndarray, shape (n,)
        Values by the dotted names of their parameters.
    rtol : float
        Allowed relative error of a curve or a simulation.

    Returns
    -------
    tuple of ndarray, shape (n,)
        Amplification, peak force of the shock [N] and bound on the relative error.

    Raises
    ------
    InvalidValueError
        If a scene is not possible, or its shock is longer than 1000 characteristic times, or 300 if each scene is
        simulated; or if the chain must be elastic and a wave is beyond first yield.
    NumericalError
        If a simulation fails.
    """
    semi_infinite = evolve(scenario, chain=evolve(scenario.chain, granules=None))
    return (_by_curve if keep_shape(values) else _by_simulation)(semi_infinite, values, rtol)


def _by_curve(scenario: Scenario, values: Mapping[str, FloatArray], rtol: float) -> LeadingWaves:
    n = float(scenario.shock.profile.duration_ratio)
    ratios: Any = rise_time_of(scenario)
    # force of first yield over that of the scenario
    yields: Any = 1.0
    for name, given in values.items():
        here = value_of(scenario, name)
        base = (1 - given**2) / (1 - here**2) if name.endswith("poisson_ratio") else given / here
        of_ratio, of_yield = POWERS[name]
        ratios, yields = ratios * base**of_ratio, yields * base**of_yield
    curve = curve_of(scenario.shock.profile, rtol, float(ratios.max()) * n)
    forces = np.asarray(values.get("shock.peak_force", np.full(ratios.shape, scenario.shock.peak_force)))
    amplifications = curve.amplification(ratios)
    require_elastic(scenario.chain, float((amplifications * forces / yields).max()))
    return amplifications, forces, curve.error(ratios)


def _by_simulation(scenario: Scenario, values: Mapping[str, FloatArray], rtol: float) -> LeadingWaves:
    scenes = scenes_of(family_of(scenario, values), values)
    longest = max(map(duration_of, scenes))
    if longest > _LONGEST_SIMULATED:
        problem = f"must last at most {_LONGEST_SIMULATED:g} characteristic times if its shape is uncertain"
        raise InvalidValueError.of("shock", f"{problem} (got {longest:.4g})")
    results = simulations(scenes, rtol)
    figures = [(result.amplification, result.shock.peak_force, result.error_estimate) for result in results]
    amplifications, forces, errors = np.array(figures).T
    return amplifications, forces, errors
