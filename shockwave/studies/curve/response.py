"""Responses: the primary of scenes that differ from a scenario in some values, for arrays of values.

Of what makes a scene, all but the shape of the shock enters by one number,

    t0/T0 = t0 F0^(1/6) R^(-4/3) rho^(-1/2) (E / (1 - nu^2))^(1/3) times a constant,

so that one curve answers for all of them. Another shape is simulated.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Any

import attrs
import numpy as np
from attrs import evolve, frozen

from shockwave.chain.chain import Chain, Scales
from shockwave.errors import InvalidValueError, NumericalError, ShockwaveError
from shockwave.fields import text_of
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import simulate_many
from shockwave.options import SimulateOptions
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.guard import trusted
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.registry import entries
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_family import Family
from shockwave.studies.curve.universal import UniversalCurve

__all__ = [
    "POWERS",
    "SIGNS",
    "Exponents",
    "Response",
    "curve_of",
    "duration_of",
    "longest_for",
    "notes_of",
    "scenario_of",
    "too_long",
    "value_of",
]

#: Values that leave the shape alone -> the power with which t0/T0 goes with them; Poisson's ratio goes with none.
POWERS = {
    "shock.peak_force": 1 / 6,
    "shock.rise_time": 1.0,
    "shock.duration": 1.0,
    "chain.radius": -4 / 3,
    "chain.diameter": -4 / 3,
    "chain.material.youngs_modulus": 1 / 3,
    "chain.material.density": -1 / 2,
    "chain.material.poisson_ratio": math.nan,
}
#: What makes a scene of one shape -> its sign in equations.
SIGNS = {
    "radius": "R",
    "density": "rho",
    "youngs_modulus": "E",
    "poisson_ratio": "nu",
    "peak_force": "F0",
    "rise_time": "t0",
}
# Two names of one value.
_TWINS = {"chain.diameter": "chain.radius", "shock.duration": "shock.rise_time"}
# Curves reach so far, or longer by so many steps to the double, up to the longest.
_LONGEST, _STEPS, _LIMIT = 50.0, 16, 1000.0
# Where there is none so long, down to this one of a half, a quarter and so on will do.
_SHORTEST = 3.0
# Of so many scenes none may last longer where each is simulated: thousands of them would take minutes.
_MANY, _EACH = 64, 300.0
_ROUNDING = 1e-9


def scenario_of(scene: Scenario | Shock, chain: Chain | None) -> Scenario:
    """The scenario that was given, or that of a shock on a chain.

    Raises
    ------
    InvalidValueError
        When it is neither.
    """
    if isinstance(scene, Scenario) and chain is None:
        return scene
    if isinstance(scene, Shock) and isinstance(chain, Chain):
        return Scenario(name="", path=None, shock=scene, chain=chain, predictor=Predictor(), simulate=SimulateOptions())
    got = f"got {text_of(scene)} and {text_of(chain)}"
    if isinstance(chain, Mapping):
        raise InvalidValueError.of("chain", f"must be a Chain, or left out (got {text_of(chain)}; name it spreads=)")
    raise InvalidValueError.of("scene", f"must be a Scenario alone, or a Shock and a Chain ({got})")


def data_of(scenario: Scenario) -> Mapping[str, Any]:
    """What the document holds, or would have to for its profile to be known."""
    if scenario.document is not None:
        return scenario.document.data
    cls = type(scenario.shock.profile)
    address = f"{cls.__module__}:{cls.__qualname__}"
    return {"shock": {"profile": next((e.name for e in entries("profiles") if e.address == address), None)}}


def value_of(scenario: Scenario, name: str) -> float:
    """What the scenario has, in SI units.

    Raises
    ------
    InvalidValueError
        When its profile does not tell.
    """
    shock, chain, last = scenario.shock, scenario.chain, name.rpartition(".")[2]
    if name in ("shock.duration", "chain.diameter"):
        return shock.duration if name == "shock.duration" else 2 * chain.radius
    block: Any = chain.material if name.startswith("chain.material.") else chain if name.startswith("chain.") else shock
    if name.startswith("shock.parameters.") or last == "duration_ratio":
        block = shock.profile
    value = getattr(block, last, None)
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        problem = f"must be a number that the scene has (got {text_of(value)}; vary another value)"
        raise InvalidValueError.of(name, problem)
    return float(value)


def duration_of(scenario: Scenario) -> float:
    """n t0/T0 of the scene."""
    ratio = Scales.of(scenario.chain, scenario.shock.peak_force).rise_time(scenario.shock.rise_time)
    return ratio * float(scenario.shock.profile.duration_ratio)


def longest_for(duration: float) -> float:
    """Up to where a curve is made that has to reach ``duration``, n t0/T0.

    Raises
    ------
    InvalidValueError
        When no curve is so long.
    """
    if not duration <= _LIMIT:
        got = f"got {duration:.4g}; shorten the shock, or soften or enlarge the granules"
        raise InvalidValueError.of("shock", f"must last at most {_LIMIT:g} natural times ({got})")
    steps = math.ceil(_STEPS * math.log2(max(duration / _LONGEST, 1.0)) - _ROUNDING)
    return min(max(_LONGEST * 2 ** (steps / _STEPS), duration), _LIMIT)


def too_long(
    durations: FloatArray, values: Mapping[str, FloatArray], limit: float = _LIMIT
) -> InvalidValueError | None:
    """The fault of scenes with these durations, n t0/T0, and values, if one is longer than ``limit``."""
    worst = int(durations.argmax())
    if durations[worst] <= limit * (1 + _ROUNDING):
        return None
    where = ", ".join(f"{name} = {given[worst]:.6g}" for name, given in values.items())
    got = f"got {durations[worst]:.4g} at {where}, in SI units"
    return InvalidValueError.of("", f"must give shocks that last at most {limit:g} natural times ({got})")


def notes_of(scenario: Scenario, besides: str = "") -> tuple[str, ...]:
    """What a reader must know of an answer for the scenario; ``besides``, of what holds for a chain that ends."""
    told = []
    if scenario.chain.granules is not None:
        told.append(f"the chain counts as one without end, not of {scenario.chain.granules} granules{besides}")
    if scenario.sweep is not None:
        told.append(f"the scenario stands for {len(scenario.sweep)} scenes: this is the first")
    return (*scenario.shock.profile.notes, *told)


def curve_of(profile: ShockProfile, rtol: float, duration: float) -> UniversalCurve:
    """The curve of a shape, as long as ``duration``, n t0/T0, needs; kept for profiles of shockwave.

    Raises
    ------
    InvalidValueError
        When no curve is so long.
    NumericalError
        When a simulation fails, or does not tell how good it is.
    """
    longest = longest_for(duration)
    halves = max(math.floor(math.log2(longest / max(duration, _SHORTEST))), 0)
    make = _kept if trusted(profile) else _made
    found = make(profile, rtol, longest, longest / 2**halves)
    if isinstance(found, NumericalError):
        raise NumericalError(str(found))
    return found


def _made(profile: ShockProfile, rtol: float, longest: float, least: float) -> UniversalCurve | NumericalError:
    """The curve up to ``longest``, or to ``least`` where there is none so long; or why there is neither."""
    for length in dict.fromkeys((longest, least)):
        try:
            return UniversalCurve(profile, rtol=rtol, longest=length)
        except NumericalError as error:
            failure = error
    return failure


_kept = lru_cache(maxsize=64)(_made)


@frozen(kw_only=True)
class Exponents:
    """Powers with which the peak force of the primary goes with what makes the scene: d ln F / d ln of each.

    All follow from the slope s of the curve, d ln (F/F0) / d ln (t0/T0).

    Attributes
    ----------
    radius, density, youngs_modulus, poisson_ratio : float
        Of the granules: -4/3 s, -s/2, s/3, 2/3 s nu^2/(1 - nu^2).
    peak_force, rise_time : float
        Of the shock: 1 + s/6, s.
    error : float
        Estimate of the absolute error of each.
    """

    radius: float
    density: float
    youngs_modulus: float
    poisson_ratio: float
    peak_force: float
    rise_time: float
    error: float

    @classmethod
    def of(cls, scenario: Scenario, curve: UniversalCurve) -> Exponents:
        """Of the scene, by the curve of its shape."""
        ratio = Scales.of(scenario.chain, scenario.shock.peak_force).rise_time(scenario.shock.rise_time)
        slope = float(curve.slope(ratio))
        found = {name.rpartition(".")[2]: power * slope for name, power in POWERS.items() if name not in _TWINS}
        square = scenario.chain.material.poisson_ratio**2
        found["poisson_ratio"] = 2 / 3 * slope * square / (1 - square)
        found["peak_force"] += 1
        steepest = max(4 / 3, 2 / 3 * square / (1 - square))
        return cls(**found, error=steepest * float(curve.slope_error(ratio)))

    def at(self, name: str) -> float:
        """That of the value called ``name``, which leaves the shape alone."""
        return float(getattr(self, _TWINS.get(name, name).rpartition(".")[2]))

    def __str__(self) -> str:
        return " ".join(f"{sign}^{getattr(self, name):.3f}" for name, sign in SIGNS.items())


@frozen(eq=False)
class Response:
    """Peak forces of the primary in scenes that differ from ``scenario`` in the values called ``names``.

    A chain counts as one without end.

    Parameters
    ----------
    scenario : Scenario
        The scene that has all other values.
    names : sequence of str
        Dotted names of numbers.
    rtol : float
        Relative error allowed of a curve or a simulation.
    """

    scenario: Scenario
    names: tuple[str, ...]
    rtol: float

    @classmethod
    def of(cls, scenario: Scenario, names: Iterable[str], rtol: float) -> Response:
        """The response, of a chain without end."""
        return cls(evolve(scenario, chain=evolve(scenario.chain, granules=None)), tuple(names), rtol)

    @property
    def keeps_shape(self) -> bool:
        """Whether all scenes share the shape of the scenario's shock: then one curve answers for them."""
        return all(name in POWERS for name in self.names)

    def __call__(self, values: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Amplification, shock's peak force [N] and bound on the relative error, for arrays of the same length.

        Raises
        ------
        InvalidValueError
            When there is no such scene, or its shock is longer than curves reach.
        NumericalError
            When a simulation fails.
        """
        return self._by_curve(values) if self.keeps_shape else self._by_simulation(values)

    def _by_curve(self, values: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray, FloatArray]:
        scenario = self.scenario
        n = float(scenario.shock.profile.duration_ratio)
        shift: Any = 0.0
        for name, given in values.items():
            here = value_of(scenario, name)
            if name.endswith("poisson_ratio"):
                shift = shift - (np.log1p(-(given**2)) - math.log1p(-(here**2))) / 3
            else:
                shift = shift + POWERS[name] * (np.log(given) - math.log(here))
        ratios = duration_of(scenario) / n * np.exp(shift)
        if wrong := too_long(ratios * n, values):
            raise wrong
        curve = curve_of(scenario.shock.profile, self.rtol, float(ratios.max()) * n * (1 - _ROUNDING))
        forces = np.asarray(values.get("shock.peak_force", np.full(ratios.shape, scenario.shock.peak_force)))
        ratios = np.minimum(ratios, curve.longest_rise_time)
        return curve.amplification(ratios), forces, curve.error(ratios)

    def _by_simulation(self, values: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray, FloatArray]:
        family = self.family
        rows = zip(*(given.tolist() for given in values.values()), strict=True)
        scenes = [family.scenario(dict(zip(values, row, strict=True))) for row in rows]
        durations = np.array([duration_of(scene) for scene in scenes])
        if wrong := too_long(durations, values, _LIMIT if len(scenes) < _MANY else _EACH):
            raise wrong
        chains = [scene.chain for scene in scenes]
        found = simulate_many([scene.shock for scene in scenes], chains, rtol=self.rtol, waves="primary")
        failed = [result for result in found if isinstance(result, ShockwaveError)]
        if failed:
            raise NumericalError(f"{len(failed)} of {len(found)} scenes could not be simulated: {failed[0]}")
        results = [result for result in found if isinstance(result, SimulationResult)]
        told = [(r.amplification, r.shock.peak_force, r.error_estimate) for r in results]
        amplifications, forces, errors = np.array(told, dtype=float).reshape(-1, 3).T
        return amplifications, forces, errors

    @property
    def family(self) -> Family:
        """Gives the scene for other values: by its profile's own constructor if that says the same as the document."""
        shock = self.scenario.document.data.get("shock") if self.scenario.document is not None else None
        cls: type = type(self.scenario.shock.profile)
        own = [name.rpartition(".")[2] for name in self.names if name not in POWERS]
        fields = [field.name for field in attrs.fields(cls) if field.init] if attrs.has(cls) else []
        told = isinstance(shock, Mapping) and {"profile", "peak_force", "rise_time"} <= shock.keys()
        quick = told and all(name in fields for name in own)
        return Family(evolve(self.scenario, document=None) if quick else self.scenario)
