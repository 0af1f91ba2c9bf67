"""How far to trust the numbers: approach to the limit, balances, errors of section 4, error against run time."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from shockwave.errors import InvalidValueError, NumericalError
from shockwave.measurement.result import SimulationResult
from shockwave.pictures.axes import area, decades, dress, finish, label_axis, scale, thinned
from shockwave.pictures.cells import NO_VALUE, check_shapes, edges_of, hatch, regions
from shockwave.pictures.style import BLACK, BLUE, COLOURS, GREY, LINES, MARKERS, MINUS, ORANGE, SIGNED, SKY, literal
from shockwave.pictures.waves import overlap_force, recorded
from shockwave.quadrature import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_CONTACTS = 30
# The picture of an approach goes as far below the error of the limit.
_DEEP = 30.0
# Bounds of the colours of errors, which have no upper bound; none is below -1.
_BOUNDS = (-1.0, -0.5, -0.2, -0.1, -0.05, -0.02, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
# Runs without a place on the axis of errors stand so many times below the least, and above the greatest error.
_APART = 8.0


# ---------------------------------------------------------------- of one simulation


def approach(ax: Axes, result: SimulationResult, contacts: Iterable[int] | None = None) -> Axes:
    """How far the primary's peak force is from its limit, contact by contact.

    Below the error estimate of the limit, shaded, a distance says nothing. Contacts at which the front has no peak of
    its own, and those from which on it is the exact wave, are left out.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    result : SimulationResult
        Of any simulation; each contact is integrated up to once more.
    contacts : iterable of int, optional
        Where to look. Left out, thirty at most, up to where the primary was read.

    Raises
    ------
    InvalidValueError
        When the chain has no such contact.
    """
    last = result.primary.contact
    floor = result.error_estimate
    if contacts is None:
        contacts = range(0, last + 1, math.ceil((last + 1) / _CONTACTS))
    distances = {}
    for contact in contacts:
        with contextlib.suppress(NumericalError):
            passage = result.passage(contact)
            if contact != last and not passage.exact:
                distances[contact] = passage.peak_force / result.peak_force - 1
    sizes = np.abs(list(distances.values()))
    ax.plot(list(distances), sizes, "o", color=BLUE, markersize=4, label="distance")
    bottom = max(sizes.min(initial=floor) / 5, floor / _DEEP)
    ax.set(yscale="log", ylim=(bottom, 4 * sizes.max(initial=floor)), xlim=(-0.5, last + 1.5))
    ax.axhspan(bottom, floor, color=GREY, alpha=0.2, linewidth=0, label="error of the limit")
    ax.axvline(last, color=GREY, linewidth=1.0, linestyle=":", label="where it was read")
    return finish(ax, "contact", "relative distance to the limit")


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
    if of == "energy":
        highest = _energy(ax, result)
        defect = result.energy_defect
        unit = "J"
    elif of == "momentum":
        highest = _momentum(ax, result)
        defect = result.momentum_defect
        unit = "N s"
    else:
        raise InvalidValueError.of("of", f"must be energy or momentum (got {of!r})")
    end = float(recorded(result, "energies", "field").times[-1])
    ax.axvline(result.shock.duration, color=GREY, linewidth=0.8, linestyle=":", label="end of shock")
    ax.plot([], [], " ", label=f"defect {defect:.1e}".replace("-", MINUS))
    ax.set_xlim(0, end)
    return finish(ax, ("time", "s", end), (of, unit, highest))


def _energy(ax: Axes, result: SimulationResult) -> float:
    """Draw the energy; the work of the shock [J]."""
    kept = recorded(result, "energies")
    times = kept.times
    kinetic = np.asarray(kept.kinetic_energy)
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
        begin = min(result.shock.duration, times[-1])
        drawn = np.array([begin, times[-1]]), np.array([work, work])
    ax.plot(*drawn, color=BLACK, linewidth=1.2, linestyle="--", label="work of shock")
    ax.set_ylim(0, 1.1 * max(work, float(total.max())))
    return work


def _momentum(ax: Axes, result: SimulationResult) -> float:
    """Draw the momentum; the greatest [N s]."""
    kept = recorded(result, "field")
    times = kept.times
    momenta = result.chain.granule_mass * np.asarray(kept.velocities)
    forward = np.maximum(momenta, 0).sum(axis=1)
    backward = np.minimum(momenta, 0).sum(axis=1)
    for values, colour, pattern, name in (
        (forward, SKY, "", "forward"),
        (backward, ORANGE, "////", "backward"),
    ):
        x, y = thinned(times, values)
        area(ax, x, 0.0, y, colour, pattern, name)
    impulse = _impulse(result, times)
    sum_line = thinned(times, momenta.sum(axis=1))
    ax.plot(*sum_line, color=BLUE, linewidth=1.2, label="sum")
    ax.plot(*thinned(times, impulse), color=BLACK, linewidth=1.2, linestyle="--", label="impulse of shock")
    ax.axhline(0, color=BLACK, linewidth=0.6)
    highest = max(float(forward.max()), float(impulse.max()))
    ax.set_ylim(1.2 * float(backward.min()) - 0.02 * highest, 1.1 * highest)
    return highest


def _impulse(result: SimulationResult, times: FloatArray) -> FloatArray:
    """Of the shock up to each of ``times`` [N s]."""
    shock = result.shock
    path = shock.profile.free_path()
    ends = np.minimum(times / shock.rise_time, float(shock.profile.duration_ratio))
    shares = [path.at(float(s))[1] for s in ends]
    return shock.peak_force * shock.rise_time * np.array(shares)


def _work(result: SimulationResult, times: FloatArray, moved: FloatArray, velocities: FloatArray) -> FloatArray:
    """Of the shock up to each of ``times`` [J].

    With J the impulse, f the first contact force, m and v mass and velocity of the first granule,
    W = int F v dt = J v - J^2/2m + int J f dt / m: smooth under the integral, where F v has the kinks of the shock.
    """
    from scipy.interpolate import CubicSpline

    impulse = _impulse(result, times)
    mass = result.chain.granule_mass
    force = overlap_force(result.chain, moved[:, :2])[:, 0]
    integral = CubicSpline(times, impulse * force).antiderivative()(times)
    return np.asarray(impulse * velocities[:, 0] - impulse**2 / (2 * mass) + integral / mass)


# ---------------------------------------------------------------- of many predictions


def trust_map(
    ax: Axes,
    x: npt.ArrayLike,
    n: npt.ArrayLike,
    error: npt.ArrayLike,
    regime: npt.ArrayLike,
    holds: npt.ArrayLike | None = None,
) -> Axes:
    """Error of the predicted peak force over the plane (n t0/T0, n), with the borders of the regimes.

    Parameters
    ----------
    ax : Axes
        Where to draw; a scale of colours is put beside it.
    x : array, shape (p,)
        n t0/T0, ascending, above 0.
    n : array, shape (q,)
        Duration ratios, ascending, above 1.
    error : array, shape (p, q)
        Relative error, prediction over simulation less one; not a number where there is none, which is left grey.
    regime : array of str, shape (p, q)
        Of the prediction; an empty one is none.
    holds : array of bool, shape (p, q), optional
        Whether the conditions (3) are met; where not, it is hatched.

    Raises
    ------
    InvalidValueError
        When shapes do not fit, or there are not two values or more along each axis.
    """
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm

    across = np.asarray(x, dtype=float)
    up = np.asarray(n, dtype=float)
    errors = np.asarray(error, dtype=float)
    regimes = np.asarray(regime, dtype=str)
    met = np.ones(errors.shape, dtype=bool) if holds is None else np.asarray(holds, dtype=bool)
    check_shapes({"error": errors, "regime": regimes, "holds": met}, across, up)
    colours = colormaps[SIGNED]
    norm = BoundaryNorm(_BOUNDS, colours.N, extend="max")
    edges = edges_of(across, log=True), edges_of(up, log=True)
    values = np.ma.masked_invalid(errors).T
    drawn = ax.pcolormesh(*edges, values, norm=norm, cmap=colours, rasterized=True, shading="flat")
    ax.set(facecolor=NO_VALUE, xlim=edges[0][[0, -1]], ylim=edges[1][[0, -1]])
    names = sorted(set(regimes.ravel()) - {""})
    regions(ax, across, up, {name: np.where(regimes == name, -0.5, 0.5) for name in names})
    hatch(ax, edges, ~met, "conditions (3) not met", "////")
    bar = scale(ax, drawn, "error (%)", spacing="uniform", ticks=_BOUNDS)
    bar.ax.set_yticklabels([f"{100 * bound:+.0f}".replace("-", MINUS) for bound in _BOUNDS])
    decades(ax, "x")
    decades(ax, "y")
    label_axis(ax, "x", "duration over characteristic time, $n t_0/T_0$")
    label_axis(ax, "y", "duration over rise time, $n$")
    return dress(ax, grid=False)


# ---------------------------------------------------------------- of methods


def work_precision(ax: Axes, rows: Iterable[Any], name: str = "relative error") -> Axes:
    """Error against time, both logarithmic, a line for each method in the order of its rows.

    A run that failed, or whose error is not a number, is a cross at the top, at the time that it took; without a time
    it is counted in the key alone. A run without any error is a triangle that points down, at the bottom.

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
    runs: dict[str, list[tuple[float, float]]] = {}
    for row in rows:
        runs.setdefault(row.method, []).append((row.seconds or math.nan, _error(row)))
    every = np.array([run for own in runs.values() for run in own]).reshape(-1, 2)
    known = every[:, 1][every[:, 1] > 0]
    bottom = known.min(initial=1.0) / _APART
    top = known.max(initial=1e-16) * _APART
    for index, (method, own) in enumerate(runs.items()):
        seconds, errors = np.array(own).T
        colour = COLOURS[index % len(COLOURS)]
        marker = MARKERS[index % len(MARKERS)]
        line = LINES[index % len(LINES)]
        exact = seconds[errors == 0]
        failed = seconds[np.isnan(errors)]
        lost = failed[np.isfinite(failed)]
        good = errors > 0
        label = literal(method) + (f" ({len(failed)} failed)" if len(failed) else "")
        look = {"marker": marker, "markersize": 3.5, "linestyle": line, "linewidth": 1.0}
        ax.plot(seconds[good], errors[good], color=colour, label=label, **look)
        ax.plot(exact, np.full(len(exact), bottom), "v", color=colour, markersize=5)
        ax.plot(lost, np.full(len(lost), top), "x", color=colour, markersize=5)
    ax.set(xscale="log", yscale="log", ylim=(bottom / 2, 2 * top))
    # the prefix of the middle of a logarithmic axis
    middle = math.sqrt(math.prod(ax.get_xlim()))
    return finish(ax, ("time", "s", middle), literal(name))


def _error(row: Any) -> float:
    """The size of the error; not a number where the run failed."""
    failed = row.problem or row.error is None or not math.isfinite(row.error)
    return math.nan if failed else abs(row.error or 0.0)
