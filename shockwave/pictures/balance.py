"""The balances of energy and momentum: what the shock has put into the chain, and where it is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from shockwave.errors import InvalidValueError
from shockwave.pictures.axes import area, finish, thinned
from shockwave.pictures.style import BLACK, BLUE, GREY, MINUS, ORANGE, SKY
from shockwave.pictures.waves import recorded

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.measurement.result import SimulationResult
    from shockwave.quadrature import FloatArray


def balance(ax: Axes, result: SimulationResult, of: Literal["energy", "momentum"] = "energy") -> Axes:
    """Input of the shock and content of the chain against time, with the defect of the balance at the end.

    Energy is stacked, of contacts upon kinetic, under the work of the shock: while it acts, where the ``field`` was
    recorded too, else its final amount. Momentum is that of granules that move forward and backward, and their sum,
    on the impulse of the shock.

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
    if of not in ("energy", "momentum"):
        raise InvalidValueError.of("of", f"must be energy or momentum (got {of!r})")
    highest = (_energy if of == "energy" else _momentum)(ax, result)
    defect = result.energy_defect if of == "energy" else result.momentum_defect
    end = float(recorded(result, "energies", "field").times[-1])
    ax.axvline(result.shock.duration, color=GREY, linewidth=0.8, linestyle=":", label="end of shock")
    ax.plot([], [], " ", label=f"defect {defect:.1e}".replace("-", MINUS))
    ax.set_xlim(0, end)
    return finish(ax, ("time", "s", end), (of, "J" if of == "energy" else "N s", highest))


def _energy(ax: Axes, result: SimulationResult) -> float:
    """Draw the energy; the work of the shock [J]."""
    kept = recorded(result, "energies")
    times, kinetic = kept.times, np.asarray(kept.kinetic_energy)
    # what is stacked has its points in common
    x, total = thinned(times, kinetic + np.asarray(kept.contact_energy))
    own = kinetic[np.searchsorted(times, x)]
    area(ax, x, 0.0, own, SKY, "", "kinetic")
    area(ax, x, own, total, ORANGE, "////", "in contacts")
    ax.plot(x, total, color=BLUE, linewidth=1.2, label="sum")
    work = float(result.found.work * result.scales.energy)
    if kept.displacements is not None and kept.velocities is not None:
        drawn = thinned(times, _work(result, times, kept.displacements, kept.velocities))
    else:
        drawn = np.array([min(result.shock.duration, times[-1]), times[-1]]), np.array([work, work])
    ax.plot(*drawn, color=BLACK, linewidth=1.2, linestyle="--", label="work of shock")
    ax.set_ylim(0, 1.1 * max(work, float(total.max())))
    return work


def _momentum(ax: Axes, result: SimulationResult) -> float:
    """Draw the momentum; the greatest [N s]."""
    kept = recorded(result, "field")
    momenta, times = result.chain.granule_mass * np.asarray(kept.velocities), kept.times
    forward, backward = np.maximum(momenta, 0).sum(axis=1), np.minimum(momenta, 0).sum(axis=1)
    for values, colour, hatch, name in ((forward, SKY, "", "forward"), (backward, ORANGE, "////", "backward")):
        x, y = thinned(times, values)
        area(ax, x, 0.0, y, colour, hatch, name)
    ax.plot(*thinned(times, momenta.sum(axis=1)), color=BLUE, linewidth=1.2, label="sum")
    impulse = _impulse(result, times)
    ax.plot(*thinned(times, impulse), color=BLACK, linewidth=1.2, linestyle="--", label="impulse of shock")
    ax.axhline(0, color=BLACK, linewidth=0.6)
    highest = max(float(forward.max()), float(impulse.max()))
    ax.set_ylim(1.2 * float(backward.min()) - 0.02 * highest, 1.1 * highest)
    return highest


def _impulse(result: SimulationResult, times: FloatArray) -> FloatArray:
    """Of the shock up to each of ``times`` [N s]."""
    shock = result.shock
    path = shock.profile.free_path()
    n = float(shock.profile.duration_ratio)
    shares = [path.at(float(s))[1] for s in np.minimum(times / shock.rise_time, n)]
    return shock.peak_force * shock.rise_time * np.array(shares)


def _work(result: SimulationResult, times: FloatArray, moved: FloatArray, velocities: FloatArray) -> FloatArray:
    """Of the shock up to each of ``times`` [J].

    With J the impulse, f the first contact force, m and v mass and velocity of the first granule,
    W = int F v dt = J v - J^2/2m + int J f dt / m: smooth under the integral, where F v has the kinks of the shock.
    """
    from scipy.interpolate import CubicSpline

    impulse, mass = _impulse(result, times), result.chain.granule_mass
    overlap = np.maximum(moved[:, 0] - (moved[:, 1] if moved.shape[1] > 1 else 0.0), 0.0)
    force = result.chain.contact_stiffness * overlap * np.sqrt(overlap)
    integral = CubicSpline(times, impulse * force).antiderivative()(times)
    return np.asarray(impulse * velocities[:, 0] - impulse**2 / (2 * mass) + integral / mass)
