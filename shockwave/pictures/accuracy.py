"""Accuracy of simulations and methods: approach to the limit, balances, error against run time."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from shockwave.errors import InvalidValueError, NumericalError
from shockwave.measurement.result import SimulationResult
from shockwave.pictures.drawing import (
    BLACK,
    BLUE,
    COLOURS,
    GREY,
    LINES,
    MARKERS,
    MINUS,
    ORANGE,
    SKY,
    area,
    finish,
    literal,
)
from shockwave.pictures.waves import recorded
from shockwave.quadrature import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# Each contact costs up to as much as the simulation.
_CONTACTS = 15
# The picture of an approach goes as far below the error of the limit.
_DEEP = 30.0
# Smaller errors are rounding.
_ROUNDING = 1e-16


def approach(ax: Axes, result: SimulationResult) -> Axes:
    """Relative distance of the primary's peak force from its limit, contact by contact.

    Below the error estimate of the limit, shaded, a distance says nothing. Contacts at which the front has no peak of
    its own, and those from which on it is the exact wave, are left out.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    result : SimulationResult
        Of any simulation; fifteen contacts at most are integrated up to once more.
    """
    last = result.primary.contact
    floor = result.error_estimate
    distances = {}
    for contact in range(0, last, math.ceil((last + 1) / _CONTACTS)):
        with contextlib.suppress(NumericalError):
            passage = result.passage(contact)
            if not passage.exact:
                distances[contact] = passage.peak_force / result.peak_force - 1
    sizes = np.abs(list(distances.values()))
    ax.plot(list(distances), sizes, "o", color=BLUE, markersize=4, label="distance")
    bottom = max(sizes.min(initial=floor) / 5, floor / _DEEP)
    ax.set(yscale="log", ylim=(bottom, 4 * sizes.max(initial=floor)), xlim=(-0.5, last + 1.5))
    ax.axhspan(bottom, floor, color=GREY, alpha=0.2, linewidth=0, label="error of the limit")
    ax.axvline(last, color=GREY, linewidth=1.0, linestyle=":", label="where it was read")
    return finish(ax, ("contact", ""), ("relative distance to the limit", ""))


def balance(ax: Axes, result: SimulationResult, of: Literal["energy", "momentum"] = "energy") -> Axes:
    """Input of the shock and content of the chain against time, with the defect of the balance at the end.

    Energy is stacked, of contacts upon kinetic, under the work of the shock from its end on. Momentum is that of
    granules that move forward and backward, and their sum, on the impulse of the shock.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    result : SimulationResult
        With ``energies`` recorded, for the momentum the ``field``; time in s, energy in J, momentum in N s.
    of : "energy" or "momentum"
        Which balance.

    Raises
    ------
    InvalidValueError
        When it is another, or what it needs was not recorded.
    """
    if of == "energy":
        _energy(ax, result)
        defect = result.energy_defect
        unit = "J"
    elif of == "momentum":
        _momentum(ax, result)
        defect = result.momentum_defect
        unit = "N s"
    else:
        raise InvalidValueError.of("of", f"must be energy or momentum (got {of!r})")
    ax.axvline(result.shock.duration, color=GREY, linewidth=0.8, linestyle=":", label="end of shock")
    ax.plot([], [], " ", label=f"defect {defect:.1e}".replace("-", MINUS))
    return finish(ax, ("time", "s"), (of, unit))


def _energy(ax: Axes, result: SimulationResult) -> None:
    kept = recorded(result, "energies")
    times = kept.times
    kinetic = np.asarray(kept.kinetic_energy)
    total = kinetic + np.asarray(kept.contact_energy)
    area(ax, times, 0.0, kinetic, SKY, "", "kinetic")
    area(ax, times, kinetic, total, ORANGE, "////", "in contacts")
    ax.plot(times, total, color=BLUE, linewidth=1.2, label="sum")
    work = float(result.found.work * result.scales.energy)
    begin = min(result.shock.duration, times[-1])
    ax.plot([begin, times[-1]], [work, work], color=BLACK, linewidth=1.2, linestyle="--", label="work of shock")
    ax.set(xlim=(0, times[-1]), ylim=(0, 1.1 * max(work, float(total.max()))))


def _momentum(ax: Axes, result: SimulationResult) -> None:
    kept = recorded(result, "field")
    times = kept.times
    momenta = result.chain.granule_mass * np.asarray(kept.velocities)
    forward = np.maximum(momenta, 0).sum(axis=1)
    backward = np.minimum(momenta, 0).sum(axis=1)
    impulse = _impulse(result, times)
    area(ax, times, 0.0, forward, SKY, "", "forward")
    area(ax, times, 0.0, backward, ORANGE, "////", "backward")
    ax.plot(times, momenta.sum(axis=1), color=BLUE, linewidth=1.2, label="sum")
    ax.plot(times, impulse, color=BLACK, linewidth=1.2, linestyle="--", label="impulse of shock")
    ax.axhline(0, color=BLACK, linewidth=0.6)
    highest = max(float(forward.max()), float(impulse.max()))
    lowest = 1.2 * float(backward.min()) - 0.02 * highest
    ax.set(xlim=(0, times[-1]), ylim=(lowest, 1.1 * highest))


def _impulse(result: SimulationResult, times: FloatArray) -> FloatArray:
    """The impulse of the shock up to each of ``times`` [N s]."""
    shock = result.shock
    path = shock.profile.free_path()
    ends = np.minimum(times / shock.rise_time, float(shock.profile.duration_ratio))
    shares = [path.at(float(s))[1] for s in ends]
    return shock.peak_force * shock.rise_time * np.array(shares)


def work_precision(ax: Axes, rows: Iterable[Any], name: str = "relative error") -> Axes:
    """Error against time, both logarithmic, a line for each method in the order of its rows.

    Runs that failed, or whose error is not a number, are counted in the key. Errors below 1e-16 are drawn there.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    rows : iterable
        Methods in their order, and the runs of each in the order in which a line joins them: objects with a
        ``method``, an ``error`` and its ``seconds`` or None, and a ``problem``, which says why a run failed.
    name : str
        The quantity that the error belongs to.
    """
    runs: dict[str, list[Any]] = {}
    for row in rows:
        runs.setdefault(row.method, []).append(row)
    for index, (method, own) in enumerate(runs.items()):
        good = [row for row in own if not row.problem and row.error is not None and math.isfinite(row.error)]
        seconds = [row.seconds or math.nan for row in good]
        errors = [max(abs(row.error), _ROUNDING) for row in good]
        failed = len(own) - len(good)
        look: dict[str, Any] = {
            "color": COLOURS[index % len(COLOURS)],
            "linestyle": LINES[index % len(LINES)],
            "marker": MARKERS[index % len(MARKERS)],
        }
        label = literal(method) + (f" ({failed} failed)" if failed else "")
        ax.plot(seconds, errors, markersize=3.5, linewidth=1.0, label=label, **look)
    ax.set(xscale="log", yscale="log")
    return finish(ax, ("time", "s"), (literal(name), ""))
