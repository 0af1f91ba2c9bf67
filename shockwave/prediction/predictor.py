"""The predictor: a shock and a chain in, an outcome out, without solving the equations of motion."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Literal

from attrs import evolve, frozen

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.solitary_wave import EXACT_COEFFICIENT, MOMENTUM, PAPER_COEFFICIENT, SolitaryWave
from shockwave.errors import InvalidValueError
from shockwave.fields import Quantity, quantity
from shockwave.prediction.expected_error import chain_warnings, expected_error
from shockwave.prediction.model_interface import ScaledAnswer, ScaledShock, Settings
from shockwave.prediction.outcome import EjectionOutcome, Exponents, Outcome, SingleOutcome, TrainOutcome
from shockwave.profiles.conditions import conditions
from shockwave.profiles.shock import Shock
from shockwave.registry import blame, find, load
from shockwave.scene_summary import Scene

if TYPE_CHECKING:
    from shockwave.prediction.many_shocks import Predictions


MOMENTUM_COEFFICIENTS = {"exact": EXACT_COEFFICIENT, "paper": PAPER_COEFFICIENT}
MOMENTUM_COEFFICIENT = Quantity("", "leading number of A", at_least=0.01, at_most=1000)


def coefficient_of(choice: str | float) -> float:
    """The leading number of A for ``"exact"``, ``"paper"`` or a number between 0.01 and 1000.

    Raises
    ------
    InvalidValueError
        For anything else.
    """
    if isinstance(choice, str) and choice in MOMENTUM_COEFFICIENTS:
        return MOMENTUM_COEFFICIENTS[choice]
    if MOMENTUM_COEFFICIENT.problem(choice) is not None:
        rule = f"must be 'exact', 'paper' or a number {MOMENTUM_COEFFICIENT.rule}"
        raise InvalidValueError.of("momentum_coefficient", f"{rule} (got {choice!r})")
    return float(choice)


@frozen
class Predictor:
    """Predicts the solitary waves that a shock makes, by section 4 of Hasan & Nemat-Nasser.

    Parameters
    ----------
    model : str
        Name of a registered model.
    rtol : float, optional
        Relative error allowed of the primary's peak force, 1e-8 to 0.5, for a model that chooses by it, as ``auto``
        does (left out, 1e-3); the others refuse it.
    momentum_coefficient : "exact", "paper" or float
        The leading number of A, eq. (4c): 4.344507853978653, 13/3, or another.
    alpha : "constant" or "literal"
        The alpha of section 4.1, which matches simulation, or eq. (5c) as printed, which gives all its roots.
    equal_tolerance : float
        How far two sides may differ, relatively, to be called equal.
    wave_threshold : float
        A later wave is listed down to this share of the primary's peak force.
    quadrature : str, optional
        Name of a quadrature for all integrals, even those with closed forms.

    Raises
    ------
    InvalidValueError, UnknownNameError
        When a setting is out of range or a name unknown.
    """

    model: str = "section-4"
    rtol: float | None = quantity(
        "",
        "relative error allowed of the primary's peak force; for model auto, 1e-3 unless given",
        at_least=1e-8,
        at_most=0.5,
        optional=True,
        default=None,
    )
    momentum_coefficient: str | float = "exact"
    alpha: Literal["constant", "literal"] = "constant"
    equal_tolerance: float = quantity("", "relative difference called equal", at_least=0, below=1, default=0.05)
    wave_threshold: float = quantity("", "weakest later wave listed, over the primary", above=0, below=1, default=5e-3)
    quadrature: str | None = None

    def __attrs_post_init__(self) -> None:
        takes = find("models", self.model).takes.split()
        coefficient_of(self.momentum_coefficient)
        if self.quadrature is not None:
            find("quadratures", self.quadrature)
        if self.alpha not in ("constant", "literal"):
            raise InvalidValueError.of("alpha", f"must be 'constant' or 'literal' (got {self.alpha!r})")
        left_out = f"must be left out for model {self.model!r}"
        if self.alpha != "constant" and "alpha" not in takes:
            raise InvalidValueError.of("alpha", f"{left_out}, which has none (got {self.alpha!r})")
        if self.rtol is not None and "rtol" not in takes:
            remedy = "take model auto, or simulate to a tolerance instead"
            raise InvalidValueError.of("rtol", f"{left_out}: its formulae have none (got {self.rtol!r}; {remedy})")

    def predict(self, shock: Shock, chain: Chain) -> Outcome:
        """The outcome of ``shock`` on ``chain``.

        Parameters
        ----------
        shock : Shock
            Profile, peak force, rise time.
        chain : Chain
            Material, radius; of one with a stated number of granules the error may not be known.

        Returns
        -------
        Outcome
            An `EjectionOutcome`, `SingleOutcome` or `TrainOutcome`.

        Raises
        ------
        NumericalError
            When a root of the train relations is not found, or no method has an answer.
        """
        scales = Scales.of(chain, shock.peak_force)
        areas = shock.profile.areas(self.quadrature)
        ratio = scales.rise_time(shock.rise_time)
        scaled = ScaledShock(shock.profile, areas, ratio, self._momentum_parameter)
        model = load("models", self.model)
        with blame("models", model):
            answer: ScaledAnswer = model(scaled, self._settings)
        return self._outcome(shock, chain, scales, scaled, answer)

    def predict_many(self, shocks: Iterable[Shock], chain: Chain | Sequence[Chain]) -> Predictions:
        """The primaries of many shocks, as arrays.

        Whatever depends on the shape alone is computed once for shocks that share a profile, or have equal ones.

        Parameters
        ----------
        shocks : iterable of Shock
            The shocks.
        chain : Chain or sequence of Chain
            One for all of them, or one each.

        Returns
        -------
        Predictions
            In the order of the shocks. One without an answer is listed among its ``failures``.

        Raises
        ------
        InvalidValueError
            When there are not as many chains as shocks, or one of these is something else.
        """
        # One shock needs none of it.
        from shockwave.prediction.many_shocks import predicted

        return predicted(self.model, self._settings, self.quadrature, self._momentum_parameter, shocks, chain)

    @property
    def _settings(self) -> Settings:
        return Settings(self.alpha, self.equal_tolerance, self.wave_threshold, self.rtol)

    @property
    def _momentum_parameter(self) -> float:
        return MOMENTUM * coefficient_of(self.momentum_coefficient) / EXACT_COEFFICIENT

    def _outcome(
        self, shock: Shock, chain: Chain, scales: Scales, scaled: ScaledShock, answer: ScaledAnswer
    ) -> Outcome:
        coefficient = coefficient_of(self.momentum_coefficient)
        checked = conditions(scaled.areas, shock.profile.duration_ratio)
        error, doubts = expected_error(answer, scaled, checked)
        of_chain = chain_warnings(chain, answer.tells_error)
        peaks = [amplitude * shock.peak_force for amplitude in answer.amplitudes]
        steps = [evolve(step, left=step.left * scales.time, right=step.right * scales.time) for step in answer.trace]
        endless = ", on an endless chain" if answer.reason and chain.granules is not None else ""
        common: dict[str, Any] = {
            "model": self.model,
            "method": answer.method or self.model,
            "reason": answer.reason + endless,
            "peak_force": peaks[0],
            "amplification": answer.amplitudes[0],
            "relation": answer.relation,
            "waves": tuple(SolitaryWave.of(peak, chain, coefficient) for peak in peaks),
            "applied_momentum": scaled.impulse * scales.momentum,
            "conditions": checked,
            "trace": tuple(steps),
            "expected_error": None if of_chain else error,
            "exponents": None if answer.sensitivity is None else Exponents.of(answer.sensitivity),
            "areas": scaled.areas,
            "momentum_coefficient": coefficient,
            "scene": Scene.of(shock, chain),
            "warnings": (*shock.profile.notes, *answer.warnings, *doubts, *of_chain),
        }
        if answer.ejection is not None:
            return EjectionOutcome(
                **common,
                virtual_rise_time=answer.ejection.virtual_rise_time * scales.time,
                added_momentum=answer.ejection.added_momentum * scales.momentum,
                window_ratio=answer.ejection.window_ratio,
            )
        if answer.regime == "train":
            return TrainOutcome(**common, roots=tuple(root * shock.peak_force for root in answer.roots))
        return SingleOutcome(**common)
