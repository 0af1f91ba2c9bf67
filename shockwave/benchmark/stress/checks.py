"""How a case is judged: against a law, another scene or another method, or by the error that it must raise."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from shockwave.benchmark.stress.case import Check, Finding
from shockwave.benchmark.stress.scenes import UNITS, Make
from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM
from shockwave.errors import ShockwaveError
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import simulate
from shockwave.prediction.outcome import Outcome
from shockwave.prediction.predictor import Predictor
from shockwave.simulation.backend import Backend

__all__ = [
    "AT_DEFAULT",
    "BOOK",
    "against",
    "by_law",
    "by_method",
    "faults_of",
    "judged",
    "like",
    "predicted",
    "refused",
    "told",
]

#: How far the book of momentum may be open: a hundred times what rounding was seen to leave.
BOOK = 1e-12
#: The tolerance asked for unless another is stated, once for the run and once for its reference.
AT_DEFAULT = 2e-6


def told(result: SimulationResult) -> str:
    """What a simulation found, and what it cost."""
    return f"{result.amplification:.8g} F0 by {result.integrator}, {result.cost.force_evaluations} evaluations"


def faults_of(result: SimulationResult) -> list[str]:
    """What no result may have: a number that is not finite, an open book, a tolerance that was missed."""
    faults = []
    try:
        json.dumps(result.to_dict(), allow_nan=False)
    except ValueError:
        faults.append("a figure of the result is not finite")
    if not result.momentum_defect <= BOOK:
        faults.append(f"the book of momentum is open by {result.momentum_defect:.1e}")
    faults += [warning for warning in result.warnings if "tolerance was not met" in warning]
    return faults


def predicted(make: Make) -> Outcome:
    """The prediction for a scene; its figures are all finite.

    Raises
    ------
    ValueError
        When one of them is not.
    """
    outcome = Predictor().predict(*make())
    json.dumps(outcome.to_dict(), allow_nan=False)
    return outcome


def judged(result: SimulationResult, reference: float, bound: float, note: str = "", *more: str) -> Finding:
    """The finding on a result whose amplification must be within ``bound`` of ``reference``; ``more`` are faults."""
    error = abs(result.amplification / reference - 1)
    faults = [*faults_of(result), *more]
    if not error <= bound:
        faults.append(f"the peak force is {result.amplification:.10g} F0, it should be {reference:.10g} F0")
    return Finding(
        outcome=told(result) + (f"; {note}" if note else ""),
        error=error,
        bound=bound,
        momentum_defect=result.momentum_defect,
        faults=tuple(faults),
    )


def _with_prediction(make: Make) -> str:
    outcome = predicted(make)
    return f"predicted {outcome.amplification:.4g} F0"


def by_law(make: Make, bound: float = 1e-6, **asked: Any) -> Check:
    """Against the law of short shocks, F = 1.1681817 F0 S^(6/5), S the impulse over that of a wave of F0."""

    def check(backend: Backend) -> Finding:
        shock, chain = make()
        result = simulate(shock, chain, backend=backend, **asked)
        impulse = shock.profile.areas("tanh-sinh").total * shock.rise_time / UNITS.time
        return judged(result, IMPULSE_LIMIT * (impulse / MOMENTUM) ** 1.2, bound, _with_prediction(make))

    return check


def by_method(make: Make, bound: float = AT_DEFAULT, **asked: Any) -> Check:
    """Against DOP853 from SciPy, a first-order method whose waves are read in another way, on the whole chain."""

    def check(backend: Backend) -> Finding:
        result = simulate(*make(), backend=backend, **asked)
        other = simulate(*make(), integrator="dop853", waves="primary")
        faults = [f"{fault} (by dop853)" for fault in faults_of(other)]
        return judged(result, other.amplification, bound, _with_prediction(make), *faults)

    return check


def like(make: Make, other: Make, bound: float, **asked: Any) -> Check:
    """Against another scene, which must have the same answer, over its own peak force; predictions alike."""

    def check(backend: Backend) -> Finding:
        result = simulate(*make(), backend=backend, **asked)
        reference = simulate(*other(), backend=backend, **asked)
        first, second = predicted(make).amplification, predicted(other).amplification
        faults = []
        if not abs(first / second - 1) <= bound:
            faults.append(f"predicted are {first:.10g} F0 and, for the other scene, {second:.10g} F0")
        return judged(result, reference.amplification, bound, f"predicted {first:.4g} F0", *faults)

    return check


def against(make: Make, reference: float, bound: float, **asked: Any) -> Check:
    """Against a number: the amplification."""

    def check(backend: Backend) -> Finding:
        result = simulate(*make(), backend=backend, **asked)
        return judged(result, reference, bound, _with_prediction(make))

    return check


def refused(call: Callable[[Backend], Any], kind: type[ShockwaveError], words: str) -> Check:
    """What is asked must raise an error of this very class, with these words in its message."""

    def check(backend: Backend) -> Finding:
        try:
            found = call(backend)
        except ShockwaveError as error:
            message = str(error)
            wrong = type(error) is not kind or words not in message
            faults = (f"it should be {kind.__name__} with '{words}'",) if wrong else ()
            return Finding(outcome=f"{type(error).__name__}: {message}", faults=faults)
        shown = told(found) if isinstance(found, SimulationResult) else type(found).__name__
        return Finding(outcome=shown, faults=(f"it should be {kind.__name__} with '{words}'",))

    return check
