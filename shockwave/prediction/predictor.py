"""The predictor: simulated values, together with those of section 4."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from threading import Lock
from types import ModuleType
from typing import TYPE_CHECKING, Any, Literal, cast, get_args

from attrs import field, frozen

from shockwave.base.arguments import explain_arguments
from shockwave.base.errors import InvalidValueError, NumericalError, PluginError, ShockwaveError, detach
from shockwave.base.quantity_fields import SI, Value, one_of, plain_text, quantity, text_of
from shockwave.prediction import section4
from shockwave.prediction.outcome import Outcome
from shockwave.prediction.scaled_shock import ScaledShock
from shockwave.prediction.section4_outcome import Exponents, Section4Outcome, outcome_of
from shockwave.profiles.area_conditions import evaluate_conditions
from shockwave.registry.registry import find
from shockwave.scene.chain import Chain, Scales
from shockwave.scene.scene import Excitation, Scene, scenes_of
from shockwave.scene.shock import Shock
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.scene.solitary_wave import EXACT_COEFFICIENT, SolitaryWave, coefficient_of, wave_law
from shockwave.scene.yielding import beyond_elastic

if TYPE_CHECKING:  # a shock on equal granules does not need it
    from shockwave.simulation.simulate import Job

Model = Literal["best", "section-4"]
# Maximum computing time of a scene by compiled code, unless the options have a timeout [s].
_PATIENCE = 10.0


@frozen
class Predictor(Value, kw_only=False):
    """Predict the waves that a shock generates: simulated values, and those of section 4 of Hasan & Nemat-Nasser.

    Parameters
    ----------
    model : "best" or "section-4"
        Simulated values with those of section 4, or section 4 alone, without a simulation.
    momentum_coefficient : "exact", "paper" or float
        Numerical coefficient of A, eq. (4c): 4.344507853978653, 13/3, or another number.
    alpha : "constant" or "literal"
        alpha of section 4.1, which agrees with simulations, or eq. (5c) as printed, of which all roots are given.
    equal_tolerance : float
        Relative difference up to which two sides count as equal.
    wave_threshold : float
        Least peak force of the later waves that section 4 lists, over that of the leading wave.
    quadrature : str, optional
        Name of a registered quadrature, which is used for all integrals, including those with closed forms.

    Raises
    ------
    InvalidValueError, UnknownNameError
        If a setting is out of range or a name unknown.

    Examples
    --------
    >>> import shockwave as sw
    >>> chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
    >>> shock = sw.Shock(
    ...     profile="triangular", duration_ratio=3, peak_force="50 N", rise_time="20 us"
    ... )
    >>> paper = sw.Predictor(momentum_coefficient="paper")
    >>> f"{paper.predict(shock, chain).section4.peak_force:.3f} N"
    '56.517 N'
    """

    model: Model = field(default="best", validator=one_of(*get_args(Model)))
    momentum_coefficient: str | float = plain_text(default="exact")
    alpha: section4.Alpha = field(default="constant", validator=one_of(*get_args(section4.Alpha)))
    equal_tolerance: SI[float] = quantity(
        "", "relative difference up to which forces count as equal", at_least=0, below=1, default=0.05
    )
    wave_threshold: SI[float] = quantity(
        "", "weakest later wave that is listed, relative to the leading wave", above=0, below=1, default=5e-3
    )
    quadrature: str | None = None

    def __attrs_post_init__(self) -> None:
        coefficient_of(self.momentum_coefficient)
        if self.quadrature is not None:
            object.__setattr__(self, "quadrature", find("quadratures", self.quadrature).name)

    @explain_arguments
    def predict(self, shock: Excitation, chain: Chain, options: SimulateOptions | None = None) -> Outcome:
        """Predict the outcome of ``shock`` on ``chain``.

        The simulation runs when one of its values is first read, unless the chain must be elastic.

        Parameters
        ----------
        shock : Shock or Impact
            Profile, peak force and rise time; or a striker.
        chain : Chain
            The chain.
        options : SimulateOptions, optional
            Options of the simulation.

        Raises
        ------
        InvalidValueError
            If the scene or an option is not valid, or forces exceed first yield in a chain that must be elastic.
        NotCoveredError, NumericalError
            If the model is ``section-4``, and it does not cover the scene or has no solution.
        PluginError
            If a profile or another plugin is faulty.
        """
        return self.predict_scene(Scene(excitation=shock, chain=chain), options)

    def predict_scene(self, scene: Scene, options: SimulateOptions | None = None) -> Outcome:
        """Predict the outcome of a scene; see `predict`."""
        (outcome,) = self.predict_scenes([scene], options)
        if isinstance(outcome, ShockwaveError):
            raise outcome
        return outcome

    @explain_arguments
    def predict_many(
        self,
        shocks: Iterable[Excitation],
        chain: Chain | Sequence[Chain],
        options: SimulateOptions | None = None,
        threads: int | None = None,
    ) -> list[Outcome | ShockwaveError]:
        """Predict many shocks; their simulations run together when a number of the first of them is read.

        Parameters
        ----------
        shocks : iterable of Shock or Impact
            The shocks or strikers.
        chain : Chain or sequence of Chain
            One chain for all shocks, or one for each shock.
        options : SimulateOptions, optional
            Options of the simulations.
        threads : int, optional
            Number of threads that run the compiled code. By default one for each core.

        Returns
        -------
        list of Outcome or ShockwaveError
            Outcomes in the order of the shocks; the error of each scene that `predict` refuses.

        Raises
        ------
        InvalidValueError
            If the number of chains differs from that of the shocks, or an argument is of the wrong type.
        """
        return self.predict_scenes(scenes_of(shocks, chain, "predict", threads), options, threads)

    def predict_scenes(
        self,
        scenes: Iterable[Scene | ShockwaveError],
        options: SimulateOptions | None = None,
        threads: int | None = None,
    ) -> list[Outcome | ShockwaveError]:
        """Predict many scenes; see `predict_many`. Errors among the scenes are passed on."""
        options = SimulateOptions() if options is None else options
        if not isinstance(options, SimulateOptions):
            raise InvalidValueError.of("options", f"must be SimulateOptions (got {text_of(options)})")
        engine = _Engine([], options, threads)
        outcomes = [self._attempt(engine, scene) for scene in scenes]
        return [self._check_elastic(outcome) for outcome in outcomes]

    @explain_arguments
    def section4(self, shock: Shock, chain: Chain) -> Section4Outcome:
        """Prediction of section 4 for a shock on a chain; see `relations` for the errors."""
        return self.relations(Scene(excitation=shock, chain=chain))

    def relations(self, scene: Scene, simulated_force: Any = lambda: None) -> Section4Outcome:
        """Prediction of section 4; ``simulated_force`` is the function that returns the simulated peak force.

        Raises
        ------
        NotCoveredError
            If the scene has features that section 4 does not cover; all are listed.
        NumericalError
            If a root of the relations for trains is not found, or the peak force is too small.
        """
        chain = scene.covered_chain("section 4", laws=True, packings=True)
        shock = cast(Shock, scene.shock)
        scales = Scales.of(chain, shock.peak_force)
        coefficient = coefficient_of(self.momentum_coefficient)
        areas = shock.profile.areas(self.quadrature)
        law = wave_law(chain.exponent)
        unit = law.momentum * coefficient / EXACT_COEFFICIENT
        scaled = ScaledShock(shock.profile, areas, scales.rise_time(shock.rise_time), unit, law)
        force = shock.peak_force * chain.contact_share
        wave = SolitaryWave.of(force, chain, coefficient)
        try:
            answer = section4.predict(scaled, self.alpha, self.equal_tolerance, self.wave_threshold)
            waves = tuple(wave.stronger(ratio, chain.exponent) for ratio in answer.amplitudes)
        except ZeroDivisionError:
            raise NumericalError("the peak force by section 4 is too small for floating-point numbers") from None
        common: dict[str, Any] = {
            "peak_force": answer.amplitudes[0] * force,
            "amplification": answer.amplitudes[0],
            "relation": answer.relation,
            "waves": waves,
            "conditions": evaluate_conditions(areas, float(shock.profile.duration_ratio)),
            "trace": tuple(step.in_units(scales.time) for step in answer.trace),
            "exponents": None if answer.sensitivity is None else Exponents.of(answer.sensitivity, chain),
            "areas": areas,
            "momentum_coefficient": coefficient,
            "wave_time": unit * scales.time,
            "warnings": answer.warnings,
            "simulated_force": simulated_force,
        }
        return outcome_of(answer, common, scales, force)

    def _attempt(self, engine: _Engine, scene: Scene | ShockwaveError) -> Outcome | ShockwaveError:
        if isinstance(scene, ShockwaveError):
            return scene
        try:
            alone = self.model == "section-4"
            simulation = None if alone else engine.add(scene)
            outcome = Outcome(scene=scene, predictor=self, options=engine.options, simulation=simulation)
            _ = outcome.section4 if alone else None
            return outcome
        except ShockwaveError as error:
            return detach(error)

    def _check_elastic(self, outcome: Outcome | ShockwaveError) -> Outcome | ShockwaveError:
        """The outcome, or the error of one with forces beyond first yield in a chain that must be elastic."""
        if isinstance(outcome, ShockwaveError) or not outcome.chain.elastic_only:
            return outcome
        if outcome.simulation is None:
            return beyond_elastic(outcome.chain, partial(getattr, outcome, "yielding")) or outcome
        try:
            result = outcome.simulation()
        except PluginError as error:
            return error
        return result if isinstance(result, InvalidValueError) else outcome


def _measurement() -> ModuleType:
    """The module that simulates, which section 4 alone does not need."""
    from shockwave.simulation import simulate

    return simulate


class _Engine:
    """Simulations of scenes with the same options, which run together when the first result is read."""

    def __init__(self, jobs: list[Job], options: SimulateOptions, threads: int | None = None) -> None:
        self.jobs, self.options, self.threads = jobs, options, threads
        self.results: list[Any] | None = None
        self._lock = Lock()

    def add(self, scene: Scene) -> PendingSimulation:
        """Add a scene; see `shockwave.simulation.simulate.job_of` for the errors."""
        self.jobs.append(_measurement().job_of(self.options, scene))
        return PendingSimulation(self, len(self.jobs) - 1)

    def result(self, index: int) -> Any:
        """Result of a scene, or its error."""
        with self._lock:
            if self.results is None:
                self.results = _measurement().run_jobs(self.jobs, self.options, self.threads, _PATIENCE)
                self.jobs = [job._replace(problem=None, case=None) for job in self.jobs]  # to free their memory
        return self.results[index]


class PendingSimulation:
    """The result of one scene of an engine.

    When pickled, it takes only this scene and its result along: a copy that has no result yet runs alone.
    """

    def __init__(self, engine: _Engine, index: int) -> None:
        self._engine, self._index = engine, index

    def __call__(self) -> Any:
        """Result of the simulation, or its error; runs the engine at the first call.

        Raises
        ------
        PluginError
            If a plugin is faulty.
        """
        result = self._engine.result(self._index)
        if isinstance(result, PluginError):
            raise result
        return result

    def __reduce__(self) -> Any:
        job, results = self._engine.jobs[self._index], self._engine.results
        result = None if results is None else results[self._index]
        if isinstance(result, ShockwaveError):
            result = None  # it is found again
        return _restore, (self._engine.options, job.scene, result)


def _restore(options: SimulateOptions, scene: Scene, result: Any) -> PendingSimulation:
    engine = _Engine([], options)
    simulation = engine.add(scene)
    engine.results = None if result is None else [result]
    return simulation
