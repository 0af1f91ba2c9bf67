"""The setup of a simulation: method and tolerances that options ask for, and the problem in scaled units."""

from __future__ import annotations

from functools import lru_cache
from types import ModuleType

import numpy as np
from attrs import evolve, frozen

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.errors import InvalidValueError, NumericalError
from shockwave.options import SimulateOptions
from shockwave.profiles.shock import Shock
from shockwave.registry import load
from shockwave.simulation.backend import chosen
from shockwave.simulation.integrator import Integrator
from shockwave.simulation.nystroem import Nystroem
from shockwave.simulation.problem import ChainProblem, Request

_RTOL = 1e-6
_STEP = 0.02
# Below this tolerance the method of high order takes fewer evaluations.
_HIGH_ORDER = 1e-7
# Shares of the tolerance, and how much of it a loose one may be at most: waves must stand out from noise.
_DOUBT = 0.5
_MOST_DOUBT = 3e-5
_LOOSEST_STEP = 2e-4
# No looser search separates the waves of a long shock.
_LONG_RTOL = 1e-6
# Below these step control gains nothing: rounding is all that remains.
_TIGHTEST_STEP = 3e-15
_TIGHTEST_TRAIN_STEP = 1e-13
# A search that misses its tolerance is repeated with a tighter one, and more work.
_TIGHTER = 0.1
_PATIENCE = 10.0
# Tolerance of a step in the runs for the train, over the relative error asked of the primary: ours, and that of other
# methods, whose step errors add up to more.
_FINE = 0.1
_OTHERS = 3e-4
# Stands for the relative error of a method of fixed step, which takes none.
_FIXED_RTOL = 1e-5
# Digits of the scaled rise time.
_DIGITS = 13
# Contact forces to be computed for a shock that lasts one characteristic time, at least: they grow with the square of
# the duration. The most there may be is a minute or two of the compiled code.
_COST = 20.0
_MOST_COST = 2e9
# The longest shock, in characteristic times of its wave, whose train is integrated. Near its peak, above so many
# tenths of it, a force makes waves that are nearly alike: such a time counts this much more. And seconds for each.
_LONGEST_TRAIN = 300.0
_NEAR_PEAK = 0.9
_ALIKE = 4.0
_TRAIN_SECONDS = 0.05


@frozen
class Setup:
    """Options with all defaults filled in, and the method.

    ``search`` is the method if the search for the primary can use it, ``compiled`` the module that steps it, or None.
    """

    options: SimulateOptions
    method: type[Integrator]
    search: type[Nystroem] | None
    compiled: ModuleType | None

    @property
    def rtol(self) -> float:
        """Relative error asked for, or what stands for it."""
        return self.options.rtol or _FIXED_RTOL

    def request(
        self, problem: ChainProblem, decades: int = 0, contacts: tuple[int, ...] = (), patient: bool = False
    ) -> Request:
        """The request to the search for the primary, tighter by so many ``decades``."""
        rtol = min(self.rtol, _LONG_RTOL) if problem.is_long else self.rtol
        tighter = _TIGHTER**decades
        if problem.rises_again:
            # Such a primary is judged late, when it changes by no more than step errors make of it.
            tighter *= _TIGHTER
        caution: float = getattr(self.method, "caution", 1.0)
        return Request(
            problem,
            tolerance=max(min(caution * rtol, _LOOSEST_STEP) * tighter, _TIGHTEST_STEP),
            doubt=max(min(_DOUBT * rtol, _MOST_DOUBT) * max(tighter, 0.3), 2e-14),
            contacts=contacts,
            patience=_PATIENCE if patient else 1.0,
        )

    def integrator(self, factor: float = 1.0) -> Integrator:
        """The method for a run of the whole chain, its tolerance ``factor`` times as loose."""
        if not self.method.adaptive:
            size = self.options.step or 0.0
            # a step twice as long shows more than ten times would: the method may not be stable there
            return self.method(size=size if factor == 1.0 else 2 * size)
        share = _OTHERS if self.search is None else _FINE
        tolerance = max(share * self.rtol, _TIGHTEST_TRAIN_STEP) * factor
        if self.search is None:
            return self.method(tolerance=tolerance)
        return self.search(tolerance=tolerance, compiled=self.compiled)


@lru_cache(maxsize=64)
def setup_of(options: SimulateOptions) -> Setup:
    """Fill in the defaults of ``options``.

    Raises
    ------
    InvalidValueError
        When the backend is not there.
    """
    name = options.integrator
    if name is None:
        tight = options.rtol is not None and options.rtol < _HIGH_ORDER
        name = "rkn1210" if tight else "rkn86"
    method: type[Integrator] = load("integrators", name)
    search = method if issubclass(method, Nystroem) else None
    compiled = chosen(options.backend) if search else None
    filled = evolve(
        options,
        integrator=name,
        rtol=(options.rtol or _RTOL) if method.adaptive else None,
        step=None if method.adaptive else (options.step or _STEP),
        backend="numpy" if compiled is None else "compiled",
    )
    return Setup(filled, method, search, compiled)


def scaled(shock: Shock, chain: Chain) -> tuple[ChainProblem, Scales]:
    """The problem in units of the wave to come: of F0, or of what a short shock makes of it if that is less.

    Raises
    ------
    InvalidValueError
        When shock or chain are none.
    NumericalError
        When the shock is too long.
    """
    if not (isinstance(shock, Shock) and isinstance(chain, Chain)):
        got = f"got {type(shock).__name__} and {type(chain).__name__}"
        raise InvalidValueError.of("shock", f"must be a Shock, and the chain a Chain ({got})")
    own = Scales.of(chain, shock.peak_force)
    # One number governs everything. Its last digits are the rounding of units: cut off, so that the same scene
    # in other units, or scaled to another chain, is the same problem to the last bit.
    ratio = float(f"{own.rise_time(shock.rise_time):.{_DIGITS}g}")
    strength = ratio * shock.profile.areas().total / MOMENTUM
    force = min(1.0, strength**1.2)
    scales = own if force == 1.0 else Scales.of(chain, shock.peak_force * force)
    problem = ChainProblem(shock.profile, ratio * force ** (1 / 6), 1 / force, chain.granules)
    cost = _COST * problem.duration**2
    if cost > _MOST_COST:
        raise NumericalError(
            f"the shock lasts {problem.duration:.3g} characteristic times of its wave, which takes {cost:.1g} contact"
            f" forces, {_MOST_COST:g} are the most: so slow a force is a matter of statics (shorten it, or soften the"
            " granules)"
        )
    return problem, scales


def immeasurable(problem: ChainProblem) -> str:
    """Why the train of a shock is not integrated unless a time limit is set; empty where it is."""
    near_peak = float(np.mean(problem.course > _NEAR_PEAK)) * problem.duration
    length = problem.duration + _ALIKE * near_peak
    if length <= _LONGEST_TRAIN:
        return ""
    return (
        f"the shock lasts {problem.duration:.3g} characteristic times of its wave, {near_peak:.2g} of them near its peak;"
        f" its train would take about {_TRAIN_SECONDS * length:.0f} s or more, and most waves would not separate"
    )
