"""Search of several parameters: the option that meets all requirements with the least of a quantity.

Each combination of materials is searched by differential evolution of the best of a sample of Sobol points. The answer
is verified by a more accurate simulation.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from attrs import define, evolve, field
from scipy.optimize import differential_evolution
from scipy.stats import qmc

from shockwave.base.errors import InvalidValueError, NumericalError, ShockwaveError
from shockwave.base.progress import track
from shockwave.studies.design_options import VERIFIED_RTOL, DesignScenes, Values
from shockwave.studies.design_result import Option, VariedParameter

# Tolerance of the simulations of the search.
_SEARCH_RTOL = 1e-5
# Margin by which the search meets inequalities: several errors of its simulations.
_MARGIN = 1e-4
# Scenes of the first sample for one number; twice as many for two, four times for three or four, as Sobol points need.
_SAMPLE = 256
# Size of the population for each parameter, and largest number of generations in each round.
_POPULATION = 10
_GENERATIONS = 40
# Spread of the population at which a round ends.
_SPREAD = 1e-7
# Distance from an end of an interval, over its length, within which the end itself is tried.
_NEAR = 1e-4
# Weights of the violation of a requirement beside the quantity over its median: a small one, with which the population
# moves along an equality, then one with which no violation pays.
_WEIGHTS = (10.0, 1e6)
# Most combinations of materials.
_COMBINATIONS = 200


def search_best(scenes: DesignScenes, seed: int) -> dict[str, Any]:
    """Search the best option; ``seed`` is that of the random numbers.

    Returns
    -------
    dict
        Fields of the `Design` that are the answer.

    Raises
    ------
    InvalidValueError
        If there are too many combinations of materials, or a scene does not have a quantity.
    NumericalError
        If no scene could be simulated.
    """
    choices = [[evolve(each, among=(name,)) for name in each.among] or [each] for each in scenes.parameters]
    combinations = list(itertools.product(*choices))
    if len(combinations) > _COMBINATIONS:
        problem = f"must have at most {_COMBINATIONS} combinations of materials (got {len(combinations)}; name fewer)"
        raise InvalidValueError.of("among", problem)
    groups = [_Group(scenes, parameters) for parameters in combinations]
    for index, group in enumerate(track("combinations", groups)):
        group.search(np.random.default_rng([seed, index]))
    ranked = sorted((min(group.options, key=scenes.rank) for group in groups if group.options), key=scenes.rank)
    if not ranked:
        first = next((f"; the first: {group.failures[0]}" for group in groups if group.failures), "")
        raise NumericalError(f"no scene of the search could be simulated{first}")
    # the search keeps a margin, so that an option other than the first is rarely needed
    feasible = [each for each in ranked if each.violation <= 0]
    verified = (_verify(scenes, each) for each in feasible or ranked[:1])
    best = next((each for each in verified if each.violation <= 0), None)
    answer = best or _verify(scenes, ranked[0])
    return {
        "solutions": () if best is None else (best,),
        "nearest": answer if best is None else None,
        "table": tuple(ranked) if any(each.among for each in scenes.parameters) else (),
        "warnings": answer.warnings,
    }


def _verify(scenes: DesignScenes, option: Option) -> Option:
    """The option by a more accurate simulation, which must meet the requirements without the margin."""
    (verified,) = scenes.options([option.values], VERIFIED_RTOL)
    return option if isinstance(verified, ShockwaveError) else verified


@define
class _Group:
    """Search among scenes with the same materials."""

    scenes: DesignScenes
    parameters: Sequence[VariedParameter]
    results: dict[Values, Option | ShockwaveError] = field(factory=dict)

    @property
    def options(self) -> list[Option]:
        return [result for result in self.results.values() if isinstance(result, Option)]

    @property
    def failures(self) -> list[ShockwaveError]:
        return [result for result in self.results.values() if isinstance(result, ShockwaveError)]

    def search(self, rng: np.random.Generator) -> None:
        """Fill ``results``."""
        size = sum(not each.among for each in self.parameters)
        if not size:
            self.simulate([[]])
            return
        population = qmc.Sobol(size, seed=rng).random(_SAMPLE * 2 ** (size - 1).bit_length())
        self.simulate(population.tolist())
        scale = float(np.median([abs(self.scenes.rank(option)[1]) for option in self.options] or [0.0])) or 1.0
        settings: Any = {"bounds": [(0.0, 1.0)] * size, "maxiter": _GENERATIONS, "tol": _SPREAD, "polish": False}
        for weight in _WEIGHTS:

            def heights(places: Any, weight: float = weight) -> Any:
                ranks = map(self.scenes.rank, self.simulate(places.T.tolist()))
                return np.array([weight * violation + quantity / scale for violation, quantity in ranks])

            best = population[np.argsort(heights(population.T))][: _POPULATION * size]
            solution = differential_evolution(
                heights, **settings, init=best, updating="deferred", vectorized=True, seed=rng
            )
            population = solution.population
        ends = np.round(solution.x)
        self.simulate([np.where(np.abs(solution.x - ends) < _NEAR, ends, solution.x).tolist()])

    def simulate(self, places: Iterable[Sequence[float]]) -> list[Option | ShockwaveError]:
        """Results at shares of the intervals."""
        values = []
        for place in places:
            shares = iter(place)
            values.append(tuple(each.among[0] if each.among else each.at(next(shares)) for each in self.parameters))
        new = [each for each in dict.fromkeys(values) if each not in self.results]
        self.results |= zip(new, self.scenes.options(new, _SEARCH_RTOL, _MARGIN), strict=True)
        return [self.results[each] for each in values]
