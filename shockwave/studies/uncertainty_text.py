"""The distribution of the primary in words and tables."""

from __future__ import annotations

import math

from shockwave.studies.uncertainty import Estimate, Sensitivity, Statistics, Uncertainty
from shockwave.text import indent, notes, si, table


def uncertainty_text(found: Uncertainty) -> str:
    """The text that ``print`` shows."""
    of = f" of {found.scenario}" if found.scenario else ""
    means = {"curve": "the universal curve of the shape", "simulation": "simulations, as the shape is uncertain"}
    lines = [
        f"uncertainty{of}: {found.draws} draws, seed {found.seed}",
        f"  each peak force   within {found.model_error:.0e} relative, by {means[found.method]}",
        f"  goes with         {found.exponents} at the nominal scene, each within {found.exponents.error:.0e}",
        "",
        indent(_distributions(found)),
        "  (+-: half the 95 % confidence interval, from sixteen batches of draws, and besides the deviations also",
        "  the bound on each force; linear sd: by the exponents)",
        "",
        indent(_sensitivities(found)),
        "  (first, total: shares of the variance that a value makes alone, and with the others together)",
    ]
    return "\n".join(lines + notes(found.warnings))


def _distributions(found: Uncertainty) -> str:
    error = found.model_error
    columns = zip(_column(found.peak_force, "N", error), _column(found.amplification, "", error), strict=True)
    return table(("", "peak force", "amplification"), ((name, force, ratio) for (name, force), (_, ratio) in columns))


def _column(one: Statistics, unit: str, error: float) -> list[tuple[str, str]]:
    def whole(estimate: Estimate) -> Estimate:
        """With what each force may be off, which moves it by no more."""
        return Estimate(estimate.value, estimate.error + error * abs(estimate.value))

    quantiles = [(f"{100 * share:g} % below", _shown(whole(each), unit)) for share, each in one.quantiles.items()]
    sds = [
        ("sd", _shown(one.sd, unit)),
        ("linear sd", _shown(Estimate(one.linear_sd, one.sd.error), unit, alone=True)),
    ]
    nominal = _shown(whole(Estimate(one.nominal, 0.0)), unit)
    return [("nominal", nominal), ("mean", _shown(whole(one.mean), unit)), *sds, *quantiles]


def _shown(estimate: Estimate, unit: str, alone: bool = False) -> str:
    """A number with as many digits as its error leaves, and that, unless it is to stand ``alone``."""
    exponent = 3 * math.floor(math.log10(abs(estimate.value)) / 3) if unit and estimate.value else 0
    value, error = (number / 10.0**exponent for number in (estimate.value, estimate.error))
    decimals = max(1 - math.floor(math.log10(error)), 0) if error > 0 else 6
    behind = "" if alone else f" +- {error:.{decimals}f}"
    return f"{value:.{decimals}f}{behind} {si(10.0**exponent, unit).removeprefix('1 ') if unit else ''}".rstrip()


def _sensitivities(found: Uncertainty) -> str:
    header = ("value", "spread", "exponent", "peak force: first", "total", "amplification: first", "total")
    return table(header, map(_row, found.sensitivities))


def _row(one: Sensitivity) -> tuple[str, ...]:
    estimates = (one.peak_force_first, one.peak_force_total, one.amplification_first, one.amplification_total)
    exponent = "-" if one.exponent is None else f"{one.exponent:.3f}"
    return one.name, one.spread, exponent, *(_shown(share, "") for share in estimates)
