"""Laws of short shocks, walls, strikers, damping and tapers; m and k are mass and contact stiffness of equal granules.

Fits of ``research/fit_laws.py`` to simulations, shown in ``docs/universal.md``; predictions do not use them.
"""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.polynomial.chebyshev import chebval
from numpy.polynomial.polynomial import polyval

from shockwave.base.errors import InvalidValueError
from shockwave.base.numerics import FloatArray, floats
from shockwave.scene.chain import HERTZ
from shockwave.scene.solitary_wave import MOMENTUM

#: Stiffness ratio of a rigid wall, the largest for Hertz's law.
RIGID = 2 * math.sqrt(2)
#: Greatest mass ratio of strikers.
HEAVIEST = 1000.0
#: Mass ratio from which the striker does not rebound.
HEAVY = 1.79
#: Least peak force of a later wave of a striker, relative to the leading wave.
THRESHOLD = 4e-3
#: Greatest spread and skewness, in absolute value, of short shocks.
MOST_SPREAD = 0.7
MOST_SKEWNESS = 1.5
#: Greatest ratio A/T of the law of damping.
MOST_DAMPING = 0.05
#: Greatest reduction q of the radius from granule to granule in the law of tapers.
MOST_TAPERED = 0.2


@cache
def _table(name: str) -> Any:
    return json.loads(Path(__file__).with_name("closed_form_laws.json").read_text(encoding="utf-8"))[name]


def _polynomial(table: Any, x: FloatArray) -> FloatArray:
    edges, coefficients = np.array(table["edges"]), np.array(table["coefficients"]).T
    x = np.clip(x, edges[0], edges[-1])
    piece = np.searchsorted(edges[1:-1], x)
    begin, end = edges[piece], edges[piece + 1]
    return np.asarray(chebval((2 * x - begin - end) / (end - begin), coefficients[:, piece], tensor=False))


def _check_range(name: str, values: npt.ArrayLike, low: float, high: float, rule: str) -> FloatArray:
    array = floats(name, values)
    outside = ~((array >= low) & (array <= high))
    if outside.any():
        raise InvalidValueError.of(name, f"must be {rule} (got {array[outside].flat[0]:g})")
    return array


def impulse_peak(strength: npt.ArrayLike, exponent: float = HERTZ) -> FloatArray:
    """I_p S^(2p/(p+1)), the amplification F/F0 of very short shocks, for contact forces d^p with p from 1.05 to 6.

    ``strength`` is S, the impulse of the shock over the momentum of a wave of its peak force F0.
    """
    strength = _check_range("strength", strength, 0.0, math.inf, "at least 0")
    p = _check_range("exponent", exponent, 1.05, 6.0, "from 1.05 to 6")
    return np.asarray((1 + np.exp(_polynomial(_table("impulse"), np.log(p - 1)))) * strength ** (2 * p / (p + 1)))


def short_peak(strength: npt.ArrayLike, spread: npt.ArrayLike, skewness: npt.ArrayLike = 0.0) -> FloatArray:
    """Amplification F/F0 of short shocks, 1.1681817 S^(6/5) exp(-tau^(5/2) q(tau, g)), for Hertz's contact force.

    ``spread`` is tau = (sigma/t_A) S^(1/5), up to 0.7, and ``skewness`` is g, from -1.5 to 1.5. sigma and g are the
    standard deviation and skewness of the force as a density in time; t_A is the momentum of a wave of F0 over F0.
    """
    tau = _check_range("spread", spread, 0.0, MOST_SPREAD, f"from 0 to {MOST_SPREAD}")
    g = _check_range("skewness", skewness, -MOST_SKEWNESS, MOST_SKEWNESS, f"from {-MOST_SKEWNESS} to {MOST_SKEWNESS}")
    terms = zip(_table("short")["coefficients"], _table("short")["powers"], strict=True)
    return np.asarray(impulse_peak(strength) * np.exp(-sum(c * tau**a * g**b for c, (a, b) in terms)))


