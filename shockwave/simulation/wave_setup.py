"""Setup of a simulation: method and tolerances from the options, and the problem in scaled units."""

from __future__ import annotations

from functools import lru_cache
from types import ModuleType

import numpy as np
from attrs import evolve, frozen

from shockwave.base.errors import NumericalError
from shockwave.engine.backend import compiled_code
from shockwave.engine.integrator import Integrator
from shockwave.engine.nystroem_integrators import Nystroem
from shockwave.engine.scaled_problem import ScaledProblem
from shockwave.engine.search_request import SearchRequest
from shockwave.registry.registry import find, load
from shockwave.scene.chain import HERTZ, Scales
from shockwave.scene.scene import Scene
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.scene.solitary_wave import wave_law

#: Default relative error of an adaptive method.
RTOL = 1e-6
#: Largest error of a result with a fixed step that is not warned of.
UNSETTLED = 0.1
#: Default step of a fixed-step method, in characteristic times of the wave.
STEP = 0.02
# Tolerance below which the method of high order needs fewer evaluations.
_HIGH_ORDER = 1e-7
# Fraction of the tolerance that is allowed for the deviation of the peak force from its limit.
_DOUBT = 0.5
# Largest deviation that is allowed, however loose the tolerance: waves must be distinguishable from noise.
_MOST_DOUBT = 3e-5
# Largest error tolerance of a step in the search, for the same reason.
_LOOSEST_STEP = 2e-4
# Largest tolerance with which the search separates the waves of a long shock.
_LONG_RTOL = 1e-6
# Least error tolerance of a step in the search; below it, rounding errors dominate.
_TIGHTEST_STEP = 3e-15
# Least error tolerance of a step in the runs for the train, for the same reason.
_TIGHTEST_TRAIN_STEP = 1e-13
# Factor of the tolerance when a search is repeated because it did not meet its tolerance.
_TIGHTER = 0.1
# Factor of the allowed work when a search is repeated.
_PATIENCE = 10.0
# Error tolerance of a step in the runs for the train, over the requested relative error, for the built-in methods.
_FINE = 0.1
# The same for other methods, whose step errors accumulate more.
_OTHERS = 3e-4
# Least and largest substitute for the relative error of a fixed-step method, and its ratio to the step to the power of
# the order. A wave whose changes are smaller counts as settled: with large steps they never end.
_FIXED_RTOL = 1e-5
_MOST_FIXED_RTOL = 1e-2
_STEP_ERROR = 10.0
# Significant digits of the scaled rise time.
_DIGITS = 13
# Number of contact forces to be computed for a shock, over the square of its duration in characteristic times of its
# wave; and the largest permitted number: a minute or two of the compiled code.
_COST = 20.0
_MAX_COST = 2e9
# Longest shock, in characteristic times of its wave, whose train is integrated.
_LONGEST_TRAIN = 600.0
# A time in which the force exceeds this fraction of its peak counts more by this factor: its waves are nearly equal.
_NEAR_PEAK = 0.9
_NEAR_PEAK_FACTOR = 4.0
# Computing time of a train for each of these characteristic times [s].
_TRAIN_SECONDS = 0.01
# Longest chain, in granules, that waves are followed through to its free end.
_TO_THE_END = 2000
# Steps in it for each granule, after a shock of several waves, and for each characteristic time of the shock.
_STEPS = 40
_DRIVEN_STEPS = 10
# Longest shock of a single wave, after which the granules soon separate, in characteristic times.
_SINGLE = 4.0
# Computing time of a step, the same for each granule, and the longest of a run without a time limit [s].
_STEP_SECONDS = 2e-4
_GRANULE_SECONDS = 2.5e-7
_MOST_SECONDS = 25.0


@frozen
class Setup:
    """Options with all defaults filled in, and the integrator.

    ``search`` is the integrator if the search for the leading wave can use its coefficients, otherwise None.
    ``compiled`` is the compiled module, or None for NumPy. ``given`` are the options without the defaults.
    """

    options: SimulateOptions
    method: type[Integrator]
    search: type[Nystroem] | None
    compiled: ModuleType | None
    given: SimulateOptions

    @property
    def rtol(self) -> float:
        """Requested relative error, or a substitute for a fixed-step method."""
        if self.method.adaptive:
            return self.options.rtol or RTOL
        error = _STEP_ERROR * (self.options.step or STEP) ** self.method.order
        return min(max(error, _FIXED_RTOL), _MOST_FIXED_RTOL)

    def rtol_of(self, problem: ScaledProblem) -> float:
        """Relative error for the search of a problem; that of a long shock is small enough to separate its waves."""
        return min(self.rtol, _LONG_RTOL) if problem.is_long else self.rtol

    def request(
        self, problem: ScaledProblem, decades: int = 0, contacts: tuple[int, ...] = (), patient: bool = False
    ) -> SearchRequest:
        """Make the request to the search for the leading wave, with a tolerance smaller by this number of decades."""
        return SearchRequest(problem, *self.accuracy(problem, decades), contacts, _PATIENCE if patient else 1.0)

    def accuracy(self, problem: ScaledProblem, decades: int = 0) -> tuple[float, float]:
        """Step tolerance, smaller by this number of decades, and permitted uncertainty of the limit for a search."""
        if problem.rises_again:
            # Such a leading wave is examined late, when its changes are as small as the step errors.
            decades += 1
        caution: float = getattr(self.method, "caution", 1.0)
        return _accuracy(self.rtol_of(problem), caution, problem.exponent, decades)

    def integrator(self, factor: float = 1.0) -> Integrator:
        """Make the integrator for a run of the whole chain, with ``factor`` times the tolerance."""
        if not self.method.adaptive:
            size = self.options.step or 0.0
            # only twice the step, because the method may be unstable with ten times the step
            size *= min(factor, 2.0)
            if issubclass(self.method, Nystroem):
                return self.method(size=size, compiled=self.compiled)
            return self.method(size=size)
        share = _OTHERS if self.search is None else _FINE
        tolerance = max(share * self.rtol, _TIGHTEST_TRAIN_STEP) * factor
        if self.search is None:
            return self.method(tolerance=tolerance)
        return self.search(tolerance=tolerance, compiled=self.compiled)


