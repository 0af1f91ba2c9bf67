"""Computation of the parts of a result that are rarely needed."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING

from attrs import frozen

from shockwave.base.errors import NumericalError
from shockwave.engine.time_limit import time_limit
from shockwave.simulation.measured_wave import Passage
from shockwave.simulation.recording import Recording
from shockwave.simulation.result_parts import ContactForces, Train
from shockwave.simulation.simulation_result import Simulation

if TYPE_CHECKING:
    from shockwave.simulation.first_pulse import FirstPulse


@frozen
class Computation:
    """Computes the parts of results that are rarely needed, by modules that are imported then; see `Simulation`.

    ``limit`` is the time limit of the whole scene [s].
    """

    limit: float | None

    def train(self, result: Simulation) -> Train:
        """All waves and the rebounding granules."""
        from shockwave.simulation.wave_train import train_of

        with self._allowed(result):
            return train_of(result)

    def passages(self, result: Simulation, contacts: Sequence[int]) -> list[Passage | NumericalError]:
        """The leading wave at these contacts; the error where it has no peak."""
        from shockwave.simulation.parts_on_demand import passages_at

        with self._allowed(result):
            return passages_at(result, contacts)

    def forces(self, result: Simulation) -> ContactForces:
        """Greatest forces at the contacts of a finite chain of equal granules."""
        from shockwave.simulation.contact_forces import forces_of

        with self._allowed(result):
            return forces_of(result)

    def recording(self, result: Simulation) -> Recording:
        """Histories that the options request."""
        if result.wave is None or result.options.sensors:
            from shockwave.simulation.chain_histories import record_chain as record
        else:
            from shockwave.simulation.parts_on_demand import record

        with self._allowed(result):
            return record(result)

    def value_with_yield(self, result: Simulation) -> tuple[str, ...]:
        """Sentence on the forces with elastic-plastic contacts, if they can be computed at once."""
        from shockwave.simulation.yield_advice import value_with_yield

        with self._allowed(result):
            return value_with_yield(result)

    def first_pulses(
        self, result: Simulation, contacts: Sequence[int] | None
    ) -> tuple[tuple[FirstPulse, ...], Sequence[str]]:
        """First pulses at contacts or, if they are None, of the sensors of the options; and warnings."""
        from shockwave.simulation.first_pulse_search import first_pulses

        with self._allowed(result):
            return first_pulses(result, contacts)

    def _allowed(self, result: Simulation) -> AbstractContextManager[None]:
        return time_limit(None if self.limit is None else self.limit - result.run_cost.seconds)
