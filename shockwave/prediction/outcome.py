"""Results of predictions: a frozen class per regime for one shock, arrays for many shocks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

import numpy as np
import numpy.typing as npt
from attrs import asdict, field, frozen

from shockwave.chain.chain import Chain
from shockwave.chain.solitary_wave import SolitaryWave
from shockwave.chain.yielding import Yielding, yielding_of
from shockwave.limit import LAST, WALL, WAVE, LeavingForce, Limit, Verdict, plain_verdict, verdict
from shockwave.prediction.model_interface import Inequality, Regime, Relation
from shockwave.profiles.base import Areas
from shockwave.profiles.conditions import Condition
from shockwave.quadrature import FloatArray
from shockwave.result_base import VERSION, Result
from shockwave.scene_summary import ChainScene, Scene
from shockwave.text import facts, limits, printed, strong

if TYPE_CHECKING:  # a result that is only printed does not need them
    from shockwave.chain.impact import Impact
    from shockwave.tables import Table


@frozen
class Exponents:
    """Local scaling exponents of the peak force of the leading wave: d ln F / d ln of each property of the granules.

    For example, with ``radius`` -1.6 the peak force scales as R^-1.6 for a given shock.
    """

    radius: float
    density: float
    youngs_modulus: float

    @classmethod
    def of(cls, sensitivity: float, chain: Chain) -> Exponents:
        """Make the exponents from d ln F / d ln A; A scales as R^(4/3) rho^(1/2) E^(-1/3), eq. (4c).

        If the contact stiffness is given, A scales as the square root of the mass, R^(3/2) rho^(1/2).
        """
        if chain.contact is not None:
            return cls(1.5 * sensitivity, sensitivity / 2, 0.0)
        return cls(4 / 3 * sensitivity, sensitivity / 2, -sensitivity / 3)


@frozen
class Estimate:
    """Best a-priori estimate of the peak force of the leading wave.

    Attributes
    ----------
    peak_force, low, high : float
        Estimate and the ends of its range [N], in which the peak force lies for at least 98 % of shocks of any kind.
    method : str
        Method of the estimate.
    """

    peak_force: float
    low: float
    high: float
    method: str


@frozen
class WallForce:
    """A-priori estimate of the greatest force on a wall.

    Attributes
    ----------
    peak_force, low, high : float
        Estimate and the ends of its range [N], in which the force lies for at least 98 % of shocks of any kind.
    """

    peak_force: float
    low: float
    high: float


def first_yield(chain: Chain, peak_force: float, striker: tuple[Impact, float] | None = None) -> Yielding | None:
    """First yield of the contacts for a leading wave of this peak force [N]; see `yielding_of`."""
    on_wall = 0.0
    if chain.end is not None:
        from shockwave.prediction.chain_laws import wall_factor  # not needed without a wall

        on_wall = float(wall_factor(chain.end.stiffness_ratio(chain.material))) * peak_force
    return yielding_of(chain, peak_force, on_wall, striker)


# Stiffness of the contact with a wall, over that of the others, below which waves of a train add up on the wall.
_SOFT = 0.15
_Estimate = TypeVar("_Estimate")
_Error = TypeVar("_Error")


@frozen
class Accuracy(Generic[_Estimate, _Error]):
    """Accuracy of one prediction or of many; see `Outcome` and `Predictions`."""

    estimate: _Estimate
    no_estimate: str | None
    expected_error: _Error
    warnings: tuple[str, ...]


class _OnDemand(Generic[_Estimate, _Error]):
    """Attributes that are computed when one of them is first accessed."""

    on_demand: Callable[[], Accuracy[_Estimate, _Error]]

    @cached_property
    def accuracy(self) -> Accuracy[_Estimate, _Error]:
        return self.on_demand()

    @property
    def estimate(self) -> _Estimate:
        return self.accuracy.estimate

    @property
    def no_estimate(self) -> str | None:
        return self.accuracy.no_estimate

    @property
    def expected_error(self) -> _Error:
        return self.accuracy.expected_error

    @property
    def warnings(self) -> tuple[str, ...]:
        return self.accuracy.warnings


def _plain(_: object, __: object, value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


@frozen(kw_only=True, slots=False, repr=False)
class Outcome(Result, _OnDemand[Estimate | None, tuple[float, float] | None]):
    """A prediction; its class corresponds to its regime.

    The estimate, the expected error and the warnings are computed when one of them is first accessed, and then kept.

    Attributes
    ----------
    scenario, model : str or None, str
        Name of the scenario, if there is one; name of the model.
    method, reason : str
        Method that gave the peak force: the model itself, or the method that it selected, with the reason.
    relation : str or None
        ``less``, ``equal`` or ``greater``: peak force of the leading wave relative to that of the shock, (5d) or (5e);
        None for a striker.
    peak_force : float
        Peak force of the leading wave [N].
    amplification : float or None
        Peak force of the leading wave over that of the shock; None for a striker.
    waves : tuple of SolitaryWave
        Waves, leading wave first.
    applied_momentum : float
        Impulse of the shock [N s].
    conditions : tuple of Condition
        Conditions (3).
    estimate, no_estimate : prediction.outcome.Estimate or None, str or None
        Best a-priori estimate of the peak force; the reason why there is none.
    expected_error : tuple of float or None
        Range of the relative error of ``peak_force``, lowest and highest, observed in simulations of similar shocks;
        None if no errors were measured or they have no useful bound.
    warnings : tuple of str
        Sentences on the limits of the prediction.
    trace : tuple of Inequality
        Inequalities that decided; both sides in seconds.
    exponents : prediction.outcome.Exponents or None
        Scaling with radius, density and stiffness; None where the relation has no derivative.
    areas : Areas or None
        Areas a1 and a2 with their errors, eq. (3); None for a striker.
    momentum_coefficient : float
        Leading number of A, eq. (4c).
    scene : Scene or ChainScene
        Summary of excitation and chain.
    wall : float or None
        Stiffness of the contact with the wall over that of the other contacts; None without a wall.
    limit : Limit or None
        Limit of the force that leaves the chain.
    first_yield : callable
        Function that computes the first yield of the contacts for the peak force of the leading wave [N].
    on_demand : callable
        Function that computes the accuracy when it is accessed.
    """

    @property
    def regime(self) -> Regime:
        """``ejection``, ``single`` or ``train``."""
        raise NotImplementedError

    scenario: str | None = None
    model: str
    method: str
    reason: str = ""
    relation: Relation | Any
    peak_force: float
    amplification: float | Any
    waves: tuple[SolitaryWave, ...]
    applied_momentum: float
    conditions: tuple[Condition, ...]
    trace: tuple[Inequality, ...]
    exponents: Exponents | None
    areas: Areas | None
    momentum_coefficient: float
    scene: Scene | ChainScene
    wall: float | None = None
    limit: Limit | None = None
    first_yield: Callable[..., Yielding | None] = field(eq=False, repr=False)
    on_demand: Callable[[], Accuracy[Estimate | None, tuple[float, float] | None]] = field(eq=False, repr=False)

    @property
    def transmitted(self) -> WallForce | None:
        """Greatest force on the wall, from the estimate; None without a wall or an estimate.

        The last granules stay at a soft wall so long that later waves add to the force. Its upper end is then that of
        one wave with the energy of all: the force on a soft wall scales as the energy to the power 3/5. Where only the
        leading wave is predicted, this energy is bounded by the momentum of the shock.
        """
        found = self.estimate
        if self.wall is None or found is None:
            return None
        from shockwave.prediction.chain_laws import wall_factor  # not needed without a wall

        factor = float(wall_factor(self.wall))
        leading, energy = self.waves[0], sum(wave.energy for wave in self.waves)
        if len(self.waves) == 1:
            energy *= max(self.applied_momentum / leading.momentum, 1.0)
        several = (energy / leading.energy) ** 0.6 if self.wall < _SOFT else 1.0
        return WallForce(factor * found.peak_force, factor * found.low, several * factor * found.high)

    @property
    def verdict(self) -> Verdict | None:
        """Verdict on the limit, from the estimate; None without a limit."""
        found: Estimate | WallForce | None = self.estimate
        name = WAVE
        if self.wall is not None:
            found, name = self.transmitted, WALL
        elif self.scene.granules is not None:
            found, name = None, LAST
        ends = {} if found is None else {"value": found.peak_force, "low": found.low, "high": found.high}
        known = LeavingForce(name=name, **ends, remedy="simulate")
        return None if self.limit is None else verdict(self.limit, known)

    @property
    def yielding(self) -> Yielding | None:
        """First yield for the estimate or, without one, the shock or a stronger wave; None without a yield strength."""
        applied = self.peak_force / (self.amplification or np.inf)  # a striker applies no force
        strongest = max(applied, *(wave.peak_force for wave in self.waves))
        return self.first_yield(strongest if self.estimate is None else self.estimate.peak_force)

    @property
    def warnings(self) -> tuple[str, ...]:
        return (*self.accuracy.warnings, *(self.yielding.warnings if self.yielding else ()))

    @property
    def shown_error(self) -> float:
        """Relative error that limits the printed digits; where it is not known, two digits are printed."""
        return 0.3 if self.expected_error is None else max(map(abs, self.expected_error))

    _brief = ("scenario", "estimate.peak_force", "model", "peak_force", "regime", "relation", "amplification", "waves")
    _tables = (("waves", "wave"), ("conditions", "condition"))

    def to_dict(self) -> dict[str, Any]:
        """Document printed by ``predict --json``: SI floats, no NaN."""
        left_out = ("on_demand", "limit", "first_yield", "wall")
        values = VERSION | asdict(self, filter=lambda each, _: each.name not in left_out, value_serializer=_plain)
        own = {"regime": self.regime, "reason": self.reason or None, "ejection": None, "scene": self.scene.to_dict()}
        own["yield"] = None if self.yielding is None else asdict(self.yielding)
        accuracy, wall = asdict(self.accuracy, value_serializer=_plain), self.transmitted
        judged = {"transmitted": wall and asdict(wall), "verdict": plain_verdict(self)}
        return {**values, **accuracy, "warnings": list(self.warnings), **own, **judged}

    def __str__(self) -> str:
        return printed(self, "shockwave.prediction.outcome_text:outcome_text")


@frozen(kw_only=True, slots=False, repr=False)
class EjectionOutcome(Outcome):
    """One wave, weaker than the shock, and the first granule rebounds (section 4.2.2).

    Attributes
    ----------
    virtual_rise_time : float
        Rise time of the virtual shock, whose wave has the peak force of the shock, (5g) [s].
    added_momentum : float
        Momentum that the ejected granule transfers to the others, (5h) [N s].
    window_ratio : float
        Duration of the window of (5h) over that of the virtual shock; measured errors are ordered by it.
    """

    regime: ClassVar[Regime] = "ejection"

    virtual_rise_time: float
    added_momentum: float
    window_ratio: float

    def to_dict(self) -> dict[str, Any]:
        document = super().to_dict()
        own = ("virtual_rise_time", "added_momentum", "window_ratio")
        document["ejection"] = {name: document.pop(name) for name in own}
        return document


@frozen(kw_only=True, slots=False, repr=False)
class SingleOutcome(Outcome):
    """One wave that carries the entire impulse (section 4.2.3)."""

    regime: ClassVar[Regime] = "single"


@frozen(kw_only=True, slots=False, repr=False)
class TrainOutcome(Outcome):
    """A wave train (sections 4.2.4 and 4.2.5).

    Attributes
    ----------
    roots : tuple of float
        All peak forces [N] that satisfy the relation for the leading wave; with constant alpha there is one.
    """

    regime: ClassVar[Regime] = "train"

    roots: tuple[float, ...] = ()


@frozen(kw_only=True, eq=False, slots=False, repr=False)
class Predictions(Result, _OnDemand[FloatArray, FloatArray]):
    """Leading waves of many shocks, in the order of the shocks; the accuracy is computed as for `Outcome`.

    Attributes
    ----------
    model : str
        Name of the model.
    peak_force, amplification : numpy.ndarray, shape (shocks,)
        Peak force of the leading wave [N], and the same over that of the shock; NaN for a shock in ``failures``.
    method : numpy.ndarray of str, shape (shocks,)
        Method that gave each answer; empty for a shock in ``failures``.
    failures : tuple of (int, str)
        Indices of the shocks without an answer, ascending, each with the reason.
    estimate : numpy.ndarray, shape (shocks, 3)
        Best a-priori estimate of the peak force and the ends of its range [N]; NaN if there is none.
    expected_error : numpy.ndarray, shape (shocks, 2)
        Lowest and highest expected relative error of ``peak_force``; infinite if it is not known.
    warnings : tuple of str
        Sentences on the limits of the predictions; those on single shocks begin with their indices.
    """

    model: str
    peak_force: FloatArray
    amplification: FloatArray
    method: npt.NDArray[np.str_]
    failures: tuple[tuple[int, str], ...]
    on_demand: Callable[[], Accuracy[FloatArray, FloatArray]] = field(repr=False)

    _brief = ("model", "peak_force.size", "failures")
    _tables = (("predictions", "shock"),)

    def _table(self, name: str) -> Table:
        from shockwave.tables import along

        found = {each: getattr(self, each) for each in ("peak_force", "amplification", "method")}
        return along("shock", range(len(self.method)), found)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Predictions) and self.to_dict() == other.to_dict()

    def to_dict(self) -> dict[str, Any]:
        """Lists of SI floats, with None for unknown numbers."""
        return {
            **VERSION,
            "model": self.model,
            "peak_force": _numbers(self.peak_force),
            "amplification": _numbers(self.amplification),
            "estimate": [triple if None not in triple else None for triple in map(_numbers, self.estimate)],
            "expected_error": [pair if None not in pair else None for pair in map(_numbers, self.expected_error)],
            "method": self.method.tolist(),
            "failures": [{"index": index, "reason": reason} for index, reason in self.failures],
            "warnings": list(self.warnings),
        }

    def __str__(self) -> str:
        """Counts by method, and the first failure."""
        head = f"{len(self.method)} predictions by {self.model}"
        pairs = [(f"by {name}", str(count)) for name, count in Counter(self.method.tolist()).most_common() if name]
        if self.failures:
            index, reason = self.failures[0]
            pairs.append(("no answer", f"{len(self.failures)}; the first, shock {index}: {reason}"))
        return "\n".join([strong(head), *limits(self.warnings), *facts(pairs)])


def _numbers(values: FloatArray) -> list[float | None]:
    return [value if np.isfinite(value) else None for value in values.tolist()]
