"""Fit the law for any exponent of the contact force to simulated shocks, and measure its range with other shocks.

    python docs/fit_kernel_law.py

writes, in about twenty minutes, ``shockwave/prediction/kernel_law.json`` and a table of ``docs/chains.md``. Half of the
shocks of the validation are of kinds that are not used in the fit.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from attrs import asdict, evolve, frozen
from fit_moments import NEW, OLD
from judge_auto import write_table
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from shock_kinds import ALL, MISLEADING, draw

import shockwave as sw
from shockwave.chain import Scales
from shockwave.chain.chain import HERTZ
from shockwave.chain.features import WAVE_EXPONENTS
from shockwave.chain.solitary_wave import wave_law
from shockwave.prediction.kernel_law import FULL_LENGTH, POWERS, RESOURCE, KernelLaw, solved
from shockwave.prediction.model_interface import ScaledShock

Kinds = Sequence[Callable[..., Any]]

PAGE = Path(__file__).parent / "chains.md"
FILE = Path(sw.__file__).parent / "prediction" / RESOURCE
STEEL = sw.Material(youngs_modulus=193e9, poisson_ratio=0.3, density=7958.0)
# Number of exponents and of coefficients of the two limits.
IMPULSE_FIT = (32, 24)
LASTING_FIT = (10, 8)
# Durations of a short and of a lasting shock over the time of the wave. The peak force of the short one differs from
# that of a vanishing duration by the power p + 1 of its duration.
SHORT = 1e-5
LASTING = 20.0
# Seed of the fit, and number of shocks of the fit and of the validation.
SEED = 1806
COUNT = 3000
# Durations in times of a wave of the shock's peak force. Near p = 1 long shocks take long to simulate: the longest
# scales as the square of p - 1 up to this value.
SHORTEST = 0.03
LONGEST = 40.0
# Factor of the longest duration for kinds with weak tails.
FAINT = 5
# Tolerance of the simulations, and largest error estimate of those that are used.
RTOL = 1e-5
MOST_ERROR = 1e-3
# Shocks that are simulated at once.
SHARE = 200
# Kinds of the fit, and those of the validation, whose seeds follow that of the fit, with their number.
FITTED: Kinds = (*ALL, *OLD)
VALIDATED: dict[str, Kinds] = {"other kinds": (*MISLEADING, *NEW), "kinds of the fit": FITTED}
JUDGED = 1000
# Pairs of a spread and the error that has weight one in the fit there, and the weight of shocks with several peaks.
ASKED = ((0, 1e-4), (0.02, 2e-4), (0.1, 0.003), (0.3, 0.015), (0.6, 0.033))
TURNING_WEIGHT = 0.5
# Exponents and spreads of the errors; the number of spreads below which the errors scale as the square.
ERROR_EXPONENTS = (1.1, 1.3, 1.6, 2.2, 3.2, 4.2, 5.5)
SPREADS = (0.02, 0.06, 0.2, 0.6, 1.5, 5.0)
SQUARE = 2
# The error is this quantile of the errors at similar exponents and spreads, multiplied by one of these factors, for
# shocks with one peak and with several, and at least LEAST at each spread, because there are few shocks near p = 1.
QUANTILE = 0.99
WIDENED = (1.4, 1.4)
LEAST = (2e-4, 1e-3, 0.01, 0.03, 0.03, 0.02)
# Largest spread with an estimate.
FARTHEST = 12.0
# Bands of the table.
EXPONENT_BANDS = (1.05, 1.25, 1.6, 2.2, 3.2, 6.0)
SPREAD_BANDS = (0.0, 0.1, 0.3, 1.0, 3.0, FARTHEST)


def chain_of(exponent: float) -> sw.Chain:
    """A chain with this exponent."""
    return sw.Chain(material=STEEL, radius=4.75e-3, contact=sw.PowerContact(exponent=exponent, stiffness=1e10))


def impulse_limit(exponent: float) -> float:
    """I_p, from the simulation of a very short shock with the impulse of a wave of 1 N."""
    chain, wave = chain_of(exponent), wave_law(exponent)
    scales = Scales.of(chain, 1.0)
    profile = sw.Triangular(duration_ratio=2)
    shock = sw.Shock(profile=profile, peak_force=2 * wave.momentum / SHORT, rise_time=SHORT / 2 * scales.time)
    return float(sw.simulate(shock, chain, rtol=1e-11).peak_force)


def lasting_limit(exponent: float) -> float:
    """C_p, from the simulation of a constant force of 1 N."""
    chain = chain_of(exponent)
    time = Scales.of(chain, 1.0).time * wave_law(exponent).momentum
    ends = [0.0, 1e-4 * time, LASTING * time, (LASTING + 1) * time]
    shock = sw.Shock(profile=sw.Tabulated(times=ends, forces=[0, 1, 1, 0]))
    return float(sw.simulate(shock, chain, rtol=1e-4, waves="primary").peak_force)


def series(function: Callable[[float], float], nodes: int, terms: int) -> list[float]:
    """Chebyshev coefficients of a function of the exponent in ln(p - 1)."""
    low, high = (math.log(end - 1) for end in WAVE_EXPONENTS)
    places = np.cos(np.pi * (np.arange(nodes) + 0.5) / nodes)
    exponents = 1 + np.exp((low + high + places * (high - low)) / 2)
    return list(map(float, chebyshev.chebfit(places, [function(float(p)) for p in exponents], terms - 1)))


# ---------------------------------------------------------------- shocks and simulations


@frozen(eq=False)
class Sample:
    """A simulated shock: its kind, the scaled shock, and F/F0."""

    kind: str
    shock: ScaledShock
    simulated: float


def drawn(seed: int, number: int, kinds: Kinds) -> tuple[str, sw.Shock, sw.Chain] | None:
    """Shock ``number`` of a sample, with a random exponent; None if there is none."""
    generator, kind = np.random.default_rng([seed, number]), kinds[number % len(kinds)]
    low, high = (math.log(end - 1) for end in WAVE_EXPONENTS)
    above = math.exp(generator.uniform(low, high))
    longest = LONGEST * min(1.0, above / FULL_LENGTH) ** 2 * (FAINT if kind in MISLEADING else 1)
    try:
        if kind in ALL or kind in MISLEADING:
            times, forces = draw(kind, number, seed, 1.0, 1.0)
            profile: sw.ShockProfile = sw.Tabulated(times=times, forces=forces)
        else:
            profile = kind(generator)
    except sw.InvalidValueError:  # because of the noise there may be no pulse
        return None
    chain = chain_of(1 + above)
    duration = math.exp(generator.uniform(math.log(SHORTEST), math.log(longest)))
    unit = wave_law(1 + above).momentum * Scales.of(chain, 1.0).time
    return kind.__name__, sw.Shock.of_duration(profile=profile, peak_force=1.0, duration=duration * unit), chain


def sample(seed: int, count: int, kinds: Kinds) -> Iterator[Sample]:
    """Simulated shocks of the kinds in turn."""
    for begin in range(0, count, SHARE):
        shocks = [each for number in range(begin, min(begin + SHARE, count)) if (each := drawn(seed, number, kinds))]
        names, excitations, chains = zip(*shocks, strict=True)
        results = sw.simulate_many(excitations, chains, rtol=RTOL, waves="primary")
        for name, shock, chain, result in zip(names, excitations, chains, results, strict=True):
            if isinstance(result, sw.SimulationResult) and result.error_estimate < MOST_ERROR:
                exponent, time = chain.exponent, Scales.of(chain, 1.0).time
                momentum = wave_law(exponent).momentum
                scaled = ScaledShock(shock.profile, shock.profile.areas(), shock.rise_time / time, momentum, exponent)
                yield Sample(name, scaled, result.amplification)


# ---------------------------------------------------------------- fit and validation


def fitted(law: KernelLaw, shocks: list[Sample]) -> KernelLaw:
    """Fit the correction by weighted least squares, and tabulate the remaining errors."""
    kernels = [solved(law, each.shock) for each in shocks]
    exponent = np.array([each.shock.exponent for each in shocks])
    spread, turns = (np.array([getattr(each, name) for each in kernels]) for name in ("spread", "turns"))
    missing = np.array([math.log(each.simulated) - one.log_force for each, one in zip(shocks, kernels, strict=True)])
    powers = (HERTZ / exponent[:, None] - 1) ** np.arange(POWERS)
    terms = (np.array([each.terms for each in kernels])[:, :, None] * powers[:, None]).reshape(len(shocks), -1)
    weight = np.where(turns, TURNING_WEIGHT, 1) / np.interp(spread, *np.transpose(ASKED))
    found = np.linalg.lstsq(terms * weight[:, None], missing * weight, rcond=None)[0]
    correction = [[float(f"{value:.6g}") for value in row] for row in found.reshape(-1, POWERS)]
    residual = np.abs(np.expm1(terms @ np.ravel(correction) - missing))
    places, knots = np.log(exponent - 1), np.log(np.subtract(ERROR_EXPONENTS, 1))
    edges = np.sqrt(np.multiply(SPREADS[:-1], SPREADS[1:]))
    band = np.searchsorted(edges, spread)
    errors = np.empty((2, len(knots), len(SPREADS)))
    for several, i, j in np.ndindex(*errors.shape):
        # the neighbours of an exponent belong to it, too
        low, high = knots[max(i - 1, 0)], knots[min(i + 1, len(knots) - 1)]
        near = ((places >= low) | (i == 0)) & ((places <= high) | (i == len(knots) - 1))
        own = near & (band == j) & (turns == several)
        scaled = residual[own] * (SPREADS[j] / spread[own]) ** (2 if j < SQUARE else 0)
        errors[several, i, j] = float(f"{max(WIDENED[several] * np.quantile(scaled, QUANTILE), LEAST[j]):.3g}")
    one, more = errors.tolist()
    return evolve(law, correction=correction, errors=one, turning_errors=more)


def judged(law: KernelLaw, shocks: list[Sample]) -> NDArray[np.float64]:
    """Exponent, spread, several peaks or not, error, half-range, and whether the range holds, for each shock.

    The last three are NaN where there is no estimate.
    """
    rows = []
    for each in shocks:
        found, kernel = law.amplifications(each.shock), solved(law, each.shock)
        judgement = (math.nan,) * 3
        if found is not None:
            peak, low, high = (end / each.simulated for end in found)
            judgement = abs(peak - 1), (high - low) / peak / 2, float(low - 2 * RTOL <= 1 <= high + 2 * RTOL)
        rows.append((each.shock.exponent, kernel.spread, float(kernel.turns), *judgement))
    return np.array(rows)


def table(found: dict[str, NDArray[np.float64]]) -> Iterator[str]:
    """Rows of the table, by kind, exponent and spread."""
    whole = np.concatenate(list(found.values()))
    parts = found | {name: whole[whole[:, 2] == turns] for turns, name in enumerate(("one peak", "several peaks"))}
    for column, name, bands in ((0, "$p$", EXPONENT_BANDS), (1, r"$\sigma$", SPREAD_BANDS)):
        for low, high in pairwise(bands):
            parts[f"{name} {low:g} to {high:g}"] = whole[(whole[:, column] >= low) & (whole[:, column] < high)]
    for name, part in (parts | {"all": whole}).items():
        known = part[np.isfinite(part[:, 3])]
        errors = " | ".join(f"{100 * float(np.quantile(known[:, 3], share)):.2g}" for share in (0.5, 0.98))
        figures = f"{100 * float(np.median(known[:, 4])):.2g} | {100 * known[:, 5].mean():.1f}"
        yield f"| {name} | {len(part)} | {len(known)} | {errors} | {figures} |"


def main() -> None:
    """Compute, fit and validate the law, and write all files."""
    limits = {
        "impulse": series(lambda p: math.log(impulse_limit(p) - 1), *IMPULSE_FIT),
        "lasting": series(lambda p: math.log(lasting_limit(p)), *LASTING_FIT),
    }
    empty: dict[str, Any] = {"correction": [], "errors": [], "turning_errors": []}
    known = {"exponents": WAVE_EXPONENTS, "error_exponents": ERROR_EXPONENTS, "spreads": SPREADS}
    law = KernelLaw(**limits, **known, **empty, farthest=FARTHEST)
    shocks = list(sample(SEED, COUNT, FITTED))
    law = fitted(law, shocks)
    entries = {
        "about": "law for any contact exponent (shockwave.prediction.kernel_law), described in docs/chains.md",
        "provenance": {"command": "python docs/fit_kernel_law.py", "shockwave": sw.__version__, "shocks": len(shocks)},
        "law": asdict(law),
    }
    FILE.write_text(json.dumps(entries, indent=1) + "\n", encoding="utf-8")
    found = {
        name: judged(law, list(sample(seed, JUDGED, kinds)))
        for seed, (name, kinds) in enumerate(VALIDATED.items(), SEED + 1)
    }
    rows = list(table(found))
    print(*rows, sep="\n")
    write_table(PAGE, "contact exponents", rows)
    worst = max(abs(law.limit(p) / impulse_limit(p) - 1) for p in (1.07, 1.3, 2.2, 5.5))
    print(f"largest error of a limit: {worst:.0e}")


if __name__ == "__main__":
    main()
