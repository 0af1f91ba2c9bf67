"""Comparison of section 4 with the simulation."""

from __future__ import annotations

import math
from itertools import zip_longest
from typing import Any

from attrs import asdict, evolve, field, frozen

from shockwave.base.errors import Fault, NotCoveredError, ShockwaveError
from shockwave.base.result import VERSION, cached_property
from shockwave.base.result_tables import Table, column, coordinate
from shockwave.base.text import render
from shockwave.prediction.outcome import Outcome
from shockwave.prediction.predictor import Predictor
from shockwave.prediction.scaled_shock import Regime, Relation
from shockwave.prediction.section4 import relation_of
from shockwave.prediction.section4_outcome import EjectionOutcome, Exponents, Section4Outcome
from shockwave.scenario.published_results import Published
from shockwave.scene.force_limit import LeavingForce
from shockwave.scene.scene import Scene
from shockwave.scene.scene_result import SceneResult
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.scene.solitary_wave import SolitaryWave
from shockwave.simulation.result_parts import MeasuredWave
from shockwave.simulation.simulate import simulate_many, simulate_scene
from shockwave.simulation.simulation_result import Simulation

# Relative change of t0/T0 for the simulated exponents, and largest tolerance of these simulations.
_STEP = 0.01
_STEP_RTOL = 1e-7


@frozen
class WaveErrors:
    """Relative errors of a predicted wave; None where it is not simulated."""

    peak_force: float | None
    momentum: float | None


@frozen
class Errors:
    """Errors of section 4; None for quantities that it does not predict.

    Attributes
    ----------
    peak_force : float or None
        Relative error of the peak force of the leading wave.
    waves : tuple of WaveErrors
        Relative errors of the predicted waves, in their order.
    added_momentum : float or None
        Relative error of the momentum that rebounding granules add.
    exponents : Exponents or None
        Absolute errors of the scaling exponents.
    """

    peak_force: float | None = None
    waves: tuple[WaveErrors, ...] = ()
    added_momentum: float | None = None
    exponents: Exponents | None = None


