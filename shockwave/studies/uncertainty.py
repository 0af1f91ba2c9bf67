"""The distribution of the primary where values of the scene are uncertain: a result as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from attrs import asdict, field, frozen

from shockwave.quadrature import FloatArray
from shockwave.studies.scaling_exponents import Exponents
from shockwave.text import printed


@frozen
class Estimate:
    """A number and its error: of one from draws half its 95 % confidence interval, as the batches differ."""

    value: float
    error: float


@frozen(kw_only=True)
class Statistics:
    """How a quantity is distributed.

    Attributes
    ----------
    nominal : float
        With all values as in the scenario.
    mean, sd : Estimate
        Mean and standard deviation.
    quantiles : mapping of float to Estimate
        Values below which these shares lie.
    linear_sd : float
        Standard deviation by the exponents at the nominal scene, to first order, beside the sampled one.
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
        As it was given, in words.
    value, sd : float
        Of the value: in the scenario, and the standard deviation as it is drawn.
    exponent : float or None
        d ln F / d ln of the value at the nominal scene; None where the value is 0.
    exponent_error : float or None
        Estimate of its absolute error.
    peak_force_first, peak_force_total, amplification_first, amplification_total : Estimate
        Indices of Sobol: the share of the variance that the value makes alone, and with all others together.
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
        Scenes of which the distribution is made; seed; scenes with those for the indices.
    method : "curve" or "simulation"
        The origin of the peak forces.
    peak_force, amplification : Statistics
        Of the primary [N], and over the peak force of the shock.
    sensitivities : tuple of Sensitivity
        In the order in which they were given.
    exponents : Exponents
        At the nominal scene.
    model_error : float
        Greatest bound on the relative error of a single peak force; the errors of sampling come besides.
    warnings : tuple of str
        What a reader must know.
    values : mapping of str to ndarray, shape (draws,)
        The draws.
    peak_forces : ndarray, shape (draws,)
        And what came out [N].
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
        whole = asdict(self, filter=lambda attribute, _: attribute.name not in ("values", "peak_forces"))
        for name in ("peak_force", "amplification"):
            pairs = whole[name]["quantiles"].items()
            whole[name]["quantiles"] = [{"share": share, **estimate} for share, estimate in pairs]
        return {**whole, "warnings": list(self.warnings), "sensitivities": list(whole["sensitivities"])}

    def __str__(self) -> str:
        return printed(self, "shockwave.studies.uncertainty_text:uncertainty_text")
