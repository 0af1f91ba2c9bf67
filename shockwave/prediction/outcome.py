"""What a prediction says: one frozen class per regime."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar

from attrs import asdict, field, frozen

from shockwave.chain.solitary_wave import SolitaryWave
from shockwave.prediction.scaled import Inequality, Regime, Relation
from shockwave.profiles.base import Areas
from shockwave.profiles.conditions import Condition
from shockwave.scene import Scene
from shockwave.text import indent, notes, range_text, si, table

__all__ = ["EjectionOutcome", "Exponents", "Outcome", "SingleOutcome", "TrainOutcome"]


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
        """From d ln F / d ln A, as A goes with R^(4/3) rho^(1/2) E^(-1/3), eq. (4c)."""
        return cls(4 / 3 * sensitivity, sensitivity / 2, -sensitivity / 3)


_RELATIONS = {"less": "less than", "equal": "about equal to", "greater": "greater than"}


@frozen(kw_only=True)
class Outcome:
    """A prediction; its class is its regime.

    Attributes
    ----------
    model, scenario : str, str or None
        What predicted it; the name of the scenario, if it came from one.
    method, reason : str
        What the peak force was found by: the model itself, unless that chooses; then why, in a sentence.
    peak_force : float
        Of the primary [N].
    amplification : float
        ``peak_force`` over the shock's.
    relation : str
        ``less``, ``equal`` or ``greater``: the primary's peak against the shock's, (5d) or (5e).
    waves : tuple of SolitaryWave
        Primary first.
    applied_momentum : float
        Impulse of the shock [N s].
    conditions : tuple of Condition
        The inequalities (3).
    trace : tuple of Inequality
        The inequalities that decided; both sides in seconds.
    expected_error : tuple of float or None
        Lowest and highest relative error of ``peak_force`` to be expected of such a shock, from simulated ones; None
        where nothing was measured or the errors have no useful bound.
    exponents : Exponents or None
        How the answer depends on radius, density and stiffness; None where the relation has no derivative.
    areas : Areas
        a1 and a2, with their errors.
    momentum_coefficient : float
        The leading number of A.
    warnings : tuple of str
        What a reader must know before using the figures.
    scene : Scene
        The shock and the chain as they were understood.
    """

    regime: ClassVar[Regime]

    model: str
    peak_force: float
    amplification: float
    relation: Relation
    waves: tuple[SolitaryWave, ...]
    applied_momentum: float
    conditions: tuple[Condition, ...]
    trace: tuple[Inequality, ...]
    expected_error: tuple[float, float] | None
    exponents: Exponents | None
    areas: Areas
    momentum_coefficient: float
    warnings: tuple[str, ...]
    scene: Scene
    method: str
    reason: str = ""
    scenario: str | None = None

    def to_dict(self) -> dict[str, Any]:
        """What ``predict --json`` prints: SI floats, no NaN."""
        return {
            "scenario": self.scenario,
            "model": self.model,
            "method": self.method,
            "reason": self.reason or None,
            "regime": self.regime,
            "relation": self.relation,
            "peak_force": self.peak_force,
            "amplification": self.amplification,
            "waves": [wave.to_dict() for wave in self.waves],
            "applied_momentum": self.applied_momentum,
            "ejection": self._ejection(),
            "conditions": [asdict(condition) for condition in self.conditions],
            "expected_error": None if self.expected_error is None else list(self.expected_error),
            "warnings": list(self.warnings),
            "trace": [asdict(comparison) for comparison in self.trace],
            "exponents": None if self.exponents is None else asdict(self.exponents),
            "areas": asdict(self.areas),
            "momentum_coefficient": self.momentum_coefficient,
            "scene": asdict(self.scene),
        }

    def _ejection(self) -> dict[str, float] | None:
        return None

    def __str__(self) -> str:
        lines = [
            f"prediction by {self.model}" + (f" of {self.scenario}" if self.scenario else ""),
            *self.scene.lines(),
            *([f"  taken             {self.method}: {self.reason}"] if self.reason else []),
            f"  regime            {self.regime}",
            f"  relation          primary {_RELATIONS[self.relation]} the shock's peak force",
            f"  peak force        {si(self.peak_force, 'N')}, {self.amplification:.5g} times the shock's",
            f"  expected error    {range_text(self.expected_error)}",
            f"  applied momentum  {si(self.applied_momentum, 'N s')}",
        ]
        ejection = self._ejection()
        if ejection:
            lines += [
                f"  ejection          virtual rise time {si(ejection['virtual_rise_time'], 's')}, "
                f"added momentum {si(ejection['added_momentum'], 'N s')}"
            ]
        if self.exponents:
            powers = self.exponents
            lines.append(
                f"  goes with         R^{powers.radius:.3f} rho^{powers.density:.3f} E^{powers.youngs_modulus:.3f}"
            )
        lines += ["", indent(_waves_text(self.waves)), ""]
        conditions = ([c.statement, f"{c.margin:+.4g} t0", "holds" if c.holds else "FAILS"] for c in self.conditions)
        lines += [indent(table(("condition (3)", "margin", ""), conditions)), ""]
        steps = ((t.statement, si(t.left, "s"), si(t.right, "s"), t.outcome, t.equation) for t in self.trace)
        lines += [indent(table(("decided by", "left", "right", "hence", "equation"), steps))]
        return "\n".join(lines + notes(self.warnings))


def _waves_text(waves: Iterable[SolitaryWave]) -> str:
    units = {"peak_force": "N", "momentum": "N s", "energy": "J", "speed": "m/s", "width": "s"}
    header = ("wave", *(name.replace("_", " ") for name in units))
    rows = (
        (str(number), *(si(getattr(wave, name), unit) for name, unit in units.items()))
        for number, wave in enumerate(waves, start=1)
    )
    return table(header, rows)


@frozen(kw_only=True)
class EjectionOutcome(Outcome):
    """One wave, weaker than the shock, and the first granule thrown back (4.2.2).

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

    def _ejection(self) -> dict[str, float] | None:
        return {
            "virtual_rise_time": self.virtual_rise_time,
            "added_momentum": self.added_momentum,
            "window_ratio": self.window_ratio,
        }


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

    roots: tuple[float, ...] = field(default=())

    def to_dict(self) -> dict[str, Any]:
        return {**super().to_dict(), "roots": list(self.roots)}
