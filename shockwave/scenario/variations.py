"""Families of scenes that differ in some values from the scene of a scenario."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Any

import attrs
from attrs import define, evolve, field

from shockwave.base.errors import Fault, InvalidValueError, below, steps_of
from shockwave.scenario.block_keys import BLOCKS
from shockwave.scenario.scenario import Scenario, parse_scenario
from shockwave.scenario.sweep_block import vary_document
from shockwave.scene.chain import Chain
from shockwave.scene.material import Material, material_of
from shockwave.scene.shock import Shock

# Shocks that are kept: a bound on the memory of a long sweep.
_MOST_KNOWN = 1024
# Block of the values that change the profile of the shock, and other keys of the shock that do.
_SHAPE = "shock.parameters"
_RESHAPING = ("shock.profile", "shock.duration_ratio")
# Block of a striker, and the numbers there.
_IMPACT = "impact"
_STRIKER = ("impact.velocity", "impact.drop_height", "impact.diameter", "impact.radius")


@define(eq=False)
class Family:
    """Scenes that differ from ``base`` in values given by their dotted names.

    Parameters
    ----------
    base : Scenario
        The scenario. If it was not read from a file, its profile cannot be replaced.
    """

    base: Scenario
    _shocks: dict[str, Shock] = field(factory=dict, init=False)
    _places: dict[str, tuple[str, str]] = field(factory=dict, init=False)

    def scenario(self, values: Mapping[str, Any]) -> Scenario:
        """The scenario with other values.

        Parameters
        ----------
        values : mapping
            Dotted names to values, numbers in SI units, as `Variable.convert` gives them.

        Raises
        ------
        ScenarioError, InvalidValueError
            When the values give no valid scene.
        PluginError
            When a plugin is faulty.
        """
        parts: defaultdict[str, dict[str, Any]] = defaultdict(dict)
        for name, value in values.items():
            block, key = self._places.get(name) or self._place(name)
            if not block:
                return self._load(values)
            parts[block][key] = value
        material = parts["chain"].get("material")
        if isinstance(material, Mapping):
            parts["chain"]["material"] = Material(**material)
        shock = self._with_profile(parts[_SHAPE]) if _SHAPE in parts else self.base.shock
        chain, constants = tuple(parts["chain"].items()), tuple(parts["chain.material"].items())
        return evolve(
            self.base,
            shock=_shock(shock, parts["shock"]),
            impact=_change(self.base.impact, parts[_IMPACT], "impact"),
            chain=_chain(self.base.chain, chain, constants) if chain or constants else self.base.chain,
            predictor=_change(self.base.predictor, parts["predict"], "predict"),
            simulate=_change(self.base.simulate, parts["simulate"], "simulate"),
        )

    def _place(self, name: str) -> tuple[str, str]:
        """Block of a variable and its key there; `_SHAPE` and its name if it changes the profile; "" for no block."""
        shock = self.base.document.data.get("shock") if self.base.document is not None else None
        # with both times in the document, each of them changes the duration ratio
        both = isinstance(shock, Mapping) and {"rise_time", "duration"} <= shock.keys()
        reshaping = (*_RESHAPING, "shock.rise_time", "shock.duration") if both else _RESHAPING
        block, _, last = name.rpartition(".")
        if block == _SHAPE or name in reshaping:
            block, last = _SHAPE, name
        directly = block == _SHAPE or block in BLOCKS or name in _STRIKER
        self._places[name] = (block if directly else "", last)
        return self._places[name]

    def _load(self, values: Mapping[str, Any]) -> Scenario:
        """The scenario of the document with other values, some of them below the blocks of the chain."""
        if self.base.document is None:
            raise _no_file_error(values)
        return parse_scenario(vary_document(self.base.document, values), self.base.path)

    def _with_profile(self, values: Mapping[str, Any]) -> Shock:
        """The shock with another profile; kept, because a grid uses it repeatedly."""
        key = repr(values)
        if key not in self._shocks:
            if len(self._shocks) >= _MOST_KNOWN:
                self._shocks.clear()
            document = self.base.document
            if document is None:
                self._shocks[key] = _change_profile(self.base.shock, values)
            else:
                changed = document.with_values({steps_of(name): value for name, value in values.items()})
                self._shocks[key] = parse_scenario(changed, self.base.path).shock
        return self._shocks[key]


def _shock(shock: Shock, values: dict[str, Any]) -> Shock:
    if "duration" in values:
        values["rise_time"] = values.pop("duration") / float(shock.profile.duration_ratio)
    made: Shock = _change(shock, values, "shock")
    return made


@lru_cache(maxsize=64)  # most points of a sweep share their chain
def _chain(chain: Chain, sizes: tuple[tuple[str, Any], ...], constants: tuple[tuple[str, float], ...]) -> Chain:
    values = dict(sizes)
    if constants:
        own = {"name": "", "source": "", **dict(constants)}
        values["material"] = _change(material_of(values.get("material", chain.material)), own, "chain", "material")
    made: Chain = _change(chain, values, "chain")
    return made


def _change(part: Any, values: dict[str, Any], *block: str) -> Any:
    """``part``, which ``block`` describes, with other ``values``."""
    if not values:
        return part
    if "diameter" in values:
        values["radius"] = values.pop("diameter") / 2
    with below(*block):
        return evolve(part, **values)


def _no_file_error(names: Iterable[str]) -> InvalidValueError:
    got = "got a shock and a chain made in Python; load a scenario from a file"
    return InvalidValueError(*(Fault(name, f"must be values of a scenario file ({got})") for name in names))


def _change_profile(shock: Shock, values: Mapping[str, Any]) -> Shock:
    """The shock with other parameters of its profile, for a scene without a document."""
    if "shock.profile" in values or not attrs.has(type(shock.profile)):
        raise _no_file_error(values)
    own = {name.rpartition(".")[2]: value for name, value in values.items()}
    return evolve(shock, profile=_change(shock.profile, own, "shock", "parameters"))
