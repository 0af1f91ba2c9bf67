"""The contact force of a ball that strikes a body, by Hertz's law, with its integrals in closed form."""

from __future__ import annotations

import math

import attrs
import numpy as np
from attrs import frozen
from scipy.special import betaincinv
from shockwave import InvalidValueError, ShockProfile, quantity
from shockwave.hooks import FloatArray

__all__ = ["HertzImpact"]

# Time to the greatest indentation over indentation/speed: (2/5) B(2/5, 1/2) = 1.4716.
_TURN = 0.4 * math.gamma(0.4) * math.sqrt(math.pi) / math.gamma(0.9)
_AREA = 0.8 / _TURN
_NEEDED = (
    "ball_mass",
    "ball_speed",
    "ball_radius",
    "ball_youngs_modulus",
    "ball_poisson_ratio",
    "struck_youngs_modulus",
    "struck_poisson_ratio",
)


@frozen(kw_only=True)
class HertzImpact(ShockProfile):
    """F1 = u^(3/2), where u is the indentation over its maximum and u' = turn sqrt(1 - u^(5/2)); n = 2.

    The pulse is symmetric about its peak, and turn = (2/5) B(2/5, 1/2) = 1.4716 makes u(1) = 1. In closed
    form w = u^(5/2) is where the regularised incomplete beta function I_w(2/5, 1/2) has the value s.

    Parameters
    ----------
    ball_mass : float, optional
        Mass m [kg], above 0. Give this and all parameters below, or none of them.
    ball_speed : float, optional
        Speed v [m/s] at first contact, above 0.
    ball_radius : float, optional
        Radius [m], above 0.
    ball_youngs_modulus, struck_youngs_modulus : float, optional
        Young's modulus E of ball and struck body [Pa], above 0.
    ball_poisson_ratio, struck_poisson_ratio : float, optional
        Poisson's ratio nu of both, above -1 and below 0.5.
    struck_radius : float, optional
        Radius of the struck body [m], above 0; if omitted, the body is flat.

    Raises
    ------
    InvalidValueError
        When a value is out of range or missing, or when the force is beyond the range of a float.

    Notes
    -----
    If the ball is given, peak force and duration follow: with k = (4/3) E* sqrt(R*), the greatest
    indentation is d = (5 m v^2/(4 k))^(2/5), the peak force k d^(3/2), the duration 2 turn d/v = 2.943 d/v.

    The struck body is assumed to be fixed, so the ball leaves with its initial speed. In a chain the first
    granule moves, and the actual force is smaller and shorter than this pulse, the more so the heavier the
    ball. For a ball of the granules' material, the table lists the peak force of the leading wave from this
    pulse, divided by that from the ball itself:

    =======================  =====  =====  =====  =====  =====  =====
    mass of ball / granule   0.02   0.05   0.1    0.2    0.5    1
    ratio of peak forces     1.02   1.06   1.12   1.23   1.54   1.96
    =======================  =====  =====  =====  =====  =====  =====

    Use the pulse only for a ball much lighter than a granule, otherwise `shockwave.Impact`.

    Areas are a1 = a2 = 0.8/turn = 0.5436. The third of the conditions (3) fails:

    ===============  =========================
    condition        margin
    ===============  =========================
    a2 >= a1         0: holds, with equality
    a1 >= 1/2        0.0436: holds
    a2 <= (n-1)/2    -0.0436: fails
    ===============  =========================

    References
    ----------
    Hertz, H. (1882). Ueber die Beruehrung fester elastischer Koerper. J. reine angew. Math. 92, 156-171.

    Johnson, K. L. (1985). Contact Mechanics, section 11.4. Cambridge University Press.
    """

    ball_mass: float | None = quantity(
        "kg", "mass of the ball", above=0, optional=True, default=None, example="0.11 g"
    )
    ball_speed: float | None = quantity(
        "m/s", "speed of the ball at first contact", above=0, optional=True, default=None, example="2 m/s"
    )
    ball_radius: float | None = quantity(
        "m", "radius of the ball", above=0, optional=True, default=None, example="1.5 mm"
    )
    ball_youngs_modulus: float | None = quantity(
        "Pa", "Young's modulus E of the ball", above=0, optional=True, default=None, example="193 GPa"
    )
    ball_poisson_ratio: float | None = quantity(
        "", "Poisson's ratio nu of the ball", above=-1, below=0.5, optional=True, default=None, example="0.3"
    )
    struck_radius: float | None = quantity(
        "m",
        "radius of the struck body; flat if omitted",
        above=0,
        optional=True,
        default=None,
        example="4.75 mm",
    )
    struck_youngs_modulus: float | None = quantity(
        "Pa", "Young's modulus E of the struck body", above=0, optional=True, default=None, example="193 GPa"
    )
    struck_poisson_ratio: float | None = quantity(
        "",
        "Poisson's ratio nu of the struck body",
        above=-1,
        below=0.5,
        optional=True,
        default=None,
        example="0.3",
    )
    duration_ratio: float = attrs.field(init=False, default=2.0)
    _impact: tuple[float, float] | None = attrs.field(init=False, repr=False, eq=False, default=None)

    def __attrs_post_init__(self) -> None:
        given = [name for name in (*_NEEDED, "struck_radius") if getattr(self, name) is not None]
        if not given:
            return
        problem = f"must be given with {given[0]} (got nothing; give all values of the impact or none)"
        errors = [InvalidValueError.of(name, problem) for name in _NEEDED if name not in given]
        if errors:
            raise InvalidValueError(*(fault for error in errors for fault in error.faults))
        object.__setattr__(self, "_impact", _impact_of(self))

    @property
    def recorded_peak_force(self) -> float | None:
        """Peak force of the impact [N], if the ball is given."""
        return self._impact[0] if self._impact is not None else None

    @property
    def recorded_rise_time(self) -> float | None:
        """Half the time of contact [s], if the ball is given."""
        return self._impact[1] if self._impact is not None else None

    @property
    def notes(self) -> tuple[str, ...]:
        """Assumption behind peak force and duration, if they follow from the ball."""
        if self._impact is None:
            return ()
        peak, half = self._impact
        figures = f"a peak force of {peak:.4g} N and a duration of {2 * half:.4g} s follow from the ball"
        return (f"{figures}, for a fixed body; the force on a movable granule is smaller",)

    def rise(self, s: FloatArray) -> FloatArray:
        return np.asarray(_energies(s)[0] ** 0.6)

    def decay(self, s: FloatArray) -> FloatArray:
        # seen from its end, the decay is the rise: no digits are lost near the end, and the last value is 0
        return self.rise(2.0 - s)

    def closed_areas(self) -> tuple[float, float]:
        return _AREA, _AREA

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        stored, kinetic = _energies(np.minimum(s, 2.0 - s))
        speed = np.sqrt(kinetic)
        # 1 - speed as a quotient, without cancellation for a small loss of speed
        return np.asarray(_AREA * np.where(s <= 1.0, stored / (1.0 + speed), 1.0 + speed))


