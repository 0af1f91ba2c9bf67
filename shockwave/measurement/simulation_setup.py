"""The setup of a simulation: method and tolerances that options ask for, and the problem in scaled units."""

from __future__ import annotations

from functools import lru_cache
from types import ModuleType

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
# The longest shock, in characteristic times of its wave: the work grows with the square.
_LONGEST = 2e4
#: The train of longer ones is not integrated: it would take hours.
MEASURABLE = 300.0


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

    def request(self, problem: ChainProblem, repeats: int = 0, contacts: tuple[int, ...] = ()) -> Request:
        """The request to the search for the primary; tighter if it is repeated."""
        rtol = min(self.rtol, _LONG_RTOL) if problem.is_long else self.rtol
        tighter = _TIGHTER**repeats
        if problem.rises_again:
            # Such a primary is judged late, when it changes by no more than step errors make of it.
            tighter *= _TIGHTER
        caution: float = getattr(self.method, "caution", 1.0)
        return Request(
            problem,
            tolerance=max(min(caution * rtol, _LOOSEST_STEP) * tighter, _TIGHTEST_STEP),
            doubt=max(min(_DOUBT * rtol, _MOST_DOUBT) * max(tighter, 0.3), 2e-14),
            contacts=contacts,
            patience=_PATIENCE if repeats else 1.0,
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
    if problem.duration > _LONGEST:
        raise NumericalError(
            f"the shock lasts {problem.duration:.3g} characteristic times of its wave, {_LONGEST:g} is the most:"
            " so slow a force is a matter of statics (shorten it, or soften the granules)"
        )
    return problem, scales
