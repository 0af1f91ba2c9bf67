"""The picture of a result: the one that `plot` of a result draws."""

from __future__ import annotations

from typing import Any

from shockwave.pictures.histories import sensors
from shockwave.pictures.picture_elements import Axes
from shockwave.pictures.studies import design, materials, pareto, universal_curves
from shockwave.pictures.waves import contact_forces, peak_forces, sources, train


def draw_scene(result: Any, *, ax: Axes | None) -> Axes:
    """Draw the histories of sensors or contacts, or the greatest forces along a chain, or those of the waves."""
    simulated, _ = sources(result)
    if simulated is not None and (simulated.options.sensors or "forces" in simulated.options.record):
        return draw_histories(simulated, ax=ax)
    if simulated is not None and simulated.contacts:
        return peak_forces(simulated, ax=ax)
    return train(result, ax=ax)


def draw_histories(result: Any, *, ax: Axes | None) -> Axes:
    """Draw the histories of sensors or, without them, contact forces."""
    return (sensors if getattr(result, "options", result).sensors else contact_forces)(result, ax=ax)


def draw_curve(result: Any, *, ax: Axes | None) -> Axes:
    """Draw a universal curve."""
    return universal_curves({"simulation": result}, ax=ax)


def draw_design(result: Any, *, ax: Axes | None) -> Axes:
    """Draw all options of a design that minimises a quantity, a ranking of materials, or the quantity."""
    if result.least is not None:
        return pareto(result, ax=ax)
    return (materials if result.is_ranked else design)(result, ax=ax)
