"""Checks of extreme cases: against a law, another scene, another method, a number, or the error that must be raised."""

from __future__ import annotations

import json
import math
import time
from typing import Any

import numpy as np
from attrs import evolve, field, frozen

from shockwave.benchmark.extreme_cases import Case
from shockwave.benchmark.scenes import FORCE, UNITS, made
from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM, SPEED
from shockwave.errors import ShockwaveError
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import scaled, setup_of, simulate
from shockwave.prediction.predictor import Predictor
from shockwave.simulation.backend import Backend
from shockwave.simulation.primary_search import find_primaries

# The greatest momentum defect allowed: a hundred times what rounding was seen to leave.
_MOMENTUM = 1e-12
# Velocities of rebounding granules, over the velocity of a single granule after the same blow.
_REBOUNDS = (-0.0710850, -0.0302738, -0.0158334, -0.0088857)


def _finite(value: float | None) -> float | None:
    return value if value is None or math.isfinite(value) else None


@frozen
class Finding:
    """The outcome of a case.

    Attributes
    ----------
    outcome : str
        The values found, or the error and its message.
    faults : tuple of str
        What should not have been; none where the case passes.
    error, bound : float or None
        Relative error against the reference of the case, and its bound; None where an error must be raised.
    momentum_defect : float or None
        Momentum in the chain against the impulse, relative; None where nothing was integrated.
    """

    outcome: str
    faults: tuple[str, ...] = ()
    error: float | None = field(default=None, converter=_finite)
    bound: float | None = None
    momentum_defect: float | None = field(default=None, converter=_finite)


def _unsound(result: SimulationResult) -> list[str]:
    """No result may have a number that is not finite, lost momentum, or a tolerance that was missed."""
    faults = [warning for warning in result.warnings if "tolerance was not met" in warning]
    try:
        json.dumps(result.to_dict(), allow_nan=False)
    except ValueError:
        faults.append("a value of the result is not finite")
    if not result.momentum_defect <= _MOMENTUM:
        faults.append(f"the momentum balance is violated by {result.momentum_defect:.1e}")
    return faults


def _judged(case: Case, result: SimulationResult, outcome: str, found: float, reference: float) -> Finding:
    """The finding on a sound result, of which a value is to be that of the reference."""
    error = abs(found / reference - 1)
    faults = _unsound(result)
    if not error <= case.bound:
        faults.append(f"the error is {error:.1e}: {found:.10g} should be {reference:.10g}")
    return Finding(outcome, tuple(faults), error, case.bound, result.momentum_defect)


def _compared(case: Case, result: SimulationResult, reference: float, note: str = "") -> Finding:
    """The finding on a result whose amplification must be that of the reference."""
    return _judged(case, result, _summary(result) + note, result.amplification, reference)


def _with_fault(finding: Finding, wrong: bool, fault: str) -> Finding:
    return evolve(finding, faults=(*finding.faults, fault)) if wrong else finding


def _summary(result: SimulationResult) -> str:
    return f"{result.amplification:.8g} F0 by {result.integrator}, {result.cost.force_evaluations} evaluations"


def _simulated(case: Case, backend: Backend, **options: Any) -> SimulationResult:
    return simulate(*made(case.scene), **{"backend": backend, **case.options, **options})


def _predicted(scene: dict[str, Any]) -> float:
    """The predicted amplification; a prediction that is not finite raises `ValueError`."""
    outcome = Predictor().predict(*made(scene))
    json.dumps(outcome.to_dict(), allow_nan=False)
    return outcome.amplification


def law(case: Case, backend: Backend) -> Finding:
    """The law of short shocks, F = 1.1681817 F0 S^(6/5), S the impulse over that of a wave of F0."""
    result = _simulated(case, backend)
    impulse = result.shock.profile.areas("tanh-sinh").total * result.shock.rise_time / UNITS.time
    reference = IMPULSE_LIMIT * (impulse / MOMENTUM) ** 1.2
    return _compared(case, result, reference, f"; predicted {_predicted(case.scene):.4g} F0")


def method(case: Case, backend: Backend) -> Finding:
    """DOP853 from SciPy, a first-order method whose waves are read in another way, on the whole chain."""
    result = _simulated(case, backend)
    other = simulate(*made(case.scene), None, "dop853", waves="primary")
    finding = _compared(case, result, other.amplification, f"; predicted {_predicted(case.scene):.4g} F0")
    faults = [f"{fault} (by dop853)" for fault in _unsound(other)]
    return evolve(finding, faults=(*finding.faults, *faults))


def like(case: Case, backend: Backend) -> Finding:
    """Another scene with the same answer over its own peak force, simulated and predicted."""
    first, second = _predicted(case.scene), _predicted(case.other)
    finding = like_simulated(case, backend)
    finding = evolve(finding, outcome=f"{finding.outcome}; predicted {first:.4g} F0")
    wrong = not abs(first / second - 1) <= case.bound
    return _with_fault(finding, wrong, f"predicted are {first:.10g} F0 and, for the other scene, {second:.10g} F0")


def like_simulated(case: Case, backend: Backend) -> Finding:
    """Another scene with the same simulated answer."""
    other = _simulated(evolve(case, scene=case.other), backend)
    return _compared(case, _simulated(case, backend), other.amplification)


def number(case: Case, backend: Backend) -> Finding:
    """An amplification found once, at tighter tolerances."""
    result = _simulated(case, backend)
    return _compared(case, result, case.reference, f"; estimated error {result.error_estimate:.0e}")