@lru_cache(maxsize=256)
def _accuracy(rtol: float, caution: float, exponent: float, decades: int) -> tuple[float, float]:
    """Error tolerance of a step and permitted uncertainty of the peak force, smaller by this number of decades."""
    tighter = _TIGHTER**decades
    # the harder a contact, the more an error of its overlap changes its force
    caution *= min(HERTZ / exponent, 1.0) ** 2
    tolerance = max(min(caution * rtol, _LOOSEST_STEP) * tighter, _TIGHTEST_STEP)
    return tolerance, max(min(_DOUBT * rtol, _MOST_DOUBT) * max(tighter, 0.3), 2e-14)


@lru_cache(maxsize=64)
def setup_of(options: SimulateOptions) -> Setup:
    """Fill in the defaults of ``options``.

    Raises
    ------
    InvalidValueError
        If the backend is not available.
    """
    name = options.integrator
    if name is None:
        tight = options.rtol is not None and options.rtol < _HIGH_ORDER
        name = "rkn1210" if tight else "rkn86"
    method: type[Integrator] = load("integrators", name)
    # a plugin may have changed the steps of the built-in method from which it is derived
    has_tableau = issubclass(method, Nystroem) and "backend" in find("integrators", name).takes
    search = method if issubclass(method, Nystroem) and has_tableau and method.adaptive else None
    compiled = compiled_code(options.backend) if has_tableau else None
    filled = evolve(
        options,
        integrator=name,
        rtol=(options.rtol or RTOL) if method.adaptive else None,
        step=None if method.adaptive else (options.step or STEP),
        backend="numpy" if compiled is None else "compiled",
    )
    return Setup(filled, method, search, compiled, options)


def warn_step(options: SimulateOptions) -> str:
    """Warning of a fixed step whose error is large."""
    step = f"The step of {options.step:g} is too large for {options.integrator}: the result is not accurate"
    return f"{step}. A smaller step reduces the error."


def scale_scene(scene: Scene) -> tuple[ScaledProblem, Scales]:
    """Scale the problem of a shock on equal granules by F0, or by the smaller peak force of its wave.

    Raises
    ------
    NumericalError
        If the shock is too long.
    """
    shock, chain = scene.shock, scene.uniform
    assert shock is not None
    assert chain is not None
    shock_scales = Scales.of(chain, shock.peak_force)
    # The scaled rise time determines the result. Its last digits depend on the units in use; they are rounded off, so
    # that the same scene in other units, or scaled to another chain, is the same problem to the last bit.
    ratio = float(f"{shock_scales.rise_time(shock.rise_time):.{_DIGITS}g}")
    exponent, wave = chain.exponent, wave_law(chain.exponent)
    strength = ratio * shock.profile.total_area / wave.momentum
    force = min(1.0, strength ** (2 * exponent / (exponent + 1)))
    scales = shock_scales if force == 1.0 else Scales.of(chain, shock.peak_force * force)
    problem = ScaledProblem(shock.profile, ratio * force**wave.of_speed, 1 / force, chain.count, exponent)
    cost = _COST * problem.duration**2
    if _MAX_COST / _NEAR_PEAK_FACTOR < cost <= _MAX_COST:
        cost *= 1 + (_NEAR_PEAK_FACTOR - 1) * float(np.mean(problem.course > _NEAR_PEAK))
    if cost > _MAX_COST:
        raise NumericalError(
            f"the shock lasts {problem.duration:.3g} characteristic times of its wave, which requires {cost:.1g}"
            f" contact forces, and the maximum is {_MAX_COST:g}: the response to such a slow force is quasi-static"
            " (shorten the shock, or use softer granules)"
        )
    return problem, scales


def immeasurable(problem: ScaledProblem) -> str:
    """Reason not to integrate the whole chain without a time limit; empty if there is none."""
    granules = problem.granules
    if granules is None and problem.duration * (1 + _NEAR_PEAK_FACTOR) <= _LONGEST_TRAIN:  # even if all of it is near
        return ""
    near_peak = float(np.mean(problem.course > _NEAR_PEAK)) * problem.duration
    length = problem.duration + _NEAR_PEAK_FACTOR * near_peak
    seconds, most = _TRAIN_SECONDS * length, _TRAIN_SECONDS * _LONGEST_TRAIN
    if granules is not None and granules <= _TO_THE_END:
        steps = granules * _STEPS + problem.duration * _DRIVEN_STEPS if problem.duration > _SINGLE else 0
        seconds, most = steps * (_STEP_SECONDS + _GRANULE_SECONDS * granules), _MOST_SECONDS
    if seconds <= most:
        return ""
    return (
        f"the shock lasts {problem.duration:.3g} characteristic times of its wave, {near_peak:.2g} of them near its"
        f" peak: the integration would take about {seconds:.0f} s or more (set a timeout to integrate all the same)"
    )
