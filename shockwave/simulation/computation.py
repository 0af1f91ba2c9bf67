"""Computation of the parts of a result that are rarely needed."""

from __future__ import annotations

from typing import Any

from attrs import frozen

from shockwave.base.text import function_at
from shockwave.engine.time_limit import time_limit

# Functions of a result that compute its parts, by their names.
_PARTS = {
    "train": "shockwave.simulation.wave_train:train_of",
    "passages": "shockwave.simulation.wave_passages:passages_at",
    "forces": "shockwave.simulation.contact_forces:forces_of",
    "recording": "shockwave.simulation.chain_histories:record_chain",
    "value_with_yield": "shockwave.simulation.yield_advice:value_with_yield",
    "first_pulses": "shockwave.simulation.first_pulse_search:first_pulses",
}


@frozen
class Computation:
    """Computes the parts of results that are rarely needed, by modules that are imported then.

    ``limit`` is the time limit of the whole scene [s].
    """

    limit: float | None

    def __call__(self, part: str, result: Any, *arguments: Any) -> Any:
        """A part of a `Simulation` by its function."""
        with time_limit(None if self.limit is None else self.limit - result.run_cost.seconds):
            return function_at(_PARTS[part])(result, *arguments)
