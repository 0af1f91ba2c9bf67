"""Optimal design: values of several parameters that meet requirements with the least mass, or another least quantity.

Each combination of materials is searched by SciPy's differential evolution, with simulations of the scenes, and the
best option found is improved by COBYLA. The answer is verified by a more accurate simulation.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from attrs import evolve, field, frozen
from scipy import optimize
from scipy.stats import qmc

from shockwave.chain.chain import Chain
from shockwave.chain.layout import mass_and_length
from shockwave.errors import InvalidValueError, NumericalError, ShockwaveError
from shockwave.log import logger
from shockwave.progress import progressed
from shockwave.quadrature import FloatArray
from shockwave.registry import entries, find
from shockwave.scenario.block_keys import MATERIALS, WALLS
from shockwave.scenario.dotted_names import Variable
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_argument import Scene
from shockwave.scenario.scene_family import Family
from shockwave.studies import varied_scenes
from shockwave.studies.optimal_result import OptimalDesign, OptimalOption
from shockwave.studies.requirements import Requirement
from shockwave.studies.simulated_quantities import Quantity, required, simulated

# its type declarations do not admit functions of many points at once
_optimize: Any = optimize
# Tolerance of the simulations of the search, and of the verification.
_SEARCH_RTOL = 1e-5
_RTOL = 1e-8
# Margin by which the search meets inequalities: several errors of its simulations.
_MARGIN = 1e-4
# Scenes of the first sample, members of a generation and local searches, each for a parameter; most generations.
_SAMPLE = 256
_MEMBERS = 12
_LOCAL = 2
_GENERATIONS = 20
# Most evaluations of a local search by COBYLA, and its first and last step over the intervals.
_EVALUATIONS = 60
_FIRST_STEP, _LAST_STEP = 0.02, 1e-5
# Least number of members of a generation that SciPy accepts.
_LEAST_MEMBERS = 5
# Least distance of the beginnings of two local searches over the intervals.
_APART = 0.1
# Most combinations of materials.
_COMBINATIONS = 200
# Violation of a requirement that has no value, because a simulation fails or a scene is not possible.
_IMPOSSIBLE = 1e3
# Intervals of positive numbers with a greater ratio of their ends are searched by ratios.
_WIDE = 3.0
# Quantities of the chain, which need no simulation.
_OWN = {"chain.mass": ("kg", "chain mass"), "chain.length": ("m", "chain length")}


def optimal_design(
    scene: Scene,
    chain: Chain | None = None,
    *,
    vary: Mapping[str, Sequence[Any] | None],
    targets: Sequence[str],
    budgets: Sequence[str] = (),
    least: str = "chain.mass",
    seed: int = 0,
) -> OptimalDesign:
    """Values of several parameters that meet all requirements with the least of a quantity.

    Parameters
    ----------
    scene : Scenario, path-like, Shock or Impact
        A scenario or its file, or a shock or striker on ``chain``.
    chain : Chain, optional
        The chain, if ``scene`` is a shock or a striker.
    vary : mapping
        Dotted names of the parameters. The value of a number is the pair of the ends of its interval, in SI units or as
        text; that of a material is a list of names, or None for the whole library.
    targets, budgets : sequence of str
        Requirements such as ``transmitted.peak_force <= 60 N`` and ``chain.length <= 0.3 m``: a quantity of the
        simulation, ``chain.mass`` or ``chain.length``, then ``<=``, ``>=`` or ``=`` and a value. An equality holds
        within a thousandth.
    least : str
        Quantity that is minimised.
    seed : int
        Seed of the search; the same seed gives the same answer.

    Returns
    -------
    OptimalDesign
        The best option, verified by a simulation, or the nearest one if none meets all requirements.

    Raises
    ------
    InvalidValueError, UnknownNameError
        If a name is unknown or a value is out of range.
    NumericalError
        If no simulation succeeds.
    """
    scenario = varied_scenes.scenario_of(scene, chain)
    contacts = scenario.simulate.contacts
    quantities = {**{name: Quantity(name, *about) for name, about in _OWN.items()}}

    def quantity(name: str) -> Quantity:
        return quantities.get(name) or Quantity.named(name, contacts, quantities)

    requirements = [Requirement.of(text, "target", quantity) for text in targets]
    requirements += [Requirement.of(text, "budget", quantity) for text in budgets]
    if not requirements:
        raise InvalidValueError.of("target", "must be given, such as 'transmitted.peak_force <= 60 N' (got nothing)")
    parameters = [_Parameter.of(name, given, scenario) for name, given in vary.items()]
    search = _Search(Family(scenario), parameters, requirements, quantity(least), seed)
    return search.run()


@frozen
class _Parameter:
    """A varied parameter: the ends of its interval, or the names of its materials."""

    variable: Variable
    ends: tuple[float, float] = (0.0, 0.0)
    names: tuple[str, ...] = ()

    @classmethod
    def of(cls, name: str, given: Sequence[Any] | None, scenario: Scenario) -> _Parameter:
        found = varied_scenes.varied(name, scenario)
        if name.endswith(MATERIALS):
            names = tuple(given or [entry.name for entry in entries("materials")])
            for one in names:
                if one.lower() not in WALLS:
                    find("materials", one)
            return cls(found, names=names)
        if found.unit is None:
            raise InvalidValueError.of("vary", f"must be numbers or materials (got {name})")
        return cls(found, varied_scenes.interval(found, given))

    @property
    def wide(self) -> bool:
        return self.ends[0] > 0 and self.ends[1] > _WIDE * self.ends[0]

    def at(self, share: float) -> float:
        """Value at a share of the interval."""
        low, high = self.ends
        share = min(max(share, 0.0), 1.0)
        value = low * (high / low) ** share if self.wide else low + share * (high - low)
        return float(round(value)) if self.variable.whole else min(max(value, low), high)


@frozen
class _Search:
    family: Family
    parameters: Sequence[_Parameter]
    requirements: Sequence[Requirement]
    least: Quantity
    seed: int
    failures: list[ShockwaveError] = field(factory=list)

    def run(self) -> OptimalDesign:
        numbers = [one for one in self.parameters if not one.names]
        materials = [one for one in self.parameters if one.names]
        combinations = list(itertools.product(*(one.names for one in materials)))
        if len(combinations) > _COMBINATIONS:
            problem = f"must have at most {_COMBINATIONS} combinations of materials (got {len(combinations)})"
            raise InvalidValueError.of("among", f"{problem}; name fewer)")
        best: list[OptimalOption] = []
        tried: list[OptimalOption] = []
        for index, names in enumerate(combinations):
            fixed = {one.variable.name: name for one, name in zip(materials, names, strict=True)}
            group = _Group(self, numbers, fixed)
            group.search(index, len(combinations))
            if group.found:
                best.append(min(group.found, key=self.rank))
                tried += group.found
        if not best:
            first = f"; the first: {self.failures[0]}" if self.failures else ""
            raise NumericalError(f"no scene of the search could be simulated{first}")
        ranked = sorted(best, key=self.rank)
        chosen, *others = ranked
        verified = self.verified(chosen)
        # the search keeps a margin, so that another option is rarely needed
        for other in others:
            if self.meets(verified) or not self.meets(other):
                break
            verified = self.verified(other)
        logger.info("design of %s: %d scenes simulated", self.family.base.name or "the scene", len(tried))
        return OptimalDesign(
            scenario=self.family.base.name,
            vary=tuple(one.variable.name for one in self.parameters),
            units=tuple(one.variable.unit or "" for one in self.parameters),
            requirements=tuple(self.requirements),
            least=self.least.name,
            least_unit=self.least.unit,
            best=verified if self.meets(verified) else None,
            nearest=verified if not self.meets(verified) else None,
            ranking=tuple(ranked) if materials else (),
            tried=tuple(tried),
            evaluations=len(tried),
            warnings=self.notes,
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the record of the shock."""
        base = self.family.base
        return () if base.impact is not None else tuple(base.shock.profile.notes)

    def rank(self, option: OptimalOption) -> tuple[float, float]:
        """Violation of the requirements, if any, then the quantity that is minimised."""
        return max(option.violation, 0.0), option.least

    def meets(self, option: OptimalOption) -> bool:
        return option.violation <= 0

    def options(self, values: Sequence[Mapping[str, Any]], rtol: float, margin: float) -> list[OptimalOption | None]:
        """Options with these values; None where a scene is not possible or its simulation fails."""
        scenes: list[Scenario | None] = []
        for one in values:
            try:
                scenes.append(self.family.scenario(one))
            except InvalidValueError as error:
                self.failures.append(error)
                scenes.append(None)
        possible = [scene for scene in scenes if scene is not None]
        results = iter(self.simulated(possible, rtol))
        return [
            None if scene is None else self.option(one, scene, next(results), margin)
            for one, scene in zip(values, scenes, strict=True)
        ]

    def simulated(self, scenes: Sequence[Scenario], rtol: float) -> list[Any]:
        """Results of the simulations; None for each if no quantity needs them."""
        needed = {self.least.name, *(one.quantity.name for one in self.requirements)}
        if not scenes or needed <= _OWN.keys():
            return [None] * len(scenes)
        return simulated(scenes, rtol)

    def option(self, values: Mapping[str, Any], scene: Scenario, result: Any, margin: float) -> OptimalOption | None:
        if isinstance(result, ShockwaveError):
            self.failures.append(result)
            return None
        needed = [*(one.quantity for one in self.requirements), self.least]
        figures = {one.name: self.read(one, scene, result, values) for one in needed}
        violation = max(one.violation(*figures[one.quantity.name], margin) for one in self.requirements)
        return OptimalOption(
            values=tuple(values[one.variable.name] for one in self.parameters),
            quantities={name: value for name, (value, _) in figures.items()},
            errors={name: error for name, (_, error) in figures.items()},
            least=figures[self.least.name][0],
            violation=violation,
        )

    def read(self, quantity: Quantity, scene: Scenario, result: Any, values: Mapping[str, Any]) -> tuple[float, float]:
        if quantity.name not in _OWN:
            return required(quantity, result, values)
        mass, length = mass_and_length(scene.chain)
        return (mass if quantity.name == "chain.mass" else length), 0.0

    def verified(self, option: OptimalOption) -> OptimalOption:
        """The option by a more accurate simulation, which must meet the requirements without the margin."""
        values = dict(zip((one.variable.name for one in self.parameters), option.values, strict=True))
        (found,) = self.options([values], _RTOL, 0.0)
        return option if found is None else evolve(found, verified=True)


