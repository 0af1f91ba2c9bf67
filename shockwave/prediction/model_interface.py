"""Input and output of prediction models, in units in which mass, contact stiffness and shock peak force are 1."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt
from attrs import field, frozen

from shockwave.chain.chain import HERTZ, Scales
from shockwave.errors import InvalidValueError, NumericalError
from shockwave.profiles.base import Areas, ShockProfile
from shockwave.profiles.guard import trusted
from shockwave.quadrature import FloatArray

Regime = Literal["ejection", "single", "train"]
Relation = Literal["less", "equal", "greater"]
Indices = npt.NDArray[np.intp]
#: Errors that concern one shock; a faulty plugin ends all predictions.
NO_ANSWER = (InvalidValueError, NumericalError)


@frozen
class ScaledShock:
    """A shock in scaled units.

    Attributes
    ----------
    profile, areas : ShockProfile, Areas
        Shape of the shock and its areas, eq. (3).
    rise_time : float
        t0/T0.
    momentum_parameter : float
        A F0^(-1/6) / T0, the momentum of a solitary wave of peak force 1.
    exponent : float
        p of the contact force d^p. Only models that take ``exponent`` are given others than Hertz's 3/2.
    """

    profile: ShockProfile
    areas: Areas
    rise_time: float
    momentum_parameter: float
    exponent: float = HERTZ

    @property
    def of_time(self) -> float:
        """Power of the peak force with which the duration of a wave scales inversely, (p - 1)/(2p): 1/6."""
        return (self.exponent - 1) / (2 * self.exponent)

    @property
    def of_momentum(self) -> float:
        """Power of the peak force with which the momentum of a wave scales, (p + 1)/(2p): 5/6."""
        return (self.exponent + 1) / (2 * self.exponent)

    @property
    def of_force(self) -> float:
        """Power of the momentum with which the peak force of a wave scales, 2p/(p + 1): 6/5."""
        return 2 * self.exponent / (self.exponent + 1)

    @property
    def duration(self) -> float:
        """Duration n t0/T0."""
        return self.profile.duration_ratio * self.rise_time

    @property
    def impulse(self) -> float:
        """Impulse of the whole shock, (a1 + a2) t0/T0."""
        return self.rise_time * self.areas.total

    @property
    def alone(self) -> Shocks:
        """This shock only, as `Shocks`."""
        return Shocks.of([self])

    def at(self, time: float) -> tuple[float, float]:
        """Impulse of the shock up to ``time``, and its force at ``time``."""
        s = time / self.rise_time
        if s >= self.profile.duration_ratio:
            return self.impulse, 0.0
        quadrature = None if self.areas.rise.method == "closed form" else self.areas.rise.method
        found = self.profile.closed_at(s) if quadrature is None and trusted(self.profile) else None
        impulse, force = found or (float(self.profile.running_impulse(s, quadrature)), float(self.profile.force(s)))
        return self.rise_time * impulse, force


@frozen
class Settings:
    """Settings of `Predictor` that are passed to a model; see there."""

    alpha: Literal["constant", "literal"] = "constant"
    equal_tolerance: float = 0.05
    wave_threshold: float = 5e-3
    rtol: float | None = None


@frozen
class Inequality:
    """An inequality of the decision: its two sides, as times over T0, its equation number, and its outcome."""

    statement: str
    left: float
    right: float
    equation: str
    outcome: str

    def in_units(self, time: float) -> Inequality:
        """Inequality with sides multiplied by ``time``."""
        return Inequality(self.statement, self.left * time, self.right * time, self.equation, self.outcome)


@frozen
class ScaledEjection:
    """Virtual rise time of (5g), added momentum of (5h), and duration of its window over that of the virtual shock."""

    virtual_rise_time: float
    added_momentum: float
    window_ratio: float


@frozen
class ScaledAnswer:
    """Answer of a model for one shock.

    Attributes
    ----------
    regime, relation : str
        Regime, and relation of the leading wave to the shock.
    amplitudes : tuple of float
        Peak forces of the waves over F0, leading wave first.
    trace : tuple of Inequality
        Inequalities that decided.
    sensitivity : float or None
        d ln F / d ln A of the leading wave; None where the relation has no derivative.
    ejection : ScaledEjection or None
        Results of (5g) and (5h), for the regime ``ejection``.
    roots : tuple of float
        All peak forces over F0 that satisfy the relation, for the regime ``train``.
    warnings : tuple of str
        Sentences on the limits of the answer.
    states_error, expected_error : bool, tuple of float or None
        Whether the model itself states the range of its relative error, and this range, None if it is unknown.
    method, reason : str
        For a model that selects a method: its name, and the reason in a sentence.
    """

    regime: Regime
    relation: Relation
    amplitudes: tuple[float, ...]
    trace: tuple[Inequality, ...]
    sensitivity: float | None
    ejection: ScaledEjection | None = None
    roots: tuple[float, ...] = ()
    warnings: tuple[str, ...] = ()
    states_error: bool = False
    expected_error: tuple[float, float] | None = None
    method: str = ""
    reason: str = ""


@frozen(eq=False)
class Shocks:
    """Many scaled shocks of a few shapes.

    Attributes
    ----------
    profiles, areas : tuple
        Profile and areas of each shape.
    shapes : numpy.ndarray of int, shape (shocks,)
        Index of the shape of each shock.
    rise_times : numpy.ndarray, shape (shocks,)
        t0/T0 of each shock.
    momentum_parameter : float
        As in `ScaledShock`.
    """

    profiles: tuple[ShockProfile, ...]
    areas: tuple[Areas, ...]
    shapes: Indices
    rise_times: FloatArray
    momentum_parameter: float

    @classmethod
    def of(cls, shocks: Sequence[ScaledShock]) -> Shocks:
        """``shocks`` with the same momentum parameter, each with a shape of its own."""
        profiles, areas = tuple(one.profile for one in shocks), tuple(one.areas for one in shocks)
        rise_times = np.array([one.rise_time for one in shocks])
        return cls(profiles, areas, np.arange(len(shocks)), rise_times, shocks[0].momentum_parameter)

    def __len__(self) -> int:
        return len(self.rise_times)

    def shock(self, index: int) -> ScaledShock:
        """Shock at ``index``."""
        shape = self.shapes[index]
        rise_time = float(self.rise_times[index])
        return ScaledShock(self.profiles[shape], self.areas[shape], rise_time, self.momentum_parameter)


@frozen(eq=False)
class ScaledShocks:
    """Scaled shocks, with their places among the given ones and their units; errors of the others by place."""

    shocks: Shocks
    places: list[int]
    units: list[Scales]
    failures: dict[int, str]


@frozen(eq=False)
class Peaks:
    """Leading waves of many shocks: arrays of shape (shocks,), to be filled.

    ``low`` and ``high`` are the ends of the range of the relative error, infinite if it is unknown; ``states_error`` as
    in `ScaledAnswer`. ``failures`` has the reason for each shock without an answer; ``warnings`` are sentences that
    apply to all shocks.

    A model that is `Model.complete` fills the others, too: regimes and relations, numbers of waves, results of (5g)
    and (5h), NaN in other regimes, and ``notes``, the warnings of single shocks.
    """

    amplification: FloatArray
    low: FloatArray
    high: FloatArray
    method: npt.NDArray[np.str_]
    states_error: npt.NDArray[np.bool_]
    regime: npt.NDArray[np.str_]
    relation: npt.NDArray[np.str_]
    waves: Indices
    virtual_rise_time: FloatArray
    added_momentum: FloatArray
    failures: dict[int, str] = field(factory=dict)
    warnings: list[str] = field(factory=list)
    notes: dict[int, tuple[str, ...]] = field(factory=dict)

    @classmethod
    def of(cls, count: int) -> Peaks:
        """Make the arrays for ``count`` shocks, without answers."""
        far, unknown, text = np.full(count, np.inf), np.full((3, count), np.nan), np.full((3, count), "", dtype="U16")
        whole = np.ones(count, dtype=np.intp)
        return cls(unknown[0], -far, far, text[0], whole > 0, text[1], text[2], whole, unknown[1], unknown[2])

    def better(self, where: Indices, amplification: FloatArray | float, bound: FloatArray | float, method: str) -> None:
        """Store answers of one method for the shocks ``where`` whose bounds are below the present ones."""
        good = bound < self.high[where]
        own, bounds = where[good], np.broadcast_to(bound, where.shape)[good]
        self.amplification[own] = np.broadcast_to(amplification, where.shape)[good]
        self.low[own], self.high[own], self.method[own] = -bounds, bounds, method


@frozen
class Model:
    """A model that also evaluates many shocks at once; like any other model, it is called for one shock.

    ``complete`` states whether ``many`` predicts regimes and later waves, too. An infinite threshold omits these waves.
    """

    one: Callable[[ScaledShock, Settings], ScaledAnswer]
    many: Callable[[Shocks, Settings], Peaks]
    complete: bool = False

    def __call__(self, shock: ScaledShock, settings: Settings) -> ScaledAnswer:
        """Answer for one shock."""
        return self.one(shock, settings)


def one_by_one(
    model: Callable[[ScaledShock, Settings], ScaledAnswer],
    shocks: Shocks,
    settings: Settings,
    where: Iterable[int] | None = None,
) -> Peaks:
    """Evaluate a model for one shock at a time; if indices ``where`` are given, all other shocks are left out."""
    results = Peaks.of(len(shocks))
    for index in range(len(shocks)) if where is None else where:
        try:
            answer = model(shocks.shock(index), settings)
        except NO_ANSWER as error:
            results.failures[index] = str(error)
            continue
        results.amplification[index], results.method[index] = answer.amplitudes[0], answer.method
        results.states_error[index], results.waves[index] = answer.states_error, len(answer.amplitudes)
        results.regime[index], results.relation[index] = answer.regime, answer.relation
        if answer.ejection is not None:
            results.virtual_rise_time[index] = answer.ejection.virtual_rise_time
            results.added_momentum[index] = answer.ejection.added_momentum
        if answer.warnings:
            results.notes[index] = answer.warnings
        if answer.expected_error is not None:
            results.low[index], results.high[index] = answer.expected_error
    return results
