"""The distribution of the primary where values of the scene are uncertain: plain data and its text."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from attrs import asdict, field, frozen

from shockwave.quadrature import FloatArray
from shockwave.studies.scaling_exponents import Exponents
from shockwave.text import notes, table


@frozen
class Estimate:
    """A number and its error: half the 95 % confidence interval of sampling, from the scatter of the batches."""

    value: float
    error: float

    def __str__(self) -> str:
        decimals = max(1 - math.floor(math.log10(self.error)), 0) if self.error > 0 else 6
        return f"{self.value:.{decimals}f} +- {self.error:.{decimals}f}"


@frozen(kw_only=True)
class Statistics:
    """Statistics of a quantity.

    Attributes
    ----------
    nominal : float
        For the values of the scenario.
    mean, sd : Estimate
        Mean and standard deviation.
    quantiles : mapping of float to Estimate
        Values below which these shares lie.
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
    """The effect of the uncertainty of one value.

    Attributes
    ----------
    name, unit : str
        Dotted name of the value, and its unit.
    spread : str
        Its distribution, in words.
    value, sd : float
        The value of the scenario, and the standard deviation of its distribution.
    exponent : float or None
        d ln F / d ln of the value at the nominal scene; None where the value is 0.
    exponent_error : float or None
        Estimate of its absolute error.
    peak_force_first, peak_force_total, amplification_first, amplification_total : Estimate
        Sobol indices: the share of the variance that the value causes alone, and together with all others.
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
    """Distribution of the primary's peak force where values of the scene are uncertain.

    Attributes
    ----------
    scenario : str
        Name of the scenario, if it has one.
    draws, seed, evaluations : int
        Scenes of the distribution; seed; scenes including those for the indices.
    method : "curve" or "simulation"
        The source of the peak forces.
    peak_force, amplification : Statistics
        Of the primary [N], and over the peak force of the shock.
    sensitivities : tuple of Sensitivity
        In the order in which they were given.
    exponents : Exponents
        At the nominal scene.
    model_error : float
        Greatest bound on the relative error of a single peak force; errors of sampling are separate.
    warnings : tuple of str
        Limits of the answer, in sentences.
    values : mapping of str to ndarray, shape (draws,)
        The draws.
    peak_forces : ndarray, shape (draws,)
        Their peak forces [N].
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
        of = f" of {self.scenario}" if self.scenario else ""
        sources = {"curve": "the universal curve of the shape", "simulation": "simulations, as the shape is uncertain"}
        forces = _column(self.peak_force)
        ratios = _column(self.amplification)
        indices = ("peak_force_first", "peak_force_total", "amplification_first", "amplification_total")
        rows = []
        for one in self.sensitivities:
            exponent = "-" if one.exponent is None else f"{one.exponent:.3f}"
            shares = (str(getattr(one, index)) for index in indices)
            rows.append((one.name, one.spread, exponent, *shares))
        header = ("value", "spread", "exponent", "peak force: first", "total", "amplification: first", "total")
        lines = [
            f"uncertainty{of}: {self.draws} draws, seed {self.seed}",
            f"  each peak force   within {self.model_error:.0e} relative, by {sources[self.method]}",
            f"  scales as         {self.exponents} at the nominal scene, each within {self.exponents.error:.0e}",
            "",
            table(("", "peak force, N", "amplification"), [(name, forces[name], ratios[name]) for name in forces]),
            "  (+-: half the 95 % confidence interval of sampling; linear sd: from the exponents)",
            "",
            table(header, rows),
            "  (first, total: shares of the variance that a value causes alone, and together with the others)",
        ]
        return "\n".join(lines + notes(self.warnings))


def _column(one: Statistics) -> dict[str, str]:
    """Statistics in printed form."""
    quantiles = {f"{100 * share:g} % below": str(estimate) for share, estimate in one.quantiles.items()}
    return {
        "nominal": f"{one.nominal:.6g}",
        "mean": str(one.mean),
        "sd": str(one.sd),
        "linear sd": f"{one.linear_sd:.4g}",
        **quantiles,
    }
