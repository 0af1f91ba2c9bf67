"""Catalogue of extreme cases, read from ``extreme_cases.toml``, and the checks of their results.

A result is compared with a law, another scene, another method, a number, or the error that must be raised.
"""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Iterable
from importlib import resources
from typing import Any

import numpy as np
from attrs import Factory, evolve, field, frozen

from shockwave.base.errors import ShockwaveError, UnknownNameError
from shockwave.benchmark.benchmark_scenes import FORCE, UNITS, make_scene
from shockwave.engine.backend import Backend
from shockwave.prediction.predictor import Predictor
from shockwave.scene.solitary_wave import IMPULSE_LIMIT, MOMENTUM
from shockwave.simulation.simulate import simulate
from shockwave.simulation.simulation_result import Simulation

# Largest permitted momentum defect: a hundred times the observed rounding error.
_MOMENTUM = 1e-12
# Velocities of rebounding granules in units of the velocity of a single granule after the same shock.
_REBOUNDS = (-0.0710850, -0.0302738, -0.0158334, -0.0088857)


@frozen(kw_only=True)
class Case:
    """One extreme case.

    Attributes
    ----------
    name, theme : str
        Name of the case and its part of the catalogue.
    description, must : str
        Description of the case, and the required result.
    check : str
        Name of the function of this module that checks the result.
    scene, other : dict
        A function of `shockwave.benchmark.benchmark_scenes` with its arguments; ``other`` is a scene to compare with.
    options : dict
        Arguments of the simulation.
    reference, bound : float
        Amplification to compare with, and the largest permitted relative difference from the reference. The default is
        twice the default tolerance, once for the run and once for its reference.
    error, message : str
        Class of the error that must be raised, and a part of its message.
    limit : float
        Time limit [s]; cases with more than the default take seconds.
    """

    name: str
    theme: str
    description: str
    check: str
    scene: dict[str, Any]
    other: dict[str, Any] = Factory(dict)
    options: dict[str, Any] = Factory(dict)
    reference: float = 0.0
    bound: float = 2e-6
    error: str = "InvalidValueError"
    message: str = ""
    must: str = field()
    limit: float = 60.0

    @must.default
    def _refusal(self) -> str:
        return f"{self.error} with {self.message!r}"

    @property
    def each_backend(self) -> bool:
        """Whether the case depends on the backend: not if it integrates nothing, or uses NumPy only."""
        return self.check != raised_error.__name__ and "backend" not in self.options


def _read() -> tuple[Case, ...]:
    document = tomllib.loads(resources.files(__package__).joinpath("extreme_cases.toml").read_text("utf-8"))
    cases = []
    for theme, entries in document["themes"].items():
        for entry in entries:
            common = document["common"].get(entry["check"], {})
            cases.append(Case(theme=theme, **{**common, **entry}))
    return tuple(cases)


#: All cases by theme.
CASES = _read()


def find_cases(names: Iterable[str]) -> tuple[Case, ...]:
    """The cases with these names or themes in the order of the catalogue; all cases if there are no names.

    Raises
    ------
    UnknownNameError
        If a name is neither a case nor a theme.
    """
    requested = set(names)
    known = [*dict.fromkeys(case.theme for case in CASES), *(case.name for case in CASES)]
    for name in requested.difference(known):
        raise UnknownNameError.of("case", name, known, "the page on extreme cases lists all")
    return tuple(case for case in CASES if not requested or {case.name, case.theme} & requested)


# ---------------------------------------------------------------- findings


def _finite(value: float | None) -> float | None:
    return value if value is None or math.isfinite(value) else None


@frozen
class Finding:
    """Outcome of a case.

    Attributes
    ----------
    outcome : str
        The computed values, or the error and its message.
    faults : tuple of str
        Violated requirements; empty if the case passes.
    error, bound : float or None
        Relative error against the reference of the case, and its bound; None if an error must be raised.
    momentum_defect : float or None
        Relative difference between the momentum of the chain and the impulse; None if nothing was integrated.
    """

    outcome: str
    faults: tuple[str, ...] = ()
    error: float | None = field(default=None, converter=_finite)
    bound: float | None = None
    momentum_defect: float | None = field(default=None, converter=_finite)


