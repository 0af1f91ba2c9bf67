"""Checks of extreme cases: against a law, another scene, another method, a number, or the error that must be raised."""

from __future__ import annotations

import json
import math
import time

import numpy as np
from attrs import evolve, field, frozen

from shockwave.benchmark.extreme_cases import Case
from shockwave.benchmark.extreme_scenes import FORCE, UNITS, made
from shockwave.chain.solitary_wave import IMPULSE_LIMIT, MOMENTUM, SPEED
from shockwave.errors import ShockwaveError
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import plan_of, scaled, simulate
from shockwave.options import SimulateOptions
from shockwave.prediction.predictor import Predictor
from shockwave.simulation.backend import Backend
from shockwave.simulation.primary import find_primaries

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


def _judged(result: SimulationResult, outcome: str, error: float, bound: float, expected: str, *others: str) -> Finding:
    """The finding on a result; an error above the bound is reported with what was ``expected``; ``others`` are faults.

    No result may have a number that is not finite, lost momentum, or a tolerance that was missed.
    """
    faults = [warning for warning in result.warnings if "tolerance was not met" in warning]
    try:
        json.dumps(result.to_dict(), allow_nan=False)
    except ValueError:
        faults.append("a value of the result is not finite")
    if not result.momentum_defect <= _MOMENTUM:
        faults.append(f"the momentum balance is violated by {result.momentum_defect:.1e}")
    if not error <= bound:
        faults.append(f"the error is {error:.1e}: {expected}")
    return Finding(outcome, (*faults, *others), error, bound, result.momentum_defect)


def _compared(case: Case, result: SimulationResult, reference: float, note: str = "", *faults: str) -> Finding:
    """The finding on a result whose amplification must be that of the reference."""
    error = abs(result.amplification / reference - 1)
    expected = f"the peak force is {result.amplification:.10g} F0, it should be {reference:.10g} F0"
    outcome = _summary(result) + (f"; {note}" if note else "")
    return _judged(result, outcome, error, case.bound, expected, *faults)


def _summary(result: SimulationResult) -> str:
    return f"{result.amplification:.8g} F0 by {result.integrator}, {result.cost.force_evaluations} evaluations"


def _simulated(case: Case, backend: Backend) -> SimulationResult:
    return simulate(*made(case.scene), **{"backend": backend, **case.options})


def _predicted(scene: dict[str, object]) -> float:
    """The predicted amplification; a prediction that is not finite raises `ValueError`."""
    outcome = Predictor().predict(*made(scene))
    json.dumps(outcome.to_dict(), allow_nan=False)
    return outcome.amplification


def law(case: Case, backend: Backend) -> Finding:
    """The law of short shocks, F = 1.1681817 F0 S^(6/5), S the impulse over that of a wave of F0."""
    result = _simulated(case, backend)
    impulse = result.shock.profile.areas("tanh-sinh").total * result.shock.rise_time / UNITS.time
    reference = IMPULSE_LIMIT * (impulse / MOMENTUM) ** 1.2
    return _compared(evolve(case, bound=1e-6), result, reference, f"predicted {_predicted(case.scene):.4g} F0")


def method(case: Case, backend: Backend) -> Finding:
    """DOP853 from SciPy, a first-order method whose waves are read in another way, on the whole chain."""
    result = _simulated(case, backend)
    other = simulate(*made(case.scene), integrator="dop853", waves="primary")
    faults = _judged(other, "", 0.0, 0.0, "").faults
    note = f"predicted {_predicted(case.scene):.4g} F0"
    return _compared(case, result, other.amplification, note, *(f"{fault} (by dop853)" for fault in faults))


def like(case: Case, backend: Backend) -> Finding:
    """Another scene with the same answer over its own peak force, simulated and predicted."""
    finding = like_simulated(case, backend)
    first, second = _predicted(case.scene), _predicted(case.other)
    if not abs(first / second - 1) <= case.bound:
        fault = f"predicted are {first:.10g} F0 and, for the other scene, {second:.10g} F0"
        finding = evolve(finding, faults=(*finding.faults, fault))
    return evolve(finding, outcome=f"{finding.outcome}; predicted {first:.4g} F0")


def like_simulated(case: Case, backend: Backend) -> Finding:
    """Another scene with the same simulated answer."""
    other = _simulated(evolve(case, scene=case.other), backend)
    return _compared(case, _simulated(case, backend), other.amplification)


def scaled_beads(case: Case, backend: Backend) -> Finding:
    """The paper's beads with the same t0/T0."""
    return like(evolve(case, other={"sized": []}, bound=1e-12), backend)


def number(case: Case, backend: Backend) -> Finding:
    """An amplification found once, at tighter tolerances."""
    result = _simulated(case, backend)
    return _compared(case, result, case.reference, f"estimated error {result.error_estimate:.0e}")


def refused(case: Case, backend: Backend) -> Finding:
    """An error of this very class, with the message in its text, by the simulation or by a passage asked for."""
    outcome, matches = "no error", False
    try:
        result = simulate(*made(case.scene), backend=backend, waves="primary", **case.options)
        outcome = _summary(result)
        for contact in case.options.get("contacts", ()):
            result.passage(contact)
    except ShockwaveError as error:
        outcome = f"{type(error).__name__}: {error}"
        matches = type(error).__name__ == case.error and case.message in str(error)
    return Finding(outcome, () if matches else (f"it should be {case.must}",))


