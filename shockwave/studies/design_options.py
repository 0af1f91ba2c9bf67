"""Options of a design: the simulations of their scenes, and the quantities that are read from them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from attrs import field, frozen

from shockwave.base.errors import InvalidValueError, ShockwaveError
from shockwave.base.quantities import GRANULES, Quantity
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.variations import Family
from shockwave.scene.yielding import law_notes
from shockwave.studies import varied_scenes
from shockwave.studies.design_result import Design, Option, VariedParameter
from shockwave.studies.quantities import Requirement, figures_of_scene
from shockwave.studies.warning_groups import WarningGroups

#: Tolerance of the simulations of answers.
VERIFIED_RTOL = 1e-8
#: Values of the parameters, in their order.
Values = tuple[float | str, ...]


@frozen
class DesignScenes:
    """Scenes that differ in the values of the parameters of a design.

    Attributes
    ----------
    family : Family
        The scenes.
    parameters, requirements, quantities, least
        As in `Design`.
    tried : list of Option
        All options so far.
    """

    family: Family
    parameters: tuple[VariedParameter, ...]
    requirements: tuple[Requirement, ...]
    quantities: tuple[Quantity, ...]
    least: str | None
    tried: list[Option] = field(factory=list)

    def options(self, values: Sequence[Values], rtol: float, margin: float = 0.0) -> list[Option | ShockwaveError]:
        """Options with these values, or the errors of scenes that are not possible or whose simulations fail.

        Parameters
        ----------
        values : sequence of tuple
            Values of the parameters of each option.
        rtol : float
            Tolerance of the simulations.
        margin : float
            Relative margin with which requirements must hold.

        Raises
        ------
        InvalidValueError
            If a scene does not have a quantity of the design.
        """
        scenes: list[Any] = [self._scene(each) for each in values]
        options = [
            result if isinstance(result, ShockwaveError) else self._option(each, scene, result, rtol, margin)
            for each, scene, result in zip(values, scenes, self._results(scenes, rtol), strict=True)
        ]
        self.tried.extend(option for option in options if isinstance(option, Option))
        return options

    def possible(self, values: Sequence[Values], rtol: float) -> list[Option]:
        """Options with these values; raises the first error of a scene."""
        options = self.options(values, rtol)
        for option in options:
            if isinstance(option, ShockwaveError):
                raise option
        return [option for option in options if isinstance(option, Option)]

    def rank(self, result: Option | ShockwaveError) -> tuple[float, float]:
        """Violation of the requirements, if any, then the quantity that is minimised; infinite for an error."""
        if isinstance(result, ShockwaveError):
            return math.inf, math.inf
        return max(result.violation, 0.0), result.quantities[self.least or ""]

    def design(self, answer: Mapping[str, Any]) -> Design:
        """The design with the fields that are its answer."""
        task = ("parameters", "requirements", "quantities", "least")
        groups, warnings = WarningGroups(), answer["warnings"]
        for option in self.tried:
            groups.add(option.warnings)
        others = groups.sentences("simulated scenes", besides=warnings)
        return Design(
            scenario=self.family.base.name,
            **{name: getattr(self, name) for name in task},
            **{**answer, "warnings": (*warnings, *others, *law_notes(self.family.base.chain))},
            tried=tuple(self.tried),
        )

    def by_name(self, values: Values) -> dict[str, float | str]:
        """The values by the names of their parameters."""
        return {each.name: value for each, value in zip(self.parameters, values, strict=True)}

    def _scene(self, values: Values) -> Scenario | InvalidValueError:
        """The scene with these values, or its error."""
        try:
            return self.family.scenario(self.by_name(values))
        except InvalidValueError as error:
            return error

    def _results(self, scenes: Sequence[Scenario | ShockwaveError], rtol: float) -> list[Any]:
        """Results of the simulations, None if no quantity needs them; or the errors."""
        if all(each in GRANULES for each in self.quantities):
            return [None if isinstance(scene, Scenario) else scene for scene in scenes]
        return varied_scenes.simulate_each(scenes, self.family.base.simulate, rtol)

    def _option(self, values: Values, scene: Scenario, result: Any, rtol: float, margin: float) -> Option:
        kinds = {each.quantity.name: each.kind for each in self.requirements}
        figures = {
            each.name: figures_of_scene(each, scene, result, self.by_name(values), kinds.get(each.name, "least"))
            for each in self.quantities
        }
        return Option(
            values=values,
            quantities={name: value for name, (value, _) in figures.items()},
            errors={name: error for name, (_, error) in figures.items()},
            violation=max(each.violation(*figures[each.quantity.name], margin) for each in self.requirements),
            verified=rtol <= VERIFIED_RTOL,
            warnings=() if result is None else result.wave_warnings,
        )