class _Group:
    """Search among scenes with the same materials."""

    def __init__(self, search: _Search, numbers: Sequence[_Parameter], fixed: Mapping[str, str]) -> None:
        self.within, self.numbers, self.fixed = search, numbers, fixed
        #: Options by their values, and the shares of the intervals at which they were first made.
        self.known: dict[tuple[float, ...], OptimalOption | None] = {}
        self.places: dict[tuple[float, ...], FloatArray] = {}

    @property
    def found(self) -> list[OptimalOption]:
        return [option for option in self.known.values() if option is not None]

    def search(self, index: int, total: int) -> None:
        """Fill ``known`` with the options of the search."""
        if not self.numbers:
            self.at(np.empty((0, 1)))
            return
        size, rng = len(self.numbers), np.random.default_rng([self.within.seed, index])
        steps = itertools.count(1)

        def report(*_: Any) -> None:
            progressed("generations", index * _GENERATIONS + min(next(steps), _GENERATIONS), total * _GENERATIONS)

        self.at(qmc.Sobol(size, seed=rng).random(_SAMPLE * size).T)
        if not self.found:
            return
        first = [self.places[key] for key in self.ranked[: _MEMBERS * size]]
        first += list(rng.random((max(_LEAST_MEMBERS - len(first), 0), size)))
        _optimize.differential_evolution(
            lambda x: np.array([math.inf if one is None else one.least for one in self.at(x)]),
            [(0.0, 1.0)] * size,
            constraints=_optimize.NonlinearConstraint(self.violations, -np.inf, 0.0),
            vectorized=True,
            updating="deferred",
            init=np.array(first),
            maxiter=_GENERATIONS,
            seed=rng,
            polish=False,
            callback=report,
        )
        if any(not one.variable.whole for one in self.numbers):
            for begin in self.beginnings(_LOCAL * size):
                self.improve(begin)

    @property
    def ranked(self) -> list[tuple[float, ...]]:
        """Keys of the options found, best first."""
        return sorted((key for key, one in self.known.items() if one is not None), key=self._rank)

    def _rank(self, key: tuple[float, ...]) -> tuple[float, float]:
        option = self.known[key]
        assert option is not None
        return self.within.rank(option)

    def beginnings(self, count: int) -> list[FloatArray]:
        """The best options that lie apart from each other."""
        chosen: list[FloatArray] = []
        for key in self.ranked:
            x = self.places[key]
            if all(np.abs(x - other).max() > _APART for other in chosen):
                chosen.append(x)
            if len(chosen) == count:
                break
        return chosen

    def improve(self, begin: FloatArray) -> None:
        """Search around an option by COBYLA."""
        (option,) = self.at(begin[:, None])
        scale = (option and abs(option.least)) or 1.0
        _optimize.minimize(
            lambda x: (math.inf if (one := self.one(x)) is None else one.least) / scale,
            begin,
            method="COBYLA",
            constraints=[
                {"type": "ineq", "fun": lambda x: -(_IMPOSSIBLE if (one := self.one(x)) is None else one.violation)},
                {"type": "ineq", "fun": lambda x: x},
                {"type": "ineq", "fun": lambda x: 1 - x},
            ],
            options={"rhobeg": _FIRST_STEP, "tol": _LAST_STEP, "maxiter": _EVALUATIONS},
        )

    def violations(self, x: FloatArray) -> FloatArray:
        return np.array([[_IMPOSSIBLE if one is None else one.violation for one in self.at(x)]])

    def one(self, x: FloatArray) -> OptimalOption | None:
        return self.at(np.clip(x, 0.0, 1.0)[:, None])[0]

    def at(self, x: FloatArray) -> list[OptimalOption | None]:
        """Options at shares of the intervals, shape (numbers, options); each is simulated once."""
        columns = np.atleast_2d(x.T) if x.ndim > 1 else x[None]
        keys = [
            tuple(one.at(share) for one, share in zip(self.numbers, column.tolist(), strict=True)) for column in columns
        ]
        new = {key: column for key, column in zip(keys, columns, strict=True) if key not in self.known}
        names = [one.variable.name for one in self.numbers]
        values = [{**self.fixed, **dict(zip(names, key, strict=True))} for key in new]
        self.places |= new
        self.known.update(zip(new, self.within.options(values, _SEARCH_RTOL, _MARGIN), strict=True))
        return [self.known[key] for key in keys]
