"""Input and result of section 4 in units in which mass, contact stiffness and shock peak force are 1."""

from __future__ import annotations

from typing import Literal

from attrs import frozen

from shockwave.profiles.shock_profile import Areas, ShockProfile
from shockwave.registry.plugin_check import is_built_in
from shockwave.scene.solitary_wave import HERTZ_WAVE, WaveLaw

Regime = Literal["ejection", "single", "train"]
Relation = Literal["less", "equal", "greater"]


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
    wave : WaveLaw
        Solitary waves of the chain.
    """

    profile: ShockProfile
    areas: Areas
    rise_time: float
    momentum_parameter: float
    wave: WaveLaw = HERTZ_WAVE

    @property
    def of_force(self) -> float:
        """Power of the momentum with which the peak force of a wave scales, 2p/(p + 1): 6/5."""
        return 2 * self.wave.exponent / (self.wave.exponent + 1)

    @property
    def duration(self) -> float:
        """Duration n t0/T0."""
        return self.profile.duration_ratio * self.rise_time

    @property
    def impulse(self) -> float:
        """Impulse of the whole shock, (a1 + a2) t0/T0."""
        return self.rise_time * self.areas.total

    def at(self, time: float) -> tuple[float, float]:
        """Impulse of the shock up to ``time``, and its force at ``time``."""
        s = time / self.rise_time
        if s >= self.profile.duration_ratio:
            return self.impulse, 0.0
        quadrature = None if self.areas.rise.method == "closed form" else self.areas.rise.method
        closed = self.profile.closed_at(s) if quadrature is None and is_built_in(self.profile) else None
        impulse, force = closed or (float(self.profile.running_impulse(s, quadrature)), float(self.profile.force(s)))
        return self.rise_time * impulse, force


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
    """Answer of section 4 for one shock.

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
    """

    regime: Regime
    relation: Relation
    amplitudes: tuple[float, ...]
    trace: tuple[Inequality, ...]
    sensitivity: float | None
    ejection: ScaledEjection | None = None
    roots: tuple[float, ...] = ()
    warnings: tuple[str, ...] = ()
