"""Uncertainty of the peak force of the leading wave, by quasi-Monte Carlo sampling.

The samples are scrambled Sobol points in sixteen independent batches. The scatter of the batches gives the sampling
error, which is reported with every number. Sobol indices are computed by Saltelli's scheme. Distributions are truncated
to the range of their parameter.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from attrs import frozen

from shockwave.chain.chain import Chain
from shockwave.errors import Fault, InvalidValueError
from shockwave.fields import Quantity
from shockwave.profiles.shock import Shock
from shockwave.progress import progressed
from shockwave.quadrature import FloatArray
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.uncertainty import Spread, read
from shockwave.scenario.value_conversion import WrongsError
from shockwave.scenario.yaml_document import dotted
from shockwave.studies import varied_scenes
from shockwave.studies.scaling_exponents import POWERS, Exponents
from shockwave.studies.uncertainty_result import Estimate, Sensitivity, Statistics, Uncertainty
from shockwave.studies.universal_curve import RTOL

_DRAWS = Quantity("", "number of draws", at_least=1024, at_most=2**18, whole=True)
_SEED = Quantity("", "seed", at_least=0, at_most=2**63 - 1, whole=True)
# Number of independent batches of samples.
_BATCHES = 16
# Half the 95 % confidence interval of a mean over the batches, over their standard deviation: Student's t for fifteen
# degrees of freedom over the root of their number.
_CONFIDENCE = 2.1314 / math.sqrt(_BATCHES)
# Smallest probability of a truncated part that is reported.
_LEAST_CUT = 1e-6
# Probabilities of the reported quantiles.
_QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
# Step of a finite difference, over the standard deviation of the parameter.
_STEP = 1e-2
# Tolerance of the simulations of a finite difference.
_DIFFERENCE_RTOL = 1e-10
# Tolerance of a curve whose slope is used.
_SLOPE_RTOL = 1e-6
# Name of the work whose progress is reported.
_WORK = "scenes"


def uncertainty(
    scene: Scenario | Shock,
    chain: Chain | None = None,
    spreads: Mapping[str, Any] | None = None,
    *,
    draws: int = 4096,
    seed: int = 0,
    rtol: float = 1e-4,
) -> Uncertainty:
    """Distribution of the peak force of the leading wave for uncertain parameters.

    Parameters
    ----------
    scene : Scenario or Shock
        A scenario, or a shock on ``chain``.
    chain : Chain, optional
        The chain, if ``scene`` is a shock.
    spreads : mapping, optional
        Dotted names and distributions, as in the ``uncertainty`` block, which they replace.
    draws : int
        Number of scenes to draw, a power of 2 from 1024 to 262144.
    seed : int
        Seed of the random numbers; the same seed gives the same digits.
    rtol : float
        Allowed relative error of one peak force, 1e-7 to 1e-2.

    Returns
    -------
    Uncertainty
        Statistics in SI units, with their sampling errors.

    Raises
    ------
    InvalidValueError
        If a value is out of range, no parameter is uncertain, or a scene that is drawn is not possible.
    NumericalError
        If a simulation fails.
    """
    draws, seed = _DRAWS.checked("draws", draws), _SEED.checked("seed", seed)
    rtol = RTOL.checked("rtol", rtol)
    if draws.bit_count() > 1:
        raise InvalidValueError.of("draws", f"must be a power of 2, such as 4096 (got {draws})")
    scenario = varied_scenes.scenario_of(scene, chain)
    drawn = [Distribution.of(spread, scenario) for spread in _spreads(scenario, spreads)]
    nominal = {one.name: np.array([one.value]) for one in drawn}
    total = draws * (len(drawn) + 2)
    progressed(_WORK, 0, total)
    # if the shock has no curve, the error is raised before anything is drawn
    curve = varied_scenes.curve_of(scenario.shock.profile, min(rtol, _SLOPE_RTOL), varied_scenes.duration_of(scenario))
    exponents = varied_scenes.exponents_of(scenario, curve)
    (amplification,), (force,), (error,) = varied_scenes.primaries(scenario, nominal, rtol)
    try:
        points, outputs, errors = _sampled(scenario, drawn, draws, seed, rtol)
    except InvalidValueError as wrong:
        problem = f"must give only valid samples ({wrong.faults[0]}; narrow the distributions or use {{factor: ...}})"
        raise InvalidValueError.of("uncertainty", problem) from None
    slopes = [slopes_at(scenario, exponents, one, nominal) for one in drawn]
    # shape (2 indices, parameters, 2 outputs, value and error)
    indices = _estimates(_indices, outputs)
    forces, ratios = outputs[:, 0, 0], outputs[:, 1, 0]
    moves = np.array([[slope.value * one.sd for slope in both] for one, both in zip(drawn, slopes, strict=True)])
    cuts = [one for one in drawn if one.cut > _LEAST_CUT]
    return Uncertainty(
        scenario=scenario.name,
        draws=draws,
        seed=seed,
        evaluations=total,
        method="curve" if varied_scenes.keep_shape(nominal) else "simulation",
        peak_force=_statistics(forces, float(amplification * force), moves[:, 0]),
        amplification=_statistics(ratios, float(amplification), moves[:, 1]),
        sensitivities=tuple(map(_sensitivity, drawn, slopes, indices.swapaxes(0, 1))),
        exponents=exponents,
        model_error=max(float(error), errors),
        warnings=(
            *varied_scenes.notes_of(scenario),
            *(f"{one.cut:.2g} of the distribution of {one.name} is out of range and truncated" for one in cuts),
        ),
        values={one.name: column for one, column in zip(drawn, points, strict=True)},
        peak_forces=forces.ravel(),
    )


def _spreads(scenario: Scenario, given: Mapping[str, Any] | None) -> tuple[Spread, ...]:
    if given is None and scenario.uncertainty:
        return scenario.uncertainty
    if given is None:
        remedy = "add a block such as uncertainty: {shock.peak_force: 5 %}"
        raise InvalidValueError.of("uncertainty", f"must name the uncertain parameters (got nothing; {remedy})")
    try:
        return read(given, varied_scenes.data_of(scenario))
    except WrongsError as error:
        faults = [Fault(dotted(("uncertainty", *wrong.path)), str(wrong.problem)) for wrong in error.wrongs]
        raise InvalidValueError(faults) from None


# ---------------------------------------------------------------- distributions


@frozen
class Distribution:
    """Truncated normal or lognormal distribution about the value of the scenario, or a uniform distribution.

    Attributes
    ----------
    spread : Spread
        The given distribution.
    value : float
        Value in the scenario.
    bounds : (float, float)
        Range of the parameter, or the ends of a uniform distribution.
    law : object
        Frozen distribution of SciPy; for a ``factor``, the distribution of the logarithm.
    cut : float
        Probability of the truncated part outside the range.
    """

    spread: Spread
    value: float
    bounds: tuple[float, float]
    law: Any
    cut: float = 0.0

    @classmethod
    def of(cls, spread: Spread, scenario: Scenario) -> Distribution:
        """The distribution about the value of ``scenario``.

        Raises
        ------
        InvalidValueError
            If a percentage is given for the value 0, or a factor for a value that is not above 0.
        """
        from scipy.stats import norm, truncnorm, uniform

        value = varied_scenes.value_of(scenario, spread.name)
        first, last = spread.numbers[0], spread.numbers[-1]
        if spread.kind == "between":
            return cls(spread, value, (first, last), uniform(first, last - first))
        if (spread.kind == "factor" and not value > 0) or (spread.kind == "relative" and value == 0):
            problem = f"must be {{sd: ...}} or {{between: ...}}, as the value is {value:g} (got {spread})"
            raise InvalidValueError.of(dotted(("uncertainty", spread.name)), problem)
        bounds = _range(spread)
        centre, scale = value, first
        ends = np.array(bounds)
        if spread.kind == "relative":
            scale = first * abs(value)
        elif spread.kind == "factor":
            centre, scale = math.log(value), math.log(first)
            with np.errstate(divide="ignore"):
                ends = np.log(np.maximum(ends, 0.0))
        low, high = (ends - centre) / scale
        return cls(spread, value, bounds, truncnorm(low, high, centre, scale), float(norm.cdf(low) + norm.sf(high)))

    @property
    def name(self) -> str:
        """Dotted name of the parameter."""
        return self.spread.name

    def at(self, probabilities: FloatArray) -> FloatArray:
        """Quantiles at these probabilities, each above 0 and below 1."""
        values = self.law.ppf(probabilities)
        if self.spread.kind == "factor":
            values = np.exp(values)
        return np.asarray(np.clip(values, *self.bounds))

    @property
    def sd(self) -> float:
        """Standard deviation of the truncated distribution."""
        if self.spread.kind != "factor":
            return float(self.law.std())
        # midpoint rule in the probability, accurate to four digits in spite of the tails
        count = 100_000
        return float(np.std(self.at((np.arange(count) + 0.5) / count)))


def _range(spread: Spread) -> tuple[float, float]:
    spec = spread.variable.key.spec
    assert spec is not None  # an uncertain parameter is a number
    low = spec.above if spec.at_least is None else spec.at_least
    high = spec.below if spec.at_most is None else spec.at_most
    return -math.inf if low is None else low, math.inf if high is None else high


# ---------------------------------------------------------------- sampling


def _sampled(
    scenario: Scenario, drawn: Sequence[Distribution], draws: int, seed: int, rtol: float
) -> tuple[FloatArray, FloatArray, float]:
    """Samples, shape (parameters, draws); peak forces and amplifications; and the greatest error bound.

    Peak forces and amplifications have the shape (batches, 2 outputs, parameters + 2, draws of a batch): for the sample
    A, for a second sample B, and for A with each column of B in turn.
    """
    points = []
    outputs = []
    errors = []
    for of_batch in np.random.SeedSequence(seed).spawn(_BATCHES):
        mixed = _mixed(drawn, np.random.default_rng(of_batch), draws // _BATCHES)
        columns = mixed.swapaxes(0, 1).reshape(len(drawn), -1)
        values = {one.name: column for one, column in zip(drawn, columns, strict=True)}
        amplification, force, error = varied_scenes.primaries(scenario, values, rtol)
        both = np.array([amplification * force, amplification])
        points.append(mixed[0])
        outputs.append(both.reshape(2, len(mixed), -1))
        errors.append(float(error.max()))
        progressed(_WORK, len(errors) * force.size, _BATCHES * force.size)
    return np.concatenate(points, axis=-1), np.array(outputs), max(errors)


def _mixed(drawn: Sequence[Distribution], rng: np.random.Generator, count: int) -> FloatArray:
    """Samples A, B, and A with each column of B in turn, shape (parameters + 2, parameters, count)."""
    from scipy.stats import qmc

    size = len(drawn)
    points = qmc.Sobol(d=2 * size, scramble=True, seed=rng).random(count).T
    # excludes 0, where quantiles may be infinite
    halves = np.clip(points, 2.0**-53, 1 - 2.0**-53).reshape(2, size, count)
    first, second = (np.array([one.at(row) for one, row in zip(drawn, half, strict=True)]) for half in halves)
    mixed = np.repeat(first[None], size, axis=0)
    mixed[range(size), range(size)] = second
    return np.concatenate([first[None], second[None], mixed])


# ---------------------------------------------------------------- statistics


def _estimates(statistic: Callable[[FloatArray], Any], batches: FloatArray) -> FloatArray:
    """A statistic of all draws and its error from the scatter of the batches, along a new last axis."""
    errors = _CONFIDENCE * np.std([statistic(batch) for batch in batches], axis=0, ddof=1)
    pooled = np.concatenate(list(batches), axis=-1)
    return np.stack([statistic(pooled), errors], axis=-1)


def _statistics(batches: FloatArray, nominal: float, moves: FloatArray) -> Statistics:
    """Statistics of draws of shape (batches, draws of a batch).

    ``moves`` are the first-order changes of the logarithm for one standard deviation of each parameter.
    """
    return Statistics(
        nominal=nominal,
        mean=Estimate(*_estimates(np.mean, batches).tolist()),
        sd=Estimate(*_estimates(lambda values: np.std(values, ddof=1), batches).tolist()),
        quantiles={share: _quantile(batches, share) for share in _QUANTILES},
        linear_sd=nominal * math.hypot(*moves),
    )


def _quantile(batches: FloatArray, share: float) -> Estimate:
    """A quantile and its error, from the fraction below it in each batch (Woodruff, J. Am. Stat. Assoc. 47, 1952).

    The scatter of the quantiles of the batches would be too small an error, because Sobol points are evenly spaced.
    """
    pooled = batches.ravel()
    value = float(np.quantile(pooled, share, method="hazen"))
    below = np.mean(batches <= value, axis=-1)
    # at least one draw, as the fraction may be a whole number of draws in each batch
    half = math.hypot(_CONFIDENCE * float(np.std(below, ddof=1)), 1 / len(pooled))
    low, high = np.quantile(pooled, [share - half, share + half], method="hazen").tolist()
    return Estimate(value, max(high - value, value - low))


def _sensitivity(one: Distribution, slopes: tuple[Estimate, Estimate], indices: FloatArray) -> Sensitivity:
    """Sensitivity to one parameter, from its indices of shape (2 indices, 2 outputs, value and error)."""
    (force_first, first), (force_total, total) = indices.tolist()
    exponent = slopes[0]
    return Sensitivity(
        name=one.name,
        unit=one.spread.variable.unit or "",
        spread=str(one.spread),
        value=one.value,
        sd=one.sd,
        exponent=exponent.value * one.value if one.value else None,
        exponent_error=exponent.error * abs(one.value) if one.value else None,
        peak_force_first=Estimate(*force_first),
        peak_force_total=Estimate(*force_total),
        amplification_first=Estimate(*first),
        amplification_total=Estimate(*total),
    )


def _indices(outputs: FloatArray) -> FloatArray:
    """First and total indices, shape (2, parameters, outputs), of outputs of shape (outputs, parameters + 2, n)."""
    from scipy.stats import sobol_indices

    own = outputs.copy()  # SciPy may subtract the mean in place
    parts: Any = {"f_A": own[:, 0], "f_B": own[:, 1], "f_AB": own[:, 2:].swapaxes(0, 1)}
    found = sobol_indices(func=parts, n=outputs.shape[-1])
    # for one parameter SciPy omits its axis
    return np.array([one.reshape(len(outputs), -1).T for one in (found.first_order, found.total_order)])


# ---------------------------------------------------------------- to first order


def slopes_at(
    scenario: Scenario, exponents: Exponents, one: Distribution, nominal: Mapping[str, FloatArray]
) -> tuple[Estimate, Estimate]:
    """Derivatives of ln F and ln (F/F0) with respect to the parameter, at the nominal values."""
    if one.name in POWERS:
        value = one.value or math.inf  # the slope vanishes at Poisson's ratio 0
        force = exponents.at(one.name) / value
        error = exponents.error / abs(value)
        own = 1 / value if one.name == "shock.peak_force" else 0.0
        return Estimate(force, error), Estimate(force - own, error)
    ends = np.clip(one.value + _STEP * one.sd * np.array([-1, -0.5, 0.5, 1]), *one.bounds)
    values = {name: np.repeat(value, len(ends)) for name, value in nominal.items()}
    ratios, forces, _ = varied_scenes.primaries(scenario, values | {one.name: ends}, _DIFFERENCE_RTOL)
    # a parameter of the profile may change the peak force of the shock too
    return _difference(ends, np.log(ratios * forces)), _difference(ends, np.log(ratios))


def _difference(ends: FloatArray, heights: FloatArray) -> Estimate:
    wide = (heights[3] - heights[0]) / (ends[3] - ends[0])
    narrow = (heights[2] - heights[1]) / (ends[2] - ends[1])
    return Estimate(float(narrow), float(abs(wide - narrow) + 2 * _DIFFERENCE_RTOL / (ends[2] - ends[1])))
