"""Scenes, runs and errors that are drawn, and what reads the data of a picture."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from attrs import frozen
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

import shockwave as sw
from scenes import CASE_B, CHAIN, FORCE, UNITS, power, triangle

ROOT = Path(__file__).parent.parent
#: So many contacts are recorded.
LAST = 45


@frozen
class Run:
    """A run of a method."""

    method: str
    error: float | None
    seconds: float | None
    problem: str = ""


def record() -> sw.Shock:
    scene = sw.load_scenario(ROOT / "profiles" / "examples" / "hammer.yaml")
    return sw.Shock(profile=scene.shock.profile, peak_force=FORCE, rise_time=3 * UNITS.time)


#: An ejection, two trains of which one has more than twenty waves, a record, and the extremes.
SHOCKS = {
    "ejection": power(0.5),
    "train": triangle(9.0),
    "long train": CASE_B,
    "record": record(),
    "tiny": sw.Shock(profile=sw.Triangular(duration_ratio=3), peak_force=1e-9, rise_time=1e-12),
    "long decay": sw.Shock(
        profile=sw.PowerLaw(rise_exponent=1e-5, decay_exponent=50, duration_ratio=1e4),
        peak_force=FORCE,
        rise_time=1e-2 * UNITS.time,
    ),
}


@cache
def compared(name: str) -> sw.Comparison:
    return sw.compare(SHOCKS[name], CHAIN)


@cache
def recorded(name: str, *record: Any) -> sw.SimulationResult:
    contacts = range(LAST) if "forces" in record else [8]
    return sw.simulate(SHOCKS[name], CHAIN, contacts=contacts, record=record)


RUNS = (
    Run("rk4", 1e-3, 0.01),
    Run("rk4", 1e-6, 0.1),
    Run("formula", 0.02, 1e-5),
    Run("rk4", 0.0, 1.0),
    Run("formula", None, 2e-5, "no wave"),
    Run("other", None, None, "not installed"),
)
X, N = np.geomspace(0.5, 30, 12), np.geomspace(1.5, 20, 10)
ERRORS = np.log(np.outer(X, N) / 20) / 5
REGIMES = np.where(np.outer(X, np.ones(10)) < 4, "ejection", "train")


def line(ax: Axes, label: str) -> Line2D:
    (found,) = (one for one in ax.get_lines() if one.get_label() == label)
    return found


def labels(ax: Axes) -> list[str]:
    legend = ax.get_legend()
    return [] if legend is None else [text.get_text() for text in legend.get_texts()]


def y_of(one: Line2D) -> np.ndarray:
    return np.asarray(one.get_ydata(), dtype=float)


def x_of(one: Line2D) -> np.ndarray:
    return np.asarray(one.get_xdata(), dtype=float)
