"""Draw the pictures of ``docs/universal.md``, the laws beside simulations, and print its table of largest errors.

    python research/draw/draw_universal.py

writes ``docs/universal/shocks.svg`` and ``ends.svg`` in half a minute. The simulated points are not those of the fits.
"""

from __future__ import annotations

import math
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from shockwave import pictures
from shockwave.pictures.picture_elements import BLACK, COLOURS, LINES, add_legend, label_axis
from shockwave.scene import closed_form_laws as laws

sys.path.append(str(Path(__file__).parents[1]))
import fit_laws as fit

FOLDER = Path(__file__).parents[2] / "docs" / "universal"
SEED = 3701
# Random pulses in the picture, and in the table.
PULSES = 120
JUDGED = 3000
POINT: Any = {"linestyle": "none", "marker": "o", "markersize": 2.6, "markeredgewidth": 0}
CURVE: Any = {"color": BLACK, "linewidth": 0.9}
# Strikers whose trains are simulated.
MASSES = np.geomspace(1.3, 900, 12)
# Damping times over the unit of the fit, each with a number of granules.
DAMPED = ((0.002, 300), (0.01, 300), (0.027, 250), (0.045, 200))


def draw_impulses(ax: Any) -> dict[str, float]:
    """I_p against the exponent."""
    p, points = np.linspace(1.05, 6, 80), np.linspace(1.13, 5.8, 12)
    simulated = np.array([fit.impulse_limit(each) for each in points])
    ax.plot(p, [laws.impulse_peak(1.0, each) for each in p], **CURVE)
    ax.plot(points, simulated, color=COLOURS[0], **POINT)
    label_axis(ax, "x", "contact exponent $p$")
    label_axis(ax, "y", "$I_p$")
    law = np.array([laws.impulse_peak(1.0, each) for each in points])
    return {"impulse, $p$ from 1.13 to 5.8": np.abs(law / simulated - 1).max()}


def draw_short(ax: Any) -> dict[str, float]:
    """Short shocks over the impulse limit, against the spread."""
    (strength, spread, skewness), shocks = fit.random_shocks(SEED, JUDGED)
    simulated = fit.amplifications(shocks)
    error = np.abs(laws.short_peak(strength, spread, skewness) / simulated - 1)
    ax.scatter(spread[:PULSES], (simulated / laws.impulse_peak(strength))[:PULSES], s=4, color=COLOURS[0], linewidth=0)
    tau = np.linspace(0, laws.MOST_SPREAD, 40)
    for g, line in zip((0.0, -1.0, 1.0), LINES, strict=False):
        ax.plot(
            tau, laws.short_peak(1.0, tau, g) / laws.impulse_peak(1.0), linestyle=line, label=f"$g = {g:g}$", **CURVE
        )
    label_axis(ax, "x", r"spread $\tau$")
    label_axis(ax, "y", r"$F/(1.168\,F_0 S^{6/5})$")
    add_legend(ax, ax.lines)
    bands = {(low, high): (spread >= low) & (spread < high) for low, high in pairwise(fit.BANDS)}
    return {f"short shocks, $\\tau$ from {low} to {high}": error[at].max() for (low, high), at in bands.items()}


def draw_wall(ax: Any) -> dict[str, float]:
    """Force on a wall against its stiffness."""
    wave, points = fit.formed_wave(), laws.RIGID * np.linspace(0.04, 0.98, 40) ** 2
    simulated = np.array([fit.wall_ratio(each, wave) for each in points]) * points**0.4
    kappa = np.linspace(0, laws.RIGID, 100)
    ax.plot(kappa, laws.wall_factor(kappa), **CURVE)
    ax.plot(points, simulated, color=COLOURS[0], **POINT)
    label_axis(ax, "x", r"stiffness ratio $\kappa$")
    label_axis(ax, "y", "$W$")
    return {"wall": np.abs(laws.wall_factor(points) / simulated - 1).max()}


