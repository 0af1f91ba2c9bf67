"""The outcome of a prediction: one frozen class per regime."""

from __future__ import annotations

from typing import Any, ClassVar

from attrs import asdict, frozen

from shockwave.chain.solitary_wave import SolitaryWave
from shockwave.prediction.model_interface import Inequality, Regime, Relation
from shockwave.profiles.base import Areas
from shockwave.profiles.conditions import Condition
from shockwave.scene_summary import Scene
from shockwave.text import printed


@frozen
class Exponents:
    """Local powers with which the primary's peak force depends on the granules: d ln F / d ln of each.

    ``radius`` -1.6 says that doubling R divides the force by 2^1.6, all else and the shock being equal.
    """

    radius: float
    density: float
    youngs_modulus: float

    @classmethod
    def of(cls, sensitivity: float) -> Exponents:
        """From d ln F / d ln A, as A scales as R^(4/3) rho^(1/2) E^(-1/3), eq. (4c)."""
        return cls(4 / 3 * sensitivity, sensitivity / 2, -sensitivity / 3)


def _plain(_: object, __: object, value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


@frozen(kw_only=True)
class Outcome:
    """A prediction; its class is its regime.

    Attributes
    ----------
    scenario, model : str or None, str
        Name of the scenario, if it came from one; name of the model.
    method, reason : str
        The method by which the peak force was found: the model itself, unless that chooses; then why, in a sentence.
    relation : str
        ``less``, ``equal`` or ``greater``: the primary's peak against the shock's, (5d) or (5e).
    peak_force : float
        Of the primary [N].
    amplification : float
        ``peak_force`` over the shock's.
    waves : tuple of SolitaryWave
        Primary first.
    applied_momentum : float
        Impulse of the shock [N s].
    conditions : tuple of Condition
        The inequalities (3).
    expected_error : tuple of float or None
        Lowest and highest relative error of ``peak_force`` to be expected of such a shock, from simulated ones; None
        where nothing was measured or the errors have no useful bound.
    warnings : tuple of str
        What a reader must know before using the figures.
    trace : tuple of Inequality
        The inequalities that decided; both sides in seconds.
    exponents : Exponents or None
        How the answer depends on radius, density and stiffness; None where the relation has no derivative.
    areas : Areas
        a1 and a2, with their errors.
    momentum_coefficient : float
        The leading number of A.
    scene : Scene
        The shock and the chain as they were understood.
    """

    regime: ClassVar[Regime]

    scenario: str | None = None
    model: str
    method: str
    reason: str = ""
    relation: Relation
    peak_force: float
    amplification: float
    waves: tuple[SolitaryWave, ...]
    applied_momentum: float
    conditions: tuple[Condition, ...]
    expected_error: tuple[float, float] | None
    warnings: tuple[str, ...]
    trace: tuple[Inequality, ...]
    exponents: Exponents | None
    areas: Areas
    momentum_coefficient: float
    scene: Scene

    def to_dict(self) -> dict[str, Any]:
        """The document that ``predict --json`` prints: SI floats, no NaN."""
        values = asdict(self, value_serializer=_plain)
        return {**values, "regime": self.regime, "reason": self.reason or None, "ejection": None}

    def __str__(self) -> str:
        return printed(self, "shockwave.prediction.outcome_text:outcome_text")


@frozen(kw_only=True)
class EjectionOutcome(Outcome):
    """One wave, weaker than the shock, and the first granule rebounds (4.2.2).

    Attributes
    ----------
    virtual_rise_time : float
        The rise time with which the wave would match the shock's peak force, (5g) [s].
    added_momentum : float
        Momentum that the ejected granule leaves to the others, (5h) [N s].
    window_ratio : float
        Share of the virtual shock from which it is taken; measured errors are ordered by it.
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


@frozen(kw_only=True)
class SingleOutcome(Outcome):
    """One wave that takes the whole impulse (4.2.3)."""

    regime: ClassVar[Regime] = "single"


@frozen(kw_only=True)
class TrainOutcome(Outcome):
    """A train of waves (4.2.4, 4.2.5).

    Attributes
    ----------
    roots : tuple of float
        Every peak force [N] that satisfies the relation read for the primary; one unless alpha is literal.
    """

    regime: ClassVar[Regime] = "train"

    roots: tuple[float, ...] = ()
