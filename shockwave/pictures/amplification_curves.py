"""Amplification against rise time: section 4, simulation, universal curve; target property of a design."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import evolve

from shockwave.chain.chain import Chain, Scales
from shockwave.errors import InvalidValueError
from shockwave.measurement.simulate import simulate_many
from shockwave.pictures.drawing import BLACK, BLUE, GREY, VERMILION, finish, literal, regime_spans, style
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
# Number of points of section 4; regime borders are drawn halfway between two of them.
_PREDICTED = 241
# Threshold that omits most later waves of trains, which are not drawn.
_FEW_LATER = 0.999
# Points of a universal curve.
_CURVE_POINTS = 600
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
    """Draw the amplification of the leading wave against t0/T0, by section 4 and simulated, with the regimes.

    For a given shape, the amplification depends on t0/T0 only.

    Parameters
    ----------
    ax : Axes
        Axes to draw on.
    profile : ShockProfile
        Shape of the shock.
    predictor : Predictor
        Settings of section 4.
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
    ratios = np.sort(_default_ratios(profile) if rise_times is None else [*map(float, rise_times)])
    if len(ratios) < 2 or not (np.isfinite(ratios) & (ratios > 0)).all():
        rule = "must be two or more finite numbers above 0"
        raise InvalidValueError.of("rise_times", f"{rule} (got {ratios.tolist()})")
    pattern = Shock(profile=profile, peak_force=1.0, rise_time=Scales.of(chain, 1.0).time)
    fine = np.geomspace(ratios[0], ratios[-1], _PREDICTED)
    section4 = evolve(predictor, model="section-4", wave_threshold=_FEW_LATER)
    outcomes = [section4.predict(shock, chain) for shock in _stretched(pattern, fine)]
    results = simulate_many(_stretched(pattern, ratios), chain, waves="primary")
    simulated = np.array([getattr(result, "amplification", math.nan) for result in results])
    predicted = np.array([outcome.amplification for outcome in outcomes])
    failed = np.isnan(simulated).sum()
    regime_spans(ax, edges_of(fine, log=True), np.array([outcome.regime for outcome in outcomes]))
    ax.plot(fine, predicted, color=BLUE, linewidth=1.2, label="section 4")
    label = "simulated" + (f" ({failed} of {len(ratios)} failed)" if failed else "")
    ax.plot(ratios, simulated, "s", color=VERMILION, markersize=3, label=label)
    return _frame(ax, (ratios[0], ratios[-1]), np.nanmax([*simulated, *predicted]), mark)


def _default_ratios(profile: ShockProfile) -> Any:
    total = profile.total_area
    most = min(_STRONGEST / total, _LONGEST / float(profile.duration_ratio))
    return np.geomspace(min(_WEAKEST / total, most / 10), most, _SIMULATED)


def _stretched(pattern: Shock, ratios: Any) -> list[Shock]:
    """Shocks with multiples of the rise time of ``pattern``."""
    return [evolve(pattern, rise_time=ratio * pattern.rise_time) for ratio in ratios.tolist()]


def _frame(ax: Axes, ends: tuple[float, float], highest: float, mark: float | None) -> Axes:
    """Label the axes, and draw the line of amplification 1 and a mark in the range."""
    ax.axhline(1.0, color=GREY, linewidth=0.8, linestyle=":")
    if mark is not None and ends[0] <= mark <= ends[1]:
        ax.axvline(mark, color=BLACK, linewidth=0.9, linestyle="-.", label="this shock")
    ax.set(xscale="log", xlim=ends, ylim=(0, 1.14 * highest))
    return finish(ax, ("rise time / characteristic time, t₀/T₀", ""), ("amplification", ""))


def universal_curves(ax: Axes, curves: Mapping[str, Any], mark: float | None = None) -> Axes:
    """Draw universal curves: amplification of the leading wave against t0/T0, with a line for each shape.

    A thin dotted line of the same colour shows section 4 at the points of the curve.

    Parameters
    ----------
    ax : Axes
        Axes to draw on.
    curves : mapping of str to UniversalCurve
        One or more curves by name.
    mark : float, optional
        t0/T0 to be marked by a vertical line.
    """
    points = {
        label: np.array(
            [(each.rise_time, each.amplification, each.section4_amplification) for each in curve.points], dtype=float
        ).T
        for label, curve in curves.items()
    }
    for index, (label, curve) in enumerate(curves.items()):
        rise_times, _, section4 = points[label]
        # rounding must not move the last point out of the range
        x = np.geomspace(rise_times[0], rise_times[-1], _CURVE_POINTS).clip(max=rise_times[-1])
        ax.plot(x, curve.amplification(x), linewidth=1.2, label=label, **style(index))
        ax.plot(
            rise_times, section4, linewidth=0.9, label="" if index else "section 4", **style(index) | {"linestyle": ":"}
        )
    together = np.hstack([*points.values()])
    ends = together[0].min(), together[0].max()
    return _frame(ax, ends, np.nanmax(together[1:]), mark)


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


def materials(ax: Axes, design: Any) -> Axes:
    """Draw a ranking of materials by the required quantity, the best one at the top.

    Parameters
    ----------
    ax : Axes
        Axes to draw on.
    design : shockwave.Design
        Design in which a material varies, or a whole number.
    """
    target = design.requirements[0]
    reached = np.array([option.reached for option in design.table])
    met = np.array([option in design.solutions for option in design.table])
    places = np.arange(len(reached))
    ax.axvline(target.value, color=GREY, linewidth=0.9, linestyle="--", label=f"target {target.sign}")
    for which, face, colour, label in ((met, BLUE, BLUE, "meets it"), (~met, "white", VERMILION, "does not")):
        ax.plot(reached[which], places[which], "o", color=colour, markerfacecolor=face, markersize=4, label=label)
    ax.set_yticks(places, [literal(str(option.value)) for option in design.table])
    ax.set_ylim(len(reached) - 0.5, -0.5)
    return finish(ax, (target.quantity.label, target.quantity.printed_unit), ("", ""))


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
