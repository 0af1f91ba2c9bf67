"""Families: scenes that differ from that of a scenario in some of its values."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping
from typing import Any

import attrs
from attrs import define, evolve, field

from shockwave.chain.chain import Chain
from shockwave.chain.material import Material
from shockwave.errors import Fault, InvalidValueError
from shockwave.profiles.shock import Shock
from shockwave.scenario.load import Scenario, scenario_of

__all__ = ["Family"]

_SHOCK = {"shock.peak_force": "peak_force", "shock.rise_time": "rise_time", "shock.duration": "rise_time"}
_CHAIN = {"chain.radius": "radius", "chain.diameter": "radius", "chain.granules": "granules"}
_MATERIAL = {f"chain.material.{name}": name for name in ("youngs_modulus", "poisson_ratio", "density")}
# Values that need neither a new profile nor a look at the document.
_DIRECT = _SHOCK.keys() | _CHAIN.keys() | _MATERIAL.keys()
_MOST_KNOWN = 1024


@define(eq=False)
class Family:
    """Scenes that differ from ``base`` in values called by their dotted names.

    Parameters
    ----------
    base : Scenario
        The scenario. One that was not read from a document takes no other profile.
    """

    base: Scenario
    _known: OrderedDict[tuple[tuple[str, Any], ...], Scenario] = field(factory=OrderedDict, init=False)
    _chain: tuple[Any, Chain] | None = field(default=None, init=False)

    def scenario(self, values: Mapping[str, Any]) -> Scenario:
        """The scenario with other values.

        Parameters
        ----------
        values : mapping
            Dotted names to values, numbers in SI units, as `shockwave.scenario.variable.Variable.value` gives them.

        Raises
        ------
        ScenarioError, InvalidValueError
            When there is no such scene.
        PluginError
            When the fault is a plugin's.
        """
        direct = {name: value for name, value in values.items() if name in _DIRECT}
        rest = {name: value for name, value in values.items() if name not in _DIRECT}
        found = self._of_document(rest) if rest else self.base
        if not direct:
            return found
        shock = _shock(found.shock, {name: value for name, value in direct.items() if name in _SHOCK})
        chain = self._chain_of(found.chain, {name: value for name, value in direct.items() if name not in _SHOCK})
        return evolve(found, shock=shock, chain=chain)

    def _of_document(self, values: Mapping[str, Any]) -> Scenario:
        """The scenario of the document with ``values`` in it; kept, as a grid comes back to it."""
        key = tuple((name, _hashable(value)) for name, value in values.items())
        if key in self._known:
            self._known.move_to_end(key)
            return self._known[key]
        document = self.base.document
        if document is None:
            found = _of_objects(self.base, values)
        else:
            document = document.having({tuple(name.split(".")): value for name, value in values.items()})
            found = evolve(scenario_of(document, self.base.path), document=self.base.document)
        self._known[key] = found
        if len(self._known) > _MOST_KNOWN:
            self._known.popitem(last=False)
        return found

    def _chain_of(self, chain: Chain, values: Mapping[str, Any]) -> Chain:
        """The chain with ``values``; the last one again where they are the same, as most points share it."""
        if not values:
            return chain
        key = (chain, tuple(values.items()))
        if self._chain is None or self._chain[0] != key:
            made = {name: value for name, value in values.items() if name in _MATERIAL}
            sizes = {_CHAIN[name]: value for name, value in values.items() if name in _CHAIN}
            if "chain.diameter" in values:
                sizes["radius"] = values["chain.diameter"] / 2
            if made:
                own = {_MATERIAL[name]: value for name, value in made.items()}
                sizes["material"] = _located("chain.material.", evolve, chain.material, name="", source="", **own)
            self._chain = key, _located("chain.", evolve, chain, **sizes)
        return self._chain[1]


def _shock(shock: Shock, values: Mapping[str, Any]) -> Shock:
    if not values:
        return shock
    own = {_SHOCK[name]: value for name, value in values.items()}
    if "shock.duration" in values:
        own["rise_time"] = values["shock.duration"] / float(shock.profile.duration_ratio)
    made: Shock = _located("shock.", evolve, shock, **own)
    return made


def _located(block: str, make: Callable[..., Any], *given: Any, **values: Any) -> Any:
    try:
        return make(*given, **values)
    except InvalidValueError as error:
        raise InvalidValueError(Fault(f"{block}{fault.path}", fault.problem) for fault in error.faults) from None


def _of_objects(base: Scenario, values: Mapping[str, Any]) -> Scenario:
    """The scenario with another material, parameters of its profile, or settings."""
    from shockwave.registry import load

    parts: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        block, _, last = name.rpartition(".")
        parts.setdefault(block.removesuffix(".parameters"), {})[last] = value
    chain, shock = parts.pop("chain", {}), parts.pop("shock", {})
    wrong = [name for name in (*parts, *chain) if name not in ("predict", "simulate", "material")]
    if wrong or not attrs.has(type(base.shock.profile)) or "profile" in shock:
        name = next(iter(values))
        problem = "must be a value of a scenario file here (got a scene made in Python; load one from a file)"
        raise InvalidValueError.of(name, problem)
    if chain:
        given = chain["material"]
        material = given if isinstance(given, Material) else load("materials", given)
        base = evolve(base, chain=evolve(base.chain, material=material))
    if shock:
        profile = _located("shock.parameters.", evolve, base.shock.profile, **shock)
        base = evolve(base, shock=evolve(base.shock, profile=profile))
    predictor = _located("predict.", evolve, base.predictor, **parts.get("predict", {}))
    simulate = _located("simulate.", evolve, base.simulate, **parts.get("simulate", {}))
    return evolve(base, predictor=predictor, simulate=simulate)


def _hashable(value: Any) -> Any:
    return value if isinstance(value, str | float | int | None) else repr(value)
