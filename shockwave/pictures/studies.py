"""Pictures of studies: universal curves, designs, and distributions of uncertain quantities."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from shockwave.base.errors import UnknownNameError
from shockwave.base.numerics import FloatArray
from shockwave.base.text import percent
from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import GREY, METHODS, Axes, draw_limit, filled_and_open, ink, literal, series
from shockwave.studies.quantities import LIMITED

if TYPE_CHECKING:
    from shockwave.studies.amplification_curve import UniversalCurve
    from shockwave.studies.design_result import Design
    from shockwave.studies.uncertainty_result import Uncertainty


# Points of a universal curve.
_CURVE_POINTS = 600
# Ratio of greatest and least value above which an axis is logarithmic.
_WIDE = 3.0
# Width of a ranking, its height without rows, and height of a row [in].
_WIDTH = 4.6
_HEIGHT = 1.0
_ROW_HEIGHT = 0.17


def _scale_axes(ax: Axes, x: FloatArray, y: FloatArray) -> None:
    """Make an axis logarithmic if its values have a wide range."""
    for set_scale, values in ((ax.set_xscale, x), (ax.set_yscale, y)):
        if 0 < _WIDE * values.min() < values.max():
            set_scale("log")


def universal_curves(
    curves: Mapping[str, UniversalCurve], mark: float | None = None, *, ax: Axes | None = None
) -> Axes:
    """Draw universal curves: amplification of the leading wave against t0/T0, with a line for each shape.

    A thin dotted line shows section 4 at the points of the curve, in the same colour if there are several.

    Parameters
    ----------
    curves : mapping of str to UniversalCurve
        One or more curves by name.
    mark : float, optional
        t0/T0 to be marked by a vertical line.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.
    """
    points = {
        label: np.array(
            [(each.rise_time, each.amplification, each.section4_amplification) for each in curve.points], dtype=float
        ).T
        for label, curve in curves.items()
    }
    rise_times = np.hstack([each[0] for each in points.values()])
    ends = rise_times.min(), rise_times.max()
    with canvas(
        ax, *curves.values(), x="rise time / characteristic time, t₀/T₀", y="amplification", from_zero=True
    ) as ax:
        for index, (label, curve) in enumerate(curves.items()):
            at, _, section4 = points[label]
            # rounding must not move the last point out of the range
            x = np.geomspace(at[0], at[-1], _CURVE_POINTS).clip(max=at[-1])
            look = series(index)
            ax.plot(x, curve.amplification(x), label=label, **look)
            look |= {"linestyle": ":"} | ({"color": METHODS["section 4"]} if len(curves) == 1 else {})
            ax.plot(at, section4, label="" if index else "section 4", **look)
        ax.axhline(1.0, color=GREY, linewidth=0.8, linestyle=":")
        if mark is not None and ends[0] <= mark <= ends[1]:
            ax.axvline(mark, color=ink(), linestyle="-.", label="this shock")
        ax.set(xscale="log", xlim=ends)
        return ax


def design(result: Design, *, ax: Axes | None = None) -> Axes:
    """Draw the required quantity of a design against the varied number, with the target and the solutions.

    Parameters
    ----------
    result : Design
        Design with a varied number.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.
    """
    (parameter,), (target,) = result.parameters, result.requirements
    quantity = target.quantity
    values, reached = np.array(sorted((option.value, option.reached) for option in result.tried)).T
    with canvas(ax, result, x=(result.varied, parameter.unit), y=(quantity.label, quantity.unit)) as ax:
        ax.plot(values, reached, color=METHODS["simulation"], label="simulations")
        draw_limit(ax, target.value, "target value")
        if places := [option.value for option in result.solutions]:
            ax.plot(places, [target.value] * len(places), "*", color=ink(), markersize=7, label="solutions")
        ax.set_xlim(values[0], values[-1])
        _scale_axes(ax, values, reached)
        return ax


def ranking_size(result: Design) -> tuple[float, float]:
    """Width and height of a legible ranking [in]."""
    return _WIDTH, _HEIGHT + _ROW_HEIGHT * len(result.table)


def materials(result: Design, *, ax: Axes | None = None) -> Axes:
    """Draw a ranking of materials by the required quantity, the best one at the top.

    Parameters
    ----------
    result : Design
        Design in which a material varies, or a whole number.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.
    """
    target = result.requirements[0]
    reached = np.array([option.reached for option in result.table])
    met = np.array([option in result.solutions for option in result.table])
    places = np.arange(len(reached))
    unit, size = target.quantity.unit, ranking_size(result)
    with canvas(ax, result, x=(target.quantity.label, unit), y=("", ""), size=size) as ax:
        draw_limit(ax, target.value, f"target {target.sign}", upright=True)
        filled_and_open(ax, "o", reached, places, met, "meets it", "does not")
        ax.set_yticks(places, [literal(str(option.value)) for option in result.table])
        ax.set_ylim(len(reached) - 0.5, -0.5)
        return ax


def pareto(result: Design, *, ax: Axes | None = None) -> Axes:
    """Draw the options of a design: the first required quantity against the one that is minimised.

    A line connects the options that no other option surpasses in both (the Pareto front).

    Parameters
    ----------
    result : Design
        Design that minimises a quantity.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.
    """
    required = next(
        (each for each in result.requirements if each.quantity.name != result.least), result.requirements[0]
    )
    quantity, least = required.quantity, next(each for each in result.quantities if each.name == result.least)
    every, front = (
        np.array([(option.quantities[least.name], option.quantities[quantity.name]) for option in options])
        for options in (result.tried, result.front(required))
    )
    with canvas(ax, result, x=(least.label, least.unit), y=(quantity.label, quantity.unit)) as ax:
        ax.plot(*every.T, ".", color=GREY, markersize=2, alpha=0.5, label="options")
        ax.plot(*front.T, color=METHODS["simulation"], label="Pareto front", drawstyle="steps-post")
        draw_limit(ax, required.value, f"required {required.sign}")
        if result.best is not None:
            place = result.best.quantities[least.name], result.best.quantities[quantity.name]
            ax.plot(*place, "*", color=ink(), markersize=7, label="best")
        _scale_axes(ax, *every.T)
        return ax


def draw_curve(result: UniversalCurve, *, ax: Axes | None) -> Axes:
    """Draw a universal curve."""
    return universal_curves({"simulation": result}, ax=ax)


def draw_design(result: Design, *, ax: Axes | None) -> Axes:
    """Draw all options of a design that minimises a quantity, a ranking of materials, or the quantity."""
    if result.least is not None:
        return pareto(result, ax=ax)
    return (materials if result.is_ranked else design)(result, ax=ax)


# ---------------------------------------------------------------- uncertainty

# Ends of the shaded interval.
_FEW, _MANY = 0.05, 0.95


def distribution(result: Uncertainty, name: str | None = None, *, ax: Axes | None = None) -> Axes:
    """Draw the distribution of a quantity, with its nominal value, its quantiles, and the limit.

    The shaded interval contains 90 % of the scenes. The legend states the probability that the limit is reached.

    Parameters
    ----------
    result : Uncertainty
        Distribution of forces for uncertain parameters.
    name : str, optional
        Name of the quantity; default: the transmitted force if there is a limit, else the first quantity.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.

    Raises
    ------
    UnknownNameError
        If there is no such quantity.
    """
    names = [each.name for each in result.quantities]
    limited = LIMITED.get(result.verdict.force) if result.verdict else None
    name = name or (limited if limited in names else names[0])
    if name not in names:
        raise UnknownNameError.of("quantity", name, names)
    quantity = result.quantities[names.index(name)]
    values = np.sort(result.outputs[name])
    low, high = (quantity.quantiles[share].value for share in (_FEW, _MANY))
    with canvas(ax, result, x=(quantity.label, quantity.unit), y="scenes", from_zero=True) as ax:
        ax.hist(values, bins="auto", color=METHODS["simulation"], label=f"{result.draws} scenes")
        ax.axvspan(low, high, color=GREY, alpha=0.2, linewidth=0, zorder=0, label="90 % of them")
        ax.axvline(quantity.nominal, color=ink(), linestyle=":", label="nominal")
        if name == limited and result.exceedance:
            reached = f"limit, reached with probability {percent(result.exceedance.probability)}"
            draw_limit(ax, result.exceedance.limit, reached, upright=True)
        return ax
