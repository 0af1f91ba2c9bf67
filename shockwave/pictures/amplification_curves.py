"""Amplification against rise time: prediction, simulation, universal curve; target property of a design."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import evolve

from shockwave.chain.chain import Chain, Scales
from shockwave.errors import InvalidValueError, ShockwaveError
from shockwave.measurement.simulate import simulate_many
from shockwave.pictures.drawing import BLACK, BLUE, GREY, VERMILION, finish, regime_spans, style
from shockwave.pictures.maps import edges_of
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.shock import Shock

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# Least impulse [F0 T0]: close to the limit of short shocks.
_WEAKEST = 0.15
# Greatest impulse [F0 T0]: long trains.
_STRONGEST = 20.0
# Longest duration of a shock [T0].
_LONGEST = 500.0
# Number of simulations.
_SIMULATED = 41
# Number of predictions; regime borders are drawn halfway between two of them.
_PREDICTED = 241
# Threshold that omits most later waves of trains, which are not drawn.
_FEW_LATER = 0.999
# Points of a universal curve.
_CURVE_POINTS = 600
# Least rise time, as a fraction of the longest one of a curve.
_SHORTEST = 1e-3
# Ratio of greatest and least value above which an axis is logarithmic.
_WIDE = 3.0


def amplification(
    ax: Axes,
    profile: ShockProfile,
    predictor: Predictor,
    chain: Chain,
    *,
    rise_times: Iterable[float] | None = None,
    mark: float | None = None,
) -> Axes:
    """Draw the amplification of the leading wave against t0/T0, with the regimes of the prediction.

    For a given shape, the amplification depends on t0/T0 only.

    Parameters
    ----------
    ax : Axes
        Axes to draw on.
    profile : ShockProfile
        Shape of the shock.
    predictor : Predictor
        Predictor of the curve.
    chain : Chain
        The chain.
    rise_times : iterable of float, optional
        t0/T0 of the simulations, at least two; default: 41 values for impulses of 0.15 to 20 F0 T0.
    mark : float, optional
        t0/T0 to be marked by a vertical line if it is in the range.

    Raises
    ------
    InvalidValueError
        If rise times are out of range.
    """
    ratios = _default_ratios(profile) if rise_times is None else sorted(map(float, rise_times))
    if len(ratios) < 2 or not all(0 < ratio < math.inf for ratio in ratios):
        rule = "must be two or more finite numbers above 0"
        raise InvalidValueError.of("rise_times", f"{rule} (got {ratios})")
    pattern = Shock(profile=profile, peak_force=1.0, rise_time=1.0)
    unit = Scales.of(chain, pattern.peak_force).time
    fine = np.geomspace(ratios[0], ratios[-1], _PREDICTED)
    patterns = [evolve(pattern, rise_time=ratio * unit) for ratio in fine.tolist()]
    paper = evolve(predictor, model="section-4", wave_threshold=_FEW_LATER)
    outcomes: list[Any] = paper.predict_many(patterns, chain)
    for outcome in outcomes:
        if isinstance(outcome, Exception):
            raise outcome
    regime_spans(ax, edges_of(fine, log=True), np.array([outcome.regime for outcome in outcomes]))
    ax.plot(fine, [outcome.amplification for outcome in outcomes], color=BLUE, linewidth=1.2, label="section 4")
    shocks = [evolve(pattern, rise_time=ratio * unit) for ratio in ratios]
    results = zip(ratios, simulate_many(shocks, chain, waves="primary"), strict=True)
    found = {ratio: one.amplification for ratio, one in results if not isinstance(one, ShockwaveError)}
    lost = len(ratios) - len(found)
    label = "simulated" + (f" ({lost} of {len(ratios)} failed)" if lost else "")
    ax.plot(list(found), list(found.values()), "s", color=VERMILION, markersize=3, label=label)
    highest = max(*found.values(), *(outcome.amplification for outcome in outcomes))
    return _frame(ax, ratios[0], ratios[-1], highest, mark)


def _default_ratios(profile: ShockProfile) -> list[float]:
    total = profile.total_area
    most = min(_STRONGEST / total, _LONGEST / float(profile.duration_ratio))
    least = min(_WEAKEST / total, most / 10)
    return list(map(float, np.geomspace(least, most, _SIMULATED)))


def _frame(ax: Axes, least: float, most: float, highest: float, mark: float | None) -> Axes:
    """Label the axes, and draw the line of amplification 1 and a mark in the range."""
    ax.axhline(1.0, color=GREY, linewidth=0.8, linestyle=":")
    if mark is not None and least <= mark <= most:
        ax.axvline(mark, color=BLACK, linewidth=0.9, linestyle="-.", label="this shock")
    ax.set(xscale="log", xlim=(least, most), ylim=(0, 1.14 * highest))
    return finish(ax, ("rise time / characteristic time, t₀/T₀", ""), ("amplification", ""))


def universal_curves(ax: Axes, curves: Mapping[str, Any], mark: float | None = None) -> Axes:
    """Draw universal curves: amplification of the leading wave against t0/T0, with a line for each shape.

    Parameters
    ----------
    ax : Axes
        Axes to draw on.
    curves : mapping of str to UniversalCurve
        One or more curves by name.
    mark : float, optional
        t0/T0 to be marked by a vertical line.
    """
    most = max(one.longest_rise_time for one in curves.values())
    least = _SHORTEST * most
    for index, (label, one) in enumerate(curves.items()):
        # rounding must not move the last point out of the range
        x = np.geomspace(least, one.longest_rise_time, _CURVE_POINTS).clip(max=one.longest_rise_time)
        ax.plot(x, one.amplification(x), linewidth=1.2, label=label, **style(index))
    highest = max(one.highest[1] for one in curves.values())
    return _frame(ax, least, most, highest, mark)


def design(ax: Axes, design: Any) -> Axes:
    """Draw the required quantity of a design against the varied number, with the target and the solutions.

    Parameters
    ----------
    ax : Axes
        Axes to draw on.
    design : shockwave.Design
        Design with a varied number.
    """
    (parameter,), (target,) = design.parameters, design.requirements
    quantity = target.quantity
    values, reached = np.array(sorted((option.value, option.reached) for option in design.tried)).T
    ax.plot(values, reached, color=BLUE, linewidth=1.2, label="simulations")
    ax.axhline(target.value, color=GREY, linewidth=0.9, linestyle="--", label="target value")
    if places := [option.value for option in design.solutions]:
        ax.plot(places, [target.value] * len(places), "o", color=VERMILION, markersize=4, label="solutions")
    ax.set_xlim(values[0], values[-1])
    if 0 < _WIDE * values.min() < values.max():
        ax.set_xscale("log")
    if 0 < _WIDE * reached.min() < reached.max():
        ax.set_yscale("log")
    return finish(ax, (design.varied, parameter.unit), (quantity.label, quantity.printed_unit))


def pareto(ax: Axes, design: Any) -> Axes:
    """Draw the options of a design: the first required quantity against the one that is minimised.

    A line connects the options that no other option surpasses in both (the Pareto front).

    Parameters
    ----------
    ax : Axes
        Axes to draw on.
    design : shockwave.Design
        Design that minimises a quantity.
    """
    required = next(
        (each for each in design.requirements if each.quantity.name != design.least), design.requirements[0]
    )
    quantity, least = required.quantity, next(each for each in design.quantities if each.name == design.least)
    every, front = (
        np.array([(option.quantities[least.name], option.quantities[quantity.name]) for option in options])
        for options in (design.tried, design.front(required))
    )
    ax.plot(*every.T, ".", color=GREY, markersize=2, alpha=0.5, label="options")
    ax.plot(*front.T, color=BLUE, linewidth=1.2, label="Pareto front", drawstyle="steps-post")
    ax.axhline(required.value, color=GREY, linewidth=0.9, linestyle="--", label=f"required {required.sign}")
    if design.best is not None:
        place = design.best.quantities[least.name], design.best.quantities[quantity.name]
        ax.plot(*place, "o", color=VERMILION, markersize=4, label="best")
    for set_scale, values in ((ax.set_xscale, every[:, 0]), (ax.set_yscale, every[:, 1])):
        if 0 < _WIDE * values.min() < values.max():
            set_scale("log")
    return finish(ax, (least.label, least.printed_unit), (quantity.label, quantity.printed_unit))
