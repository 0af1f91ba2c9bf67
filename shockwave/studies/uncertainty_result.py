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
        for name in ("peak_force", "amplification"):
            pairs = document[name]["quantiles"].items()
            document[name]["quantiles"] = [{"share": share, **estimate} for share, estimate in pairs]
        return document

    def __str__(self) -> str:
        force = self.peak_force
        mean, low, high = map(self._shown, (force.mean, force.quantiles[0.05], force.quantiles[0.95]))
        sources = {"curve": "the universal curve of the shape", "simulation": "simulations, as the shape is uncertain"}
        ranked = sorted(self.sensitivities, key=lambda one: one.peak_force_total.value, reverse=True)
        forces = self._column(force)
        ratios = self._column(self.amplification)
        indices = "the sensitivity indices"
        details = [
            ("peak forces", f"from {sources[self.method]}, each accurate to {self.model_error:.0e}"),
            ("scales as", f"{self.exponents} at the nominal values, each accurate to {self.exponents.error:.0e}"),
            ("samples", f"{self.draws}, seed {self.seed}; {self.evaluations} including those for {indices}"),
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

    def _column(self, one: Statistics) -> dict[str, str]:
        """Printed statistics of one quantity."""
        nominal = si(one.nominal, "", error=self.model_error)
        quantiles = {_percentile(share): self._shown(estimate) for share, estimate in one.quantiles.items()}
        linear = f"{one.linear_sd:.4g}"
        moments = {"nominal": nominal, "mean": self._shown(one.mean), "sd": self._shown(one.sd), "linear sd": linear}
        return moments | quantiles

    def _shown(self, estimate: Estimate) -> str:
        """A statistic with its sampling error and the error of the peak forces together."""
        return str(Estimate(estimate.value, math.hypot(estimate.error, self.model_error * estimate.value)))


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
    return str(Estimate(100 * share.value, 100 * share.error))