def draw_waves(ax: Any) -> dict[str, float]:
    """Peak forces of the waves of a striker against its mass."""
    leading = np.array([fit.leading_wave(mass) for mass in MASSES])
    simulated = leading[:, None] * np.array([fit.train(mass) for mass in MASSES])
    mass_ratio = np.geomspace(0.1, laws.HEAVIEST, 80)
    waves, law = laws.striker_waves(mass_ratio), laws.striker_waves(MASSES)
    for number in range(6):
        shown = waves[:, number] > 0
        ax.plot(mass_ratio[shown], waves[shown, number], **CURVE)
        judged = law[:, number] > 0
        ax.plot(MASSES[judged], simulated[judged, number], color=COLOURS[number], **POINT)
    ax.set_xscale("log")
    label_axis(ax, "x", r"mass ratio $\mu$ of the striker")
    label_axis(ax, "y", r"$F/(m^3 k^2 v^6)^{1/5}$, six waves")
    off = np.where(law > 0, np.abs(law - simulated) / simulated[:, :1], 0.0)
    return {
        "striker, leading wave": off[:, 0].max(),
        "striker, later waves, over the leading one": off[:, 1:].max(),
    }


def draw_velocity(ax: Any) -> dict[str, float]:
    """Velocity of a striker afterwards against its mass."""
    masses = np.geomspace(0.02, 1.75, 15)
    simulated = np.array([1 - 2 / (1 + mass) * fit.rebound(math.log(mass)) for mass in masses])
    mass_ratio = np.geomspace(0.01, 10, 160)
    ax.plot(mass_ratio, laws.striker_velocity(mass_ratio), **CURVE)
    ax.plot(masses, simulated, color=COLOURS[0], **POINT)
    ax.set_xscale("log")
    label_axis(ax, "x", r"mass ratio $\mu$ of the striker")
    label_axis(ax, "y", "$v'/v$")
    error = np.abs(laws.striker_velocity(masses) - simulated)
    return {
        r"velocity of the striker, $\mu$ below 1.1, over $v$": error[masses < fit.LIGHT].max(),
        r"velocity of the striker, $\mu$ from 1.1, over $v$": error[masses >= fit.LIGHT].max(),
    }


def draw_damping(ax: Any) -> dict[str, float]:
    """Decay under damping against the number of contacts."""
    errors = {}
    for index, (damping, granules) in enumerate(DAMPED):
        n, times = fit.decay(damping, granules)
        ratio = damping / times[0]
        simulated = (times[0] / times) ** 6
        ax.plot(n[::2], laws.damped_decay(n[::2], ratio), **CURVE)
        ax.plot(n[::4], simulated[::4], color=COLOURS[index], label=f"$A/T$ = {ratio:.3f}", **POINT)
        errors[ratio] = np.abs(laws.damped_decay(n, ratio) / simulated - 1).max()
    ax.set_yscale("log")
    label_axis(ax, "x", "contacts $n$")
    label_axis(ax, "y", "$F_n/F$")
    add_legend(ax, ax.lines[1::2])
    return {f"damping, $A/T$ = {ratio:.3f}": error for ratio, error in errors.items()}


PICTURES = {
    "shocks": (draw_impulses, draw_short, draw_damping),
    "ends": (draw_wall, draw_waves, draw_velocity),
}


def draw(name: str) -> tuple[Figure, dict[str, float]]:
    """A picture, and the largest relative errors of the laws that it shows."""
    figure, axes = pictures.figure(1, 3, (7.4, 2.9))
    errors = {}
    with rc_context(pictures.style()):
        for ax, draw_law in zip(axes, PICTURES[name], strict=True):
            errors |= draw_law(ax)
    return figure, errors


def main() -> None:
    """Draw the pictures and print the table."""
    FOLDER.mkdir(exist_ok=True)
    for name in PICTURES:
        figure, errors = draw(name)
        for law, error in errors.items():
            print(f"| {law} | {error:.1g} |")
        pictures.save(figure, FOLDER / f"{name}.svg")


if __name__ == "__main__":
    main()