def _energies(s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Stored and kinetic energy over their sum, w = u^(5/2) and 1 - w, for 0 <= s <= 1; both accurate."""
    s = np.asarray(s, dtype=float)
    # the smaller one is inverted, and the larger one is the remainder: neither loses digits
    early = s <= 0.5
    lesser = np.where(
        early,
        betaincinv(0.4, 0.5, np.where(early, s, 0.5)),
        betaincinv(0.5, 0.4, np.where(early, 0.5, 1.0 - s)),
    )
    return np.where(early, lesser, 1.0 - lesser), np.where(early, 1.0 - lesser, lesser)


def _impact_of(impact: HertzImpact) -> tuple[float, float]:
    """Peak force [N] and half the time of contact [s]."""
    try:
        peak, half = _peak_and_half(impact)
    except ArithmeticError:  # overflow or underflow
        peak, half = math.nan, math.nan
    if not all(math.isfinite(value) and value > 0 for value in (peak, half)):
        got = f"got {peak:g} N for {2 * half:g} s"
        problem = f"must give a force that a floating-point number can hold ({got})"
        raise InvalidValueError.of("ball_mass", problem)
    return peak, half


def _peak_and_half(impact: HertzImpact) -> tuple[float, float]:
    values = {name: float(getattr(impact, name)) for name in _NEEDED}
    compliance = sum(
        (1 - values[f"{body}_poisson_ratio"] ** 2) / values[f"{body}_youngs_modulus"]
        for body in ("ball", "struck")
    )
    curvature = 1 / values["ball_radius"] + (1 / impact.struck_radius if impact.struck_radius else 0.0)
    stiffness = 4 / 3 / compliance / math.sqrt(curvature)
    mass, speed = values["ball_mass"], values["ball_speed"]
    indentation = (1.25 * mass * speed * speed / stiffness) ** 0.4
    return stiffness * indentation**1.5, _TURN * indentation / speed
