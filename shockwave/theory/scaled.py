"""What a prediction model takes and gives, in scaled units (mass, contact stiffness, peak force of the shock 1)."""

from __future__ import annotations

from typing import Literal

from attrs import field, frozen

from shockwave.profiles.base import Areas, ShockProfile

__all__ = ["Inequality", "Regime", "Relation", "ScaledAnswer", "ScaledEjection", "ScaledShock", "Settings"]

Regime = Literal["ejection", "single", "train"]
Relation = Literal["less", "equal", "greater"]


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
        """Of the whole shock, t0 (a1 + a2)."""
        return self.rise_time * self.areas.total

    def impulse_until(self, time: float) -> float:
        """Of the shock up to ``time``."""
        if time >= self.duration:
            return self.impulse
        return self.rise_time * float(self.profile.running_impulse(time / self.rise_time, self._quadrature))

    def force_at(self, time: float) -> float:
        """Of the shock at ``time``."""
        return float(self.profile.force(time / self.rise_time))

    @property
    def _quadrature(self) -> str | None:
        method = self.areas.rise.method
        return None if method == "closed form" else method


@frozen
class Settings:
    """How the relations are read; see `Predictor`."""

    alpha: Literal["constant", "literal"] = "constant"
    equal_tolerance: float = 0.05
    wave_threshold: float = 5e-3


@frozen
class Inequality:
    """One inequality that decided: its two sides (times over T0), its equation, and what followed."""

    statement: str
    left: float
    right: float
    equation: str
    outcome: str


@frozen
class ScaledEjection:
    """The virtual rise time of (5g), the added momentum of (5h), and how far the window reaches back."""

    virtual_rise_time: float
    added_momentum: float
    window_ratio: float


@frozen
class ScaledAnswer:
    """What a model found.

    ``amplitudes`` are peak forces of the waves, primary first. ``sensitivity`` is d ln F / d ln A of the
    primary, or None where the relation has no derivative. ``roots`` are all peak forces that satisfy the
    relation read. ``trust`` is the number by which measured errors are ordered (None: not measured). A model that
    ``tells_error`` brings the lowest and highest relative error of the primary's peak force itself, or None where it
    does not know.
    """

    regime: Regime
    relation: Relation
    amplitudes: tuple[float, ...]
    trace: tuple[Inequality, ...]
    sensitivity: float | None
    trust: float | None = None
    ejection: ScaledEjection | None = None
    roots: tuple[float, ...] = ()
    warnings: tuple[str, ...] = field(default=())
    tells_error: bool = False
    expected_error: tuple[float, float] | None = None