def wall_factor(stiffness_ratio: npt.ArrayLike) -> FloatArray:
    """W, greatest force on a flat wall over the peak force of the solitary wave that meets it.

    ``stiffness_ratio`` is kappa, from 0 to 2 sqrt(2): stiffness of the contact with the wall over that of the others.

    Examples
    --------
    >>> import shockwave as sw
    >>> same, rigid = sw.wall_factor([2**0.5, 8**0.5])
    >>> f"{same:.4f}, {rigid:.4f}"
    '1.9439, 2.2384'
    """
    kappa = _check_range("stiffness_ratio", stiffness_ratio, 0.0, RIGID * (1 + 1e-12), "from 0 to 2 sqrt(2)")
    return np.asarray(kappa**0.4 * _polynomial(_table("wall"), kappa))


def _log_mass(mass_ratio: npt.ArrayLike) -> FloatArray:
    return np.log(_check_range("mass_ratio", mass_ratio, 1e-300, HEAVIEST, f"above 0, at most {HEAVIEST:g}"))


def striker_waves(mass_ratio: npt.ArrayLike) -> FloatArray:
    """Peak forces of the first six waves of a striker with velocity v, on the last axis.

    They are relative to ``(m^3 k^2 v^6)^(1/5)`` with the mass m and contact stiffness k of the granules.

    ``mass_ratio`` is the mass of the striker over m, up to 1000. Waves below 0.4 % of the leading wave are 0.

    Examples
    --------
    >>> import shockwave as sw
    >>> sw.striker_waves(2.0).round(4).tolist()
    [0.9503, 0.1346, 0.0211, 0.0039, 0.0, 0.0]
    """
    x = _log_mass(mass_ratio)
    later = (np.where(x >= law["edges"][0], _polynomial(law, x), 0.0) for law in _table("later"))
    relative = np.stack([np.ones_like(x), *later], axis=-1)
    leading = impulse_peak(2 * np.exp(x) / MOMENTUM) * np.exp(_polynomial(_table("leading"), x))
    return np.asarray(leading[..., None] * np.where(relative >= THRESHOLD, relative, 0.0))


def striker_velocity(mass_ratio: npt.ArrayLike) -> FloatArray:
    """Velocity of a striker afterwards over that before: negative if it rebounds, about 0 from a mass ratio of 1.79."""
    x = _log_mass(mass_ratio)
    return np.where(x > math.log(HEAVY), 0.0, 1 - 2 / (1 + np.exp(x)) * _polynomial(_table("rebound"), x))


def damped_decay(contacts: npt.ArrayLike, damping_ratio: npt.ArrayLike) -> FloatArray:
    """Peak force of a wave after n contacts with Kuwabara-Kono damping, over its first one; the arrays are broadcast.

    ``damping_ratio``, from 0 to 0.05, is the time A of the model over ``T = m^(1/2) k^(-1/3) F^(-1/6)`` of the first
    force.

    Examples
    --------
    >>> import shockwave as sw
    >>> sw.damped_decay([10, 100], damping_ratio=0.01).round(4).tolist()
    [0.9376, 0.5398]
    """
    n = _check_range("contacts", contacts, 0.0, math.inf, "at least 0")
    ratio = _check_range("damping_ratio", damping_ratio, 0.0, MOST_DAMPING, f"from 0 to {MOST_DAMPING:g}")
    longer = _table("damping")["slope"] * ratio * n
    return np.asarray((1 + longer - _table("damping")["shortfall"] * ratio * np.log1p(longer)) ** -6.0)


def taper_ratio(reduction: npt.ArrayLike) -> FloatArray:
    """(1 - q)^(1/5 + q P(q)), peak force at a contact over that at the previous one far along a geometric taper.

    ``reduction`` is q, from 0 to 0.2: each radius is 1 - q times the one before it. The exponent 1/5 alone is that of a
    wave that keeps its energy; the polynomial P accounts for the energy lost to the granules behind it.
    """
    q = _check_range("reduction", reduction, 0.0, MOST_TAPERED, f"from 0 to {MOST_TAPERED:g}")
    return np.asarray((1 - q) ** (0.2 + q * polyval(q, _table("taper")["coefficients"])))
