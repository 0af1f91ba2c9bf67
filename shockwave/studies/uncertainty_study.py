"""Uncertainty of the peak force of the leading wave, or of the forces in a chain, by simulations of drawn scenes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, SupportsFloat

import numpy as np
from attrs import define, evolve, field

from shockwave.base.errors import InvalidValueError, ShockwaveError, below
from shockwave.base.numerics import FloatArray
from shockwave.base.progress import logger, report_progress
from shockwave.base.quantities import STRUCTURE, YIELD, Quantity
from shockwave.base.quantity_fields import Declaration, join
from shockwave.base.text import si
from shockwave.scenario.scenario import Scenario, SceneArgument
from shockwave.scenario.uncertainty_block import Spread, read
from shockwave.scenario.variations import Family
from shockwave.scene.chain import Chain
from shockwave.scene.force_limit import LeavingForce, Limit, limit_of, verdict
from shockwave.scene.yielding import law_notes
from shockwave.studies import quasi_monte_carlo as sampling
from shockwave.studies import varied_scenes
from shockwave.studies.quantities import figures_of, find_target, list_reported, quantities_of
from shockwave.studies.quasi_monte_carlo import WORK, Distribution
from shockwave.studies.uncertainty_result import Estimate, Parameter, QuantityStatistics, Sensitivity, Uncertainty
from shockwave.studies.warning_groups import WarningGroups

_DRAWS = Declaration("", "number of draws", at_least=256, at_most=2**18, whole=True)
# Default number of draws for equal granules, where a simulation takes less than a millisecond, and for other chains.
_EQUAL_DRAWS = 1024
_CHAIN_DRAWS = 512
# Longest shock on equal granules [characteristic times]: thousands of longer simulations take hours.
_LONGEST = 300.0
# Step of a finite difference, over the standard deviation of the parameter: late collisions make slopes over smaller
# steps irregular. Tolerance of its simulations.
_STEP = 0.3
_STEP_RTOL = 1e-8
# Probabilities of the values between which a parameter must change a quantity.
_ENDS = (0.01, 0.99)
# Standard deviation, over the error of a simulation, of a spread that the error may have caused.
_NOISE = 3.0
# The force that a limit is for.
_LIMITED = {"chain": Quantity("leaving.value", "N"), "spring": STRUCTURE[2]}


def uncertainty(
    scene: SceneArgument,
    chain: Chain | None = None,
    spreads: Mapping[str, Any] | None = None,
    *,
    draws: int | None = None,
    seed: int = 0,
    rtol: float = 1e-4,
    limit: Limit | SupportsFloat | str | None = None,
    quantities: Sequence[str] = (),
) -> Uncertainty:
    """Distribution of the peak force of the leading wave, or of the forces in a chain where it has no limit.

    Parameters
    ----------
    scene : Scenario, path-like, Shock or Impact
        A scenario or its file, or a shock or striker on ``chain``.
    chain : Chain, optional
        The chain, if ``scene`` is a shock or a striker.
    spreads : mapping, optional
        Dotted names and distributions, as in the ``uncertainty`` block, which they replace.
    draws : int, optional
        Number of scenes to draw, a power of 2 from 256 to 262144; by default 1024 for a shock on equal granules with
        free ends, otherwise 512. Each is simulated, and as many again for every parameter.
    seed : int
        Seed of the random numbers; the same seed gives the same digits.
    rtol : float
        Tolerance of a simulation, 1e-7 to 1e-2.
    limit : Limit, float or str, optional
        Limit on the transmitted force, or this force [N]; by default that of the scenario. With a
        limit, the probability that it is reached is computed.
    quantities : sequence of str
        Names of further quantities, or ratios of two, such as ``sensors[1].peak / sensors[0].peak``.

    Returns
    -------
    Uncertainty
        Statistics in SI units, with their sampling errors.

    Raises
    ------
    InvalidValueError
        If a value is out of range, no parameter is uncertain, or a drawn scene is not valid.
    NumericalError
        If a simulation fails.

    Examples
    --------
    >>> import shockwave as sw
    >>> chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
    >>> shock = sw.Shock(
    ...     profile="triangular", duration_ratio=3, peak_force="50 N", rise_time="20 us"
    ... )
    >>> result = sw.uncertainty(shock, chain, {"chain.radius": "1 %"}, draws=256)
    >>> f"{result.peak_force.mean.value:.1f} N"
    '53.6 N'
    """
    scenario = varied_scenes.scenario_of(scene, chain)
    scenario = evolve(scenario, limit=limit_of(limit) or scenario.limit)
    equal = scenario.scene.uniform is not None
    draws = _DRAWS.check("draws", (_EQUAL_DRAWS if equal else _CHAIN_DRAWS) if draws is None else draws)
    seed, rtol = varied_scenes.SEED.check("seed", seed), varied_scenes.RTOL.check("rtol", rtol)
    if draws.bit_count() > 1:
        raise InvalidValueError.of("draws", f"must be a power of 2, such as 1024 (got {draws})")
    distributions = [Distribution.of(spread, scenario) for spread in _spreads(scenario, spreads)]
    report_progress(WORK, 0, draws * (len(distributions) + 2))
    logger.info("uncertainty of %s: %d scenes", scenario.name or "the scene", draws * (len(distributions) + 2))
    named = [find_target(name, list_reported(scenario), "quantities") for name in quantities]
    return _result(UncertainScenes.of(scenario, distributions, rtol, named), draws, seed, rtol)


def _spreads(scenario: Scenario, block: Mapping[str, Any] | None) -> tuple[Spread, ...]:
    if block is None and scenario.uncertainty:
        return scenario.uncertainty
    if block is None:
        remedy = "add a block such as uncertainty: {shock.peak_force: 5 %}"
        raise InvalidValueError.of("uncertainty", f"must name the uncertain parameters (got nothing; {remedy})")
    for name in block if isinstance(block, Mapping) else ():
        varied_scenes.check_parameter(name, scenario, "uncertainty")
    with below("uncertainty"):
        return read(block, varied_scenes.data_of(scenario))


@define
class UncertainScenes:
    """Scenes about that of a scenario, with what is read from their simulations."""

    scenario: Scenario
    distributions: Sequence[Distribution]
    #: Simulation of the scenario itself.
    nominal: Any
    #: Quantities that are read.
    quantities: list[Quantity]
    family: Family
    warnings: WarningGroups = field(factory=WarningGroups)

    @classmethod
    def of(
        cls, scenario: Scenario, distributions: Sequence[Distribution], rtol: float, named: Sequence[Quantity]
    ) -> UncertainScenes:
        """Simulate the scenario itself; ``named`` quantities are read before its usual ones."""
        (nominal,) = varied_scenes.simulate_all([scenario], scenario.simulate, rtol, _LONGEST)
        quantities = list(dict.fromkeys((*named, *quantities_of(scenario, nominal))))
        return cls(scenario, distributions, nominal, quantities, Family(scenario))

    def evaluate(self, values: Mapping[str, FloatArray], rtol: float) -> tuple[FloatArray, FloatArray]:
        """Quantities, shape (quantities, n), and their greatest relative errors; see `quasi_monte_carlo.Evaluate`.

        The ratio to first yield follows, of contacts where it is known, and, with a limit, the transmitted force and
        its bound after the simulated time.
        """
        rows = zip(*(column.tolist() for column in values.values()), strict=True)
        scenes = [self.family.scenario(dict(zip(values, row, strict=True))) for row in rows]
        results = varied_scenes.simulate_all(scenes, self.scenario.simulate, rtol, _LONGEST)
        for result in results:
            self.warnings.add(result.wave_warnings)
        limit = self.scenario.limit
        # of first yield not `figures_of`, which has none while other contacts may yield first
        readers: list[Callable[[Any], tuple[float, float] | None]]
        readers = [partial(figures_of, each) for each in self.quantities]
        readers += [each.figures for each in YIELD[: self.nominal.yielding is not None]]
        if limit is not None:
            readers.append(partial(figures_of, _LIMITED[limit.at]))
        figures = [[read(result) or (math.nan, 0.0) for result in results] for read in readers]
        if limit is not None:
            figures.append([(_bound_later_force(limit.force_of(result.leaving)), 0.0) for result in results])
        read_values, errors = np.moveaxis(np.array(figures), -1, 0)
        return read_values, errors.max(axis=1)

    def slopes(self) -> list[list[Estimate]]:
        """Derivatives of the quantities with respect to each parameter, at the nominal values."""
        nominal = {each.name: np.array([each.value]) for each in self.distributions}
        slopes = []
        for each in self.distributions:
            ends = sampling.scenes_about(each, _STEP, nominal)
            heights = self.evaluate(ends, _STEP_RTOL)[0][: len(self.quantities)]
            slopes.append([sampling.difference(ends[each.name], row, _STEP_RTOL * abs(row[0])) for row in heights])
        return slopes

    def check_effects(self, rtol: float) -> None:
        """Raise `InvalidValueError` for a parameter that changes none of the quantities."""
        nominal = {each.name: np.repeat(each.value, 2) for each in self.distributions}
        for each in self.distributions:
            ends = each.at(np.array(_ENDS))
            try:
                figures, _ = self.evaluate(nominal | {each.name: ends}, rtol)
            except ShockwaveError:
                continue  # reported for the samples
            if np.array_equal(figures[:, 0], figures[:, 1], equal_nan=True):
                same = join((quantity.label for quantity in self.quantities), "and")
                low, high = (si(end, each.spread.variable.unit or "") for end in ends.tolist())
                problem = f"must change a quantity of the result (got the same {same} for {low} and {high}; delete it)"
                raise InvalidValueError.of(("uncertainty", each.name), problem)
        self.warnings = WarningGroups()

    def all_warnings(self) -> list[str]:
        """Warnings of the nominal scene, and those of other kinds of the drawn scenes."""
        warnings = self.nominal.wave_warnings
        return [*warnings, *self.warnings.sentences(besides=warnings)]


def _result(scenes: UncertainScenes, draws: int, seed: int, rtol: float) -> Uncertainty:
    """Simulate the drawn scenes and those around the nominal one."""
    scenario, distributions, nominal = scenes.scenario, scenes.distributions, scenes.nominal
    scenes.check_effects(rtol)
    points, outputs, errors = sampling.draw_samples(distributions, draws, seed, partial(scenes.evaluate, rtol=rtol))
    evaluations = draws * (len(distributions) + 2)
    warnings, exceedance, judgement = scenes.all_warnings(), None, None
    if scenario.limit is not None:
        forces, later, leaving = outputs[:, -2, 0], outputs[:, -1, 0], nominal.leaving
        judgement = verdict(scenario.limit, leaving)
        if not np.isnan(forces).all():
            force = scenario.limit.force_of(leaving)
            exceedance, judgement = sampling.exceedance(scenario.limit, force, forces, float(errors[-2]), later)
    yields = None
    if nominal.yielding is not None:
        flags = (outputs[:, len(scenes.quantities), 0] > 1).astype(float)
        yields = Estimate(*sampling.estimates(np.mean, flags).tolist())
    outputs = outputs[:, : len(scenes.quantities)]
    statistics, notes = _statistics(scenes, outputs, errors)
    return Uncertainty(
        scenario=scenario.name,
        draws=draws,
        seed=seed,
        evaluations=evaluations,
        parameters=tuple(map(_parameter, distributions)),
        quantities=tuple(statistics),
        warnings=(*warnings, *law_notes(scenario.chain), *notes, *sampling.cut_warnings(distributions)),
        exceedance=exceedance,
        verdict=judgement,
        yield_probability=yields,
        values=dict(zip([each.name for each in distributions], points, strict=True)),
        outputs={each.name: outputs[:, i, 0].ravel() for i, each in enumerate(scenes.quantities)},
    )


def _statistics(
    scenes: UncertainScenes, outputs: FloatArray, errors: FloatArray
) -> tuple[list[QuantityStatistics], list[str]]:
    """Statistics of the quantities that all drawn scenes have, and notes on them and on the others."""
    slopes, shares = scenes.slopes(), sampling.estimates(sampling.indices, outputs)
    statistics, notes = [], []
    for index, (quantity, gradient) in enumerate(zip(scenes.quantities, zip(*slopes, strict=True), strict=True)):
        if not (np.isfinite(outputs[:, index]).all() and all(math.isfinite(slope.value) for slope in gradient)):
            notes.append(f"the {quantity.label} is left out, because some scenes have none")
            continue
        value, _ = figures_of(quantity, scenes.nominal) or (0.0, 0.0)
        pairs = zip(scenes.distributions, gradient, shares[:, :, index].swapaxes(0, 1), strict=True)
        each = QuantityStatistics(
            name=quantity.name,
            unit=quantity.unit.replace(" ", "*"),
            label=quantity.label,
            **sampling.statistics(outputs[:, index, 0]),
            nominal=value,
            model_error=float(errors[index]),
            sensitivities=tuple(_sensitivity(parameter, slope, value, part) for parameter, slope, part in pairs),
        )
        statistics.append(each)
        if each.sd.value <= _NOISE * each.model_error * abs(each.nominal):
            notes.append(f"the spread of the {quantity.label} is within the error of the simulations")
    return statistics, notes


def _bound_later_force(force: LeavingForce) -> float:
    """Bound of a transmitted force after the simulated time [N], infinite where none is known."""
    return math.inf if force.high is None else force.later


def _parameter(each: Distribution) -> Parameter:
    unit = each.spread.variable.unit or ""
    return Parameter(name=each.name, unit=unit, spread=str(each.spread), value=each.value, sd=each.sd)


def _sensitivity(each: Distribution, slope: Estimate, value: float, indices: FloatArray) -> Sensitivity:
    """Sensitivity of a quantity with this ``value`` and ``slope``, from indices of shape (2, value and error)."""
    first, total = (Estimate(*pair) for pair in indices.tolist())
    scale = each.value / value
    return Sensitivity(
        name=each.name,
        exponent=slope.value * scale if each.value else None,
        exponent_error=slope.error * abs(scale) if each.value else None,
        first=first,
        total=total,
    )
