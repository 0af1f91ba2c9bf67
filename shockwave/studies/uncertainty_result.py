"""Distributions of forces for uncertain parameters: statistics, sensitivities, and the values that were drawn."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from attrs import Attribute, asdict, field, frozen

from shockwave.base.numerics import FloatArray
from shockwave.base.result import VERSION, Result
from shockwave.base.result_tables import Table, along
from shockwave.base.text import render
from shockwave.scene.force_limit import Exceedance, Verdict


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
class Sensitivity:
    """Effect of the uncertainty of one parameter on one quantity.

    Attributes
    ----------
    name : str
        Dotted name of the parameter.
    exponent, exponent_error : float or None
        d ln of the quantity / d ln of the parameter at the nominal scene, and the estimate of its absolute error; None
        if the value of the parameter is 0.
    first, total : Estimate
        Sobol indices: the fraction of the variance caused by the parameter alone, and including its interactions.
    """

    name: str
    exponent: float | None
    exponent_error: float | None
    first: Estimate
    total: Estimate


@frozen(kw_only=True)
class QuantityStatistics:
    """Statistics of one quantity.

    Attributes
    ----------
    name, unit, label : str
        Name in the document of `simulate`, SI unit, and printed name.
    nominal : float
        Value for the parameters of the scenario.
    mean, sd : Estimate
        Mean and standard deviation.
    quantiles : mapping of float to Estimate
        Quantiles by their probabilities.
    model_error : float
        Greatest estimate of the relative error of a single simulation; the sampling error is separate.
    sensitivities : tuple of Sensitivity
        One for each uncertain parameter, in the given order.
    """

    name: str
    unit: str
    label: str
    nominal: float
    mean: Estimate
    sd: Estimate
    quantiles: Mapping[float, Estimate] = field(hash=False)
    model_error: float
    sensitivities: tuple[Sensitivity, ...]


@frozen(kw_only=True, repr=False)
class Uncertainty(Result):
    """Distributions of the leading wave's peak force and amplification, or of the forces in a chain.

    Attributes
    ----------
    scenario : str
        Name of the scenario, if it has one.
    draws, seed, evaluations : int
        Number of scenes drawn; seed; number of scenes including those for the Sobol indices.
    parameters : tuple of Parameter
        The uncertain parameters, in the given order.
    quantities : tuple of QuantityStatistics
        The requested ones; the force that the limit concerns; then peak force and amplification of the leading wave
        where it has a limit, or else the greatest force, the force and the impulse on a wall, the restitution of a
        striker and the dissipated energy, of those that every scene has; then the forces at the contacts and the
        figures of the sensors of the scenario.
    warnings : tuple of str
        Limits of the result, in sentences.
    exceedance, verdict : Exceedance, Verdict or None
        Probability that the limit is reached, and the verdict on the range of 98 % of the scenes; None without a limit.
    yield_probability : Estimate or None
        Probability that a contact yields, of those whose yield strength is known; None where there are none.
    values : mapping of str to ndarray, shape (draws,)
        Values of the parameters that were drawn.
    outputs : mapping of str to ndarray, shape (draws,)
        Values of the quantities of the scenes that were drawn, by their names.
    """

    scenario: str
    draws: int
    seed: int
    evaluations: int
    parameters: tuple[Parameter, ...]
    quantities: tuple[QuantityStatistics, ...]
    warnings: tuple[str, ...]
    exceedance: Exceedance | None = None
    verdict: Verdict | None = None
    yield_probability: Estimate | None = None
    values: Mapping[str, FloatArray] = field(eq=False, repr=False)
    outputs: Mapping[str, FloatArray] = field(eq=False, repr=False)

    _brief = ("scenario", "quantities", "parameters", "draws")
    _picture = "shockwave.pictures.studies:distribution"
    _tables = (("quantiles", "probability"), ("sensitivities", "parameter"), ("draws", "draw"))

    @property
    def peak_force(self) -> QuantityStatistics | None:
        """Peak force of the leading wave [N]; None where it has no limit."""
        return self._find_quantity("peak_force")

    @property
    def amplification(self) -> QuantityStatistics | None:
        """Ratio of this peak force to that of the shock; None where it has no limit."""
        return self._find_quantity("amplification")

    def _find_quantity(self, name: str) -> QuantityStatistics | None:
        return next((each for each in self.quantities if each.name == name), None)

    def _table(self, name: str) -> Table | None:
        units: Any = {each.name: each.unit.replace("*", " ") for each in self.quantities}
        if name == "draws":
            units |= {each.name: each.unit for each in self.parameters}
            return along("draw", range(self.draws), {**self.outputs, **self.values}, units)
        if name == "sensitivities":
            shares = {
                f"{each.name} {kind}{suffix}": [getattr(getattr(share, kind), part) for share in each.sensitivities]
                for each in self.quantities
                for kind in ("first", "total")
                for suffix, part in (("", "value"), (" error", "error"))
            }
            return along("parameter", [each.name for each in self.parameters], shares, dict.fromkeys(shares, ""))
        columns = {each.name: [quantile.value for quantile in each.quantiles.values()] for each in self.quantities}
        return along("probability", [*self.quantities[0].quantiles], columns, units) if columns else None

    def to_dict(self) -> dict[str, Any]:
        """The document that ``uncertainty --json`` prints: SI floats, without the draws."""
        return VERSION | asdict(self, filter=lambda attribute, _: bool(attribute.repr), value_serializer=_plain)

    def __str__(self) -> str:
        return render(self, "shockwave.studies.uncertainty_text:text_of_uncertainty")


def _plain(_: object, attribute: Attribute[Any] | None, value: Any) -> Any:
    """Convert quantiles to a list; return any other value unchanged."""
    if attribute is not None and attribute.name == "quantiles":
        return [{"share": share, **asdict(estimate)} for share, estimate in value.items()]
    return value