def refused(case: Case, backend: Backend) -> Finding:
    """An error of this very class, with the message in its text, by the simulation or by a passage asked for."""
    try:
        result = _simulated(case, backend, waves="primary")
        for contact in case.options.get("contacts", ()):
            result.passage(contact)
    except ShockwaveError as error:
        name = type(error).__name__
        matches = name == case.error and case.message in str(error)
        return Finding(f"{name}: {error}", () if matches else (f"it should be {case.must}",))
    return Finding(_summary(result), (f"it should be {case.must}",))


def blow_on_two(case: Case, backend: Backend) -> Finding:
    """Half of the kinetic energy goes through the contact: 2/5 F^(5/3) = L^2/4 in units of mass and stiffness."""
    result = _simulated(case, backend)
    impulse = 1.5 * result.shock.rise_time / UNITS.time
    expected = FORCE * impulse * UNITS.time / result.chain.granule_mass
    spalled = (result.spall_velocities or (0.0,))[0]
    finding = _compared(case, result, (5 / 8 * impulse**2) ** 0.6)
    wrong = not abs(spalled / expected - 1) <= case.bound
    return _with_fault(finding, wrong, f"the second granule should leave with {expected:g} m/s, as the first had")


def far_passage(case: Case, backend: Backend) -> Finding:
    """At contact 1e5 the arrival time depends on the error of the peak force through the speed, to a sixth of it."""
    passage = _simulated(case, backend).passages[0]
    result = _simulated(case, backend, rtol=1e-11)
    outcome = f"arrives after {passage.arrival_time / UNITS.time:.9g} T0, known by the exact wave"
    bounded = evolve(case, bound=min(passage.error_estimate, 1e-6))
    return _judged(bounded, result, outcome, passage.arrival_time, result.passages[0].arrival_time)


def integrated_passage(case: Case, backend: Backend) -> Finding:
    """With no extrapolation uncertainty allowed the search goes on to the longest chain that it may take."""
    contact = 15_000
    result = _simulated(case, backend)
    setup, (problem, _) = setup_of(result.options), scaled(*made(case.scene))
    assert setup.search is not None
    request = evolve(setup.request(problem, contacts=(contact,)), doubt=1e-300)
    (found,) = find_primaries([request], setup.search, setup.compiled)
    arrival = found.passages[0].time
    reference = result.found.time + (contact - result.found.contact) / (SPEED * result.found.peak ** (1 / 6))
    finding = _judged(case, result, f"arrives after {arrival:.9g} T0, {found.steps:g} steps", arrival, reference)
    finding = evolve(finding, momentum_defect=found.momentum_defect)
    wrong = not found.momentum_defect <= _MOMENTUM
    return _with_fault(finding, wrong, f"the momentum balance is violated by {found.momentum_defect:.1e} at the end")


def quickly(case: Case, backend: Backend) -> Finding:
    """Prediction and simulation within a second, the best of three records of which nothing was computed yet."""
    seconds = []
    for _ in range(3):
        scene = made(case.scene)
        begin = time.perf_counter()
        predicted = Predictor().predict(*scene).amplification
        result = simulate(*scene, backend=backend, waves="primary")
        seconds.append(time.perf_counter() - begin)
    fastest = min(seconds)
    tight = simulate(*scene, 1e-10, backend=backend, waves="primary")
    note = f"; predicted {predicted:.4g} F0, both in {fastest:.2g} s"
    finding = _compared(case, result, tight.amplification, note)
    return _with_fault(finding, fastest > 1.0, f"prediction and simulation took {fastest:.2f} s")


def no_more_steps(case: Case, backend: Backend) -> Finding:
    """A smooth pulse in ten times as many samples takes no more steps."""
    coarse, fine = (simulate(*made(scene), backend=backend, waves="primary") for scene in (case.other, case.scene))
    steps = fine.found.steps / coarse.found.steps
    finding = _compared(case, fine, coarse.amplification, f"; {steps:.2g} times the steps")
    return _with_fault(finding, steps > 1.5, f"it took {steps:.2g} times the steps")


def rebound(case: Case, backend: Backend) -> Finding:
    """Eight granules rebound; the velocities of the first four are known to seven digits."""
    result = _simulated(case, backend)
    impulse = result.shock.profile.areas("tanh-sinh").total * result.shock.rise_time * FORCE
    found = np.array(result.recoil_velocities[: len(_REBOUNDS)]) * result.chain.granule_mass / impulse
    shown = ", ".join(f"{share:.6f}" for share in found)
    outcome = f"{result.ejected_granules} rebound, at {shown} of the velocity of a single one"
    worst = max(found / _REBOUNDS, key=lambda share: abs(share - 1))
    return _judged(case, result, outcome, worst, 1.0)


def flying_apart(case: Case, backend: Backend) -> Finding:
    """The momentum of granules that left either end is the impulse: granules that met were not lost."""
    result = _simulated(case, backend)
    spalls = result.spall_velocities or ()
    carried = result.chain.granule_mass * sum(spalls) + result.recoil_momentum
    # left out are granules slower than a thousandth of the fastest; the last before them are hardly faster
    outcome = f"{len(spalls)} granules fly off the end, {_summary(result)}"
    return _judged(case, result, outcome, carried, result.applied_momentum)


_GENERIC = (law, method, like, like_simulated, number, refused)
_SINGLE = (blow_on_two, far_passage, integrated_passage, quickly, no_more_steps, rebound, flying_apart)
#: Each check by the name that a case gives.
CHECKS = {check.__name__: check for check in (*_GENERIC, *_SINGLE)} | {"scaled_beads": like}
