"""Draw the pictures of ``docs/universal.md``.

    python docs/draw_universal.py

writes, in about half a minute, ``docs/universal/collapse.svg``, random pulses of many kinds on one curve, and
``docs/universal/cost.svg``, error against run time of all methods for the peak force of the leading wave. The former
changes only if matplotlib or the simulated values change; the run times of the latter are those of the machine that
draws it. The kinds of pulses are those of ``fit_moments.py`` in the same folder.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from attrs import frozen
from fit_moments import CHAIN, NEW, OLD, SCALES, Array, lasting
from judge_auto import fresh
from matplotlib.axes import Axes

import shockwave as sw
from shockwave import UniversalCurve, pictures
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.pictures.drawing import BLACK, COLOURS, GREY, LINES, MARKERS, label_axis
from shockwave.pictures.figures import SMALL
from shockwave.prediction.model_interface import ScaledShock, Shocks
from shockwave.prediction.shock_impulses import pulse_of
from shockwave.prediction.short_shock_law import CORRECTION, IMPULSE_LIMIT, integrals, short_law

FOLDER = Path(__file__).parent / "universal"
# Seed and number of the pulses.
SEED = 6401
COUNT = 260
#: Names of the families of pulses, with their kinds.
FAMILIES = {
    "power laws, exponentials": ("power_law", "exponential"),
    "records of random peaks": ("one_peak", "several_peaks"),
    "half-sine, haversine, Hertz, blast": ("half_sine", "haversine", "hertz", "friedlander"),
    "trapezoid, sawtooth": ("trapezoid", "sawtooth"),
    "two humps": ("two_humps",),
    "records with noise": ("noisy",),
}
# Range of the durations, in T0.
SHORTEST = 0.3
LONGEST = 40.0
# Tolerances of the methods that have one.
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
# Relative error of the reference simulations.
KNOWN = 1e-11


@frozen(eq=False)
class Drawn:
    """Pulses: family, tau, x of the short law, skewness, simulated and predicted F over the impulse limit."""

    family: list[str]
    spread: Array
    x: Array
    skewness: Array
    simulated: Array
    predicted: Array


def drawn() -> Drawn:
    """Random pulses of all kinds, with tau from 0.01 to 5."""
    draw, kinds = np.random.default_rng(SEED), (*OLD, *NEW)
    rows: list[tuple[Any, ...]] = []
    shocks = []
    while len(rows) < COUNT:
        kind = kinds[len(rows) % len(kinds)]
        try:
            profile = kind(draw)
        except sw.InvalidValueError:  # because of the noise there may be no pulse
            continue
        areas, duration = profile.areas(), math.exp(draw.uniform(math.log(SHORTEST), math.log(LONGEST)))
        shock = lasting(profile, duration)
        ratio = shock.rise_time / SCALES.time
        pulse = pulse_of(ScaledShock(profile, areas, ratio, MOMENTUM))
        if not pulse.known:
            continue
        correction, skewness, _ = integrals([profile], [areas.total])[0].tolist()
        family = next(name for name, known in FAMILIES.items() if kind.__name__ in known)
        limit = IMPULSE_LIMIT * pulse.impulses.sum() ** 1.2
        peak = sw.Predictor().predict(shock, CHAIN).amplification
        rows.append((family, pulse.spread, CORRECTION * correction * ratio**3, skewness, limit, peak / limit))
        shocks.append(shock)
    results = sw.simulate_many(shocks, CHAIN, rtol=1e-5, waves="primary")
    peaks = np.array([result.amplification for result in results if isinstance(result, sw.SimulationResult)])
    family, *numbers = zip(*rows, strict=True)
    spread, x, skewness, limit, predicted = (np.array(each) for each in numbers)
    return Drawn(list(family), spread, x, skewness, peaks / limit, predicted)


def scatter(made: Drawn, most: float = 0.3) -> float:
    """Largest relative deviation from one curve in tau, for pulses with a spread of at most ``most``."""
    near = made.spread <= most
    spread, off = made.spread[near], np.log(made.simulated[near])
    columns = np.stack([spread**power for power in (2, 2.5, 3, 4)], axis=1)
    return float(np.abs(np.expm1(off - columns @ np.linalg.lstsq(columns, off, rcond=None)[0])).max())


def points(ax: Axes, made: Drawn, across: Array, values: Array, top: float) -> None:
    """Draw a mark for each pulse; pulses above the picture are marked at its edge."""
    for index, family in enumerate(FAMILIES):
        own = np.array([each == family for each in made.family])
        look = {"color": COLOURS[index], "marker": MARKERS[index], "linestyle": "none", "markersize": 2.6}
        inside = own & (values <= top)
        ax.plot(across[inside], values[inside], label=family, alpha=0.8, markeredgewidth=0, **look)
    low, high = float(np.quantile(across, 0.03)), float(np.max(across)) * 1.5
    beyond = (values > top) & (across > low)
    ax.plot(across[beyond], np.full(beyond.sum(), top), "^", color=BLACK, markersize=3, clip_on=False)
    if beyond.any():
        ax.text(0.98, 0.95, f"{beyond.sum()} above", transform=ax.transAxes, ha="right", fontsize=SMALL)
    ax.set_xscale("log")
    ax.set_xlim(low, high)
    ax.set_ylim(0, top)


def collapse(made: Drawn) -> None:
    """Draw simulated and predicted pulses over the spread, and simulated ones over x with the short law."""
    figure, (left, middle, right) = pictures.figure(1, 3, (9.6, 3.8))
    points(left, made, made.spread, made.simulated, 1.6)
    points(middle, made, made.spread, made.predicted, 1.6)
    short = made.x < short_law().farthest
    at = np.geomspace(made.x[short].min(), short_law().farthest, 100)
    points(right, made, made.x, made.simulated, 1.6)
    for skewness, line in zip((-1.0, 0.0, 1.0), LINES[1:], strict=False):
        ones = np.ones_like(at) * IMPULSE_LIMIT ** (-1 / 1.2)
        curve = short_law().amplification(ones, at, skewness)
        right.plot(at, curve, color=BLACK, linestyle=line, linewidth=0.9, label=f"law, skewness {skewness:g}")
    names = ("simulated", "by section 4", "simulated")
    across = (r"spread $\tau$", r"spread $\tau$", r"$x = 1.1445\, q\,(t_0/T_0)^3$")
    for ax, name, below in zip((left, middle, right), names, across, strict=True):
        label_axis(ax, "y", rf"$F / (1.168\, F_0 S^{{6/5}})$, {name}")
        label_axis(ax, "x", below)
    figure.set_layout_engine(None)
    figure.subplots_adjust(left=0.06, right=0.985, bottom=0.13, top=0.8, wspace=0.28)
    figure.legend(*right.get_legend_handles_labels(), loc="upper center", ncols=3, fontsize=SMALL, frameon=False)
    pictures.save(figure, FOLDER / "collapse.svg")


# ---------------------------------------------------------------- error against run time


def shocks_of(profiles: list[sw.ShockProfile], count: int) -> list[sw.Shock]:
    """``count`` shocks of each shape, log-uniform in their duration."""
    draw = np.random.default_rng(SEED + 1)
    durations = np.exp(draw.uniform(math.log(0.05), math.log(20), (len(profiles), count)))
    return [lasting(profile, value) for profile, own in zip(profiles, durations, strict=True) for value in own]


def best(calls: dict[Any, Callable[[], Array]], repeats: int = 3) -> dict[Any, tuple[float, Array]]:
    """Shortest run time of each call with empty caches, and its result; the calls take turns."""
    found: dict[Any, tuple[float, Array]] = {}
    for _ in range(repeats):
        for name, call in calls.items():
            fresh()
            begin = time.perf_counter()
            values = call()
            seconds = time.perf_counter() - begin
            found[name] = min(seconds, found[name][0] if name in found else math.inf), values
    return found


def ways(profiles: list[sw.ShockProfile], shocks: list[sw.Shock]) -> dict[Any, Callable[[], Array]]:
    """All methods for the amplification, by name and tolerance."""
    each = len(shocks) // len(profiles)

    def model(name: str) -> Callable[[], Array]:
        return lambda: np.array([sw.Predictor(model=name).predict(shock, CHAIN).amplification for shock in shocks])

    def many(name: str) -> Callable[[], Array]:
        return lambda: sw.Predictor(model=name).predict_many(shocks, CHAIN).amplification

    def one_by_one(rtol: float) -> Callable[[], Array]:
        return lambda: np.array([sw.simulate(s, CHAIN, rtol=rtol, waves="primary").amplification for s in shocks])

    def together(rtol: float) -> Callable[[], Array]:
        return lambda: np.array(
            [result.amplification for result in sw.simulate_many(shocks, CHAIN, rtol=rtol, waves="primary")]  # type: ignore[union-attr]
        )

    ratios = np.array([shock.rise_time / SCALES.time for shock in shocks]).reshape(len(profiles), each)

    def curve(rtol: float) -> Callable[[], Array]:
        made = [UniversalCurve(profile, rtol) for profile in profiles]
        return lambda: np.concatenate([one.amplification(own) for one, own in zip(made, ratios, strict=True)])

    def auto(rtol: float) -> Callable[[], Array]:
        return lambda: sw.Predictor(model="auto", rtol=rtol).predict_many(shocks, CHAIN).amplification

    areas = tuple(profile.areas() for profile in profiles)
    shapes = np.repeat(np.arange(len(profiles)), each)

    def short_form() -> Array:
        values, bounds, _ = short_law().of(Shocks(tuple(profiles), areas, shapes, ratios.ravel(), MOMENTUM))
        return np.where(bounds <= 1e-2, values, np.nan)

    calls: dict[Any, Callable[[], Array]] = {("section 4", 0): model("section-4")}
    calls[("short form of the law, where it holds", 0)] = short_form
    calls[("law of moments", 0)] = model("moments")
    calls[("law of moments, many at once", 0)] = many("moments")
    calls |= {("curve, once made", rtol): curve(rtol) for rtol in TOLERANCES[:5]}
    calls |= {("auto, many at once", rtol): auto(rtol) for rtol in TOLERANCES[:5]}
    calls |= {("simulation", rtol): one_by_one(rtol) for rtol in TOLERANCES}
    calls |= {("simulation, many at once", rtol): together(rtol) for rtol in TOLERANCES}
    return calls


def cost() -> None:
    """Draw the 99th percentile of the error against the run time per pulse, over that of a simulation to 1e-6."""
    profiles: list[sw.ShockProfile] = [
        sw.Triangular(duration_ratio=3),
        sw.PowerLaw(rise_exponent=0.5, decay_exponent=2, duration_ratio=4),
        sw.Exponential(rise_rate=2, decay_rate=4, duration_ratio=8),
        sw.Tabulated(times=[0, 1, 2, 3, 5], forces=[0, 0.6, 1, 0.5, 0]),
    ]
    shocks = shocks_of(profiles, 60)
    results = sw.simulate_many(shocks, CHAIN, rtol=KNOWN, waves="primary")
    true = np.array([result.amplification for result in results if isinstance(result, sw.SimulationResult)])
    found = best(ways(profiles, shocks))
    unit = found[("simulation", 1e-6)][0]
    figure, (ax,) = pictures.figure(1, 1, (7.4, 3.6))
    names = list(dict.fromkeys(name for name, _ in found))
    for index, name in enumerate(names):
        own = [
            (seconds / unit, np.abs(values / true - 1)) for (of, _), (seconds, values) in found.items() if of == name
        ]
        across = [seconds for seconds, _ in own]
        look = {"color": (*COLOURS, GREY)[index], "marker": MARKERS[index], "markersize": 4}
        ax.plot(across, [np.nanquantile(error, 0.99) for _, error in own], label=name, linewidth=1, **look)
        if len(own) == 1:
            median = float(np.nanmedian(own[0][1]))
            ax.plot(across * 2, [median, np.nanquantile(own[0][1], 0.99)], color=look["color"], linewidth=0.8)
            ax.plot(across, [median], marker="_", color=look["color"], markersize=7)
        print(
            name, [(f"{seconds:.2g}", f"{np.nanmedian(e):.1e}", f"{np.nanquantile(e, 0.99):.1e}") for seconds, e in own]
        )
    ax.set_xscale("log")
    ax.set_yscale("log")
    label_axis(ax, "x", "time of a pulse, over that of one simulation to 1e-6")
    label_axis(ax, "y", "relative error, 99th percentile")
    figure.set_layout_engine(None)
    figure.subplots_adjust(left=0.09, right=0.66, bottom=0.13, top=0.97)
    figure.legend(loc="upper right", fontsize=SMALL, frameon=False)
    pictures.save(figure, FOLDER / "cost.svg")


def main() -> None:
    """Draw both pictures."""
    FOLDER.mkdir(exist_ok=True)
    made = drawn()
    for low, high in ((0, 0.1), (0.1, 0.3), (0.3, 0.7), (0.7, 12)):
        here = (made.spread >= low) & (made.spread < high)
        print(f"tau {low} to {high}: {here.sum()} pulses, section 4 above 1.6: {(made.predicted[here] > 1.6).sum()}")
    print(f"up to tau 0.3 off one curve: {100 * scatter(made):.2f} %")
    collapse(made)
    cost()


if __name__ == "__main__":
    main()