def blow_on_two(case: Case, backend: Backend) -> Finding:
    """Half of the kinetic energy goes through the contact: 2/5 F^(5/3) = L^2/4 in units of mass and stiffness."""
    result = _simulated(case, backend)
    impulse = 1.5 * result.shock.rise_time / UNITS.time
    expected = FORCE * impulse * UNITS.time / result.chain.granule_mass
    faults = []
    if not result.spall_velocities or abs(result.spall_velocities[0] / expected - 1) > 1e-6:
        faults.append(f"the second granule should leave with {expected:g} m/s, the velocity of the first before")
    return _compared(evolve(case, bound=1e-6), result, (5 / 8 * impulse**2) ** 0.6, "", *faults)


def far_passage(case: Case, backend: Backend) -> Finding:
    """At contact 1e5 the arrival time depends on the error of the peak force through the speed, to a sixth of it."""
    options = {"contacts": [100_000], "waves": "primary"}
    result = _simulated(evolve(case, options=options), backend)
    tight = _simulated(evolve(case, options={**options, "rtol": 1e-11}), backend)
    arrival, reference = (each.passages[0].arrival_time for each in (result, tight))
    bound = min(result.passages[0].error_estimate, 1e-6)
    outcome = f"arrives after {arrival / UNITS.time:.9g} T0, known by the exact wave"
    expected = f"it arrives after {arrival:g} s, it should after {reference:g} s"
    return _judged(result, outcome, abs(arrival / reference - 1), bound, expected)


def integrated_passage(case: Case, backend: Backend) -> Finding:
    """With no extrapolation uncertainty allowed the search goes on to the longest chain that it may take."""
    contact = 15_000
    options = SimulateOptions(rtol=1e-8, backend=backend, waves="primary")
    result = _simulated(evolve(case, options={"rtol": 1e-8, "waves": "primary"}), backend)
    plan, (problem, scales) = plan_of(options), scaled(*made(case.scene))
    assert plan.search is not None
    request = evolve(plan.request(problem, contacts=(contact,)), doubt=1e-300)
    (integrated,) = find_primaries([request], plan.search, plan.compiled)
    if not integrated.passages:
        return Finding(f"the front was lost at contact {integrated.contact:g}", ("no passage was read",))
    reference = result.found.time + (contact - result.found.contact) / (SPEED * result.found.peak ** (1 / 6))
    arrival = integrated.passages[0].time
    faults = []
    if not integrated.momentum_defect <= _MOMENTUM:
        faults.append(f"the momentum balance is violated by {integrated.momentum_defect:.1e} at the end")
    outcome = f"arrives after {arrival * scales.time / UNITS.time:.9g} T0, {integrated.steps:g} steps"
    expected = f"it arrives after {arrival:.9g}, the exact wave after {reference:.9g}"
    finding = _judged(result, outcome, abs(arrival / reference - 1), 1e-8, expected, *faults)
    return evolve(finding, momentum_defect=integrated.momentum_defect)


def quickly(case: Case, backend: Backend) -> Finding:
    """Prediction and simulation within a second, the best of three records of which nothing was computed yet."""
    seconds = []
    for _ in range(3):
        scene = made(case.scene)
        begin = time.perf_counter()
        outcome = Predictor().predict(*scene)
        result = simulate(*scene, backend=backend, waves="primary")
        seconds.append(time.perf_counter() - begin)
    tight = simulate(*scene, backend=backend, waves="primary", rtol=1e-10)
    fastest = min(seconds)
    faults = [] if fastest < 1.0 else [f"prediction and simulation took {fastest:.2f} s"]
    note = f"predicted {outcome.amplification:.4g} F0, both in {fastest:.2g} s"
    return _compared(evolve(case, bound=1e-6), result, tight.amplification, note, *faults)


def no_more_steps(case: Case, backend: Backend) -> Finding:
    """A smooth pulse in ten times as many samples takes no more steps."""
    coarse, fine = (simulate(*made(scene), backend=backend, waves="primary") for scene in (case.other, case.scene))
    steps = fine.found.steps / coarse.found.steps
    faults = [] if steps < 1.5 else [f"it took {steps:.2g} times the steps"]
    return _compared(case, fine, coarse.amplification, f"{steps:.2g} times the steps", *faults)


def rebound(case: Case, backend: Backend) -> Finding:
    """Eight granules rebound; the velocities of the first four are known to seven digits."""
    result = _simulated(case, backend)
    shock = result.shock
    velocity = shock.profile.areas("tanh-sinh").total * shock.rise_time * FORCE / result.chain.granule_mass
    found = np.array(result.recoil_velocities[: len(_REBOUNDS)]) / velocity
    error = float(np.abs(found / _REBOUNDS - 1).max()) if len(found) == len(_REBOUNDS) else math.inf
    shown = ", ".join(f"{share:.6f}" for share in found)
    outcome = f"{result.ejected_granules} rebound, at {shown} of the velocity of a single one"
    return _judged(result, outcome, error, 2e-5, f"velocities over that of a single granule are {_REBOUNDS}")


def flying_apart(case: Case, backend: Backend) -> Finding:
    """The momentum of granules that left either end is the impulse: granules that met were not lost."""
    result = _simulated(case, backend)
    spalls = result.spall_velocities or ()
    carried = result.chain.granule_mass * sum(spalls) + result.recoil_momentum
    # left out are granules slower than a thousandth of the fastest; the last before them are hardly faster
    error = abs(carried / result.applied_momentum - 1)
    outcome = f"{len(spalls)} granules fly off the end, {_summary(result)}"
    expected = f"granules that fly apart carry {carried:g} N s of {result.applied_momentum:g} N s"
    return _judged(result, outcome, error, 1e-3, expected)


_GENERIC = (law, method, like, like_simulated, scaled_beads, number, refused)
_SINGLE = (blow_on_two, far_passage, integrated_passage, quickly, no_more_steps, rebound, flying_apart)
#: Each check by the name that a case gives.
CHECKS = {check.__name__: check for check in (*_GENERIC, *_SINGLE)}
