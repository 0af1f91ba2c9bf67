"""The first argument of functions on a scene: a scenario, its file, or an excitation with a chain beside it."""

from __future__ import annotations

import os
from typing import TypeAlias

from shockwave.base.errors import InvalidValueError
from shockwave.base.quantity_fields import text_of
from shockwave.scenario.scenario import Scenario, load_scenario
from shockwave.scene.scene import Excitation

#: A scenario, its file, or an excitation whose chain is given beside it.
SceneArgument: TypeAlias = "Scenario | str | os.PathLike[str] | Excitation"


def scenario_alone(scene: object, chain: object) -> Scenario:
    """The scenario of a single case, loaded if ``scene`` is a path.

    Raises
    ------
    InvalidValueError
        If it comes with a chain, is something else, or stands for a sweep.
    ShockwaveError
        As `load_scenario`.
    """
    named = isinstance(scene, str | os.PathLike)
    scenario = load_scenario(scene) if chain is None and named else scene  # type: ignore[arg-type]
    if chain is not None or not isinstance(scenario, Scenario):
        rule = "must be a scenario or its file alone, or a shock or an impact together with a chain"
        raise InvalidValueError.of("scene", f"{rule} (got {text_of(scene)} {'and' if chain else 'without'} a chain)")
    if scenario.sweep is not None:
        got = f"got a sweep of {len(scenario.sweep)}; shockwave.run_sweep runs it"
        raise InvalidValueError.of("scene", f"must describe a single case ({got})")
    return scenario
