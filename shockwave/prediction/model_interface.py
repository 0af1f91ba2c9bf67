"""The input and output of prediction models, in scaled units: mass, contact stiffness, peak force of the shock 1."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
import numpy.typing as npt
from attrs import field, frozen

from shockwave.profiles.base import Areas, ShockProfile
from shockwave.quadrature import FloatArray

Regime = Literal["ejection", "single", "train"]
Relation = Literal["less", "equal", "greater"]
Indices = npt.NDArray[np.intp]


@frozen
class ScaledShock:
    """A shock whose only scale is its rise time t0/T0.

    ``momentum_parameter`` is A F0^(-1/6) / T0: the momentum of a wave of peak force 1.
    """

    profile: ShockProfile
    areas: Areas
    rise_time: float
    momentum_parameter: float

    @property
    def duration(self) -> float:
        """n t0 / T0."""
        return self.profile.duration_ratio * self.rise_time

    @property
    def impulse(self) -> float:
        """Impulse of the whole shock, t0 (a1 + a2)."""
        return self.rise_time * self.areas.total

    def impulse_until(self, time: float) -> float:
        """Impulse of the shock up to ``time``."""
        if time >= self.duration:
            return self.impulse
        method = self.areas.rise.method
        quadrature = None if method == "closed form" else method
        return self.rise_time * float(self.profile.running_impulse(time / self.rise_time, quadrature))

    def force_at(self, time: float) -> float:
        """Force of the shock at ``time``."""
        return float(self.profile.force(time / self.rise_time))


@frozen
class Settings:
    """Settings of `Predictor` that a model uses."""

    alpha: Literal["constant", "literal"] = "constant"
    equal_tolerance: float = 0.05
    wave_threshold: float = 5e-3
    rtol: float | None = None


@frozen
class Inequality:
    """One inequality that decided: its two sides (times over T0), its equation, and the outcome."""

    statement: str
    left: float
    right: float
    equation: str
    outcome: str


@frozen
class ScaledEjection:
    """The virtual rise time of (5g), the added momentum of (5h), and the window over the virtual shock."""

    virtual_rise_time: float
    added_momentum: float
    window_ratio: float


@frozen
class ScaledAnswer:
    """The answer of a model.

    ``amplitudes`` are peak forces of the waves, primary first. ``sensitivity`` is d ln F / d ln A of the
    primary, or None where the relation has no derivative. ``roots`` are all peak forces that satisfy the
    relation. ``trust`` is the number by which measured errors are ordered (None: not measured). A model that
    ``states_error`` gives the lowest and highest relative error of the primary's peak force itself, or None where it
    is unknown. A model that chooses among others states the ``method`` used, and the ``reason`` in a sentence.
    """

    regime: Regime
    relation: Relation
    amplitudes: tuple[float, ...]
    trace: tuple[Inequality, ...]
    sensitivity: float | None
    trust: float | None = None
    ejection: ScaledEjection | None = None
    roots: tuple[float, ...] = ()
    warnings: tuple[str, ...] = ()
    states_error: bool = False
    expected_error: tuple[float, float] | None = None
    method: str = ""
    reason: str = ""


@frozen(eq=False)
class Shocks:
    """Many scaled shocks of few shapes.

    Attributes
    ----------
    profiles, areas : tuple
        Of each shape.
    shapes : numpy.ndarray of int, shape (shocks,)
        Index of the shape of each shock.
    rise_times : numpy.ndarray, shape (shocks,)
        t0/T0 of each.
    momentum_parameter : float
        As of `ScaledShock`.
    """

    profiles: tuple[ShockProfile, ...]
    areas: tuple[Areas, ...]
    shapes: Indices
    rise_times: FloatArray
    momentum_parameter: float

    def __len__(self) -> int:
        return len(self.rise_times)

    def shock(self, index: int) -> ScaledShock:
        """The shock at ``index``."""
        shape = self.shapes[index]
        rise_time = float(self.rise_times[index])
        return ScaledShock(self.profiles[shape], self.areas[shape], rise_time, self.momentum_parameter)


@frozen(eq=False)
class Peaks:
    """The primaries of many shocks: arrays of the shape (shocks,), to be filled.

    ``low`` and ``high`` are the ends of the relative error, infinite where it is unknown. ``failures`` holds the reason
    for each shock without an answer; ``warnings`` are sentences on all of them.
    """

    amplification: FloatArray
    low: FloatArray
    high: FloatArray
    method: npt.NDArray[np.str_]
    failures: dict[int, str]
    warnings: list[str] = field(factory=list)

    @classmethod
    def of(cls, count: int) -> Peaks:
        """Peaks of ``count`` shocks, none known yet."""
        far = np.full(count, np.inf)
        return cls(np.full(count, np.nan), -far, far, np.full(count, "", dtype="U16"), {})

    def better(self, where: Indices, amplification: FloatArray | float, bound: FloatArray | float, method: str) -> None:
        """Put in answers of one method for the shocks ``where``, as far as their bounds are below those present."""
        good = bound < self.high[where]
        own, bounds = where[good], np.broadcast_to(bound, where.shape)[good]
        self.amplification[own] = np.broadcast_to(amplification, where.shape)[good]
        self.low[own], self.high[own], self.method[own] = -bounds, bounds, method


@frozen
class Model:
    """A model that has an answer for many shocks at once; called, it answers one as any other does."""

    one: Callable[[ScaledShock, Settings], ScaledAnswer]
    many: Callable[[Shocks, Settings], Peaks]

    def __call__(self, shock: ScaledShock, settings: Settings) -> ScaledAnswer:
        """The answer for one shock."""
        return self.one(shock, settings)