@frozen(kw_only=True, slots=False, repr=False)
class Comparison(SceneResult):
    """Prediction of section 4 for a shock on a chain, and its simulation.

    Attributes
    ----------
    predicted : Outcome or None
        The prediction by section 4 alone; None where it does not cover the scene.
    simulated : Simulation
        The simulation.
    equal_tolerance : float
        Relative difference up to which peak forces are called equal.
    published : Published or None
        Figures printed in a source for the same scene.
    faults : tuple of Fault
        Features of the scene that section 4 does not cover.
    """

    predicted: Outcome | None
    simulated: Simulation
    equal_tolerance: float = field(default=0.05, repr=False)
    published: Published | None = None
    faults: tuple[Fault, ...] = ()

    _brief = (
        *("simulated.scenario", "simulated.peak_force", "greatest_force.peak_force"),
        *("predicted.peak_force", "relation"),
    )
    _tables = (("waves", "wave"),)

    @property
    def _paper(self) -> Section4Outcome | None:
        """Section 4, where the simulation has a leading wave to compare it with."""
        return None if self.predicted is None or self.simulated.peak_force is None else self.predicted.section4

    @property
    def reason(self) -> str | None:
        """Reason why there is no prediction; None where there is one."""
        return "\n".join(map(str, self.faults)) or None

    @property
    def scene(self) -> Scene:  # type: ignore[override]
        """Shock or impact, and chain."""
        return self.simulated.scene

    @property
    def leaving(self) -> LeavingForce:
        """The simulated transmitted force."""
        return self.simulated.leaving

    @property
    def relation(self) -> Relation | None:
        """Simulated relation of the leading wave to the shock."""
        ratio = self.simulated.amplification
        return None if ratio is None else relation_of(ratio, self.equal_tolerance)

    @property
    def waves(self) -> tuple[MeasuredWave, ...]:
        """Simulated waves that have settled, strongest first."""
        return tuple(wave for wave in self.simulated.waves if wave.error_estimate is not None)

    @property
    def added_momentum(self) -> float | None:
        """Momentum that rebounding granules add to the waves by simulation [N s]; None if it is not known."""
        if self.simulated.options.waves != "train":
            return None
        recoil, error = self.simulated.recoil_momentum, self.simulated.recoil_error
        known = recoil is not None and error is not None and error < abs(recoil)
        return -float(recoil) if known else None

    @property
    def regime(self) -> Regime | None:
        """Regime by simulation: more than one wave, or whether granules rebound; None without the whole train."""
        simulated = self.simulated
        if simulated.peak_force is None or simulated.options.waves != "train" or not simulated.train.is_integrated:
            return None
        return "train" if len(self.waves) > 1 else "ejection" if simulated.ejected_granules else "single"

    @cached_property
    def exponents(self) -> Exponents | None:
        """Simulated scaling exponents, from t0/T0 a percent up and down; None where section 4 has none."""
        simulated = self.simulated
        if self._paper is None or self._paper.exponents is None:
            return None
        shock, options = simulated.shock, simulated.options
        shocks = [evolve(shock, rise_time=shock.rise_time * factor) for factor in (1 - _STEP, 1 + _STEP)]
        rtol = None if options.rtol is None else min(options.rtol, _STEP_RTOL)
        settings = {name: getattr(options, name) for name in ("integrator", "step", "timeout")}
        settings |= {"waves": "primary", "backend": options.wanted_backend}
        results: Any = simulate_many(shocks, simulated.chain, rtol, **settings)
        if any(isinstance(result, ShockwaveError) for result in results):
            return None
        low, high = (math.log(result.peak_force) for result in results)
        # the peak force is F0 f(t0/T0), and T0 scales as A
        return Exponents.of(-(high - low) / (math.log1p(_STEP) - math.log1p(-_STEP)), simulated.chain)

    @cached_property
    def errors(self) -> Errors:
        """Errors of the predictions."""
        paper = self._paper
        if paper is None:
            return Errors()
        prediction, simulated = paper.exponents, self.exponents
        exponents, added = None, None
        if prediction is not None and simulated is not None:
            pairs = ((getattr(prediction, name), getattr(simulated, name)) for name in asdict(prediction))
            exponents = Exponents(*(left - right for left, right in pairs))
        if isinstance(paper, EjectionOutcome) and self.added_momentum is not None:
            added = paper.added_momentum / self.added_momentum - 1
        waves = zip_longest(paper.waves, self.waves[: len(paper.waves)])
        return Errors(
            peak_force=paper.peak_force / self.simulated.peak_force - 1,
            waves=tuple(self._wave_errors(*pair) for pair in waves),
            added_momentum=added,
            exponents=exponents,
        )

    def _wave_errors(self, predicted: SolitaryWave, simulated: MeasuredWave | None) -> WaveErrors:
        if simulated is None:
            return WaveErrors(None, None)
        # a settled wave is the exact solitary wave of its peak force; what neighbours leave at its ends is not its own
        momentum = SolitaryWave.of(simulated.peak_force, self.simulated.chain).momentum
        return WaveErrors(predicted.peak_force / simulated.peak_force - 1, predicted.momentum / momentum - 1)

    @property
    def agrees(self) -> dict[str, bool | None]:
        """Whether relation, regime and number of waves are as predicted; None where they are not known."""
        paper = self._paper
        if paper is None:
            return {"relation": None, "regime": None, "count": None}
        regime = self.regime
        return {
            "relation": paper.relation == self.relation,
            "regime": None if regime is None else paper.regime == regime,
            "count": None if regime is None else len(paper.waves) == len(self.waves),
        }

    @property
    def greatest_force(self) -> Any:
        """Greatest simulated contact force where no peak force of a leading wave is simulated; else None."""
        return self.simulated.greatest_force if self.simulated.peak_force is None else None

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the simulation, which are those of the comparison."""
        return self.simulated.warnings

    def _table(self, name: str) -> Table | None:
        paper = self._paper
        if paper is None:
            table: Table | None = self.simulated._main_table()
            return table
        forces = [
            *zip_longest(*([wave.peak_force for wave in part.waves] for part in (paper, self)), fillvalue=math.nan)
        ]
        places = coordinate("wave", range(len(forces))) | coordinate("source", ["section4", "simulated"])
        return places | column("peak_force", forces, "wave", "source")

    def to_dict(self) -> dict[str, Any]:
        """The document that ``compare --json`` prints."""
        names = "scenario", "predicted", "simulated", "errors", "agrees", "published", "reason", "verdict", "warnings"
        return VERSION | self._document(*names) | ({} if self._paper else {"errors": None, "agrees": None})

    def __str__(self) -> str:
        return render(self, "shockwave.studies.comparison_text:comparison_text")


def compare(
    scene: Scene, predictor: Predictor, options: SimulateOptions, published: Published | None = None
) -> Comparison:
    """Simulate a scene, with the prediction of section 4 where it covers the scene.

    Parameters
    ----------
    scene : Scene
        Shock or impact, and chain.
    predictor, options : Predictor, SimulateOptions
        Settings; the model is ``section-4``.
    published : Published, optional
        Figures printed in a source for the same scene.
    """
    simulated = simulate_scene(scene, options)
    # the simulation has judged a chain that must be elastic
    elastic = scene if not scene.chain.elastic_only else evolve(scene, chain=evolve(scene.chain, elastic_only=False))
    (outcome,) = predictor.predict_scenes([elastic])
    faults = outcome.faults if isinstance(outcome, NotCoveredError) else ()
    if isinstance(outcome, ShockwaveError) and not faults:
        raise outcome
    return Comparison(
        predicted=None if isinstance(outcome, ShockwaveError) else outcome,
        simulated=simulated,
        equal_tolerance=predictor.equal_tolerance,
        published=published,
        faults=tuple(map(scene.place_fault, faults)),
    )
