"""Prediction of section 4 for one shock, in SI units: a frozen class for each regime."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from attrs import field, frozen

from shockwave.base.result import Result
from shockwave.prediction.scaled_shock import Inequality, Regime, Relation, ScaledAnswer
from shockwave.profiles.area_conditions import Condition
from shockwave.profiles.shock_profile import Areas
from shockwave.scene.chain import Chain, Scales
from shockwave.scene.solitary_wave import SolitaryWave


@frozen
class Exponents:
    """Local scaling exponents of the peak force of the leading wave: ``d ln F/d ln`` of each property of the granules.

    For example, with ``radius`` -1.6 the peak force scales as ``R^-1.6`` for a given shock.
    """

    radius: float
    density: float
    youngs_modulus: float

    @classmethod
    def of(cls, sensitivity: float, chain: Chain) -> Exponents:
        """Make the exponents from ``d ln F/d ln A``; A scales as ``R^(4/3) rho^(1/2) E^(-1/3)``, eq. (4c).

        If the contact stiffness is given, A scales as the square root of the mass, ``R^(3/2) rho^(1/2)``.
        """
        if chain.contact is not None:
            return cls(1.5 * sensitivity, sensitivity / 2, 0.0)
        return cls(4 / 3 * sensitivity, sensitivity / 2, -sensitivity / 3)


@frozen(kw_only=True, slots=False, repr=False)
class Section4Outcome(Result):
    """Prediction of section 4 for one shock; its class corresponds to its regime.

    Attributes
    ----------
    peak_force : float
        Peak force of the leading wave [N].
    amplification : float
        Peak force of the leading wave over that of the shock.
    relation : str
        ``less``, ``equal`` or ``greater``: peak force of the leading wave relative to that of the shock, (5d) or (5e).
    waves : tuple of SolitaryWave
        Waves, leading wave first.
    conditions : tuple of Condition
        Conditions (3).
    trace : tuple of Inequality
        Inequalities that decided; both sides in seconds.
    exponents : Exponents or None
        Scaling with radius, density and stiffness; None where the relation has no derivative.
    areas : Areas
        Areas a1 and a2 with their errors, eq. (3).
    momentum_coefficient : float
        Numerical coefficient of A, eq. (4c).
    wave_time : float
        ``A F0^(-1/6)``, the impulse of a wave with the peak force of the shock over this force [s].
    warnings : tuple of str
        Sentences on the limits of the relations.
    simulated_force : callable
        Function that returns the simulated peak force [N], or None where there is none.
    """

    regime: ClassVar[Regime]

    peak_force: float
    amplification: float
    relation: Relation
    waves: tuple[SolitaryWave, ...]
    conditions: tuple[Condition, ...]
    trace: tuple[Inequality, ...]
    exponents: Exponents | None
    areas: Areas
    momentum_coefficient: float
    wave_time: float
    warnings: tuple[str, ...] = ()
    simulated_force: Callable[[], float | None] = field(eq=False, repr=False)

    @property
    def holds(self) -> bool:
        """Whether all conditions (3) hold; section 4 was derived for shocks that satisfy them."""
        return all(condition.holds for condition in self.conditions)

    @property
    def error(self) -> float | Any:
        """Relative difference of the peak force from the simulated one; None where there is no simulation."""
        simulated = self.simulated_force()
        return None if simulated is None else self.peak_force / simulated - 1

    @property
    def ejection(self) -> dict[str, float] | None:
        """Results for rebounding granules, of the regime ``ejection``; None in others."""
        names = ("virtual_rise_time", "added_momentum", "window_ratio")
        return {name: getattr(self, name) for name in names} if self.regime == "ejection" else None

    _brief = ("regime", "peak_force", "amplification", "relation", "waves")
    _picture = "shockwave.pictures.waves:train"
    _tables = (("waves", "wave"), ("conditions", "condition"))

    def to_dict(self) -> dict[str, Any]:
        """Block ``section4`` of the document that ``predict --json`` prints, without the decision."""
        names = ("peak_force", "amplification", "relation", "error", "holds", "waves", "exponents", "areas")
        return self._document(*names, "momentum_coefficient", "warnings")


@frozen(kw_only=True, slots=False, repr=False)
class EjectionOutcome(Section4Outcome):
    """One wave, weaker than the shock, and the first granule rebounds (section 4.2.2).

    Attributes
    ----------
    virtual_rise_time : float
        Rise time of the virtual shock, whose wave has the peak force of the shock, (5g) [s].
    added_momentum : float
        Momentum that the ejected granule transfers to the others, (5h) [N s].
    window_ratio : float
        Duration of the window of (5h) over that of the virtual shock.
    """

    regime: ClassVar[Regime] = "ejection"

    virtual_rise_time: float
    added_momentum: float
    window_ratio: float


@frozen(kw_only=True, slots=False, repr=False)
class SingleOutcome(Section4Outcome):
    """One wave that carries the entire impulse (section 4.2.3)."""

    regime: ClassVar[Regime] = "single"


@frozen(kw_only=True, slots=False, repr=False)
class TrainOutcome(Section4Outcome):
    """A wave train (sections 4.2.4 and 4.2.5).

    Attributes
    ----------
    roots : tuple of float
        All peak forces [N] that satisfy the relation for the leading wave; with constant alpha there is one.
    """

    regime: ClassVar[Regime] = "train"

    roots: tuple[float, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        return {**super().to_dict(), "roots": list(self.roots)}


def outcome_of(answer: ScaledAnswer, common: dict[str, Any], scales: Scales, force: float) -> Section4Outcome:
    """Outcome of the regime, with the values that all regimes have; ``force`` is the peak force at a contact."""
    if answer.ejection is not None:
        return EjectionOutcome(
            **common,
            virtual_rise_time=answer.ejection.virtual_rise_time * scales.time,
            added_momentum=answer.ejection.added_momentum * scales.momentum,
            window_ratio=answer.ejection.window_ratio,
        )
    if answer.regime == "train":
        return TrainOutcome(**common, roots=tuple(root * force for root in answer.roots))
    return SingleOutcome(**common)
