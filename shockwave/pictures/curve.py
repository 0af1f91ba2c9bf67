"""Amplification against rise time: predicted and simulated, as universal curves, and along the value of a design."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import evolve

from shockwave.chain.chain import Chain, Scales
from shockwave.errors import InvalidValueError, ShockwaveError
from shockwave.measurement.simulate import simulate_many
from shockwave.pictures.axes import decades, finish, named
from shockwave.pictures.style import BLACK, BLUE, COLOURS, GREY, LINES, SKY, VERMILION
from shockwave.prediction.outcome import Outcome
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.shock import Shock

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# Impulses over F0 T0, from the impulse limit to long trains.
_WEAKEST = 0.15
_STRONGEST = 20.0
# No whole duration is longer than so many T0.
_LONGEST = 500.0
_SIMULATED = 41
_PREDICTED_TO_SIMULATED = 6
# Borders of regimes are drawn halfway between two predictions: of so many at least.
_PREDICTED = 61
_SHADES = {"ejection": "#FFFFFF", "single": "#D0D0D0", "train": "#F1F1F1"}
# A regime narrower than this share of the picture has no name in it.
_NARROW = 0.14
_CURVE_POINTS = 600
# Least rise time over the longest of a curve.
_SHORTEST = 1e-3
# A band narrower than this share of the amplification is no more than the line.
_VISIBLE = 2e-3
# A range of more than this factor is drawn by equal ratios.
_WIDE = 3.0


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
    pattern = Shock(profile=profile, peak_force=peak_force, rise_time=1.0)
    unit = Scales.of(chain, pattern.peak_force).time

    def shock(ratio: float) -> Shock:
        return evolve(pattern, rise_time=ratio * unit)

    points = max(_PREDICTED_TO_SIMULATED * (len(ratios) - 1) + 1, _PREDICTED)
    fine = np.geomspace(ratios[0], ratios[-1], points).tolist()
    outcomes = [predictor.predict(shock(ratio), chain) for ratio in fine]
    _predictions(ax, fine, outcomes)
    highest = _simulations(ax, ratios, [shock(ratio) for ratio in ratios], chain)
    highest = max(highest, *(outcome.amplification for outcome in outcomes))
    return _frame(ax, fine[0], fine[-1], highest, None if mark is None else mark / unit)


def _frame(ax: Axes, least: float, most: float, highest: float, mark: float | None) -> Axes:
    """Axes of amplification and t0/T0, with the level of the shock and a mark within the range."""
    ax.axhline(1.0, color=GREY, linewidth=0.8, linestyle=":")
    if mark is not None and least <= mark <= most:
        ax.axvline(mark, color=BLACK, linewidth=0.9, linestyle="-.", label="this shock")
    ax.set(xscale="log", xlim=(least, most), ylim=(0, 1.14 * highest))
    return finish(ax, "rise time over characteristic time, $t_0/T_0$", "amplification")


def _ratios(profile: ShockProfile, rise_times: Iterable[float] | None) -> list[float]:
    if rise_times is None:
        total = profile.areas().total
        most = min(_STRONGEST / total, _LONGEST / float(profile.duration_ratio))
        least = min(_WEAKEST / total, most / 10)
        chosen: list[float] = np.geomspace(least, most, _SIMULATED).tolist()
        return chosen
    given = sorted({float(ratio) for ratio in rise_times})
    if len(given) < 2 or not all(0 < ratio < math.inf for ratio in given):
        rule = "must be two or more finite numbers above 0"
        raise InvalidValueError.of("rise_times", f"{rule} (got {given})")
    return given


def _simulations(ax: Axes, ratios: list[float], shocks: list[Shock], chain: Chain) -> float:
    """Marks of the simulated primaries; the greatest amplification among them, 0 without any."""
    found = {}
    for ratio, result in zip(ratios, simulate_many(shocks, chain, waves="primary"), strict=True):
        if not isinstance(result, ShockwaveError):
            found[ratio] = result.amplification
    lost = len(ratios) - len(found)
    label = "simulated" + (f" ({lost} of {len(ratios)} failed)" if lost else "")
    ax.plot(list(found), list(found.values()), "s", color=VERMILION, markersize=3, label=label)
    return max(found.values(), default=0.0)


def _predictions(ax: Axes, ratios: list[float], outcomes: list[Outcome]) -> None:
    """Regimes, and line and band of the predictions, interrupted where they jump from regime to regime."""
    names = [outcome.regime for outcome in outcomes]
    jumps = [index for index in range(1, len(names)) if names[index] != names[index - 1]]
    borders = [math.sqrt(ratios[jump - 1] * ratios[jump]) for jump in jumps]
    _regimes(ax, [ratios[0], *borders, ratios[-1]], [names[index] for index in [0, *jumps]])
    rows = [(outcome.amplification, *_range(outcome)) for outcome in outcomes]
    columns = np.column_stack((ratios, rows))
    x, middle, low, high = np.insert(columns, jumps, math.nan, axis=0).T
    ax.plot(x, middle, color=BLUE, linewidth=1.2, label="predicted")
    if np.isfinite(low).any():
        ax.fill_between(x, low, high, color=SKY, alpha=0.35, linewidth=0, label="expected")


def _range(outcome: Outcome) -> tuple[float, float]:
    """Least and greatest amplification expected of a simulation; not a number where none is known."""
    low, high = outcome.expected_error or (math.nan, math.nan)
    # an error of -100 % leaves the greatest open: beyond any picture
    return outcome.amplification / (1 + high), outcome.amplification / max(1 + low, 1e-3)


def _regimes(ax: Axes, edges: list[float], names: Sequence[str]) -> None:
    """Shades and names of the regimes, and their borders."""
    shortest_named = _NARROW * math.log(edges[-1] / edges[0])
    for name, (begin, end) in zip(names, pairwise(edges), strict=True):
        shade = _SHADES.get(name, _SHADES["train"])
        ax.axvspan(begin, end, color=shade, linewidth=0, zorder=0)
        if math.log(end / begin) > shortest_named:
            middle = math.sqrt(begin * end)
            named(ax, middle, 0.985, name, va="top", xycoords=ax.get_xaxis_transform())
    for border in edges[1:-1]:
        ax.axvline(border, color=GREY, linewidth=0.8, linestyle="--")


def curve(
    ax: Axes,
    curves: Any,
    *,
    labels: Sequence[str] | None = None,
    mark: float | None = None,
) -> Axes:
    """Amplification of the primary against t0/T0, for one shape or several; errors that would show are bands.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    curves : UniversalCurve or sequence of them
        One line each.
    labels : sequence of str, optional
        Their names; left out, none for one curve, and numbers for several.
    mark : float, optional
        A t0/T0 of one's own, marked by a line.

    Raises
    ------
    InvalidValueError
        When there is no curve, or labels are not one each.
    """
    drawn = list(curves) if isinstance(curves, Sequence) else [curves]
    if not drawn:
        raise InvalidValueError.of("curves", "must be one curve or more (got none)")
    if labels is None:
        numbers = [str(number) for number in range(1, len(drawn) + 1)]
        labels = ["universal curve"] if len(drawn) == 1 else numbers
    if len(labels) != len(drawn):
        rule = f"must be one for each of {len(drawn)} curves"
        raise InvalidValueError.of("labels", f"{rule} (got {len(labels)})")
    most = max(one.longest_rise_time for one in drawn)
    for index, (one, label) in enumerate(zip(drawn, labels, strict=True)):
        _line(ax, one, label, _SHORTEST * most, index)
    highest = max(one.highest[1] for one in drawn)
    return _frame(ax, _SHORTEST * most, most, highest, mark)


def _line(ax: Axes, one: Any, label: str, least: float, index: int) -> None:
    # rounding must not put the last beyond the range
    last = one.longest_rise_time
    x = np.geomspace(least, last, _CURVE_POINTS).clip(max=last)
    values = one.amplification(x)
    errors = one.error(x)
    colour = COLOURS[index % len(COLOURS)]
    style = LINES[index % len(LINES)]
    ax.plot(x, values, linestyle=style, color=colour, linewidth=1.2, label=label)
    if _VISIBLE < float(errors.max()) < math.inf:
        low = values * (1 - errors)
        high = values * (1 + errors)
        ax.fill_between(x, low, high, color=colour, alpha=0.35, linewidth=0)


def design(
    ax: Axes,
    values: Sequence[float],
    reached: Sequence[float],
    wanted: float,
    solutions: Sequence[float] = (),
    *,
    labels: tuple[str, str] = ("value", "target"),
    units: tuple[str, str] = ("", ""),
) -> Axes:
    """The target of a design against the varied value, with the wanted level, and the solutions on it.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    values, reached : sequence of float
        The line, by ascending values.
    wanted : float
        The level.
    solutions : sequence of float
        Values at which the line has it.
    labels, units : (str, str)
        Of the two axes; a unit is empty for a number without one.
    """
    ax.plot(values, reached, color=BLUE, linewidth=1.2, label="along the interval")
    ax.axhline(wanted, color=GREY, linewidth=0.9, linestyle="--", label="wanted")
    if solutions:
        levels = [wanted] * len(solutions)
        ax.plot(solutions, levels, "o", color=VERMILION, markersize=4, label="solutions")
    ax.set_xlim(values[0], values[-1])
    across = labels[0], units[0], max(values)
    up = labels[1], units[1], max(reached)
    if 0 < _WIDE * min(values) < max(values):
        decades(ax, "x")
    if 0 < _WIDE * min(reached) < max(reached):
        decades(ax, "y")
    return finish(ax, across, up)
