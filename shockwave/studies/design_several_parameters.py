"""Search of several parameters: the option that meets all requirements with the least of a quantity.

Each combination of materials is searched by samples of Sobol points, first in all intervals, then in smaller and
smaller boxes about the best options. The answer is verified by a more accurate simulation.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from attrs import define, evolve, field
from scipy.stats import qmc

from shockwave.base.errors import InvalidValueError, NumericalError, ShockwaveError
from shockwave.base.numerics import FloatArray
from shockwave.base.progress import track
from shockwave.studies.design_options import VERIFIED_RTOL, DesignScenes, Values
from shockwave.studies.design_result import Option, VariedParameter

# Tolerance of the simulations of the search.
_SEARCH_RTOL = 1e-5
# Margin by which the search meets inequalities: several errors of its simulations.
_MARGIN = 1e-4
# Scenes of the first sample for one number; twice as many for two, four times for three or four, as Sobol points need.
_SAMPLE = 256
# Scenes in a box for each number, and boxes, each about the best option of the one before.
_STEPS = 8
_BOXES = 4
# Rounds, half the width of the first box over the intervals, and the ratio of the widths of two rounds: the last box
# is a few 1e-5 wide.
_ROUNDS = 12
_WIDTH = 0.15
_SHRINKING = 0.5
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
    ranked = sorted((group.ranked[0] for group in groups if group.options), key=groups[0].rank)
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
    #: Options, and the shares of the intervals at which each value was first tried.
    options: list[Option] = field(factory=list)
    places: dict[Values, FloatArray] = field(factory=dict)
    failures: list[ShockwaveError] = field(factory=list)

    def rank(self, option: Option) -> tuple[float, float]:
        """Violation of the requirements, if any, then the quantity that is minimised."""
        return max(option.violation, 0.0), option.quantities[self.scenes.least or ""]

    @property
    def ranked(self) -> list[Option]:
        """The options, best first."""
        return sorted(self.options, key=self.rank)

    def search(self, rng: np.random.Generator) -> None:
        """Fill ``options``."""
        size = sum(not each.among for each in self.parameters)
        if not size:
            self.simulate(np.empty((1, 0)))
            return
        sobol, width = qmc.Sobol(size, seed=rng), _WIDTH
        self.simulate(sobol.random(_SAMPLE * 2 ** (size - 1).bit_length()))
        centres = self.centres()
        for _ in range(_ROUNDS):
            for index, centre in enumerate(centres):
                around = self.places[centre.values] + width * (2 * sobol.random(_STEPS * size) - 1)
                centres[index] = min([centre, *self.simulate(np.clip(around, 0.0, 1.0))], key=self.rank)
            width *= _SHRINKING

    def centres(self) -> list[Option]:
        """The best options that lie apart from each other."""
        apart: list[Option] = []
        for option in self.ranked:
            distances = (np.abs(self.places[option.values] - self.places[each.values]).max() for each in apart)
            if len(apart) < _BOXES and min(distances, default=math.inf) > _WIDTH:
                apart.append(option)
        return apart

    def simulate(self, places: FloatArray) -> list[Option]:
        """New options at shares of the intervals, shape (scenes, numbers)."""
        new: dict[Values, FloatArray] = {}
        for place in places:
            shares = iter(place.tolist())
            values = tuple(each.among[0] if each.among else each.at(next(shares)) for each in self.parameters)
            if values not in self.places:
                self.places[values] = new[values] = place
        results = self.scenes.options(list(new), _SEARCH_RTOL, _MARGIN)
        self.failures += [result for result in results if isinstance(result, ShockwaveError)]
        options = [result for result in results if isinstance(result, Option)]
        self.options += options
        return options
