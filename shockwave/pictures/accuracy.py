"""Accuracy of simulations and methods: approach to the limit, balance of energy, work-precision diagram."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from shockwave.base.errors import NotCoveredError, NumericalError
from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import GREY, METHODS, MINUS, OCHRE, SKY, Axes, area, ink, literal, series
from shockwave.pictures.waves import find_histories
from shockwave.simulation.simulation_result import Simulation

# Most contacts of an approach; each one costs up to as much as the simulation.
_CONTACTS = 15
# Lower end of the ordinate of an approach, as a fraction of the error of the limit.
_LOWEST = 1 / 30
# Smallest error that is drawn; smaller ones are rounding errors.
_ROUNDING = 1e-16


def approach(result: Simulation, *, ax: Axes | None = None) -> Axes:
    """Draw the relative distance of the peak force of the leading wave from its limit, contact by contact.

    Distances below the error estimate of the limit, which is shaded, carry no information. Contacts at which the front
    has no separate peak, and those at which the wave has become the exact solitary wave, are omitted.

    Parameters
    ----------
    result : Simulation
        Result of any simulation of equal spheres. At most fifteen contacts are computed by simulating again.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.

    Raises
    ------
    NotCoveredError
        If the result is of a chain beyond equal spheres.
    """
    if result.wave is None:
        got = "got forces at contacts alone; pictures.peak_forces and pictures.chain_map draw its forces"
        raise NotCoveredError.of("result", f"must have a leading wave with a limit ({got})")
    last = result.primary.contact
    floor = result.error_estimate
    distances = {}
    for contact in range(0, last, math.ceil((last + 1) / _CONTACTS)):
        with contextlib.suppress(NumericalError):
            passage = result.passage(contact)
            if not passage.exact:
                distances[contact] = passage.peak_force / result.peak_force - 1
    sizes = np.abs(list(distances.values()))
    bottom = max(sizes.min(initial=floor) / 5, floor * _LOWEST)
    with canvas(ax, result, x="contact", y="relative distance from the limit") as ax:
        ax.plot(list(distances), sizes, "o", color=METHODS["simulation"], label="simulation")
        ax.set(yscale="log", ylim=(bottom, 4 * sizes.max(initial=floor)), xlim=(-0.5, last + 1.5))
        ax.axhspan(bottom, floor, color=GREY, alpha=0.2, linewidth=0, label="error estimate of the limit")
        ax.axvline(last, color=GREY, linestyle=":", label="measurement of the limit")
        return ax


def balance(result: Simulation, *, ax: Axes | None = None) -> Axes:
    """Draw the energy of the chain against time, with the input of the shock.

    The energy is stacked, contact energy on kinetic energy, with the work of the shock from its end on; in chains
    beyond equal spheres with the work or the energy of the striker, of which damping dissipates a part. The legend
    states the defect of the balance at the end.

    Parameters
    ----------
    result : Simulation
        Result with ``energies`` recorded; time in s, energy in J.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.

    Raises
    ------
    InvalidValueError
        If the energies were not recorded.
    """
    histories = find_histories(result, "energies")
    times = histories.times
    kinetic = np.asarray(histories.kinetic_energy)
    total = kinetic + np.asarray(histories.contact_energy)
    work = result.applied_energy if result.wave is None else result.wave.applied_energy
    begin, name = 0.0, "energy of the striker"
    if result.shock is not None:
        begin, name = min(result.shock.duration, times[-1]), "work of the shock"
    with canvas(ax, result, x="time", y="energy", from_zero=True) as ax:
        area(ax, times, 0.0, kinetic, SKY, "", "kinetic energy")
        area(ax, times, kinetic, total, OCHRE, "////", "contact energy")
        ax.plot(times, total, color=METHODS["simulation"], label="total")
        ax.plot([begin, times[-1]], [work, work], color=ink(), linestyle="--", label=name)
        ax.set_xlim(0, times[-1])
        if result.shock is not None:
            ax.axvline(result.shock.duration, color=GREY, linewidth=0.8, linestyle=":", label="end of the shock")
        ax.plot([], [], " ", color="none", label=f"defect {result.energy_defect:.1e}".replace("-", MINUS))
        return ax


def work_precision(rows: Iterable[Any], name: str = "relative error", *, ax: Axes | None = None) -> Axes:
    """Draw a work-precision diagram: error against run time, with a line for each method.

    The legend counts runs that failed or have no finite error. Errors below 1e-16 are drawn at 1e-16.

    Parameters
    ----------
    rows : iterable
        Runs, in the order in which a line connects those of a method: objects with a ``method``, an ``error`` and a
        run time in ``seconds`` (or None), and a ``problem``, empty unless the run failed.
    name : str
        Label of the error.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.
    """
    runs: dict[str, list[Any]] = {}
    for row in rows:
        runs.setdefault(row.method, []).append(row)
    with canvas(ax, x="run time", y=(literal(name), "")) as ax:
        for index, (method, attempts) in enumerate(runs.items()):
            good = [row for row in attempts if not row.problem and row.error is not None and math.isfinite(row.error)]
            seconds = [row.seconds or math.nan for row in good]
            errors = [max(abs(row.error), _ROUNDING) for row in good]
            failed = len(attempts) - len(good)
            label = literal(method) + (f" ({failed} failed)" if failed else "")
            ax.plot(seconds, errors, label=label, **series(index, marked=True))
        ax.set(xscale="log", yscale="log")
        return ax