def _general_faults(result: Simulation) -> list[str]:
    """Faults of any result: values that are not finite, lost momentum, missed tolerance."""
    faults = [warning for warning in result.warnings if "tolerance was not met" in warning]
    try:
        json.dumps(result.to_dict(), allow_nan=False)
    except ValueError:
        faults.append("a value of the result is not finite")
    if not result.momentum_defect <= _MOMENTUM:
        faults.append(f"the momentum balance is violated by {result.momentum_defect:.1e}")
    return faults


def _judge(
    case: Case, result: Simulation, outcome: str, value: float, reference: float, more: Iterable[str] = ()
) -> Finding:
    """The finding on a result with a value that must equal the reference; ``more`` are other faults."""
    error = abs(value / reference - 1)
    faults = _general_faults(result)
    if not error <= case.bound:
        faults.append(f"the error is {error:.1e}: {value:.10g} should be {reference:.10g}")
    return Finding(outcome, (*faults, *more), error, case.bound, result.momentum_defect)


def _compare(case: Case, result: Simulation, reference: float, note: str = "", more: Iterable[str] = ()) -> Finding:
    """The finding on a result with an amplification that must equal the reference."""
    return _judge(case, result, _summary(result) + note, result.amplification, reference, more)


def _summary(result: Simulation) -> str:
    return f"{result.amplification:.8g} F0 by {result.integrator}, {result.cost.force_evaluations} evaluations"


def _simulate(case: Case, backend: Backend, **options: Any) -> Simulation:
    return simulate(*make_scene(case.scene), **{"backend": backend, **case.options, **options})


def _predict(scene: dict[str, Any]) -> float:
    """The predicted amplification; raises `ValueError` if the prediction is not finite."""
    outcome: Any = Predictor(model="section-4").predict(*make_scene(scene))
    json.dumps(outcome.to_dict(), allow_nan=False)
    return float(outcome.amplification)


def impulse_limit(case: Case, backend: Backend) -> Finding:
    """Impulse limit, F = 1.1681817 F0 S^(6/5), with S the impulse over that of a solitary wave of F0."""
    result = _simulate(case, backend)
    impulse = result.shock.profile.areas("tanh-sinh").total * result.shock.rise_time / UNITS.time
    reference = IMPULSE_LIMIT * (impulse / MOMENTUM) ** 1.2
    return _compare(case, result, reference, f"; predicted {_predict(case.scene):.4g} F0")


def dop853(case: Case, backend: Backend) -> Finding:
    """DOP853 from SciPy on the whole chain, with waves that are measured by other code."""
    result, other = _simulate(case, backend), simulate(*make_scene(case.scene), integrator="dop853", waves="primary")
    faults = [f"{fault} (dop853)" for fault in _general_faults(other)]
    return _compare(case, result, other.amplification, f"; predicted {_predict(case.scene):.4g} F0", faults)


def equal_scene(case: Case, backend: Backend) -> Finding:
    """Another scene with the same simulated and predicted amplification."""
    first, second = _predict(case.scene), _predict(case.other)
    fault = f"the predictions are {first:.10g} F0, and {second:.10g} F0 for the other case"
    faults = [] if abs(first / second - 1) <= case.bound else [fault]
    return equal_simulation(case, backend, f"; predicted {first:.4g} F0", faults)


def equal_simulation(case: Case, backend: Backend, note: str = "", more: Iterable[str] = ()) -> Finding:
    """Another scene with the same simulated amplification."""
    other = _simulate(evolve(case, scene=case.other), backend)
    return _compare(case, _simulate(case, backend), other.amplification, note, more)


def reference_value(case: Case, backend: Backend) -> Finding:
    """Amplification that was computed at tighter tolerances."""
    result = _simulate(case, backend)
    return _compare(case, result, case.reference, f"; estimated error {result.error_estimate:.0e}")


