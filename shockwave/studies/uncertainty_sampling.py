"""Uncertainty of the peak force of the leading wave, or of the forces in a chain without a leading wave."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from attrs import asdict, evolve

from shockwave.chain.chain import Chain
from shockwave.errors import Fault, InvalidValueError
from shockwave.fields import Quantity as Number
from shockwave.limit import WAVE, Limit, limit_of, verdict
from shockwave.log import logger
from shockwave.progress import progressed
from shockwave.quadrature import FloatArray
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_argument import Scene
from shockwave.scenario.scene_family import Family
from shockwave.scenario.uncertainty import Spread, read
from shockwave.scenario.value_conversion import WrongsError
from shockwave.scenario.yaml_document import dotted
from shockwave.studies import sampling, varied_scenes
from shockwave.studies.quantities import Quantity, quantities_of
from shockwave.studies.sampling import WORK, Distribution
from shockwave.studies.scaling_exponents import POWERS, Exponents
from shockwave.studies.uncertainty_result import (
    Estimate,
    Parameter,
    QuantityStatistics,
    Sensitivity,
    Share,
    SimulatedUncertainty,
    Uncertainty,
)
from shockwave.studies.universal_curve import RTOL

_DRAWS = Number("", "number of draws", at_least=256, at_most=2**18, whole=True)
# Default number of draws from a curve, and if each is a simulation of a chain beyond equal spheres.
_OF_CURVE = 4096
_OF_SIMULATIONS = 512
# Outputs of a scene with a leading wave.
_OUTPUTS = ("peak_force", "amplification")
# Step of a finite difference, over the standard deviation of the parameter, and tolerance of its simulations.
_STEP = 1e-2
_DIFFERENCE_RTOL = 1e-10
# The same in chains beyond equal spheres, where late collisions make slopes over smaller steps irregular.
_FORCE_STEP = 0.3
_FORCE_RTOL = 1e-8
# Standard deviation, over the error of a simulation, of a spread that the error may have caused.
_NOISE = 3.0
# Tolerance of a curve whose slope is used.
_SLOPE_RTOL = 1e-6


def uncertainty(
    scene: Scene,
    chain: Chain | None = None,
    spreads: Mapping[str, Any] | None = None,
    *,
    draws: int | None = None,
    seed: int = 0,
    rtol: float = 1e-4,
    limit: Limit | float | str | None = None,
) -> Uncertainty | SimulatedUncertainty:
    """Distribution of the peak force of the leading wave, or of the forces in a chain beyond equal spheres.

    Parameters
    ----------
    scene : Scenario, path-like, Shock or Impact
        A scenario or its file, or a shock or striker on ``chain``.
    chain : Chain, optional
        The chain, if ``scene`` is a shock or a striker.
    spreads : mapping, optional
        Dotted names and distributions, as in the ``uncertainty`` block, which they replace.
    draws : int, optional
        Number of scenes to draw, a power of 2 from 256 to 262144; by default 4096, or 512 in a chain beyond equal
        spheres, where each scene is simulated.
    seed : int
        Seed of the random numbers; the same seed gives the same digits.
    rtol : float
        Allowed relative error of one peak force, 1e-7 to 1e-2.
    limit : Limit, float or str, optional
        Limit of the force that leaves the chain, or this force [N]; by default that of the scenario. The probability
        that it is reached is found then. A finite chain of equal granules is simulated, as its last contact is judged.

    Returns
    -------
    Uncertainty or SimulatedUncertainty
        Statistics in SI units, with their sampling errors; a `SimulatedUncertainty` for a chain beyond equal spheres.

    Raises
    ------
    InvalidValueError
        If a value is out of range, no parameter is uncertain, or a scene that is drawn is not possible.
    NumericalError
        If a simulation fails.
    """
    scenario = varied_scenes.scenario_of(scene, chain)
    scenario = evolve(scenario, limit=limit_of(limit) or scenario.limit)
    # curves are those of endless chains
    covered = varied_scenes.is_covered(scenario) and (scenario.limit is None or scenario.chain.count is None)
    draws = _DRAWS.checked("draws", (_OF_CURVE if covered else _OF_SIMULATIONS) if draws is None else draws)
    seed, rtol = varied_scenes.SEED.checked("seed", seed), RTOL.checked("rtol", rtol)
    if draws.bit_count() > 1:
        raise InvalidValueError.of("draws", f"must be a power of 2, such as 4096 (got {draws})")
    drawn = [Distribution.of(spread, scenario) for spread in _spreads(scenario, spreads)]
    progressed(WORK, 0, draws * (len(drawn) + 2))
    logger.info("uncertainty of %s: %d scenes", scenario.name or "the scene", draws * (len(drawn) + 2))
    return (_of_leading_wave if covered else _of_forces)(scenario, drawn, draws, seed, rtol)


def _of_leading_wave(
    scenario: Scenario, drawn: Sequence[Distribution], draws: int, seed: int, rtol: float
) -> Uncertainty:
    nominal = {one.name: np.array([one.value]) for one in drawn}
    # if the shock has no curve, the error is raised before anything is drawn
    curve = varied_scenes.curve_of(scenario.shock.profile, min(rtol, _SLOPE_RTOL), varied_scenes.duration_of(scenario))
    exponents = varied_scenes.exponents_of(scenario, curve)

    def evaluate(values: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
        amplification, force, error = varied_scenes.primaries(scenario, values, rtol)
        return np.array([amplification * force, amplification]), np.array([error.max()])

    ((peak_force,), (amplification,)), (error,) = evaluate(nominal)
    points, outputs, (errors,) = sampling.sampled(drawn, draws, seed, evaluate)
    slopes = [slopes_at(scenario, exponents, one, nominal) for one in drawn]
    # shape (2 indices, parameters, 2 outputs, value and error)
    shares = sampling.estimates(sampling.indices, outputs)
    forces, ratios = outputs[:, 0, 0], outputs[:, 1, 0]
    largest = float(max(error, errors))
    reached = sampling.exceedance(scenario.limit, WAVE, forces, largest) if scenario.limit else (None, None)
    moves = np.array([[slope.value * one.sd for slope in both] for one, both in zip(drawn, slopes, strict=True)])
    return Uncertainty(
        method="curve" if varied_scenes.keep_shape(nominal) else "simulation",
        peak_force=sampling.statistics(forces, float(peak_force), moves[:, 0]),
        amplification=sampling.statistics(ratios, float(amplification), moves[:, 1]),
        sensitivities=tuple(map(_sensitivity, drawn, slopes, shares.swapaxes(0, 1))),
        exponents=exponents,
        model_error=largest,
        warnings=(*varied_scenes.notes_of(scenario), *sampling.cut_warnings(drawn)),
        **_sampled(scenario, drawn, points, seed, reached),
        peak_forces=forces.ravel(),
    )


def _of_forces(
    scenario: Scenario, drawn: Sequence[Distribution], draws: int, seed: int, rtol: float
) -> SimulatedUncertainty:
    (result,) = varied_scenes.simulations([scenario], rtol)
    quantities = quantities_of(scenario, result)
    read = [*quantities, *[Quantity("leaving.value", "N", "")] * (scenario.limit is not None)]
    family, nominal = Family(scenario), {one.name: np.array([one.value]) for one in drawn}
    later = [0.0]

    def evaluate(values: Mapping[str, FloatArray], rtol: float = rtol) -> tuple[FloatArray, FloatArray]:
        found = varied_scenes.simulations(varied_scenes.scenes_of(family, values), rtol)
        if scenario.limit is not None:
            later.extend(each.leaving.later for each in found)
        figures = np.array([[one.read(each) or (math.nan, 0.0) for each in found] for one in read])
        return figures[..., 0], figures[..., 1].max(axis=1)

    points, outputs, errors = sampling.sampled(drawn, draws, seed, evaluate)
    reached: tuple[Any, Any] = (None, None)
    if scenario.limit is not None:
        leaving, forces = result.leaving, outputs[:, -1, 0]
        if leaving.high is not None and np.isfinite(forces).all():
            error = float(errors[-1])
            reached = sampling.exceedance(scenario.limit, leaving.name, forces, error, max(later))
        else:  # some forces are not known: the simulated time ends too early, or they have no upper bound
            reached = None, verdict(scenario.limit, evolve(leaving, high=None))
    shares = sampling.estimates(sampling.indices, outputs)
    slopes = []
    for one in drawn:
        values = sampling.scenes_about(one, _FORCE_STEP, nominal)
        rows, _ = evaluate(values, _FORCE_RTOL)
        slopes.append([sampling.difference(values[one.name], row, _FORCE_RTOL).value for row in rows])
    made, notes = [], []
    for index, quantity in enumerate(quantities):
        value, _ = quantity.read(result) or (0.0, 0.0)
        slope = [of_parameter[index] / value for of_parameter in slopes]
        if not (np.isfinite(outputs[:, index]).all() and np.isfinite(slope).all()):
            notes.append(f"the {quantity.label} is left out, because some scenes have none")
            continue
        moves = np.array([own * one.sd for own, one in zip(slope, drawn, strict=True)])
        found = sampling.statistics(outputs[:, index, 0], value, moves)
        if found.sd.value <= _NOISE * errors[index] * abs(value):
            notes.append(f"the spread of the {quantity.label} is within the error of the simulations")
        sensitivities = (
            Share(name=one.name, exponent=own * one.value, first=Estimate(*first), total=Estimate(*total))
            for one, own, first, total in zip(drawn, slope, *shares[:, :, index].tolist(), strict=True)
        )
        known: dict[str, Any] = {**asdict(found, recurse=False), **quantity._asdict()}
        error = float(errors[index])
        made.append(QuantityStatistics(**known, model_error=error, sensitivities=tuple(sensitivities)))
    return SimulatedUncertainty(
        parameters=tuple(Parameter(**_described(one)) for one in drawn),
        quantities=tuple(made),
        warnings=(*result.warnings, *notes, *sampling.cut_warnings(drawn)),
        **_sampled(scenario, drawn, points, seed, reached),
        outputs={one.name: outputs[:, index, 0].ravel() for index, one in enumerate(quantities)},
    )


def _spreads(scenario: Scenario, given: Mapping[str, Any] | None) -> tuple[Spread, ...]:
    if given is None and scenario.uncertainty:
        return scenario.uncertainty
    if given is None:
        remedy = "add a block such as uncertainty: {shock.peak_force: 5 %}"
        raise InvalidValueError.of("uncertainty", f"must name the uncertain parameters (got nothing; {remedy})")
    for name in given if isinstance(given, Mapping) else ():
        varied_scenes.check_parameter(name, scenario, "uncertainty")
    try:
        return read(given, varied_scenes.data_of(scenario))
    except WrongsError as error:
        faults = [Fault(dotted(("uncertainty", *wrong.path)), str(wrong.problem)) for wrong in error.wrongs]
        raise InvalidValueError(faults) from None


def _sampled(
    scenario: Scenario, drawn: Sequence[Distribution], points: FloatArray, seed: int, reached: Sequence[Any]
) -> dict[str, Any]:
    """Fields of `Sampled` but the warnings; ``reached`` is the exceedance and the verdict."""
    draws, names = len(points[0]), [one.name for one in drawn]
    about = {"scenario": scenario.name, "draws": draws, "seed": seed, "evaluations": draws * (len(drawn) + 2)}
    return about | {"exceedance": reached[0], "verdict": reached[1], "values": dict(zip(names, points, strict=True))}


def _described(one: Distribution) -> dict[str, Any]:
    """Fields of a `Parameter`."""
    unit = one.spread.variable.unit or ""
    return {"name": one.name, "unit": unit, "spread": str(one.spread), "value": one.value, "sd": one.sd}


def _sensitivity(one: Distribution, slopes: Sequence[Estimate], indices: FloatArray) -> Sensitivity:
    """Sensitivity to one parameter, from its indices of shape (2 indices, 2 outputs, value and error)."""
    exponent, names = slopes[0], [f"{name}_{index}" for index in ("first", "total") for name in _OUTPUTS]
    shares: Any = zip(names, (Estimate(*pair) for pair in indices.reshape(-1, 2).tolist()), strict=True)
    return Sensitivity(
        **_described(one),
        exponent=exponent.value * one.value if one.value else None,
        exponent_error=exponent.error * abs(one.value) if one.value else None,
        **dict(shares),
    )


# ---------------------------------------------------------------- to first order


def slopes_at(
    scenario: Scenario, exponents: Exponents, one: Distribution, nominal: Mapping[str, FloatArray]
) -> list[Estimate]:
    """Derivatives of ln F and ln (F/F0) with respect to the parameter, at the nominal values."""
    if one.name in POWERS:
        value = one.value or math.inf  # the slope vanishes at Poisson's ratio 0
        force = exponents.at(one.name) / value
        error = exponents.error / abs(value)
        own = 1 / value if one.name == "shock.peak_force" else 0.0
        return [Estimate(force, error), Estimate(force - own, error)]
    values = sampling.scenes_about(one, _STEP, nominal)
    ratios, forces, _ = varied_scenes.primaries(scenario, values, _DIFFERENCE_RTOL)
    # a parameter of the profile may change the peak force of the shock too
    heights = np.log(ratios * forces), np.log(ratios)
    return [sampling.difference(values[one.name], each, _DIFFERENCE_RTOL) for each in heights]
