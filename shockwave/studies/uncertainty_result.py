"""Distribution of the peak force for uncertain parameters: the data and their text."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from attrs import Attribute, asdict, field, frozen

from shockwave.limit import Exceedance, Verdict, verdict_facts
from shockwave.quadrature import FloatArray
from shockwave.result_base import VERSION, Result
from shockwave.studies.scaling_exponents import Exponents
from shockwave.tables import Table, along
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
# Label of the verdict, whose range contains this share of the scenes.
_VERDICT = "98 % of scenes"
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
class Parameter:
    """An uncertain parameter.

    Attributes
    ----------
    name, unit : str
        Dotted name of the parameter, and its unit.
    spread : str
        Description of its distribution.
    value, sd : float
        Value in the scenario, and standard deviation of the distribution.
    """

    name: str
    unit: str
    spread: str
    value: float
    sd: float


@frozen(kw_only=True)
class Sensitivity(Parameter):
    """Effect of the uncertainty of one parameter on the leading wave.

    Attributes
    ----------
    exponent : float or None
        d ln F / d ln of the parameter at the nominal scene; None if its value is 0.
    exponent_error : float or None
        Estimate of the absolute error of the exponent.
    peak_force_first, peak_force_total, amplification_first, amplification_total : Estimate
        Sobol indices: the fraction of the variance caused by the parameter alone, and including its interactions.
    """

    exponent: float | None
    exponent_error: float | None
    peak_force_first: Estimate
    peak_force_total: Estimate
    amplification_first: Estimate
    amplification_total: Estimate


@frozen(kw_only=True, repr=False)
class Sampled(Result):
    """A sample of scenes.

    Attributes
    ----------
    scenario : str
        Name of the scenario, if it has one.
    draws, seed, evaluations : int
        Number of scenes drawn; seed; number of scenes including those for the Sobol indices.
    warnings : tuple of str
        Limits of the result, in sentences.
    exceedance, verdict : Exceedance, Verdict or None
        Probability that the limit is reached, and the verdict on the range of 98 % of the scenes; None without a limit.
    values : mapping of str to ndarray, shape (draws,)
        Values of the parameters that were drawn.
    """

    scenario: str
    draws: int
    seed: int
    evaluations: int
    warnings: tuple[str, ...]
    exceedance: Exceedance | None = None
    verdict: Verdict | None = None
    values: Mapping[str, FloatArray] = field(eq=False, repr=False)

    _tables = (("quantiles", "probability"), ("draws", "draw"))

    def to_dict(self) -> dict[str, Any]:
        """The document that ``uncertainty --json`` prints: SI floats, without the draws."""
        return VERSION | asdict(self, filter=lambda attribute, _: bool(attribute.repr), value_serializer=_plain)


def _plain(_: object, attribute: Attribute[Any] | None, value: Any) -> Any:
    """Convert quantiles to a list; return any other value unchanged."""
    if attribute is not None and attribute.name == "quantiles":
        return [{"share": share, **asdict(estimate)} for share, estimate in value.items()]
    return value


@frozen(kw_only=True, repr=False)
class Uncertainty(Sampled):
    """Distribution of the peak force of the leading wave for uncertain parameters.

    It has the attributes of `Sampled` and the following ones.

    Attributes
    ----------
    method : "curve" or "simulation"
        Source of the peak forces.
    peak_force, amplification : Statistics
        Peak force of the leading wave [N], and its ratio to that of the shock.
    sensitivities : tuple of Sensitivity
        One for each uncertain parameter, in the given order.
    exponents : scaling_exponents.Exponents
        Exponents at the nominal scene.
    model_error : float
        Greatest bound on the relative error of a single peak force; the sampling error is separate.
    peak_forces : ndarray, shape (draws,)
        Peak forces of the scenes that were drawn [N].
    """

    method: str
    peak_force: Statistics
    amplification: Statistics
    sensitivities: tuple[Sensitivity, ...]
    exponents: Exponents
    model_error: float
    peak_forces: FloatArray = field(eq=False, repr=False)

    _brief = ("scenario", "peak_force.mean", "peak_force.sd", "draws", "method")

    def _table(self, name: str) -> Table:
        if name == "draws":
            units: Any = {one.name: one.unit for one in self.sensitivities}
            return along("draw", range(self.draws), {"peak_force": self.peak_forces, **self.values}, units)
        statistics = {"peak_force": self.peak_force, "amplification": self.amplification}
        found = {each: _quantiles(one) for each, one in statistics.items()}
        return along("probability", [*self.peak_force.quantiles], found)

    def __str__(self) -> str:
        sources = {"curve": "the universal curve of the shape", "simulation": "simulations, as the shape is uncertain"}
        ranked = sorted(self.sensitivities, key=lambda one: one.peak_force_total.value, reverse=True)
        details = [
            ("peak forces", f"from {sources[self.method]}, each accurate to {self.model_error:.0e}"),
            ("scales as", f"{self.exponents} at the nominal values, each accurate to {self.exponents.error:.0e}"),
        ]
        variances = table(list(_row(ranked[0])), [list(_row(one).values()) for one in ranked], _SPARE)
        error = self.model_error
        shown = [("peak force", " N", self.peak_force, error), ("amplification", "", self.amplification, error)]
        return _page(self, shown, 1, variances, (_VARIANCE_LEGEND, _STATISTICS_LEGEND), details)


@frozen(kw_only=True)
class Share:
    """Effect of the uncertainty of one parameter on one quantity.

    Attributes
    ----------
    name : str
        Dotted name of the parameter.
    exponent : float
        d ln of the quantity / d ln of the parameter at the nominal scene.
    first, total : Estimate
        Sobol indices: the fraction of the variance caused by the parameter alone, and including its interactions.
    """

    name: str
    exponent: float
    first: Estimate
    total: Estimate


@frozen(kw_only=True)
class QuantityStatistics(Statistics):
    """Statistics of one quantity of the simulations.

    Attributes
    ----------
    name, unit, label : str
        Name in the document of `simulate`, SI unit, and printed name.
    model_error : float
        Greatest bound on the relative error of a single simulation; the sampling error is separate.
    sensitivities : tuple of Share
        One for each uncertain parameter, in the given order.
    """

    name: str
    unit: str
    label: str
    model_error: float
    sensitivities: tuple[Share, ...]

    @property
    def printed_unit(self) -> str:
        """The unit after a number."""
        return self.unit and f" {self.unit.replace('*', ' ')}"


@frozen(kw_only=True, repr=False)
class SimulatedUncertainty(Sampled):
    """Distributions of the forces in a chain beyond equal spheres for uncertain parameters, from simulations.

    It has the attributes of `Sampled` and the following ones.

    Attributes
    ----------
    parameters : tuple of Parameter
        The uncertain parameters, in the given order.
    quantities : tuple of QuantityStatistics
        The greatest force, the force and the impulse on a wall, the restitution of a striker, the dissipated energy,
        and the forces at the contacts of the scenario; those that every scene has.
    outputs : mapping of str to ndarray, shape (draws,)
        Values of the quantities of the scenes that were drawn, by their names.
    """

    parameters: tuple[Parameter, ...]
    quantities: tuple[QuantityStatistics, ...]
    outputs: Mapping[str, FloatArray] = field(eq=False, repr=False)

    _brief = ("scenario", "quantities", "parameters", "draws")

    def _table(self, name: str) -> Table:
        units: Any = {one.name: one.unit.replace("*", " ") for one in self.quantities}
        if name == "draws":
            units |= {one.name: one.unit for one in self.parameters}
            return along("draw", range(self.draws), {**self.outputs, **self.values}, units)
        found = {one.name: _quantiles(one) for one in self.quantities}
        return along("probability", [*self.quantities[0].quantiles], found, units)

    def to_dict(self) -> dict[str, Any]:
        """The document that ``uncertainty --json`` prints: SI floats, without the draws."""
        return super().to_dict() | {"method": "simulation", "peak_force": None, "amplification": None}

    def __str__(self) -> str:
        named = self.quantities
        first = [f"{one.label}: first-order, %" for one in named]
        header = ["source of variance", *(f"{one.label}, %" for one in named), "spread", *first]
        rows = []
        for one, *shares in zip(self.parameters, *(each.sensitivities for each in named), strict=True):
            alone = (_percent(share.first) for share in shares)
            rows.append([one.name, *(_percent(share.total) for share in shares), one.spread, *alone])
        shown = [(one.label, one.printed_unit, one, one.model_error) for one in named]
        errors = ", ".join(f"{one.label} {one.model_error:.0e}" for one in named)
        details = [("simulations", f"largest relative error of a scene: {errors}")]
        return _page(self, shown, 2, table(header, rows, header[2:]), (_SHARES_LEGEND, _SIMULATED_LEGEND), details)


def _quantiles(one: Statistics) -> list[float]:
    return [estimate.value for estimate in one.quantiles.values()]


def _page(
    found: Sampled,
    quantities: Sequence[tuple[str, str, Statistics, float]],
    leading: int,
    variances: str,
    legends: tuple[str, str],
    details: Sequence[tuple[str, str]],
) -> str:
    """Text of a result.

    Parameters
    ----------
    quantities : sequence
        Label, unit printed after a number, statistics and relative error of each quantity.
    leading : int
        Number of quantities in the first lines.
    variances : str
        The table of variances.
    legends, details
        Legends of both tables, and further facts.
    """
    leads = []
    for label, unit, one, error in quantities[:leading]:
        mean, low, high = (_shown(each, error) for each in (one.mean, one.quantiles[0.05], one.quantiles[0.95]))
        leads += paragraph("", f"{label}: mean {mean}{unit}, 90 % between {low} and {high}{unit}", 2)
    header = ["", *(f"{label}{unit and ',' + unit}" for label, unit, *_ in quantities)]
    columns = [_column(one, error) for *_, one, error in quantities]
    samples = f"{found.draws}, seed {found.seed}; {found.evaluations} including those for the sensitivity indices"
    lines = [
        *map(strong, leads),
        *facts([*verdict_facts(found, _VERDICT), *[("exceedance", str(found.exceedance))] * bool(found.exceedance)]),
        *limits(found.warnings),
        "",
        variances,
        *paragraph("  ", legends[0], 2),
        "",
        table(header, [[name, *(column[name] for column in columns)] for name in columns[0]], header[1:]),
        *paragraph("  ", legends[1], 2),
        "",
        *facts([*details, ("samples", samples), ("scenario", found.scenario or "-")]),
    ]
    return "\n".join(lines)


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
