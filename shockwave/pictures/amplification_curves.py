"""Universal curves: amplification against rise time; target property of a design."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from shockwave.pictures.figure_files import mark_warnings, picture
from shockwave.pictures.picture_elements import BLACK, BLUE, GREY, VERMILION, finish, literal, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.base.numerics import FloatArray


# Points of a universal curve.
_CURVE_POINTS = 600
# Ratio of greatest and least value above which an axis is logarithmic.
_WIDE = 3.0


def _frame(ax: Axes, ends: tuple[float, float], highest: float, mark: float | None) -> Axes:
    """Label the axes, and draw the line of amplification 1 and a mark in the range."""
    ax.axhline(1.0, color=GREY, linewidth=0.8, linestyle=":")
    if mark is not None and ends[0] <= mark <= ends[1]:
        ax.axvline(mark, color=BLACK, linewidth=0.9, linestyle="-.", label="this shock")
    ax.set(xscale="log", xlim=ends, ylim=(0, 1.14 * highest))
    return finish(ax, ("rise time / characteristic time, t₀/T₀", ""), ("amplification", ""))


def _scale_axes(ax: Axes, x: FloatArray, y: FloatArray) -> None:
    """Make an axis logarithmic if its values have a wide range."""
    for set_scale, values in ((ax.set_xscale, x), (ax.set_yscale, y)):
        if 0 < _WIDE * values.min() < values.max():
            set_scale("log")


@picture
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
    mark_warnings(ax, curves.values())
    return _frame(ax, ends, np.nanmax(together[1:]), mark)


@picture
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
    _scale_axes(ax, values, reached)
    return finish(ax, (design.varied, parameter.unit), (quantity.label, quantity.unit))


@picture
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
    return finish(ax, (target.quantity.label, target.quantity.unit), ("", ""))


@picture
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
    _scale_axes(ax, *every.T)
    return finish(ax, (least.label, least.unit), (quantity.label, quantity.unit))
