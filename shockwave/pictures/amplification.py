"""Amplification of a shock against its rise time, predicted and simulated."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from shockwave.chain.chain import Scales
from shockwave.errors import InvalidValueError, ShockwaveError
from shockwave.pictures.style import BLACK, BLUE, GREY, SKY, SMALL, VERMILION, dress, key, ratio
from shockwave.profiles.shock import Shock

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.chain.chain import Chain
    from shockwave.measurement.result import SimulationResult
    from shockwave.prediction.outcome import Outcome
    from shockwave.prediction.predictor import Predictor
    from shockwave.profiles.base import ShockProfile

    Predict: TypeAlias = Callable[[float], Outcome]

__all__ = ["amplification"]

# From the impulse limit to long trains: impulse over F0 T0. No whole duration is longer than so many T0.
_WEAKEST, _STRONGEST, _LONGEST, _POINTS = 0.15, 20.0, 500.0, 41
_PREDICTED_TO_SIMULATED = 6
_HALVINGS = 40
_SHADES = {"ejection": "#FFFFFF", "single": "#D0D0D0", "train": "#F1F1F1"}
# A regime narrower than this share of the picture has no name in it.
_ROOM = 0.14


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
    _regimes(ax, fine, outcomes, predicted)
    _predictions(ax, fine, outcomes)
    highest = _simulations(ax, ratios, [shock(ratio) for ratio in ratios], chain)
    ax.axhline(1.0, color=GREY, linewidth=0.8, linestyle=":")
    if mark is not None and fine[0] <= mark / unit <= fine[-1]:
        ax.axvline(mark / unit, color=BLACK, linewidth=0.9, linestyle="-.", label="this shock")
    ax.set_ylim(0, 1.14 * max(highest, *(outcome.amplification for outcome in outcomes)))
    ratio(ax, "x", "rise time over natural time, $t_0/T_0$")
    ratio(ax, "y", "amplification")
    key(ax)
    return dress(ax)


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

    results: list[SimulationResult | ShockwaveError] = simulate_many(shocks, chain, waves="primary")
    known = [
        (ratio, result.amplification)
        for ratio, result in zip(ratios, results, strict=True)
        if not isinstance(result, ShockwaveError)
    ]
    lost = len(ratios) - len(known)
    label = "simulated" + (f" ({lost} of {len(ratios)} failed)" if lost else "")
    ax.plot([x for x, _ in known], [y for _, y in known], "s", color=VERMILION, markersize=3, label=label)
    return max((y for _, y in known), default=0.0)


def _predictions(ax: Axes, ratios: Sequence[float], outcomes: Sequence[Outcome]) -> None:
    """A line for each stretch of one regime: between regimes the prediction jumps."""
    changes = [i for i in range(1, len(ratios)) if outcomes[i].regime != outcomes[i - 1].regime]
    label: str | None = "predicted"
    for begin, end in pairwise([0, *changes, len(ratios)]):
        values = [outcome.amplification for outcome in outcomes[begin:end]]
        # a stretch of one point has no line
        style = "-" if end - begin > 1 else "."
        ax.plot(ratios[begin:end], values, style, color=BLUE, linewidth=1.2, markersize=2, label=label)
        label = None
    label = "expected"
    for begin, end in pairwise([0, *changes, len(ratios)]):
        told = [index for index in range(begin, end) if outcomes[index].expected_error is not None]
        for stretch in np.split(told, np.flatnonzero(np.diff(told) != 1) + 1) if told else []:
            low, high = zip(*(_range(outcomes[index]) for index in stretch), strict=True)
            x = [ratios[index] for index in stretch]
            ax.fill_between(x, low, high, color=SKY, alpha=0.35, linewidth=0, label=label)
            label = None


def _range(outcome: Outcome) -> tuple[float, float]:
    """Least and greatest amplification expected of a simulation."""
    assert outcome.expected_error is not None
    low, high = outcome.expected_error
    # an error of -100 % leaves the greatest open: beyond any picture
    return outcome.amplification / (1 + high), outcome.amplification / max(1 + low, 1e-3)


def _regimes(ax: Axes, ratios: Sequence[float], outcomes: Sequence[Outcome], predicted: Predict) -> None:
    """Shades and names of the regimes, and their borders by bisection."""
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=2.0, foreground="white")]
    named: dict[str, Any] = {"ha": "center", "va": "top", "fontsize": SMALL, "path_effects": halo}
    least, most = ratios[0], ratios[-1]
    spans = [(least, str(outcomes[0].regime))]
    for (short, before), (long, after) in pairwise(zip(ratios, outcomes, strict=True)):
        if before.regime != after.regime:
            spans.append((_border(predicted, short, long), str(after.regime)))
    ax.set_xscale("log")
    ax.set_xlim(least, most)
    for (begin, name), end in zip(spans, [*(begin for begin, _ in spans[1:]), most], strict=True):
        ax.axvspan(begin, end, color=_SHADES.get(name, _SHADES["train"]), linewidth=0, zorder=0)
        if begin != least:
            ax.axvline(begin, color=GREY, linewidth=0.8, linestyle="--")
        if math.log(end / begin) > _ROOM * math.log(most / least):
            middle = math.sqrt(begin * end)
            ax.text(middle, 0.985, name, transform=ax.get_xaxis_transform(), **named)


def _border(predicted: Predict, short: float, long: float) -> float:
    """Where the regime of ``short`` ends."""
    before = predicted(short).regime
    for _ in range(_HALVINGS):
        middle = math.sqrt(short * long)
        if predicted(middle).regime == before:
            short = middle
        else:
            long = middle
    return math.sqrt(short * long)
