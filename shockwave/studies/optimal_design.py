"""Optimal design: values of several parameters that meet requirements with the least mass, or another least quantity.

Each combination of materials is searched by SciPy's differential evolution, with simulations of the scenes, and the
best option found is improved by COBYLA. The answer is verified by a more accurate simulation.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from attrs import evolve, field, frozen
from scipy import optimize
from scipy.stats import qmc

from shockwave.chain.chain import Chain
from shockwave.chain.layout import mass_and_length
from shockwave.errors import InvalidValueError, NumericalError, ShockwaveError
from shockwave.fields import text_of
from shockwave.log import logger
from shockwave.progress import progressed
from shockwave.quadrature import FloatArray
from shockwave.scenario.block_keys import MATERIALS
from shockwave.scenario.dotted_names import Variable
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_argument import Scene
from shockwave.scenario.scene_family import Family
from shockwave.studies import varied_scenes
from shockwave.studies.optimal_result import OptimalDesign, OptimalOption
from shockwave.studies.quantities import OWN, Quantity, Requirement, contacts_of, required
from shockwave.text import si

#: Values of the parameters, in their order.
_Values = tuple[float | str, ...]
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
# Hint in the error for the mass of an endless chain.
_OR_LEAST = "; or state another quantity to minimise, --least of the command or least in Python"
# Most combinations of materials.
_COMBINATIONS = 200
# An option whose simulation fails, or whose scene is not possible.
_IMPOSSIBLE = OptimalOption(values=(), quantities={}, errors={}, least=math.inf, violation=1e3)


def optimal_design(
    scene: Scene,
    chain: Chain | None = None,
    *,
    vary: Mapping[str, str | Sequence[Any] | None],
    targets: str | Sequence[str],
    budgets: str | Sequence[str] = (),
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
    targets, budgets : str or sequence of str
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
    if not isinstance(vary, Mapping) or not vary:
        rule = 'must be a mapping of names to intervals or materials, such as {"chain.radius": ("2 mm", "8 mm")}'
        raise InvalidValueError.of("vary", f"{rule} (got {text_of(vary)})")
    scenario = varied_scenes.scenario_of(scene, chain)
    seed, contacts = varied_scenes.SEED.checked("seed", seed), contacts_of(scenario)

    def quantity(name: str, kind: str) -> Quantity:
        return OWN.get(str(name)) or Quantity.named(name, contacts, OWN, kind)

    requirements = [
        Requirement.of(text, kind, quantity)
        for kind, given in (("target", targets), ("budget", budgets))
        for text in ([given] if isinstance(given, str) or not isinstance(given, Iterable) else given)
        if given is not None
    ]
    if not requirements:
        raise InvalidValueError.of("target", "must be given, such as 'transmitted.peak_force <= 60 N' (got nothing)")
    parameters = [_Parameter.of(name, given, scenario) for name, given in vary.items()]
    return _Search(Family(scenario), parameters, requirements, quantity(least, "least"), seed).run()


@frozen
class _Parameter:
    """A varied parameter: the ends of its interval, or the names of its materials."""

    variable: Variable
    ends: tuple[float, float] = (0.0, 0.0)
    names: tuple[str, ...] = ()

    @classmethod
    def of(cls, name: str, given: str | Sequence[Any] | None, scenario: Scenario) -> _Parameter:
        found = varied_scenes.varied(name, scenario)
        if name.endswith(MATERIALS):
            return cls(found, names=varied_scenes.materials_of(given))
        if found.unit is None:
            raise InvalidValueError.of("vary", f"must be numbers or materials (got {name})")
        return cls(found, varied_scenes.interval(found, given))

    def at(self, share: float) -> float:
        """Value at a share of the interval."""
        low, high = self.ends
        share = min(max(share, 0.0), 1.0)
        value = low * (high / low) ** share if varied_scenes.is_wide(self.ends) else low + share * (high - low)
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
        combinations = list(
            itertools.product(*([evolve(one, names=(name,)) for name in one.names] or [one] for one in self.parameters))
        )
        if len(combinations) > _COMBINATIONS:
            problem = f"must have at most {_COMBINATIONS} combinations of materials (got {len(combinations)})"
            raise InvalidValueError.of("among", f"{problem}; name fewer)")
        groups = [_Group(self, combination) for combination in combinations]
        for index, group in enumerate(groups):
            group.search(index, len(groups))
        tried = [option for group in groups for option in group.known.values()]
        if not tried:
            first = f"; the first: {self.failures[0]}" if self.failures else ""
            raise NumericalError(f"no scene of the search could be simulated{first}")
        ranked = sorted((min(group.known.values(), key=_rank) for group in groups if group.known), key=_rank)
        # the search keeps a margin, so that an option other than the first is rarely needed
        verified = map(self.verified, [one for one in ranked if one.violation <= 0] or ranked[:1])
        best = next((one for one in verified if one.violation <= 0), None)
        base = self.family.base
        logger.info("design of %s: %d scenes simulated", base.name or "the scene", len(tried))
        return OptimalDesign(
            scenario=base.name,
            vary=tuple(one.variable.name for one in self.parameters),
            units=tuple(one.variable.unit or "" for one in self.parameters),
            requirements=tuple(self.requirements),
            least=self.least.name,
            least_unit=self.least.unit,
            best=best,
            nearest=self.verified(ranked[0]) if best is None else None,
            ranking=tuple(ranked) if any(one.names for one in self.parameters) else (),
            tried=tuple(tried),
            evaluations=len(tried),
            warnings=(*self.later(best), *(() if base.impact is not None else base.shock.profile.notes)),
        )

    def options(self, values: Iterable[_Values], rtol: float, margin: float) -> dict[_Values, OptimalOption]:
        """Options keyed by their values, except those whose scene is not possible or whose simulation fails."""
        scenes: dict[_Values, Scenario] = {}
        for key in values:
            try:
                scenes[key] = self.family.scenario(self.named(key))
            except InvalidValueError as error:
                self.failures.append(error)
        found = {}
        for (key, scene), result in zip(scenes.items(), self.simulated([*scenes.values()], rtol), strict=True):
            if isinstance(result, ShockwaveError):
                self.failures.append(result)
            else:
                found[key] = self.option(key, scene, result, margin)
        return found

    def named(self, values: _Values) -> dict[str, float | str]:
        return {one.variable.name: value for one, value in zip(self.parameters, values, strict=True)}

    def simulated(self, scenes: Sequence[Scenario], rtol: float) -> list[Any]:
        """Results of the simulations; None for each if no quantity needs them."""
        needed = {self.least.name, *(one.quantity.name for one in self.requirements)}
        if not scenes or needed <= OWN.keys():
            return [None] * len(scenes)
        return varied_scenes.simulated(scenes, rtol)

    def option(self, values: _Values, scene: Scenario, result: Any, margin: float) -> OptimalOption:
        needed = [*(one.quantity for one in self.requirements), self.least]
        # an endless chain has no mass
        hint = "" if any(one.quantity.name in OWN for one in self.requirements) else _OR_LEAST
        own = mass_and_length(scene.chain, hint) if any(one.name in OWN for one in needed) else ()
        known = {name: (value, 0.0) for name, value in zip(OWN, own, strict=False)}
        kinds = {self.least.name: "least"} | {one.quantity.name: one.kind for one in self.requirements}
        figures = {
            one.name: known.get(one.name) or required(one, result, self.named(values), kinds[one.name])
            for one in needed
        }
        return OptimalOption(
            values=values,
            quantities={name: value for name, (value, _) in figures.items()},
            errors={name: error for name, (_, error) in figures.items()},
            least=figures[self.least.name][0],
            violation=max(one.violation(*figures[one.quantity.name], margin) for one in self.requirements),
        )

    def verified(self, option: OptimalOption) -> OptimalOption:
        """The option by a more accurate simulation, which must meet the requirements without the margin."""
        found = self.options([option.values], _RTOL, 0.0)
        return evolve(found[option.values], verified=True) if found else option

    def later(self, option: OptimalOption | None) -> Iterator[str]:
        """Warning of a requirement that a collision after the simulated time may violate."""
        limits = [
            one for one in self.requirements if one.quantity.name == "transmitted.peak_force" and one.sign == "<="
        ]
        if option is None or not limits:
            return
        (result,) = varied_scenes.simulations([self.family.scenario(self.named(option.values))], _RTOL)
        for one in limits:
            if result.later_force > one.value:
                force = f"up to {si(result.later_force, 'N', 3)}" if result.later_force < math.inf else "more"
                yield f"After the simulated time {force} may act on the wall (extend simulate.until)."


def _rank(option: OptimalOption) -> tuple[float, float]:
    """Violation of the requirements, if any, then the quantity that is minimised."""
    return max(option.violation, 0.0), option.least


class _Group:
    """Search among scenes with the same materials."""

    def __init__(self, search: _Search, parameters: Sequence[_Parameter]) -> None:
        self.within, self.parameters = search, parameters
        self.numbers = [one for one in parameters if not one.names]
        #: Options keyed by their values, and the shares of the intervals at which each was first tried.
        self.known: dict[_Values, OptimalOption] = {}
        self.places: dict[_Values, FloatArray] = {}

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
        if not self.known:
            return
        first = self.ranked[: _MEMBERS * size]
        first += list(rng.random((max(_LEAST_MEMBERS - len(first), 0), size)))
        _optimize.differential_evolution(
            lambda x: np.array([one.least for one in self.at(x)]),
            [(0.0, 1.0)] * size,
            constraints=_optimize.NonlinearConstraint(
                lambda x: np.array([[one.violation for one in self.at(x)]]), -np.inf, 0.0
            ),
            vectorized=True,
            updating="deferred",
            init=np.array(first),
            maxiter=_GENERATIONS,
            seed=rng,
            polish=False,
            callback=report,
        )
        if all(one.variable.whole for one in self.numbers):
            return
        # the best options that lie apart from each other
        apart: list[FloatArray] = []
        for x in self.ranked:
            if len(apart) < _LOCAL * size and all(np.abs(x - other).max() > _APART for other in apart):
                apart.append(x)
        for begin in apart:
            self.improve(begin)

    @property
    def ranked(self) -> list[FloatArray]:
        """Places of the options found, best first."""
        return [self.places[key] for key in sorted(self.known, key=lambda key: _rank(self.known[key]))]

    def improve(self, begin: FloatArray) -> None:
        """Search around an option by COBYLA."""
        scale = abs(self.at(begin)[0].least) or 1.0
        _optimize.minimize(
            lambda x: self.at(x)[0].least / scale,
            begin,
            method="COBYLA",
            constraints=[
                {"type": "ineq", "fun": lambda x: -self.at(x)[0].violation},
                {"type": "ineq", "fun": lambda x: x},
                {"type": "ineq", "fun": lambda x: 1 - x},
            ],
            options={"rhobeg": _FIRST_STEP, "tol": _LAST_STEP, "maxiter": _EVALUATIONS},
        )

    def at(self, x: FloatArray) -> list[OptimalOption]:
        """Options at shares of the intervals, shape (numbers,) or (numbers, options); each is simulated once."""
        keys, new = [], {}
        for column in np.atleast_2d(x.T):
            shares = iter(column.tolist())
            keys.append(tuple(one.names[0] if one.names else one.at(next(shares)) for one in self.parameters))
            if keys[-1] not in self.places:
                new[keys[-1]] = column
        self.places |= new
        self.known |= self.within.options(new, _SEARCH_RTOL, _MARGIN)
        return [self.known.get(key, _IMPOSSIBLE) for key in keys]
