"""The text of an uncertainty: the distributions in short, the causes of the variance, and the statistics."""

from __future__ import annotations

import math

from attrs import evolve

from shockwave.base.text import facts, limits, paragraph, percent, si, strong, table
from shockwave.scene.force_limit import verdict_facts
from shockwave.scene.yielding import UNJUDGED
from shockwave.studies.uncertainty_result import Estimate, QuantityStatistics, Uncertainty

# Most quantities in the first lines.
_LEADING = 2
_SHARES_LEGEND = (
    "(contribution of a parameter to the variance of each quantity, including its interactions with other parameters; "
    "first-order: without them; +-: half the 95 % confidence interval of sampling)"
)
_STATISTICS_LEGEND = (
    "(sd: standard deviation; +-: half the 95 % confidence interval of sampling, and the error of the simulations)"
)
_ABOVE = "; contributions above 100 % are due to sampling, and more draws reduce them)"
# Note on the verdict.
_RANGE = " (median, and range of 98 % of the scenes)"
# Share of the variance above which more than 100 % is printed, and the legend explains it.
_SHOWN_ABOVE = 1.005
# Smallest printed error of a share of the variance.
_LEAST_SHARE = 1e-5


def text_of_uncertainty(result: Uncertainty) -> str:
    """The distributions in short, warnings, the table of variances, the table of statistics, and the cost."""
    leads, result = [], evolve(result, quantities=tuple(map(_in_prefixed_unit, result.quantities)))
    for each in result.quantities[:_LEADING]:
        mean, low, high = (_text(part, each) for part in (each.mean, each.quantiles[0.05], each.quantiles[0.95]))
        unit = _unit(each)
        leads += paragraph("", f"{each.label}: mean {mean}{unit}, 90 % between {low} and {high}{unit}", 2)
    errors = ", ".join(f"{each.label} {each.model_error:.0e}" for each in result.quantities)
    samples = f"{result.draws}, seed {result.seed}; {result.evaluations} including those for the sensitivity indices"
    probabilities = [("exceedance", str(result.exceedance))] if result.exceedance else []
    if result.yield_probability is not None:
        share = result.yield_probability
        where = " at contacts that are judged" if any(UNJUDGED in each for each in result.warnings) else ""
        probabilities.append(("first yield", f"probability {percent(share.value)} +- {percent(share.error)}{where}"))
    lines = [
        *map(strong, leads),
        *facts([*verdict_facts(result, _RANGE), *probabilities]),
        *limits(result.warnings),
        *(["", *_variances(result), "", *_statistics(result)] if result.quantities else []),
        "",
        *facts(
            [
                ("simulations", f"largest relative error of a scene: {errors or '-'}"),
                ("samples", samples),
                ("scenario", result.scenario or "-"),
            ]
        ),
    ]
    return "\n".join(lines)


def _variances(result: Uncertainty) -> list[str]:
    """The table of contributions to the variance, that of the greatest to the first quantity first."""
    labels = [each.label for each in result.quantities]
    exponents, first = ([f"{label}: {what}" for label in labels] for what in ("exponent", "first-order, %"))
    header = ["source of variance", *(f"{label}, %" for label in labels), "spread", *exponents, *first]
    rows = []
    shares = list(zip(*(each.sensitivities for each in result.quantities), strict=True))
    for parameter, effects in sorted(
        zip(result.parameters, shares, strict=True), key=lambda pair: -pair[1][0].total.value
    ):
        row = [parameter.name.removeprefix("chain."), *(_percent(each.total) for each in effects), parameter.spread]
        row += ["-" if each.exponent is None else f"{each.exponent:.3f}" for each in effects]
        rows.append([*row, *(_percent(each.first) for each in effects)])
    above = any(share.total.value > _SHOWN_ABOVE for effects in shares for share in effects)
    legend = _SHARES_LEGEND.removesuffix(")") + (_ABOVE if above else ")")
    return [table(header, rows, header[2:]), *paragraph("  ", legend, 2)]


def _statistics(result: Uncertainty) -> list[str]:
    """The table of statistics."""
    header = ["", *(f"{each.label}{_unit(each) and ',' + _unit(each)}" for each in result.quantities)]
    columns = [_column(each) for each in result.quantities]
    rows = [[name, *(column[name] for column in columns)] for name in columns[0]]
    return [table(header, rows, header[1:]), *paragraph("  ", _STATISTICS_LEGEND, 2)]


def _column(each: QuantityStatistics) -> dict[str, str]:
    """Printed statistics of one quantity."""
    nominal = si(each.nominal, "", error=each.model_error)
    quantiles = {_percentile(share): _text(estimate, each) for share, estimate in each.quantiles.items()}
    moments = {"nominal": nominal, "mean": _text(each.mean, each), "sd": _text(each.sd, each)}
    return moments | quantiles


def _in_prefixed_unit(each: QuantityStatistics) -> QuantityStatistics:
    """The statistics in the unit with the SI prefix that the nominal value has."""
    number, _, unit = si(each.nominal, each.unit.replace("*", " "), 15).partition(" ")
    if not each.nominal or not unit:
        return each
    factor = 10.0 ** round(math.log10(float(number) / each.nominal))
    mean, sd, *quantiles = (
        Estimate(factor * estimate.value, factor * estimate.error)
        for estimate in (each.mean, each.sd, *each.quantiles.values())
    )
    shares = dict(zip(each.quantiles, quantiles, strict=True))
    return evolve(each, nominal=factor * each.nominal, unit=unit, mean=mean, sd=sd, quantiles=shares)


def _unit(each: QuantityStatistics) -> str:
    """The unit after a number."""
    return each.unit and f" {each.unit}"


def _text(estimate: Estimate, each: QuantityStatistics) -> str:
    """A statistic with its sampling error and the relative error of the simulations together."""
    return str(Estimate(estimate.value, math.hypot(estimate.error, each.model_error * estimate.value)))


def _percentile(share: float) -> str:
    return "median" if share == 0.5 else f"{100 * share:g}th percentile"


def _percent(share: Estimate) -> str:
    return str(Estimate(100 * share.value, 100 * max(share.error, _LEAST_SHARE)))
