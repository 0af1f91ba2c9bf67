"""Amplification of a shock against its rise time, predicted and simulated."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from itertools import groupby, pairwise
from typing import TYPE_CHECKING

import numpy as np

from shockwave.chain.chain import Scales
from shockwave.errors import InvalidValueError, ShockwaveError
from shockwave.pictures.axes import finish, named
from shockwave.pictures.style import BLACK, BLUE, GREY, SKY, VERMILION
from shockwave.profiles.shock import Shock

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.chain.chain import Chain
    from shockwave.prediction.outcome import Outcome
    from shockwave.prediction.predictor import Predictor
    from shockwave.profiles.base import ShockProfile


# Impulses over F0 T0, from the impulse limit to long trains.
_WEAKEST = 0.15
_STRONGEST = 20.0
# No whole duration is longer than so many T0.
_LONGEST = 500.0
_POINTS = 41
_PREDICTED_TO_SIMULATED = 6
_HALVINGS = 40
_SHADES = {"ejection": "#FFFFFF", "single": "#D0D0D0", "train": "#F1F1F1"}
# A regime narrower than this share of the picture has no name in it.
_NARROW = 0.14


def amplification(
    ax: Axes,
    profile: ShockProfile,
    predictor: Predictor,
    chain: Chain,
    *,
    peak_force: float = 1.0,
    rise_times: Iterable[float] | None = None,
    mark: float | None = None,
) -> Axes:
    """Peak force of the primary over that of the shock against t0/T0, with the regimes of the prediction.

    For one shape it depends on t0/T0 alone: chain and peak force choose T0, and change nothing else. The band is where
    simulation is expected, by the errors measured for such shocks; there is none where no range is known.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    profile : ShockProfile
        The shape.
    predictor : Predictor
        Whose predictions are drawn.
    chain : Chain
        As for `simulate`.
    peak_force : float
        F0 [N], above 0.
    rise_times : iterable of float, optional
        t0/T0 at which to simulate, two at least. Left out, 41 for impulses of 0.15 to 20 F0 T0.
    mark : float, optional
        A rise time of one's own [s], marked by a line if it lies within.

    Raises
    ------
    InvalidValueError
        When rise times or peak force are out of range.
    """
    ratios = _ratios(profile, rise_times)
    unit = Scales.of(chain, Shock(profile=profile, peak_force=peak_force, rise_time=1.0).peak_force).time

    def shock(ratio: float) -> Shock:
        return Shock(profile=profile, peak_force=peak_force, rise_time=ratio * unit)

    def predicted(ratio: float) -> Outcome:
        return predictor.predict(shock(ratio), chain)

    fine = np.geomspace(ratios[0], ratios[-1], _PREDICTED_TO_SIMULATED * (len(ratios) - 1) + 1).tolist()
    outcomes = [predicted(ratio) for ratio in fine]
    ax.set(xscale="log", xlim=(fine[0], fine[-1]))
    _regimes(ax, fine, outcomes, predicted)
    _predictions(ax, fine, outcomes)
    highest = _simulations(ax, ratios, [shock(ratio) for ratio in ratios], chain)
    ax.axhline(1.0, color=GREY, linewidth=0.8, linestyle=":")
    if mark is not None and fine[0] <= mark / unit <= fine[-1]:
        ax.axvline(mark / unit, color=BLACK, linewidth=0.9, linestyle="-.", label="this shock")
    ax.set_ylim(0, 1.14 * max(highest, *(outcome.amplification for outcome in outcomes)))
    return finish(ax, "rise time over characteristic time, $t_0/T_0$", "amplification")


def _ratios(profile: ShockProfile, rise_times: Iterable[float] | None) -> list[float]:
    if rise_times is None:
        total = profile.areas().total
        most = min(_STRONGEST / total, _LONGEST / float(profile.duration_ratio))
        chosen: list[float] = np.geomspace(min(_WEAKEST / total, most / 10), most, _POINTS).tolist()
        return chosen
    given = sorted({float(ratio) for ratio in rise_times})
    if len(given) < 2 or not all(0 < ratio < math.inf for ratio in given):
        raise InvalidValueError.of("rise_times", f"must be two or more finite numbers above 0 (got {given})")
    return given


def _simulations(ax: Axes, ratios: Sequence[float], shocks: list[Shock], chain: Chain) -> float:
    """Marks of the simulated primaries; the greatest amplification among them, 0 without any."""
    # a page without this picture has no need of the simulator
    from shockwave.measurement.simulate import simulate_many

    results = zip(ratios, simulate_many(shocks, chain, waves="primary"), strict=True)
    found = {ratio: one.amplification for ratio, one in results if not isinstance(one, ShockwaveError)}
    lost = len(ratios) - len(found)
    label = "simulated" + (f" ({lost} of {len(ratios)} failed)" if lost else "")
    ax.plot(list(found), list(found.values()), "s", color=VERMILION, markersize=3, label=label)
    return max(found.values(), default=0.0)


def _predictions(ax: Axes, ratios: Sequence[float], outcomes: Sequence[Outcome]) -> None:
    """A line and a band for each stretch of one regime: between regimes the prediction jumps."""
    stretches = groupby(zip(ratios, outcomes, strict=True), key=lambda pair: pair[1].regime)
    for index, (_, pairs) in enumerate(stretches):
        x, own = zip(*pairs, strict=True)
        # a stretch of one point has no line
        style, first = "-" if len(x) > 1 else ".", index == 0
        values = [outcome.amplification for outcome in own]
        label = "predicted" if first else None
        ax.plot(x, values, style, color=BLUE, linewidth=1.2, markersize=2, label=label)
        low, high = np.transpose([_range(outcome) for outcome in own])
        if np.isfinite(low).any():
            label = None if "expected" in ax.get_legend_handles_labels()[1] else "expected"
            ax.fill_between(x, low, high, color=SKY, alpha=0.35, linewidth=0, label=label)


def _range(outcome: Outcome) -> tuple[float, float]:
    """Least and greatest amplification expected of a simulation; not a number where none is known."""
    low, high = outcome.expected_error or (math.nan, math.nan)
    # an error of -100 % leaves the greatest open: beyond any picture
    return outcome.amplification / (1 + high), outcome.amplification / max(1 + low, 1e-3)


def _regimes(
    ax: Axes, ratios: Sequence[float], outcomes: Sequence[Outcome], predicted: Callable[[float], Outcome]
) -> None:
    """Shades and names of the regimes, and their borders."""
    least, most = ratios[0], ratios[-1]
    spans = [(least, outcomes[0].regime)]
    for (short, before), (long, after) in pairwise(zip(ratios, outcomes, strict=True)):
        if before.regime != after.regime:
            spans.append((_border(predicted, short, long), after.regime))
            ax.axvline(spans[-1][0], color=GREY, linewidth=0.8, linestyle="--")
    for (begin, name), (end, _) in pairwise([*spans, (most, "")]):
        ax.axvspan(begin, end, color=_SHADES.get(name, _SHADES["train"]), linewidth=0, zorder=0)
        if math.log(end / begin) > _NARROW * math.log(most / least):
            named(ax, math.sqrt(begin * end), 0.985, name, va="top", xycoords=ax.get_xaxis_transform())


def _border(predicted: Callable[[float], Outcome], short: float, long: float) -> float:
    """Where the regime of ``short`` ends, by bisection."""
    before = predicted(short).regime
    for _ in range(_HALVINGS):
        middle = math.sqrt(short * long)
        if predicted(middle).regime == before:
            short = middle
        else:
            long = middle
    return math.sqrt(short * long)
