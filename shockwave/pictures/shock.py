"""Pictures of the shock: areas of rise and decay, and the correction (5g,h)."""

from __future__ import annotations

import numpy as np

from shockwave.base.errors import InvalidValueError
from shockwave.base.numerics import FloatArray
from shockwave.pictures.figure_files import canvas
from shockwave.pictures.picture_elements import METHODS, MINUS, OCHRE, SKY, Axes, area, ink, si_label, thin
from shockwave.prediction.section4_outcome import EjectionOutcome, Section4Outcome
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.scene.shock import Shock

# Points of the rise, and of the decay.
_POINTS = 240
# Symbol of the virtual rise time.
_VIRTUAL = "t\N{COMBINING CIRCUMFLEX ACCENT}₀"


def pulse(shock: Shock, *, ax: Axes | None = None) -> Axes:
    """Draw the force against time, with the areas a1 of the rise and a2 of the decay, eq. (3).

    Parameters
    ----------
    shock : Shock
        The shock; time in s, force in N.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.
    """
    areas = shock.profile.areas()
    s = _abscissae(shock.profile)
    times = shock.rise_time * s
    forces = shock.peak_force * shock.profile.force(s)
    with canvas(ax, shock, x="time", y="force", from_zero=True) as ax:
        for name, value, inside, colour, hatch in (
            ("rise, a₁", areas.rise.value, times <= shock.rise_time, SKY, "////"),
            ("decay, a₂", areas.decay.value, times >= shock.rise_time, OCHRE, r"\\\\"),
        ):
            label = f"{name} = {value:.4g} F₀ t₀"
            area(ax, times[inside], 0.0, forces[inside], colour, hatch, label)
        chosen = thin(forces)
        ax.plot(times[chosen], forces[chosen], color=ink())
        ax.set_xlim(0, shock.duration)
        return ax


def correction_area(shock: Shock, outcome: Section4Outcome, *, ax: Axes | None = None) -> Axes:
    """Draw Figure 1 of the paper: the shock, the virtual shock of (5g), and the area that (5h) adds twice.

    Parameters
    ----------
    shock : Shock
        The shock.
    outcome : Section4Outcome
        Its prediction, in the regime ejection.
    ax : Axes, optional
        Axes to draw on; default: those of a new figure.

    Raises
    ------
    InvalidValueError
        If the regime is another one.
    """
    if not isinstance(outcome, EjectionOutcome):
        got = getattr(outcome, "regime", type(outcome).__name__)
        raise InvalidValueError.of("outcome", f"must have the regime ejection, to which (5g,h) apply (got {got})")
    profile, force, virtual = shock.profile, shock.peak_force, outcome.virtual_rise_time
    n = float(profile.duration_ratio)
    s = _abscissae(profile)
    begin = max(n * virtual - (virtual - shock.rise_time), 0.0)
    added = np.unique(np.append(s[s > begin / virtual], begin / virtual))
    with canvas(ax, x="time", y="force", from_zero=True) as ax:
        label = f"added: 2 \N{MULTIPLICATION SIGN} area = {si_label(outcome.added_momentum, 'N s')}"
        area(ax, virtual * added, 0.0, force * profile.force(added), OCHRE, "////", label)
        for time, name, colour, line in (
            (shock.rise_time, "shock, t₀", METHODS["shock"], "-"),
            (virtual, f"virtual shock, {_VIRTUAL}", METHODS["section 4"], "--"),
        ):
            label = f"{name} = {si_label(time, 's')}"
            forces = force * profile.force(s)
            chosen = thin(forces)
            ax.plot(time * s[chosen], forces[chosen], color=colour, linestyle=line, label=label)
        ax.axvline(begin, color=ink(), linewidth=0.7, linestyle=":", label=f"n {_VIRTUAL} {MINUS} Δt₀")
        ax.set_xlim(0, n * virtual)
        return ax


def _abscissae(profile: ShockProfile) -> FloatArray:
    """Times at which the force is drawn: kinks, equal steps, and dense points at the ends of rise and decay."""
    n = float(profile.duration_ratio)
    breaks = np.asarray(profile.breakpoints, dtype=float)
    dense = np.geomspace(1e-9, 0.5, _POINTS // 4)
    share = np.concatenate((np.linspace(0, 1, _POINTS), dense, 1 - dense))
    # the force may jump just after 0 and at 1
    return np.unique(np.concatenate((breaks, share, 1 + (n - 1) * share, [np.nextafter(1.0, 2.0)])).clip(0, n))
