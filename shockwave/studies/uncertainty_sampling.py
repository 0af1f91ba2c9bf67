"""Uncertainty of the primary, by seeded quasi-Monte Carlo.

Points are those of Sobol, scrambled anew in each of sixteen independent batches: how much the batches differ gives the
error of sampling, which is reported with every number. Indices are those of Saltelli.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from shockwave.chain.chain import Chain
from shockwave.errors import Fault, InvalidValueError
from shockwave.fields import Quantity
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.uncertainty import Spread, read
from shockwave.scenario.value_conversion import WrongsError
from shockwave.scenario.yaml_document import dotted
from shockwave.studies import scene_response
from shockwave.studies.scaling_exponents import POWERS, Exponents
from shockwave.studies.spread_distribution import Distribution
from shockwave.studies.uncertainty import Estimate, Sensitivity, Statistics, Uncertainty
from shockwave.text import si

_DRAWS = Quantity("", "number of draws", at_least=1024, at_most=2**18, whole=True)
_SEED = Quantity("", "seed", at_least=0, at_most=2**63 - 1, whole=True)
_RTOL = Quantity("", "relative error allowed", at_least=1e-7, at_most=1e-2)
_BATCHES = 16
# Student's t for 95 % and fifteen degrees of freedom, of a mean over the batches.
_CONFIDENCE = 2.1314 / math.sqrt(_BATCHES)
_QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
# The share below a quantile may be a whole number of draws in each batch: it is known to no better than one draw.
_DRAW = 1.0
# Least share cut off that is reported.
_LEAST_CUT = 1e-6
# A deviation over the value that is rounding.
_NARROWEST = 1e-9
# Step of a difference over the standard deviation, the tolerance of its simulations, and that of a curve for its slope.
_STEP = 1e-2
_TIGHT = 1e-10
_SLOPE = 1e-6


def uncertainty(
    scene: Scenario | Shock,
    chain: Chain | None = None,
    spreads: Mapping[str, Any] | None = None,
    *,
    draws: int = 4096,
    seed: int = 0,
    rtol: float = 1e-4,
) -> Uncertainty:
    """Distribution of the primary's peak force where values of the scene are uncertain.

    Parameters
    ----------
    scene : Scenario or Shock
        A scenario, or the shock on ``chain``.
    chain : Chain, optional
        Where ``scene`` is a shock.
    spreads : mapping, optional
        Dotted names and how well the values are known, as in the block ``uncertainty``; it takes the place of that
        of the scenario.
    draws : int
        Scenes to draw, a power of 2 from 1024 to 262144.
    seed : int
        The same seed gives the same digits.
    rtol : float
        Relative error allowed of one peak force, 1e-7 to 1e-2.

    Returns
    -------
    Uncertainty
        In SI units.

    Raises
    ------
    InvalidValueError
        When a value is out of range, nothing is uncertain, or a scene that is drawn does not exist.
    NumericalError
        When a scene cannot be simulated.
    """
    _check(draws, seed, rtol)
    draws, seed = int(draws), int(seed)
    scenario = scene_response.scenario_of(scene, chain)
    known = _spreads(scenario, spreads)
    nominal = {spread.name: scene_response.value_of(scenario, spread.name) for spread in known}
    drawn = [_distribution(spread, nominal[spread.name]) for spread in known]
    # for a shock without a curve this raises before anything is drawn
    curve = scene_response.curve_of(scenario.shock.profile, min(rtol, _SLOPE), scene_response.duration_of(scenario))
    exponents = scene_response.exponents_of(scenario, curve)
    slopes = [slopes_at(scenario, exponents, one, nominal) for one in drawn]
    (amplification,), _, (error,) = scene_response.primaries(
        scenario, {name: np.array([value]) for name, value in nominal.items()}, rtol
    )
    points, outputs, errors = _sampled(scenario, drawn, draws, seed, rtol)
    # indices: shape (2 indices, values, 2 outputs)
    indices = _estimates(_indices, outputs)
    sds = [one.sd for one in drawn]
    nominals = float(amplification) * scenario.shock.peak_force, float(amplification)
    statistics = [
        _statistics(outputs[:, output, 0], nominals[output], [slope[output].value for slope in slopes], sds)
        for output in range(2)
    ]
    return Uncertainty(
        scenario=scenario.name,
        draws=draws,
        seed=seed,
        evaluations=draws * (len(drawn) + 2),
        method="curve" if scene_response.keep_shape(nominal) else "simulation",
        peak_force=statistics[0],
        amplification=statistics[1],
        sensitivities=tuple(
            _sensitivity(one, nominal[one.spread.name], slope, indices[:, number])
            for number, (one, (slope, _)) in enumerate(zip(drawn, slopes, strict=True))
        ),
        exponents=exponents,
        model_error=max(float(error), errors),
        warnings=_warnings(scenario, drawn, nominal),
        values={one.spread.name: column for one, column in zip(drawn, points, strict=True)},
        peak_forces=outputs[:, 0, 0].ravel(),
    )


# ---------------------------------------------------------------- what was asked


def _check(draws: Any, seed: Any, rtol: Any) -> None:
    for name, spec, value in (("draws", _DRAWS, draws), ("seed", _SEED, seed), ("rtol", _RTOL, rtol)):
        if problem := spec.problem(value):
            raise InvalidValueError.of(name, problem)
    if int(draws).bit_count() > 1:
        below = 1 << (int(draws).bit_length() - 1)
        near = f"{below} or {2 * below}" if 2 * below <= 2**18 else str(below)
        raise InvalidValueError.of("draws", f"must be a power of 2 (got {draws}; {near} is near)")


def _spreads(scenario: Scenario, given: Mapping[str, Any] | None) -> tuple[Spread, ...]:
    if given is None and scenario.uncertainty:
        return scenario.uncertainty
    if given is None:
        remedy = "add a block such as uncertainty: {shock.peak_force: 5 %}"
        raise InvalidValueError.of("uncertainty", f"must say which values are uncertain (got nothing; {remedy})")
    try:
        return read(given, scene_response.data_of(scenario))
    except WrongsError as error:
        faults = [Fault(dotted(("uncertainty", *wrong.path)), str(wrong.problem)) for wrong in error.wrongs]
        raise InvalidValueError(faults) from None


def _distribution(spread: Spread, value: float) -> Distribution:
    found = Distribution.of(spread, value)
    if not found.sd > _NARROWEST * abs(value):
        problem = f"must leave the value uncertain by more than {_NARROWEST:g} of it (got {spread}; leave it out)"
        raise InvalidValueError.of(dotted(("uncertainty", spread.name)), problem)
    return found


def _warnings(scenario: Scenario, drawn: Sequence[Distribution], nominal: Mapping[str, float]) -> tuple[str, ...]:
    warnings = [
        f"{one.cut:.2g} of the distribution of {one.spread.name} lay outside its range and was cut off"
        for one in drawn
        if one.cut > _LEAST_CUT
    ]
    for spread in (one.spread for one in drawn if one.spread.kind == "between"):
        value = nominal[spread.name]
        if not spread.numbers[0] <= value <= spread.numbers[1]:
            here = si(value, spread.variable.unit or "").rstrip()
            warnings.append(f"{spread.name} is {here} in the scenario, outside {spread}, between which it is drawn")
    return (*scene_response.notes_of(scenario), *warnings)


# ---------------------------------------------------------------- sampling


def _sampled(
    scenario: Scenario, drawn: Sequence[Distribution], draws: int, seed: int, rtol: float
) -> tuple[FloatArray, FloatArray, float]:
    """Draws, shape (values, draws); peak forces and amplifications; and the greatest error.

    These are of shape (batches, 2 outputs, values + 2, draws of a batch): for the draws A, for others B, and for A with
    each value of B in turn.
    """
    generators = map(np.random.default_rng, np.random.SeedSequence(seed).spawn(_BATCHES))
    batches = [_batch(scenario, _mixed(drawn, rng, draws // _BATCHES), drawn, rtol) for rng in generators]
    points, outputs, errors = zip(*batches, strict=True)
    return np.concatenate(points, axis=-1), np.array(outputs), max(errors)


def _batch(
    scenario: Scenario, mixed: FloatArray, drawn: Sequence[Distribution], rtol: float
) -> tuple[FloatArray, FloatArray, float]:
    """The draws A, and what `_sampled` returns, of one batch."""
    columns = mixed.transpose(1, 0, 2).reshape(len(drawn), -1)
    values = {one.spread.name: column for one, column in zip(drawn, columns, strict=True)}
    try:
        amplification, force, error = scene_response.primaries(scenario, values, rtol)
    except InvalidValueError as wrong:
        problem = f"{scene_response.impossible(wrong, 'draw')}: narrow the spreads, or give a {{factor: ...}}"
        raise InvalidValueError.of("uncertainty", problem) from None
    outputs = np.array([amplification * force, amplification]).reshape(2, len(mixed), -1)
    return mixed[0], outputs, float(error.max())


def _mixed(drawn: Sequence[Distribution], rng: np.random.Generator, count: int) -> FloatArray:
    """Values of the draws A, of B, and of A with each value of B in turn, shape (values + 2, values, count)."""
    from scipy.stats import qmc

    size = len(drawn)
    shares = qmc.Sobol(d=2 * size, scramble=True, seed=rng).random(count).T
    # a scrambled point may be 0
    halves = np.clip(shares, 2.0**-53, 1 - 2.0**-53).reshape(2, size, count)
    first, second = (np.array([one.at(row) for one, row in zip(drawn, half, strict=True)]) for half in halves)
    mixed = np.repeat(first[None], size, axis=0)
    mixed[range(size), range(size)] = second
    return np.concatenate([first[None], second[None], mixed])


# ---------------------------------------------------------------- statistics


def _pooled(batches: FloatArray) -> FloatArray:
    """All batches as one, the draws along the last axis."""
    return np.concatenate(list(batches), axis=-1)


def _estimates(statistic: Callable[[FloatArray], Any], batches: FloatArray) -> FloatArray:
    """A statistic of all draws together and its error as the batches differ, along a new last axis."""
    errors = _CONFIDENCE * np.std([statistic(batch) for batch in batches], axis=0, ddof=1)
    return np.stack([statistic(_pooled(batches)), errors], axis=-1)


def _statistics(batches: FloatArray, nominal: float, slopes: Sequence[float], sds: Sequence[float]) -> Statistics:
    linear = math.hypot(*(slope * sd for slope, sd in zip(slopes, sds, strict=True)))
    return Statistics(
        nominal=nominal,
        mean=Estimate(*_estimates(np.mean, batches).tolist()),
        sd=Estimate(*_estimates(lambda values: np.std(values, ddof=1), batches).tolist()),
        quantiles={share: _quantile(batches, share) for share in _QUANTILES},
        linear_sd=nominal * linear,
    )


def _quantile(batches: FloatArray, share: float) -> Estimate:
    """Estimated from the share below it in each batch (Woodruff, J. Am. Stat. Assoc. 47, 1952).

    Quantiles of the batches differ by less than the error: between two draws of so even points there is hardly a
    choice.
    """
    pooled = batches.ravel()
    value = float(np.quantile(pooled, share, method="hazen"))
    below = np.mean(batches <= value, axis=-1)
    off = math.hypot(_CONFIDENCE * float(np.std(below, ddof=1)), _DRAW / len(pooled))
    low, high = np.quantile(pooled, [share - off, share + off], method="hazen").tolist()
    return Estimate(value, max(high - value, value - low))


def _sensitivity(one: Distribution, value: float, slope: Estimate, indices: FloatArray) -> Sensitivity:
    """The sensitivity to one value, of indices of shape (2 indices, 2 outputs, value and error)."""
    (force_first, first), (force_total, total) = indices.tolist()
    return Sensitivity(
        name=one.spread.name,
        unit=one.spread.variable.unit or "",
        spread=str(one.spread),
        value=value,
        sd=one.sd,
        exponent=slope.value * value if value else None,
        exponent_error=slope.error * abs(value) if value else None,
        peak_force_first=Estimate(*force_first),
        peak_force_total=Estimate(*force_total),
        amplification_first=Estimate(*first),
        amplification_total=Estimate(*total),
    )


def _indices(outputs: FloatArray) -> FloatArray:
    """First and total indices, shape (2, values, outputs), of outputs of shape (outputs, values + 2, n)."""
    from scipy.stats import sobol_indices

    # without its mean an index loses no digits
    centred: FloatArray = outputs - outputs[:, :2].mean(axis=(1, 2), keepdims=True)
    parts: Any = {"f_A": centred[:, 0], "f_B": centred[:, 1], "f_AB": centred[:, 2:].transpose(1, 0, 2)}
    found = sobol_indices(func=parts, n=outputs.shape[-1])
    # of one value they come without its axis
    return np.array([one.reshape(len(outputs), -1).T for one in (found.first_order, found.total_order)])


# ---------------------------------------------------------------- to first order


def slopes_at(
    scenario: Scenario, exponents: Exponents, one: Distribution, nominal: Mapping[str, float]
) -> tuple[Estimate, Estimate]:
    """d ln F and d ln (F/F0) over d of the value at the nominal scene, the other values that are drawn kept."""
    name, value = one.spread.name, nominal[one.spread.name]
    if name in POWERS:
        if not value:  # of Poisson's ratio it is 0 at 0
            return Estimate(0.0, 0.0), Estimate(0.0, 0.0)
        force, error = exponents.at(name) / value, exponents.error / abs(value)
        own = 1 / value if name == "shock.peak_force" else 0.0
        return Estimate(force, error), Estimate(force - own, error)
    step = _STEP * one.sd
    ends = np.clip([value - step, value - step / 2, value + step / 2, value + step], one.begin, one.end)
    values = {other: np.full(ends.shape, here) for other, here in nominal.items()} | {name: ends}
    ratios, forces, _ = scene_response.primaries(scenario, values, _TIGHT)
    # what sets the shape may set the peak force of the shock too
    return _difference(ends, np.log(ratios * forces)), _difference(ends, np.log(ratios))


def _difference(ends: FloatArray, heights: FloatArray) -> Estimate:
    a, b, c, d = heights
    wide, narrow = (d - a) / (ends[3] - ends[0]), (c - b) / (ends[2] - ends[1])
    return Estimate(float(narrow), float(abs(wide - narrow) + 2 * _TIGHT / (ends[2] - ends[1])))