def raised_error(case: Case, backend: Backend) -> Finding:
    """Error of the required class and message, raised by the simulation or by a requested passage."""
    try:
        result = _simulate(case, backend, waves="primary")
        for contact in case.options.get("contacts", ()):
            result.passage(contact)
    except ShockwaveError as error:
        name = type(error).__name__
        matches = name == case.error and case.message in str(error)
        return Finding(f"{name}: {error}", () if matches else (f"it should be {case.must}",))
    return Finding(_summary(result), (f"it should be {case.must}",))


def late_meeting(case: Case, backend: Backend) -> Finding:
    """A collision of two granules swaps their velocities: half the square of their difference goes into the contact."""
    result = _simulate(case, backend)
    fast, slow = (velocity / UNITS.velocity for velocity in result.spall_velocities or (0.0, 0.0))
    met = result.waves[-1]
    outcome = f"meet after {met.arrival_time / UNITS.time:.4g} T0, {_summary(result)}"
    return _judge(case, result, outcome, met.peak_force / FORCE, (5 / 8 * (fast - slow) ** 2) ** 0.6)


def far_passage(case: Case, backend: Backend) -> Finding:
    """Arrival time at contact 1e5, whose relative error is a sixth of that of the peak force."""
    passage = _simulate(case, backend).passages[0]
    result = _simulate(case, backend, rtol=1e-11)
    outcome = f"arrives after {passage.arrival_time / UNITS.time:.9g} T0"
    bounded = evolve(case, bound=min(passage.error_estimate, 1e-6))
    return _judge(bounded, result, outcome, passage.arrival_time, result.passages[0].arrival_time)


def rebound(case: Case, backend: Backend) -> Finding:
    """Rebound of eight granules; the velocities of the first four are known to seven digits."""
    result = _simulate(case, backend)
    impulse = result.shock.profile.areas("tanh-sinh").total * result.shock.rise_time * FORCE
    found = np.array(result.recoil_velocities[: len(_REBOUNDS)]) * result.chain.granule_mass / impulse
    shown = ", ".join(f"{share:.6f}" for share in found)
    outcome = f"{result.ejected_granules} granules rebound, velocities {shown} times that of a single granule"
    worst = max(found / _REBOUNDS, key=lambda share: abs(share - 1))
    return _judge(case, result, outcome, worst, 1.0)


def separation(case: Case, backend: Backend) -> Finding:
    """The granules that leave both ends carry the entire impulse."""
    result = _simulate(case, backend)
    spalls = result.spall_velocities or ()
    carried = result.chain.granule_mass * sum(spalls) + result.recoil_momentum
    # granules slower than a thousandth of the fastest are not listed
    outcome = f"{len(spalls)} granules leave the free end, {_summary(result)}"
    return _judge(case, result, outcome, carried, result.applied_momentum)


def tight_tolerance(case: Case, backend: Backend) -> Finding:
    """The same chain at rtol 1e-9, by the compiled code if it was built: the greatest force at every contact."""
    result: Any = _simulate(case, backend)
    exact: Any = simulate(*make_scene(case.scene), **{**case.options, "backend": "auto", "rtol": 1e-9})
    # contacts that the wave reaches at the end only have forces of no accuracy
    least = case.bound * exact.greatest_force.peak_force
    pairs = [pair for pair in zip(result.contacts, exact.contacts, strict=True) if pair[1].peak_force > least]
    found, reference = max(pairs, key=lambda pair: abs(pair[0].peak_force / pair[1].peak_force - 1))
    greatest = result.greatest_force
    outcome = f"{greatest.peak_force / FORCE:.8g} F0 at contact {greatest.contact} by {result.integrator}"
    return _judge(case, result, outcome, found.peak_force, reference.peak_force)


_GENERIC = (impulse_limit, dop853, equal_scene, equal_simulation, reference_value, raised_error, tight_tolerance)
_SINGLE = (late_meeting, far_passage, rebound, separation)
#: Checks by name.
CHECKS = {check.__name__: check for check in (*_GENERIC, *_SINGLE)} | {"scaled_beads": equal_scene}
