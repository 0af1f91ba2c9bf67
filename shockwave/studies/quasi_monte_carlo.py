"""Quasi-Monte Carlo sampling of distributions, and statistics with their sampling errors.

The samples are scrambled Sobol points in sixteen independent batches. The scatter of the batches gives the sampling
error, which is reported with every number. Sobol indices are computed by Saltelli's scheme. Distributions are truncated
to the range of their parameter.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from attrs import evolve, frozen
from scipy.stats import norm, qmc, sobol_indices, truncnorm, uniform

from shockwave.base.errors import InvalidValueError
from shockwave.base.numerics import FloatArray
from shockwave.base.progress import report_progress
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.uncertainty_block import Spread
from shockwave.scene.force_limit import Exceedance, LeavingForce, Limit, Verdict, verdict
from shockwave.studies import varied_scenes
from shockwave.studies.uncertainty_result import Estimate

# Number of independent batches of samples.
_BATCHES = 16
# Half the 95 % confidence interval of a mean over the batches, over their standard deviation: Student's t for fifteen
# degrees of freedom over the root of their number.
_CONFIDENCE = 2.1314 / math.sqrt(_BATCHES)
# Smallest probability of a truncated part that is reported.
_LEAST_CUT = 1e-6
# Probabilities of the reported quantiles.
_QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
# Smallest uncertainty of a fraction, in draws: an event not observed in n draws has, with 95 % confidence, a
# probability below 3/n.
_LEAST_DRAWS = 3.0
# Probabilities of the ends of the range of a verdict.
_RANGE = (0.01, 0.99)
#: Name of the work whose progress is reported.
WORK = "scenes"

#: Outputs of shape (outputs, n), and bounds on their relative errors of shape (outputs,), for arrays of shape (n,).
Evaluate = Callable[[Mapping[str, FloatArray]], tuple[FloatArray, FloatArray]]


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
        Range of the parameter; for a uniform distribution, the smallest one that contains its values and that in the
        scenario.
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
        value = varied_scenes.value_of(scenario, spread.name)
        first, last = spread.numbers[0], spread.numbers[-1]
        if spread.kind == "between":
            return cls(spread, value, (min(first, value), max(last, value)), uniform(first, last - first))
        if (spread.kind == "factor" and not value > 0) or (spread.kind == "relative" and value == 0):
            problem = f"must be {{sd: ...}} or {{between: ...}}, as the value is {value:g} (got {spread})"
            raise InvalidValueError.of(("uncertainty", spread.name), problem)
        bounds = _range(spread)
        centre, scale = value, first * abs(value) if spread.kind == "relative" else first
        ends = np.array(bounds)
        if spread.kind == "factor":
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


def cut_warnings(distributions: Sequence[Distribution]) -> tuple[str, ...]:
    """Warnings of distributions that are truncated."""
    cuts = [each for each in distributions if each.cut > _LEAST_CUT]
    return tuple(f"{each.cut:.2g} of the distribution of {each.name} is out of range and truncated" for each in cuts)


def scenes_about(parameter: Distribution, step: float, nominal: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """The ``nominal`` values, with one ``parameter`` at four values within ``step`` standard deviations of its own."""
    low, high = ((parameter.value + bound) / 2 for bound in parameter.bounds)  # the range may exclude its bounds
    ends = np.clip(parameter.value + step * parameter.sd * np.array([-1, -0.5, 0.5, 1]), low, high)
    return {name: np.repeat(value, len(ends)) for name, value in nominal.items()} | {parameter.name: ends}


def difference(ends: FloatArray, heights: FloatArray, error: float) -> Estimate:
    """Derivative from the ``heights`` at the four values of `scenes_about`, each with this absolute error."""
    wide = (heights[3] - heights[0]) / (ends[3] - ends[0])
    narrow = (heights[2] - heights[1]) / (ends[2] - ends[1])
    return Estimate(float(narrow), float(abs(wide - narrow) + 2 * error / (ends[2] - ends[1])))


# ---------------------------------------------------------------- sampling


def draw_samples(
    distributions: Sequence[Distribution], draws: int, seed: int, evaluate: Evaluate
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Samples, shape (parameters, draws); outputs; and their greatest error bounds, shape (outputs,).

    Outputs have the shape (batches, outputs, parameters + 2, draws of a batch): for the sample A, for a second sample
    B, and for A with each column of B in turn.

    Raises
    ------
    InvalidValueError
        If a sample is not valid.
    """
    points, outputs, errors = [], [], []
    try:
        for of_batch in np.random.SeedSequence(seed).spawn(_BATCHES):
            samples = _draw_batch(distributions, np.random.default_rng(of_batch), draws // _BATCHES)
            columns = samples.swapaxes(0, 1).reshape(len(distributions), -1)
            heights, error = evaluate(dict(zip([each.name for each in distributions], columns, strict=True)))
            points.append(samples[0])
            outputs.append(heights.reshape(len(heights), len(samples), -1))
            errors.append(error)
            report_progress(WORK, len(errors) * columns.shape[-1], _BATCHES * columns.shape[-1])
    except InvalidValueError as wrong:
        problem = f"must give only valid samples ({wrong.faults[0]}; narrow the distributions or use {{factor: ...}})"
        raise InvalidValueError.of("uncertainty", problem) from None
    return np.concatenate(points, axis=-1), np.array(outputs), np.max(errors, axis=0)


def _draw_batch(distributions: Sequence[Distribution], rng: np.random.Generator, count: int) -> FloatArray:
    """Samples A, B, and A with each column of B in turn, shape (parameters + 2, parameters, count)."""
    size = len(distributions)
    points = qmc.Sobol(d=2 * size, scramble=True, seed=rng).random(count).T
    # excludes 0, where quantiles may be infinite
    halves = np.clip(points, 2.0**-53, 1 - 2.0**-53).reshape(2, size, count)
    first, second = (np.array([each.at(row) for each, row in zip(distributions, half, strict=True)]) for half in halves)
    samples = np.repeat(first[None], size, axis=0)
    samples[range(size), range(size)] = second
    return np.concatenate([first[None], second[None], samples])


# ---------------------------------------------------------------- statistics


def estimates(statistic: Callable[[FloatArray], Any], batches: FloatArray) -> FloatArray:
    """A statistic of all draws and its error from the scatter of the batches, along a new last axis."""
    errors = _CONFIDENCE * np.std([statistic(batch) for batch in batches], axis=0, ddof=1)
    pooled = np.concatenate(list(batches), axis=-1)
    return np.stack([statistic(pooled), errors], axis=-1)


def statistics(batches: FloatArray) -> dict[str, Any]:
    """Mean, standard deviation and quantiles of draws of shape (batches, draws of a batch)."""
    return {
        "mean": Estimate(*estimates(np.mean, batches).tolist()),
        "sd": Estimate(*estimates(lambda values: np.std(values, ddof=1), batches).tolist()),
        "quantiles": {share: _quantile(batches, share) for share in _QUANTILES},
    }


def _quantile(batches: FloatArray, share: float) -> Estimate:
    """A quantile and its error, from the fraction below it in each batch (Woodruff, J. Am. Stat. Assoc. 47, 1952).

    The scatter of the quantiles of the batches would be too small an error, because Sobol points are evenly spaced.
    """
    pooled = batches.ravel()
    value = float(np.quantile(pooled, share, method="hazen"))
    below = np.mean(batches <= value, axis=-1)
    # at least one draw, as the fraction may be a whole number of draws in each batch
    half = math.hypot(_CONFIDENCE * float(np.std(below, ddof=1)), 1 / len(pooled))
    low, high = np.quantile(pooled, np.clip([share - half, share + half], 0, 1), method="hazen").tolist()
    return Estimate(value, max(high - value, value - low))


def indices(outputs: FloatArray) -> FloatArray:
    """First and total indices, shape (2, parameters, outputs), of outputs of shape (outputs, parameters + 2, n)."""
    # SciPy may subtract the mean in place, and does not take a single output of a single parameter
    doubled = np.repeat(outputs, 2, axis=0) if outputs.shape[:2] == (1, 3) else outputs.copy()
    parts: Any = {"f_A": doubled[:, 0], "f_B": doubled[:, 1], "f_AB": doubled[:, 2:].swapaxes(0, 1)}
    with np.errstate(invalid="ignore", divide="ignore"):
        sobol = sobol_indices(func=parts, n=outputs.shape[-1])
    # for one parameter SciPy omits its axis; an output without variance has no shares
    shares = [part.reshape(len(doubled), -1).T[:, : len(outputs)] for part in (sobol.first_order, sobol.total_order)]
    return np.nan_to_num(shares, posinf=0)


def exceedance(
    limit: Limit, leaving: LeavingForce, batches: FloatArray, error: float, later: FloatArray | float = 0.0
) -> tuple[Exceedance, Verdict]:
    """Probability and verdict for forces that leave the chain, shape (batches, draws per batch), with this error.

    NaN is a force that is not known; ``leaving`` is that of the nominal scene. After the simulated time the forces are
    less than ``later``. The interval of the probability allows for the error of the contact law, as the verdict does,
    whose range contains 98 % of the scenes.
    """
    is_known, forces = ~np.isnan(batches), np.nan_to_num(batches)
    least, most = (1 - error) * forces, (1 + error) * forces
    bound = np.where(is_known, np.maximum(most, later), math.inf)
    law_low, law_high = leaving.law_error or (0.0, 0.0)
    ends = least / (1 + law_high), forces, bound / (1 + law_low)
    exceeded = [(each >= limit.force).astype(float) for each in ends]
    (certain, below), (value, _), (possible, above) = (estimates(np.mean, values).tolist() for values in exceeded)
    floor = _LEAST_DRAWS / batches.size
    result = Exceedance(
        limit=limit.force,
        probability=value,
        low=max(certain - max(below, floor), 0.0),
        high=min(possible + max(above, floor), 1.0),
        draws=batches.size,
        undecided=round((possible - certain) * batches.size),
    )
    force = evolve(
        leaving,
        value=float(np.median(forces)) if is_known.all() else None,
        low=float(np.quantile(least, _RANGE[0])),
        high=float(np.quantile(most, _RANGE[1], method="higher")),
        remedy=verdict(limit, leaving).remedy or "narrow the distributions",
        later=float(np.quantile(bound, _RANGE[1], method="higher")),
    )
    return result, verdict(limit, force)
