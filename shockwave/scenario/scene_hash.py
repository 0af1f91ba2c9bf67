"""The content of a scenario in one form and in SI units, and the hash of that."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from shockwave.prediction.predictor import coefficient_of
from shockwave.profiles.base import ShockProfile
from shockwave.scenario.block_keys import keys_of
from shockwave.scenario.scenario import Scenario

# Digits that a change of units leaves alone; the last ones are its rounding.
_DIGITS = 12
# Longer lists stand as their hash.
_LONGEST = 64
# Where a profile that keeps no parameters is looked at: so many points of rise and decay each.
_POINTS = 129


def scene_hash(scenario: Scenario) -> str:
    """SHA-256 of the normalised scenario, in hexadecimal digits."""
    return hashlib.sha256(normalised(scenario).encode()).hexdigest()


def normalised(scenario: Scenario) -> str:
    """The scenario as canonical JSON: sorted keys, SI units, numbers to 12 digits, defaults written out.

    It holds what the answers depend on. Names, comments, sources and printed figures are left out, and it makes no
    difference in which units the scenario was written. Lists of more than 64 numbers stand as their length and hash.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    """
    shock, chain, predictor = scenario.shock, scenario.chain, scenario.predictor
    cls = type(shock.profile)
    constants = ("youngs_modulus", "poisson_ratio", "density")
    form = {
        "chain": {
            "material": {name: getattr(chain.material, name) for name in constants},
            "radius": chain.radius,
            "granules": chain.granules,
        },
        "predict": {**_settings(predictor), "momentum_coefficient": coefficient_of(predictor.momentum_coefficient)},
        "shock": {
            "parameters": parameters(shock.profile),
            "peak_force": shock.peak_force,
            "profile": f"{cls.__module__}:{cls.__qualname__}",
            "rise_time": shock.rise_time,
        },
        "simulate": {**_settings(scenario.simulate), "record": sorted(set(scenario.simulate.record))},
    }
    return json.dumps(_canonical(form), sort_keys=True, separators=(",", ":"), allow_nan=False)


def parameters(profile: ShockProfile) -> dict[str, Any]:
    """Arguments of the profile's constructor; its force at some points, if it does not keep them."""
    names = [key.name for key in keys_of(type(profile))]
    if all(hasattr(profile, name) for name in names):
        return {name: getattr(profile, name) for name in names}
    n = float(profile.duration_ratio)
    places = np.concatenate((np.linspace(0, 1, _POINTS), np.linspace(1, n, _POINTS)))
    return {"duration_ratio": n, "force": profile.force(places)}


def _settings(block: attrs.AttrsInstance) -> dict[str, Any]:
    return {field.name: getattr(block, field.name) for field in attrs.fields(type(block)) if field.init}


def _canonical(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, int | float):
        # adding zero takes the sign from a zero
        return float(f"{value:.{_DIGITS - 1}e}") + 0.0
    if isinstance(value, Mapping):
        return {str(key): _canonical(inner) for key, inner in value.items()}
    if isinstance(value, Sequence):
        inner = [_canonical(one) for one in value]
        if len(inner) <= _LONGEST:
            return inner
        return {"length": len(inner), "sha256": hashlib.sha256(json.dumps(inner).encode()).hexdigest()}
    if attrs.has(type(value)):
        return {"class": type(value).__qualname__, **_canonical(_settings(value))}
    return str(value)
