"""Normalised form of a scenario in SI units, and its hash."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from shockwave.profiles.shock_profile import ShockProfile
from shockwave.scenario.block_keys import keys_of
from shockwave.scenario.scenario import Scenario
from shockwave.scene.chain import Chain
from shockwave.scene.scene import uniform_of
from shockwave.scene.solitary_wave import coefficient_of

# Significant digits; the last digits of a float depend on the units in which a value was written.
_DIGITS = 12
# Length of a list; a longer one is represented by its hash.
_LONGEST = 64
# Points of the rise, and of the decay, that represent a profile without stored parameters.
_POINTS = 129


def scene_hash(scenario: Scenario) -> str:
    """SHA-256 of the normalised scenario, in hexadecimal digits."""
    return hashlib.sha256(normalise(scenario).encode()).hexdigest()


def normalise(scenario: Scenario) -> str:
    """Scenario as canonical JSON: sorted keys, SI units, numbers to 12 digits, defaults written out.

    It contains everything on which the results depend. Names, comments, sources and published results are left out, and
    the units of the file do not matter. A list of more than 64 numbers is represented by its length and hash.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    """
    predictor = scenario.predictor
    form = {
        "chain": _chain(scenario.chain),
        "predict": {**_settings(predictor), "momentum_coefficient": coefficient_of(predictor.momentum_coefficient)},
        **_excitation(scenario),
        "simulate": {**_settings(scenario.simulate), "record": sorted(set(scenario.simulate.record))},
    }
    if not scenario.simulate.sensors:
        del form["simulate"]["sensors"]
    if scenario.chain.elastic_only:
        form["elastic_only"] = True
    if scenario.limit is not None:
        form["limit"] = attrs.asdict(scenario.limit, filter=lambda field, value: value != field.default)
    return json.dumps(_canonical(form), sort_keys=True, separators=(",", ":"), allow_nan=False)


def _chain(chain: Chain) -> dict[str, Any]:
    equal = uniform_of(chain)
    if equal is None or equal.contact is not None:
        from shockwave.scene.description import plain  # not needed for equal granules

        return dict(plain(chain, names=False))
    names = ("youngs_modulus", "poisson_ratio", "density", "yield_strength")
    material = {name: value for name in names if (value := getattr(equal.material, name)) is not None}
    packing = {} if equal.packing is None else {"packing": equal.packing}
    return {"material": material, "radius": equal.radius, "granules": equal.granules, **packing}


def _excitation(scenario: Scenario) -> dict[str, Any]:
    for name, other in (("impact", scenario.impact), ("motion", scenario.motion)):
        if other is not None:
            from shockwave.scene.description import plain  # not needed for a shock

            return {name: plain(other, names=False)}
    shock = scenario.shock
    cls = type(shock.profile)
    excitation = {
        "parameters": parameters(shock.profile),
        "peak_force": shock.peak_force,
        "profile": f"{cls.__module__}:{cls.__qualname__}",
        "rise_time": shock.rise_time,
    }
    return {"shock": excitation}


def parameters(profile: ShockProfile) -> dict[str, Any]:
    """Arguments of the profile's constructor; if it does not store them, its force at some points."""
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
        # adding zero removes the sign of a zero
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
