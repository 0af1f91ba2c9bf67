"""Families: scenes that differ from that of a scenario in some of its values."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import attrs
from attrs import define, evolve, field

from shockwave.chain.chain import Chain
from shockwave.errors import Fault, InvalidValueError
from shockwave.profiles.shock import Shock
from shockwave.registry import load
from shockwave.scenario.loader import scenario_of
from shockwave.scenario.scenario import Scenario

_SHOCK = {"peak_force", "rise_time", "duration"}
_CHAIN = {"chain.radius", "chain.diameter", "chain.granules"}
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
    _known: dict[str, Scenario] = field(factory=dict, init=False)

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
        # These need neither a new profile nor a look at the document.
        parts: dict[str, dict[str, Any]] = {"shock": {}, "chain": {}, "chain.material": {}}
        rest: dict[str, Any] = {}
        for name, value in values.items():
            block, _, last = name.rpartition(".")
            direct = block == "chain.material" or name in _CHAIN or (block == "shock" and last in _SHOCK)
            (parts[block] if direct else rest)[last if direct else name] = value
        found = self._rebuilt(rest) if rest else self.base
        shock, chain = found.shock, found.chain
        if parts["shock"]:
            shock = _shock(shock, parts["shock"])
        if parts["chain"] or parts["chain.material"]:
            chain = _chain(chain, tuple(parts["chain"].items()), tuple(parts["chain.material"].items()))
        return evolve(found, shock=shock, chain=chain) if len(rest) < len(values) else found

    def _rebuilt(self, values: Mapping[str, Any]) -> Scenario:
        """The scenario built anew with ``values``; kept, as a grid comes back to it."""
        key = repr(sorted(values.items()))
        if key not in self._known:
            if len(self._known) >= _MOST_KNOWN:
                self._known.clear()
            document = self.base.document
            if document is None:
                self._known[key] = _of_objects(self.base, values)
            else:
                changed = document.having({tuple(name.split(".")): value for name, value in values.items()})
                self._known[key] = evolve(scenario_of(changed, self.base.path), document=document)
        return self._known[key]


def _shock(shock: Shock, values: dict[str, Any]) -> Shock:
    if "duration" in values:
        values["rise_time"] = values.pop("duration") / float(shock.profile.duration_ratio)
    made: Shock = _located("shock.", shock, **values)
    return made


@lru_cache(maxsize=64)  # most points of a sweep share it
def _chain(chain: Chain, sizes: tuple[tuple[str, Any], ...], constants: tuple[tuple[str, float], ...]) -> Chain:
    values = dict(sizes)
    if "diameter" in values:
        values["radius"] = values.pop("diameter") / 2
    if constants:
        values["material"] = _located("chain.material.", chain.material, name="", source="", **dict(constants))
    made: Chain = _located("chain.", chain, **values)
    return made


def _located(block: str, part: Any, **values: Any) -> Any:
    """``part`` with ``values``; faults name them by their block."""
    try:
        return evolve(part, **values) if values else part
    except InvalidValueError as error:
        raise InvalidValueError(Fault(f"{block}{fault.path}", fault.problem) for fault in error.faults) from None


def _of_objects(base: Scenario, values: Mapping[str, Any]) -> Scenario:
    """The scenario with another material, parameters of its profile, or settings."""
    parts: dict[str, dict[str, Any]] = {"predict": {}, "simulate": {}, "shock.parameters": {}, "chain": {}}
    for name, value in values.items():
        block, _, last = name.replace("shock.duration_ratio", "shock.parameters.duration_ratio").rpartition(".")
        if block not in parts or (block == "shock.parameters" and not attrs.has(type(base.shock.profile))):
            problem = "must be a value of a scenario file here (got a scene made in Python; load one from a file)"
            raise InvalidValueError.of(name, problem)
        parts[block][last] = value
    if "material" in parts["chain"] and isinstance(parts["chain"]["material"], str):
        parts["chain"]["material"] = load("materials", parts["chain"]["material"])
    profile = _located("shock.parameters.", base.shock.profile, **parts["shock.parameters"])
    return evolve(
        base,
        chain=_located("chain.", base.chain, **parts["chain"]),
        shock=evolve(base.shock, profile=profile),
        predictor=_located("predict.", base.predictor, **parts["predict"]),
        simulate=_located("simulate.", base.simulate, **parts["simulate"]),
    )
