"""Uncertainty of the primary, by seeded quasi-Monte Carlo.

Points are those of Sobol, scrambled anew in each of sixteen batches that share nothing: what a batch says differs from
the next one's by the error of sampling, which is told with every number. Indices are those of Saltelli.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from attrs import evolve

from shockwave.chain.chain import Chain
from shockwave.errors import Fault, InvalidValueError
from shockwave.fields import Quantity, text_of
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.uncertainty import Spread, read
from shockwave.scenario.yaml_document import Steps, dotted
from shockwave.studies.curve.response import (
    POWERS,
    Exponents,
    Response,
    curve_of,
    data_of,
    duration_of,
    notes_of,
    scenario_of,
    value_of,
)
from shockwave.studies.uncertainties.distribution import Distribution
from shockwave.studies.uncertainties.result import Estimate, Sensitivity, Statistics, Uncertainty
from shockwave.text import si

__all__ = ["uncertainty"]

_DRAWS = Quantity("", "number of draws", at_least=1024, at_most=2**18, whole=True)
_SEED = Quantity("", "seed", at_least=0, at_most=2**63 - 1, whole=True)
_RTOL = Quantity("", "relative error allowed", at_least=1e-7, at_most=1e-2)
_BATCHES = 16
# Student's t for 95 % and fifteen degrees of freedom, of a mean over the batches.
_CONFIDENCE = 2.1314 / math.sqrt(_BATCHES)
_QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
# The share below a quantile may be a whole number of draws in each batch: it is known to no better than one draw.
_DRAW = 1.0
# A share cut off that is told; a deviation over the value that is rounding.
_TOLD, _NARROWEST = 1e-6, 1e-9
# Step of a difference over the standard deviation, the tolerance of its simulations, and that of a curve for its slope.
_STEP, _TIGHT, _SLOPE = 1e-2, 1e-10, 1e-6


def uncertainty(
    scene: Scenario | Shock,
    chain: Chain | None = None,
    spreads: Mapping[str, Any] | None = None,
    *,
    draws: int = 4096,
    seed: int = 0,
    rtol: float = 1e-4,
) -> Uncertainty:
    """How the primary's peak force is distributed where values of the scene are uncertain.

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
    scenario = scenario_of(scene, chain)
    known = _spreads(scenario, spreads)
    nominal = {spread.name: value_of(scenario, spread.name) for spread in known}
    drawn = [_distribution(spread, nominal[spread.name]) for spread in known]
    response = Response.of(scenario, nominal, rtol)
    # of a shock for which there is no curve this says so before anything is drawn
    exponents = Exponents.of(scenario, curve_of(scenario.shock.profile, min(rtol, _SLOPE), duration_of(scenario)))
    slopes = [_slopes(response, exponents, one, nominal) for one in drawn]
    (amplification,), _, (error,) = response({name: np.array([value]) for name, value in nominal.items()})
    batches = _batches(response, drawn, int(draws), int(seed))
    sampled = np.concatenate([outputs for _, outputs, _ in batches], axis=-1)
    forces, ratios = zip(*slopes, strict=True)
    columns = np.concatenate([points for points, _, _ in batches], axis=-1)
    return Uncertainty(
        scenario=scenario.name,
        draws=int(draws),
        seed=int(seed),
        evaluations=int(draws) * (len(drawn) + 2),
        method="curve" if response.keeps_shape else "simulation",
        peak_force=_statistics(batches, 0, float(amplification) * scenario.shock.peak_force, forces, drawn),
        amplification=_statistics(batches, 1, float(amplification), ratios, drawn),
        sensitivities=_sensitivities(nominal, batches, sampled, drawn, forces),
        exponents=exponents,
        model_error=max(float(error), *(error for _, _, error in batches)),
        warnings=_warnings(scenario, drawn, nominal),
        values={one.spread.name: column for one, column in zip(drawn, columns, strict=True)},
        peak_forces=sampled[0, 0],
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
    faults: list[Fault] = []

    def add(steps: Steps, problem: str, at_key: bool) -> None:
        faults.append(Fault(dotted(("uncertainty", *map(_step, steps))), problem))

    found = read(given, data_of(scenario), add)
    if faults:
        raise InvalidValueError(faults)
    return found


def _step(step: object) -> str | int:
    return step if isinstance(step, str | int) else text_of(step)


def _distribution(spread: Spread, value: float) -> Distribution:
    found = Distribution.of(spread, value)
    if not found.sd > _NARROWEST * abs(value):
        problem = f"must leave the value uncertain by more than {_NARROWEST:g} of it (got {spread}; leave it out)"
        raise InvalidValueError.of(dotted(("uncertainty", spread.name)), problem)
    return found


def _warnings(scenario: Scenario, drawn: Sequence[Distribution], nominal: Mapping[str, float]) -> tuple[str, ...]:
    told = [
        f"{one.cut:.2g} of the distribution of {one.spread.name} lay outside its range and was cut off"
        for one in drawn
        if one.cut > _TOLD
    ]
    for spread in (one.spread for one in drawn if one.spread.kind == "between"):
        value = nominal[spread.name]
        if not spread.numbers[0] <= value <= spread.numbers[1]:
            here = si(value, spread.variable.unit or "").rstrip()
            told.append(f"{spread.name} is {here} in the scenario, outside {spread}, between which it is drawn")
    return (*notes_of(scenario), *told)


# ---------------------------------------------------------------- sampling

#: Draws, shape (values, n); outputs, shape (2, values + 2, n): peak force and amplification for A, for B and for each A
#: with one value of B; greatest error.
_Batch = tuple[FloatArray, FloatArray, float]


def _batches(response: Response, drawn: Sequence[Distribution], draws: int, seed: int) -> list[_Batch]:
    generators = map(np.random.default_rng, np.random.SeedSequence(seed).spawn(_BATCHES))
    try:
        return [_batch(response, drawn, rng, draws // _BATCHES) for rng in generators]
    except InvalidValueError as error:
        fault = error.faults[0]
        problem = f"must draw scenes that can be: {fault}" if fault.path else fault.problem
        remedy = "narrow the spreads, or give a {factor: ...}"
        raise InvalidValueError.of("uncertainty", f"{problem}: {remedy}") from None


def _batch(response: Response, drawn: Sequence[Distribution], rng: np.random.Generator, count: int) -> _Batch:
    from scipy.stats import qmc

    size = len(drawn)
    shares = qmc.Sobol(d=2 * size, scramble=True, seed=rng).random(count).T
    # a scrambled point may be 0
    points = np.clip(shares, 2.0**-53, 1 - 2.0**-53)
    first, second = (
        np.array([one.at(column) for one, column in zip(drawn, half, strict=True)])
        for half in (points[:size], points[size:])
    )
    mixed = np.repeat(first[None], size, axis=0)
    mixed[range(size), range(size)] = second
    whole = np.concatenate([first[None], second[None], mixed])
    columns = whole.transpose(1, 0, 2).reshape(size, -1)
    amplification, force, error = response(
        {one.spread.name: column for one, column in zip(drawn, columns, strict=True)}
    )
    outputs = np.array([amplification * force, amplification]).reshape(2, size + 2, count)
    return first, outputs, float(error.max())


def _estimate(pooled: Any, batches: Sequence[Any]) -> Any:
    """A number, or an array of them, from all draws together, each with its error as the batches differ."""
    errors = _CONFIDENCE * np.std(np.array(batches), axis=0, ddof=1)
    return np.stack(np.broadcast_arrays(pooled, errors), axis=-1)


def _statistics(
    batches: Sequence[_Batch], output: int, nominal: float, slopes: Sequence[Estimate], drawn: Sequence[Distribution]
) -> Statistics:
    parts = [outputs[output, 0] for _, outputs, _ in batches]
    pooled = np.concatenate(parts)

    def told(statistic: Any) -> Any:
        return _estimate(statistic(pooled), [statistic(part) for part in parts]).tolist()

    linear = math.hypot(*(slope.value * one.sd for slope, one in zip(slopes, drawn, strict=True)))
    return Statistics(
        nominal=nominal,
        mean=Estimate(*told(np.mean)),
        sd=Estimate(*told(lambda values: np.std(values, ddof=1))),
        quantiles={share: _quantile(pooled, parts, share) for share in _QUANTILES},
        linear_sd=nominal * linear,
    )


def _quantile(pooled: FloatArray, parts: Sequence[FloatArray], share: float) -> Estimate:
    """By what the batches say of the share below it (Woodruff, J. Am. Stat. Assoc. 47, 1952).

    Their own quantiles differ by less than the error: between two draws of so even points there is hardly a choice.
    """
    value = float(np.quantile(pooled, share, method="hazen"))
    below = [float(np.mean(part <= value)) for part in parts]
    off = math.hypot(_CONFIDENCE * float(np.std(below, ddof=1)), _DRAW / len(pooled))
    low, high = np.quantile(pooled, [share - off, share + off], method="hazen").tolist()
    return Estimate(value, max(high - value, value - low))


def _sensitivities(
    nominal: Mapping[str, float],
    batches: Sequence[_Batch],
    sampled: FloatArray,
    drawn: Sequence[Distribution],
    slopes: Sequence[Estimate],
) -> tuple[Sensitivity, ...]:
    # shape (2 indices, values, 2 outputs, value and error)
    indices = _estimate(_indices(sampled), [_indices(outputs) for _, outputs, _ in batches])
    found = []
    for number, (one, slope) in enumerate(zip(drawn, slopes, strict=True)):
        name, value = one.spread.name, nominal[one.spread.name]
        own = indices[:, number].tolist()
        found.append(
            Sensitivity(
                name=name,
                unit=one.spread.variable.unit or "",
                spread=str(one.spread),
                value=value,
                sd=one.sd,
                exponent=slope.value * value if value else None,
                exponent_error=slope.error * abs(value) if value else None,
                peak_force_first=Estimate(*own[0][0]),
                peak_force_total=Estimate(*own[1][0]),
                amplification_first=Estimate(*own[0][1]),
                amplification_total=Estimate(*own[1][1]),
            )
        )
    return tuple(found)


def _indices(outputs: FloatArray) -> FloatArray:
    """First and total indices, shape (2, values, outputs), of outputs of shape (outputs, values + 2, n)."""
    from scipy.stats import sobol_indices

    # without its mean an index loses no digits
    centred = outputs - outputs[:, :2].mean(axis=(1, 2), keepdims=True)
    parts: Any = {"f_A": centred[:, 0], "f_B": centred[:, 1], "f_AB": centred[:, 2:].transpose(1, 0, 2)}
    found = sobol_indices(func=parts, n=outputs.shape[-1])
    # of one value they come without its axis
    return np.array([one.reshape(len(outputs), -1).T for one in (found.first_order, found.total_order)])


# ---------------------------------------------------------------- to first order


def _slopes(
    response: Response, exponents: Exponents, one: Distribution, nominal: Mapping[str, float]
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
    ends = np.clip([value - step, value - step / 2, value + step / 2, value + step], *one.bounds)
    values = {other: np.full(ends.shape, here) for other, here in nominal.items()} | {name: ends}
    ratios, forces, _ = evolve(response, rtol=_TIGHT)(values)
    # what sets the shape may set the peak force of the shock too
    found = (_difference(ends, np.log(heights)) for heights in (ratios * forces, ratios))
    return next(found), next(found)


def _difference(ends: FloatArray, heights: FloatArray) -> Estimate:
    a, b, c, d = heights
    wide, narrow = (d - a) / (ends[3] - ends[0]), (c - b) / (ends[2] - ends[1])
    return Estimate(float(narrow), float(abs(wide - narrow) + 2 * _TIGHT / (ends[2] - ends[1])))
