"""Distribution of the peak force for uncertain parameters: the data and their text."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from attrs import asdict, field, frozen

from shockwave.quadrature import FloatArray
from shockwave.studies.scaling_exponents import Exponents
from shockwave.text import facts, limits, paragraph, si, strong, table

# Columns of the variance table that a narrow screen leaves out, the last named first.
_SPARE = ("spread", "exponent", "amplification: first-order, %", "amplification: total, %")
_VARIANCE_LEGEND = (
    "(first-order, total: contribution of a parameter to the variance of the peak force, without and with its "
    "interactions with other parameters; +-: half the 95 % confidence interval of sampling)"
)
_STATISTICS_LEGEND = (
    "(sd: standard deviation; linear sd: to first order, from the exponents; +-: half the 95 % confidence interval of "
    "sampling, and the error of the peak forces)"
)
_SHARES_LEGEND = (
    "(contribution of a parameter to the variance of each quantity, including its interactions with other parameters; "
    "first-order: without them; +-: half the 95 % confidence interval of sampling)"
)
_SIMULATED_LEGEND = (
    "(sd: standard deviation; linear sd: from the slopes at the nominal values; +-: half the 95 % confidence interval "
    "of sampling, and the error of the simulations)"
)
# Smallest printed error of a share of the variance.
_LEAST_SHARE = 1e-5


@frozen
class Estimate:
    """A number and its sampling error: half the 95 % confidence interval, from the scatter of the batches."""

    value: float
    error: float

    def __str__(self) -> str:
        decimals = -math.floor(math.log10(self.error / 3)) if 0 < self.error < math.inf else 6
        shown = (f"{round(number, decimals):.{max(decimals, 0)}f}" for number in (self.value, self.error))
        return " +- ".join(shown)


@frozen(kw_only=True)
class Statistics:
    """Statistics of one quantity.

    Attributes
    ----------
    nominal : float
        Value for the parameters of the scenario.
    mean, sd : Estimate
        Mean and standard deviation.
    quantiles : mapping of float to Estimate
        Quantiles by their probabilities.
    linear_sd : float
        Standard deviation to first order, from the exponents at the nominal scene.
    """

    nominal: float
    mean: Estimate
    sd: Estimate
    quantiles: Mapping[float, Estimate] = field(hash=False)
    linear_sd: float


@frozen(kw_only=True)
class Sensitivity:
    """Effect of the uncertainty of one parameter.

    Attributes
    ----------
    name, unit : str
        Dotted name of the parameter, and its unit.
    spread : str
        Description of its distribution.
    value, sd : float
        Value in the scenario, and standard deviation of the distribution.
    exponent : float or None
        d ln F / d ln of the parameter at the nominal scene; None if its value is 0.
    exponent_error : float or None
        Estimate of the absolute error of the exponent.
    peak_force_first, peak_force_total, amplification_first, amplification_total : Estimate
        Sobol indices: the fraction of the variance caused by the parameter alone, and including its interactions.
    """

    name: str
    unit: str
    spread: str
    value: float
    sd: float
    exponent: float | None
    exponent_error: float | None
    peak_force_first: Estimate
    peak_force_total: Estimate
    amplification_first: Estimate
    amplification_total: Estimate


@frozen(kw_only=True)
class Uncertainty:
    """Distribution of the peak force of the leading wave for uncertain parameters.

    Attributes
    ----------
    scenario : str
        Name of the scenario, if it has one.
    draws, seed, evaluations : int
        Number of scenes drawn; seed; number of scenes including those for the Sobol indices.
    method : "curve" or "simulation"
        Source of the peak forces.
    peak_force, amplification : Statistics
        Peak force of the leading wave [N], and its ratio to that of the shock.
    sensitivities : tuple of Sensitivity
        One for each uncertain parameter, in the given order.
    exponents : Exponents
        Exponents at the nominal scene.
    model_error : float
        Greatest bound on the relative error of a single peak force; the sampling error is separate.
    warnings : tuple of str
        Limits of the result, in sentences.
    values : mapping of str to ndarray, shape (draws,)
        Values of the parameters that were drawn.
    peak_forces : ndarray, shape (draws,)
        Peak forces of the scenes that were drawn [N].
    """

    scenario: str
    draws: int
    seed: int
    evaluations: int
    method: str
    peak_force: Statistics
    amplification: Statistics
    sensitivities: tuple[Sensitivity, ...]
    exponents: Exponents
    model_error: float
    warnings: tuple[str, ...]
    values: Mapping[str, FloatArray] = field(eq=False, repr=False)
    peak_forces: FloatArray = field(eq=False, repr=False)

    def to_dict(self) -> dict[str, Any]:
        """The document that ``uncertainty --json`` prints: SI floats, without the draws."""
        document = asdict(self, filter=lambda attribute, _: attribute.name not in ("values", "peak_forces"))
        return document | {name: _listed(document[name]) for name in ("peak_force", "amplification")}

    def __str__(self) -> str:
        force = self.peak_force
        ends = force.mean, force.quantiles[0.05], force.quantiles[0.95]
        mean, low, high = (_shown(each, self.model_error) for each in ends)
        sources = {"curve": "the universal curve of the shape", "simulation": "simulations, as the shape is uncertain"}
        ranked = sorted(self.sensitivities, key=lambda one: one.peak_force_total.value, reverse=True)
        forces = _column(force, self.model_error)
        ratios = _column(self.amplification, self.model_error)
        details = [
            ("peak forces", f"from {sources[self.method]}, each accurate to {self.model_error:.0e}"),
            ("scales as", f"{self.exponents} at the nominal values, each accurate to {self.exponents.error:.0e}"),
            ("samples", _samples(self)),
            ("scenario", self.scenario or "-"),
        ]
        lines = [
            *map(strong, paragraph("", f"peak force: mean {mean} N, 90 % between {low} and {high} N", 2)),
            *limits(self.warnings),
            "",
            table(list(_row(ranked[0])), [list(_row(one).values()) for one in ranked], _SPARE),
            *paragraph("  ", _VARIANCE_LEGEND, 2),
            "",
            table(("", "peak force, N", "amplification"), [(name, forces[name], ratios[name]) for name in forces]),
            *paragraph("  ", _STATISTICS_LEGEND, 2),
            "",
            *facts(details),
        ]
        return "\n".join(lines)


@frozen
class Parameter:
    """An uncertain parameter: its dotted name, unit, distribution in words, value in the scenario, and deviation."""

    name: str
    unit: str
    spread: str
    value: float
    sd: float


@frozen(kw_only=True)
class QuantityStatistics:
    """Distribution of one quantity of the simulations.

    Attributes
    ----------
    name, unit, label : str
        Name in the document of `simulate`, SI unit, and printed name.
    statistics : Statistics
        Its statistics.
    model_error : float
        Greatest bound on the relative error of a single simulation; the sampling error is separate.
    first, total : tuple of Estimate
        Sobol indices of the parameters, in their order: the fraction of the variance that a parameter causes alone, and
        including its interactions.
    exponents : tuple of float
        d ln of the quantity / d ln of each parameter at the nominal scene.
    """

    name: str
    unit: str
    label: str
    statistics: Statistics
    model_error: float
    first: tuple[Estimate, ...]
    total: tuple[Estimate, ...]
    exponents: tuple[float, ...]


@frozen(kw_only=True)
class SimulatedUncertainty:
    """Distributions of the forces in a chain beyond equal spheres for uncertain parameters, from simulations.

    Attributes
    ----------
    scenario : str
        Name of the scenario, if it has one.
    draws, seed, evaluations : int
        Number of scenes drawn; seed; number of scenes including those for the Sobol indices.
    parameters : tuple of Parameter
        The uncertain parameters, in the given order.
    quantities : tuple of QuantityStatistics
        The greatest force, the force and the impulse on a wall, the restitution of a striker, the dissipated energy,
        and the forces at the contacts of the scenario; those that every scene has.
    warnings : tuple of str
        Limits of the result, in sentences.
    values, outputs : mapping of str to ndarray, shape (draws,)
        Values of the parameters that were drawn, and of the quantities, by their names.
    """

    scenario: str
    draws: int
    seed: int
    evaluations: int
    parameters: tuple[Parameter, ...]
    quantities: tuple[QuantityStatistics, ...]
    warnings: tuple[str, ...]
    values: Mapping[str, FloatArray] = field(eq=False, repr=False)
    outputs: Mapping[str, FloatArray] = field(eq=False, repr=False)

    def to_dict(self) -> dict[str, Any]:
        """The document that ``uncertainty --json`` prints: SI floats, without the draws."""
        document = asdict(self, filter=lambda attribute, _: attribute.name not in ("values", "outputs"))
        for one in document["quantities"]:
            shares = zip(self.parameters, *(one.pop(name) for name in ("exponents", "first", "total")), strict=True)
            names = ("name", "exponent", "first", "total")
            one["sensitivities"] = [dict(zip(names, (each.name, *more), strict=True)) for each, *more in shares]
            one |= _listed(one.pop("statistics"))
        return {**document, "method": "simulation", "peak_force": None, "amplification": None}

    def __str__(self) -> str:
        named = self.quantities
        totals, firsts = [one.total for one in named], [one.first for one in named]
        first = [f"{one.label}: first-order, %" for one in named]
        header = ["source of variance", *(f"{one.label}, %" for one in named), "spread", *first]
        rows = []
        for index, one in enumerate(self.parameters):
            total, alone = ([_percent(each[index]) for each in shares] for shares in (totals, firsts))
            rows.append([one.name, *total, one.spread, *alone])
        columns = [_column(one.statistics, one.model_error) for one in named]
        units = [f"{one.label}, {one.unit.replace('*', ' ')}" if one.unit else one.label for one in named]
        errors = ", ".join(f"{one.label} {one.model_error:.0e}" for one in named)
        details = [
            ("simulations", f"largest relative error of a scene: {errors}"),
            ("samples", _samples(self)),
            ("scenario", self.scenario or "-"),
        ]
        lines = [
            *(strong(line) for one in named[:2] for line in paragraph("", _lead(one), 2)),
            *limits(self.warnings),
            "",
            table(header, rows, header[2:]),
            *paragraph("  ", _SHARES_LEGEND, 2),
            "",
            table(["", *units], [[name, *(column[name] for column in columns)] for name in columns[0]], units[1:]),
            *paragraph("  ", _SIMULATED_LEGEND, 2),
            "",
            *facts(details),
        ]
        return "\n".join(lines)


def _lead(one: QuantityStatistics) -> str:
    mean, low, high = (
        _shown(each, one.model_error)
        for each in (one.statistics.mean, one.statistics.quantiles[0.05], one.statistics.quantiles[0.95])
    )
    unit = one.unit and f" {one.unit.replace('*', ' ')}"
    return f"{one.label}: mean {mean}{unit}, 90 % between {low} and {high}{unit}"


def _samples(found: Uncertainty | SimulatedUncertainty) -> str:
    including = f"{found.evaluations} including those for the sensitivity indices"
    return f"{found.draws}, seed {found.seed}; {including}"


def _listed(statistics: dict[str, Any]) -> dict[str, Any]:
    """Statistics with the quantiles as a list."""
    pairs = statistics["quantiles"].items()
    return {**statistics, "quantiles": [{"share": share, **estimate} for share, estimate in pairs]}


def _column(one: Statistics, error: float) -> dict[str, str]:
    """Printed statistics of one quantity with this relative error."""
    nominal = si(one.nominal, "", error=error)
    quantiles = {_percentile(share): _shown(estimate, error) for share, estimate in one.quantiles.items()}
    moments = {"nominal": nominal, "mean": _shown(one.mean, error), "sd": _shown(one.sd, error)}
    return moments | {"linear sd": f"{one.linear_sd:.4g}"} | quantiles


def _shown(estimate: Estimate, error: float) -> str:
    """A statistic with its sampling error and the relative error of each value together."""
    return str(Estimate(estimate.value, math.hypot(estimate.error, error * estimate.value)))


def _percentile(share: float) -> str:
    return "median" if share == 0.5 else f"{100 * share:g}th percentile"


def _row(one: Sensitivity) -> dict[str, str]:
    """The columns of one parameter."""
    return {
        "source of variance": one.name,
        "first-order, %": _percent(one.peak_force_first),
        "total, %": _percent(one.peak_force_total),
        "spread": one.spread,
        "exponent": "-" if one.exponent is None else f"{one.exponent:.3f}",
        "amplification: first-order, %": _percent(one.amplification_first),
        "amplification: total, %": _percent(one.amplification_total),
    }


def _percent(share: Estimate) -> str:
    return str(Estimate(100 * share.value, 100 * max(share.error, _LEAST_SHARE)))
