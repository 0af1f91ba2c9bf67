"""The predictor: outcomes of shocks on chains without integration of the equations of motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from functools import cache, partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from attrs import evolve, frozen

from shockwave.chain.chain import HERTZ, Chain, Scales
from shockwave.chain.solitary_wave import EXACT_COEFFICIENT, SolitaryWave, coefficient_of, wave_law
from shockwave.chain.yielding import beyond_elastic
from shockwave.errors import Fault, InvalidValueError, NotCoveredError
from shockwave.fields import quantity
from shockwave.plausibility import unusual_warnings
from shockwave.prediction.accuracy_of_many import Ranges, accuracies, contact_forces
from shockwave.prediction.expected_error import (
    FIRST_CONTACTS,
    accuracy_with_exponent,
    failed_conditions,
    in_chain,
    unbounded,
    warning_of,
)
from shockwave.prediction.model_interface import (
    NO_ANSWER,
    Model,
    Peaks,
    ScaledAnswer,
    ScaledShock,
    ScaledShocks,
    Settings,
    Shocks,
    one_by_one,
)
from shockwave.prediction.outcome import (
    Accuracy,
    EjectionOutcome,
    Estimate,
    Exponents,
    Outcome,
    Predictions,
    SingleOutcome,
    TrainOutcome,
    first_yield,
)
from shockwave.prediction.prediction_columns import PredictionColumns, prediction_columns
from shockwave.profiles.base import Areas, ShockProfile
from shockwave.profiles.conditions import conditions
from shockwave.profiles.guard import is_value
from shockwave.profiles.shock import Shock
from shockwave.registry import blame, find, load
from shockwave.scene_summary import ChainScene, Scene, check_scene, scenes_of

if TYPE_CHECKING:  # a shock on equal granules does not need it
    from shockwave.chain.impact import Impact

_RTOL = "relative tolerance of the peak force of the leading wave; for model auto, 1e-3 if omitted"


@frozen
class Predictor:
    """Predict the solitary waves that a shock generates, by section 4 of Hasan & Nemat-Nasser or another model.

    Parameters
    ----------
    model : str
        Name of a registered model.
    rtol : float, optional
        Allowed relative error of the peak force of the leading wave, 1e-8 to 0.5, for a model that selects a method by
        it, such as ``auto`` (default 1e-3). Other models refuse it.
    momentum_coefficient : "exact", "paper" or float
        Leading number of A, eq. (4c): 4.344507853978653, 13/3, or another number.
    alpha : "constant" or "literal"
        alpha of section 4.1, which agrees with simulations, or eq. (5c) as printed, of which all roots are given.
    equal_tolerance : float
        Relative difference up to which two sides are called equal.
    wave_threshold : float
        Least peak force of the later waves that are listed, over that of the leading wave.
    quadrature : str, optional
        Name of a registered quadrature, which is used for all integrals, including those with closed forms.

    Raises
    ------
    InvalidValueError, UnknownNameError
        If a setting is out of range or a name unknown.
    """

    model: str = "section-4"
    rtol: float | None = quantity("", _RTOL, at_least=1e-8, at_most=0.5, optional=True, default=None)
    momentum_coefficient: str | float = "exact"
    alpha: Literal["constant", "literal"] = "constant"
    equal_tolerance: float = quantity("", "relative difference called equal", at_least=0, below=1, default=0.05)
    wave_threshold: float = quantity(
        "", "weakest later wave that is listed, relative to the leading wave", above=0, below=1, default=5e-3
    )
    quadrature: str | None = None

    def __attrs_post_init__(self) -> None:
        model = find("models", self.model)
        takes = model.takes.split()
        object.__setattr__(self, "model", model.name)  # which may differ in case
        coefficient_of(self.momentum_coefficient)
        if self.quadrature is not None:
            object.__setattr__(self, "quadrature", find("quadratures", self.quadrature).name)
        if self.alpha not in ("constant", "literal"):
            raise InvalidValueError.of("alpha", f"must be 'constant' or 'literal' (got {self.alpha!r})")
        for name, default in (("alpha", "constant"), ("rtol", None)):
            value = getattr(self, name)
            if value != default and name not in takes:
                rule = f"must be left out for model {self.model!r}, which does not use it"
                raise InvalidValueError.of(name, f"{rule} (got {value!r})")

    def predict(self, shock: Shock | Impact, chain: Chain) -> Outcome:
        """Predict the outcome of ``shock`` on ``chain``.

        Parameters
        ----------
        shock : Shock or Impact
            Profile, peak force and rise time; or a striker, whose waves follow from a law of its own with every model.
        chain : Chain
            Material and radius, and a fixed wall if there is one; for a finite chain the expected error may not be
            known.

        Returns
        -------
        Outcome
            An `EjectionOutcome`, `SingleOutcome` or `TrainOutcome`; a `StrikerOutcome` for an impact.

        Raises
        ------
        NotCoveredError
            If the scene has features beyond equal granules with free ends or a fixed wall.
        InvalidValueError
            If ``shock`` is not a Shock or ``chain`` not a Chain.
        NumericalError
            If a root of the relations for trains is not found, or no method has an answer.
        """
        (found,) = self.predict_each([shock], [chain])
        if isinstance(found, Exception):
            raise found
        return found

    def predict_each(self, shocks: Sequence[Shock | Impact], chains: Sequence[Chain]) -> list[Outcome | Exception]:
        """Predict the outcome of each of ``shocks`` on its chain, or return its error; see `predict`.

        The accuracies of all outcomes are computed together, when the first of them is accessed.
        """
        model = load("models", self.model)
        scaled: list[ScaledShock] = []
        answers: list[ScaledAnswer] = []
        found: list[Outcome | Exception] = []
        ranges = Ranges(scaled, answers, self._settings)
        for shock, given in zip(shocks, chains, strict=True):
            try:
                if not isinstance(shock, Shock):
                    from shockwave.prediction.striker import striker_outcome  # not needed for a shock

                    found.append(striker_outcome(shock, given, self.name))
                    continue
                chain = self._covered(shock, given)
                one = self._scaled(shock, chain)
                with blame("models", model):
                    answer: ScaledAnswer = model(one, self._settings)
            except Exception as error:
                found.append(error)
                continue
            scaled.append(one)
            answers.append(answer)
            found.append(self._outcome(shock, chain, given, one, answer, partial(ranges, len(scaled) - 1)))
        for index, each in enumerate(found):
            if isinstance(each, Outcome):
                found[index] = beyond_elastic(chains[index], partial(getattr, each, "yielding")) or each
        return found

    @property
    def name(self) -> str:
        """The model, for messages."""
        return f"model {self.model!r}"

    @property
    def contact(self) -> Literal["stiffness", "exponent"]:
        """Contact forces that the model covers; see `shockwave.chain.coverage.Contact`."""
        return "exponent" if "exponent" in find("models", self.model).takes.split() else "stiffness"

    def _covered(self, shock: Shock, chain: Chain) -> Chain:
        """The chain as a number of equal granules before a wall; raises NotCoveredError for further features."""
        equal = isinstance(chain, Chain) and chain.is_uniform and isinstance(shock, Shock) and not shock.profile.pulls
        if isinstance(chain, Chain) and not equal:
            from shockwave.chain.coverage import predictable  # not needed for equal granules

            chain = predictable(chain, shock, self.name, self.contact)
        check_scene(shock, chain)
        return chain

    def _scaled(self, shock: Shock, chain: Chain) -> ScaledShock:
        areas = shock.profile.areas(self.quadrature)
        ratio = Scales.of(chain, shock.peak_force).rise_time(shock.rise_time)
        return ScaledShock(shock.profile, areas, ratio, self._momentum_parameter(chain.exponent), chain.exponent)

    def _outcome(
        self,
        shock: Shock,
        chain: Chain,
        given: Chain,
        scaled: ScaledShock,
        answer: ScaledAnswer,
        ranges: Callable[[], Sequence[float]],
    ) -> Outcome:
        """The outcome on the ``given`` chain, which amounts to ``chain``, and a wall if it has one."""
        scales = Scales.of(chain, shock.peak_force)
        coefficient = coefficient_of(self.momentum_coefficient)
        force = shock.peak_force * chain.contact_share
        unit = SolitaryWave.of(force, chain, coefficient)
        chain_assumed = ", on an endless chain" if answer.reason and chain.count is not None else ""
        walled = chain if given.end is None else evolve(chain, end=given.end)
        common: dict[str, Any] = {
            "model": self.model,
            "method": answer.method or self.model,
            "reason": answer.reason + chain_assumed,
            "peak_force": answer.amplitudes[0] * force,
            "amplification": answer.amplitudes[0],
            "relation": answer.relation,
            "waves": tuple(unit.stronger(ratio, chain.exponent) for ratio in answer.amplitudes),
            "applied_momentum": scaled.impulse * scales.momentum,
            "conditions": conditions(scaled.areas, shock.profile.duration_ratio),
            "trace": tuple(step.in_units(scales.time) for step in answer.trace),
            "exponents": None if answer.sensitivity is None else Exponents.of(answer.sensitivity, chain),
            "areas": scaled.areas,
            "momentum_coefficient": coefficient,
            "scene": Scene.of(shock, chain) if given.end is None else ChainScene.of(shock, given),
            "wall": None if given.end is None else given.end.stiffness_ratio(chain.material),
            "first_yield": partial(first_yield, walled),
            "on_demand": partial(self._accuracy, shock, walled, scaled, answer, ranges),
        }
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

    def _accuracy(
        self,
        shock: Shock,
        chain: Chain,
        scaled: ScaledShock,
        answer: ScaledAnswer,
        ranges: Callable[[], Sequence[float]],
    ) -> Accuracy[Any, Any]:
        if chain.exponent != HERTZ:
            return accuracy_with_exponent(shock, chain, scaled, answer, self.model)
        *values, least, most = ranges()
        force = shock.peak_force * chain.contact_share
        problem, *widened = in_chain(chain, scaled, values, (least, most))
        *values, least, most = np.hstack(widened).tolist()
        peak, low, high = (value * force for value in values)
        problem = problem or (unbounded(scaled, force) if math.isnan(peak) else "")
        failed = "" if answer.states_error else failed_conditions(scaled)
        warnings = [*[failed] * bool(failed), *answer.warnings, *[warning_of(problem)] * bool(problem)]
        own = answer.states_error and answer.expected_error is not None
        method = (answer.method or self.model) if own else "moments"
        return Accuracy(
            None if problem else Estimate(peak, low, high, method),
            problem or None,
            None if problem or math.isinf(least) else (least, most),
            (
                *shock.profile.notes,
                *unusual_warnings(shock, chain),
                *warnings,
                *[FIRST_CONTACTS] * (chain.count is not None),
            ),
        )

    def predict_many(self, shocks: Iterable[Shock], chain: Chain | Sequence[Chain]) -> Predictions:
        """Predict the leading waves of many shocks, as arrays.

        Quantities that depend only on the shape are computed once for all shocks with equal profiles.

        Parameters
        ----------
        shocks : iterable of Shock
            The shocks.
        chain : Chain or sequence of Chain
            One chain for all shocks, or one for each shock.

        Returns
        -------
        Predictions
            Results in the order of the shocks; ``failures`` lists the shocks without an answer.

        Raises
        ------
        InvalidValueError
            If the number of chains differs from that of the shocks, or an argument is of the wrong type.
        """
        scenes = scenes_of(shocks, chain, "predict")
        shocks, given = [shock for shock, _ in scenes], [each for _, each in scenes]
        chains = list(given)
        together = self._scaled_many(shocks, chains)
        scaled, places, failures = together.shocks, together.places, together.failures
        model, leading = load("models", self.model), evolve(self._settings, wave_threshold=math.inf)
        with blame("models", model):
            at_once = isinstance(model, Model)
            found: Peaks = model.many(scaled, leading) if at_once else one_by_one(model, scaled, leading)
        failures.update({places[index]: reason for index, reason in found.failures.items()})
        results = Peaks.of(len(shocks))
        results.amplification[places] = found.amplification
        results.method[places] = np.where(found.method == "", self.model, found.method)
        forces = contact_forces(shocks, chains)
        elastic = [index for index, each in enumerate(given) if each.elastic_only]
        alone = self.predict_each([shocks[index] for index in elastic], [given[index] for index in elastic])
        for index, outcome in zip(elastic, alone, strict=True):
            if isinstance(outcome, Exception):
                failures.setdefault(index, str(outcome))
                results.amplification[index] = np.nan
        results.method[list(failures)] = ""
        return Predictions(
            model=self.model,
            peak_force=results.amplification * forces,
            amplification=results.amplification,
            method=results.method,
            failures=tuple(sorted(failures.items())),
            on_demand=partial(accuracies, shocks, given, scaled, found, places),
        )

    def columns(self, shocks: Sequence[Shock], chains: Sequence[Chain]) -> PredictionColumns | None:
        """Predict shocks, each on its chain, with all results in columns; None for a model that has no such results."""
        model = load("models", self.model)
        given, chains = chains, list(chains)
        if not (isinstance(model, Model) and model.complete) or any(chain.elastic_only for chain in chains):
            return None
        together = self._scaled_many(shocks, chains)
        with blame("models", model):
            return prediction_columns(model.many(together.shocks, self._settings), together, shocks, given)

    def _scaled_many(self, shocks: Sequence[Shock], chains: list[Chain]) -> ScaledShocks:
        """Scaled shocks; replaces chains that amount to equal granules."""
        scales = cache(Scales.of)
        failures: dict[int, str] = {}
        # keys: the profile, or its identity if equal profiles may differ in their values
        shapes: dict[object, tuple[int, ShockProfile, Areas]] = {}
        numbers: dict[int, int] = {}  # identity of a profile -> number of its shape
        given: dict[int, tuple[int, float]] = {}  # index of a shock -> number of its shape, rise time
        units: list[Scales] = []
        for index, (shock, each) in enumerate(zip(shocks, chains, strict=True)):
            check_scene(shock, each)
            try:
                if not each.is_uniform or shock.profile.pulls:
                    chains[index] = each = self._covered(shock, each)
                    if each.exponent != HERTZ:
                        rule = "must be 1.5 where many shocks are predicted at once"
                        got = f"got {each.exponent:g}; predict one at a time"
                        raise NotCoveredError([Fault("chain.contact.exponent", f"{rule} ({got})")])
                profile = shock.profile
                unit = scales(each, shock.peak_force)
                rise_time = unit.rise_time(shock.rise_time)
                if id(profile) not in numbers:
                    key = profile if is_value(profile) else id(profile)
                    if key not in shapes:
                        shapes[key] = len(shapes), profile, profile.areas(self.quadrature)
                    numbers[id(profile)] = shapes[key][0]
            except NO_ANSWER as error:
                failures[index] = str(error)
            else:
                given[index] = numbers[id(profile)], rise_time
                units.append(unit)
        scaled = Shocks(
            profiles=tuple(profile for _, profile, _ in shapes.values()),
            areas=tuple(areas for _, _, areas in shapes.values()),
            shapes=np.array([number for number, _ in given.values()], dtype=np.intp),
            rise_times=np.array([time for _, time in given.values()], dtype=float),
            momentum_parameter=self._momentum_parameter(HERTZ),
        )
        return ScaledShocks(scaled, list(given), units, failures)

    @property
    def _settings(self) -> Settings:
        return Settings(self.alpha, self.equal_tolerance, self.wave_threshold, self.rtol)

    def _momentum_parameter(self, exponent: float) -> float:
        return wave_law(exponent).momentum * coefficient_of(self.momentum_coefficient) / EXACT_COEFFICIENT
