"""The shock itself: its areas, the conditions (3), and the correction of (5g,h)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shockwave.errors import InvalidValueError
from shockwave.pictures.style import (
    BLACK,
    BLUE,
    LABEL,
    ORANGE,
    SKY,
    VERMILION,
    dress,
    key,
    measure,
    ratio,
    thinned,
    thousandths,
)
from shockwave.prediction.outcome import EjectionOutcome
from shockwave.profiles.conditions import TOLERANCE
from shockwave.profiles.conditions import conditions as conditions_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.prediction.outcome import Outcome
    from shockwave.profiles.base import ShockProfile
    from shockwave.profiles.shock import Shock
    from shockwave.quadrature import FloatArray

__all__ = ["conditions", "correction_area", "pulse"]

# An area narrower than this share of the picture, or with its name so near the axis, is named in the key alone.
_ROOM, _LOW = 0.12, 0.06
_POINTS = 240


def pulse(ax: Axes, shock: Shock) -> Axes:
    """Force against time, with the areas a1 under the rise and a2 under the decay, eq. (3).

    Parameters
    ----------
    ax : Axes
        Where to draw.
    shock : Shock
        What to draw; time in s, force in N.
    """
    profile, unit = shock.profile, shock.rise_time
    areas, n = profile.areas(), float(profile.duration_ratio)
    s = _abscissae(profile)
    x, y = thinned(unit * s, shock.peak_force * profile.force(s))
    parts = (
        ("1", "rise", areas.rise.value, x <= unit, SKY, "////", (0.0, 1.0)),
        ("2", "decay", areas.decay.value, x >= unit, ORANGE, r"\\\\", (1.0, n)),
    )
    for number, name, area, inside, colour, hatch, (begin, end) in parts:
        label = f"{name}, $a_{number}$ = {area:.4g} $F_0 t_0$"
        # hatches keep the two apart in grey
        ax.fill_between(
            x[inside], y[inside], facecolor=colour, alpha=0.55, hatch=hatch, edgecolor="white", linewidth=0, label=label
        )
        middle = begin + (0.62 if number == "1" else 0.33) * (end - begin)
        height = 0.4 * shock.peak_force * float(profile.force(middle))
        if end - begin > _ROOM * n and height > _LOW * shock.peak_force:
            box = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.85}
            ax.text(unit * middle, height, f"$a_{number}$", ha="center", va="center", fontsize=LABEL, bbox=box)
    ax.plot(x, y, color=BLACK, linewidth=1.2)
    ax.set_xlim(0, unit * n)
    ax.set_ylim(0, 1.08 * shock.peak_force)
    measure(ax, "x", shock.duration, "s", "time")
    measure(ax, "y", shock.peak_force, "N", "force")
    key(ax)
    return dress(ax)


def conditions(ax: Axes, shock: Shock) -> Axes:
    """The three conditions (3): by how much each holds, as a share of both its sides together.

    Parameters
    ----------
    ax : Axes
        Where to draw; a low and wide one will do.
    shock : Shock
        Whose areas are judged. The margins told are in units of its rise time.
    """
    areas, n = shock.profile.areas(), float(shock.profile.duration_ratio)
    a1, a2 = areas.rise.value, areas.decay.value
    both = (a1 + a2, a1 + 0.5, a2 + (n - 1) / 2)
    judged = conditions_of(areas, n)
    told = []
    for place, (condition, sides) in enumerate(zip(judged, both, strict=True)):
        colour = BLUE if condition.holds else VERMILION
        share = condition.margin / sides
        ax.plot([0, share], [place, place], color=colour, linewidth=4, solid_capstyle="butt")
        ax.plot([share], [place], "o" if condition.holds else "X", color=colour, markersize=7)
        margin = condition.margin if abs(condition.margin) > TOLERANCE * n else 0.0
        verdict = "holds" if condition.holds else "fails"
        figures = f"{margin:+.4g} $t_0$, {verdict}".replace("-", "\N{MINUS SIGN}")
        told.append(f"{_formula(condition.statement)}\n{figures}")
    ax.axvline(0, color=BLACK, linewidth=0.8)
    ax.set_xlim(-1.08, 1.08)
    ax.set_xticks((-1, -0.5, 0, 0.5, 1))
    ax.set_ylim(2.6, -0.6)
    ax.set_yticks(range(len(told)), told)
    ratio(ax, "x", "margin over the sum of both sides")
    return dress(ax)


def correction_area(ax: Axes, shock: Shock, outcome: Outcome) -> Axes:
    """Figure 1 of the paper: the shock, the virtual shock of (5g), and the area that (5h) adds twice.

    Parameters
    ----------
    ax : Axes
        Where to draw.
    shock : Shock
        That was predicted.
    outcome : Outcome
        Its prediction, of the regime ejection.

    Raises
    ------
    InvalidValueError
        When the outcome is of another regime.
    """
    if not isinstance(outcome, EjectionOutcome):
        got = getattr(outcome, "regime", type(outcome).__name__)
        raise InvalidValueError.of("outcome", f"must be an ejection, to which (5g,h) belong (got {got})")
    profile, force, virtual = shock.profile, shock.peak_force, outcome.virtual_rise_time
    s, n = _abscissae(profile), float(profile.duration_ratio)
    shape = force * profile.force(s)
    begin = max(n * virtual - (virtual - shock.rise_time), 0.0)
    added = np.unique(np.append(s[s > begin / virtual], begin / virtual))
    label = rf"added: 2 $\times$ area = {thousandths(outcome.added_momentum, 'N s')}"
    ax.fill_between(
        virtual * added,
        force * profile.force(added),
        facecolor=ORANGE,
        alpha=0.6,
        hatch="////",
        edgecolor="white",
        linewidth=0,
        label=label,
    )
    own, other = (thousandths(time, "s") for time in (shock.rise_time, virtual))
    ax.plot(*thinned(shock.rise_time * s, shape), color=BLUE, linewidth=1.4, label=f"shock, $t_0$ = {own}")
    ax.plot(
        *thinned(virtual * s, shape),
        color=VERMILION,
        linewidth=1.4,
        linestyle="--",
        label=rf"virtual shock, $\hat{{t}}_0$ = {other}",
    )
    ax.axvline(begin, color=BLACK, linewidth=0.7, linestyle=":", label=r"$n \hat{t}_0 - \Delta t_0$")
    ax.set_xlim(0, n * virtual)
    ax.set_ylim(0, 1.08 * force)
    measure(ax, "x", n * virtual, "s", "time")
    measure(ax, "y", force, "N", "force")
    key(ax)
    return dress(ax)


def _formula(statement: str) -> str:
    """An inequality as mathematics."""
    for plain, set_ in ((">=", r"\geq"), ("<=", r"\leq"), ("a1", "a_1"), ("a2", "a_2")):
        statement = statement.replace(plain, set_)
    return f"${statement}$"


def _abscissae(profile: ShockProfile) -> FloatArray:
    """Where to take the force: at its kinks, evenly, and ever more densely towards the ends of rise and decay."""
    n, breaks = float(profile.duration_ratio), np.asarray(profile.breakpoints, dtype=float)
    dense = np.geomspace(1e-9, 0.5, _POINTS // 4)
    share = np.concatenate((np.linspace(0, 1, _POINTS), dense, 1 - dense))
    # just after 0 and at 1 the force may jump
    return np.unique(np.concatenate((breaks, share, 1 + (n - 1) * share, [np.nextafter(1.0, 2.0)])).clip(0, n))
