"""Search of several parameters: the option that meets all requirements with the least of a quantity.

Each combination of materials is searched by SciPy's differential evolution, and the best options found are improved by
COBYLA. The answer is verified by a more accurate simulation.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from attrs import define, evolve, field
from scipy import optimize
from scipy.stats import qmc

from shockwave.errors import InvalidValueError, NumericalError, ShockwaveError
from shockwave.progress import progressed
from shockwave.quadrature import FloatArray
from shockwave.studies.design_result import Option, VariedParameter
from shockwave.studies.design_scenes import VERIFIED_RTOL, DesignScenes, Values

# its type declarations do not admit functions of many points at once
_optimize: Any = optimize
# Tolerance of the simulations of the search.
_SEARCH_RTOL = 1e-5
# Margin by which the search meets inequalities: several errors of its simulations.
_MARGIN = 1e-4
# Scenes of the first sample, members of a generation and local searches, each for a parameter; most generations.
_SAMPLE = 256
_MEMBERS = 12
_LOCAL = 2
_GENERATIONS = 20
# Most evaluations of a local search by COBYLA, and its first and last step over the intervals.
_EVALUATIONS = 60
_FIRST_STEP = 0.02
_LAST_STEP = 1e-5
# Least number of members of a generation that SciPy accepts.
_LEAST_MEMBERS = 5
# Least distance of the beginnings of two local searches over the intervals.
_APART = 0.1
# Most combinations of materials.
_COMBINATIONS = 200
# Violation of a scene that is not possible or whose simulation fails.
_IMPOSSIBLE = 1e3


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
        problem = f"must have at most {_COMBINATIONS} combinations of materials (got {len(combinations)})"
        raise InvalidValueError.of("among", f"{problem}; name fewer)")
    groups = [
        _Group(scenes, combination, np.random.default_rng([seed, i])) for i, combination in enumerate(combinations)
    ]
    for index, group in enumerate(groups):
        group.search(index, len(groups))
    best_of_groups = [min(group.options.values(), key=group.rank) for group in groups if group.options]
    if not best_of_groups:
        failures = [group.failures[0] for group in groups if group.failures]
        first = f"; the first: {failures[0]}" if failures else ""
        raise NumericalError(f"no scene of the search could be simulated{first}")
    ranked = sorted(best_of_groups, key=groups[0].rank)
    # the search keeps a margin, so that an option other than the first is rarely needed
    verified = (_verified(scenes, each) for each in [each for each in ranked if each.violation <= 0] or ranked[:1])
    best = next((each for each in verified if each.violation <= 0), None)
    answer = best or _verified(scenes, ranked[0])
    return {
        "solutions": () if best is None else (best,),
        "nearest": answer if best is None else None,
        "table": tuple(ranked) if len(combinations) > 1 or scenes.parameters[0].among else (),
        "warnings": answer.warnings,
    }


def _verified(scenes: DesignScenes, option: Option) -> Option:
    """The option by a more accurate simulation, which must meet the requirements without the margin."""
    (verified,) = scenes.options([option.values], VERIFIED_RTOL)
    return option if isinstance(verified, ShockwaveError) else verified


@define
class _Group:
    """Search among scenes with the same materials."""

    scenes: DesignScenes
    parameters: Sequence[VariedParameter]
    rng: np.random.Generator
    #: Options keyed by their values, and the shares of the intervals at which each was first tried.
    options: dict[Values, Option] = field(factory=dict)
    places: dict[Values, FloatArray] = field(factory=dict)
    failures: list[ShockwaveError] = field(factory=list)

    @property
    def numbers(self) -> list[VariedParameter]:
        """Parameters that are numbers."""
        return [each for each in self.parameters if not each.among]

    def rank(self, option: Option) -> tuple[float, float]:
        """Violation of the requirements, if any, then the quantity that is minimised."""
        return max(option.violation, 0.0), self.least(option)

    def least(self, option: Option) -> float:
        """The quantity that is minimised."""
        assert self.scenes.least is not None
        return option.quantities[self.scenes.least]

    def search(self, index: int, total: int) -> None:
        """Fill ``options``; this is group ``index`` of ``total``."""
        size = len(self.numbers)
        if not size:
            self.simulate(np.empty((0, 1)))
            return
        self.simulate(qmc.Sobol(size, seed=self.rng).random(_SAMPLE * size).T)
        if not self.options:
            return
        steps = itertools.count(1)
        self.evolve(
            lambda *_: progressed(
                "generations", index * _GENERATIONS + min(next(steps), _GENERATIONS), total * _GENERATIONS
            )
        )
        if all(each.whole for each in self.numbers):
            return
        # the best options that lie apart from each other
        apart: list[FloatArray] = []
        for place in self.ranked:
            if len(apart) < _LOCAL * size and all(np.abs(place - other).max() > _APART for other in apart):
                apart.append(place)
        for begin in apart:
            self.improve(begin)

    @property
    def ranked(self) -> list[FloatArray]:
        """Places of the options, best first."""
        return [self.places[key] for key in sorted(self.options, key=lambda key: self.rank(self.options[key]))]

    def evolve(self, report: Any) -> None:
        """Search by differential evolution from the best options; ``report`` is called after every generation."""
        size = len(self.numbers)
        first = self.ranked[: _MEMBERS * size]
        first += list(self.rng.random((max(_LEAST_MEMBERS - len(first), 0), size)))
        _optimize.differential_evolution(
            lambda x: self.simulate(x)[0],
            [(0.0, 1.0)] * size,
            constraints=_optimize.NonlinearConstraint(lambda x: self.simulate(x)[1:], -np.inf, 0.0),
            vectorized=True,
            updating="deferred",
            init=np.array(first),
            maxiter=_GENERATIONS,
            seed=self.rng,
            polish=False,
            callback=report,
        )

    def improve(self, begin: FloatArray) -> None:
        """Search around an option by COBYLA."""
        scale = abs(float(self.simulate(begin)[0, 0])) or 1.0
        _optimize.minimize(
            lambda x: float(self.simulate(x)[0, 0]) / scale,
            begin,
            method="COBYLA",
            constraints=[
                {"type": "ineq", "fun": lambda x: -float(self.simulate(x)[1, 0])},
                {"type": "ineq", "fun": lambda x: x},
                {"type": "ineq", "fun": lambda x: 1 - x},
            ],
            options={"rhobeg": _FIRST_STEP, "tol": _LAST_STEP, "maxiter": _EVALUATIONS},
        )

    def simulate(self, x: FloatArray) -> FloatArray:
        """The minimised quantity and the violation, shape (2, options), at shares of the intervals.

        ``x`` has the shape (numbers,) or (numbers, options); each scene is simulated once.
        """
        keys: list[Values] = []
        new: dict[Values, FloatArray] = {}
        for column in np.atleast_2d(x.T):
            shares = iter(column.tolist())
            keys.append(tuple(each.among[0] if each.among else each.at(next(shares)) for each in self.parameters))
            if keys[-1] not in self.places:
                new[keys[-1]] = column
        self.places |= new
        for key, option in zip(new, self.scenes.options(list(new), _SEARCH_RTOL, _MARGIN), strict=True):
            if isinstance(option, ShockwaveError):
                self.failures.append(option)
            else:
                self.options[key] = option
        options = [self.options.get(key) for key in keys]
        figures = [(math.inf, _IMPOSSIBLE) if each is None else (self.least(each), each.violation) for each in options]
        return np.array(figures).T
