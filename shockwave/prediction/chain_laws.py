r"""Universal laws of walls, strikers and damping in chains of equal granules, from fits to simulations.

Each law depends on one dimensionless number:

- a solitary wave that meets a flat wall exerts on it W(kappa) times its peak force, kappa = k_wall/k;
- a striker with the mass ratio mu and the velocity v, whose contact is as stiff as those of the chain, generates waves
  of the peak forces f_j(mu) (m^3 k^2 v^6)^(1/5);
- a wave of peak force F in a chain with Kuwabara-Kono damping decays, because its characteristic time
  T = m^(1/2) k^(-1/3) F^(-1/6) increases by a(A/T) A from one contact to the next, where A is the time of the model.

The first two are piecewise Chebyshev polynomials. ``chain_laws.json`` contains the coefficients,
``docs/fit_chain_laws.py`` computes them, and ``docs/chain-laws.md`` describes their validation.
"""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.errors import InvalidValueError
from shockwave.prediction.short_shock_law import IMPULSE_LIMIT
from shockwave.quadrature import FloatArray

#: Name of the file with the coefficients, beside this one.
RESOURCE = "chain_laws.json"
#: Stiffness ratio of a rigid wall, the largest for Hertz's law.
RIGID = 2 * math.sqrt(2)
#: Mass ratios of the law of strikers.
MASS_RATIOS = (1e-3, 1e3)
#: Mass ratio from which the striker does not rebound.
HEAVY = 1.79
#: Waves of a train whose peak forces are known.
WAVES = 6
#: Least peak force of a wave that counts, relative to the leading wave.
THRESHOLD = 4e-3
#: Greatest ratio A/T of the law of damping.
MOST_DAMPING = 0.05


@frozen(eq=False)
class Pieces:
    """A piecewise Chebyshev polynomial: edges, shape (pieces + 1,), and coefficients, shape (pieces, degree + 1)."""

    edges: FloatArray
    coefficients: FloatArray

    @classmethod
    def of(cls, given: dict[str, Any]) -> Pieces:
        """The pieces from lists of coefficients of any lengths."""
        most = max(map(len, given["coefficients"]))
        rows = [[*row, *[0.0] * (most - len(row))] for row in given["coefficients"]]
        return cls(np.array(given["edges"]), np.array(rows))

    def __call__(self, x: FloatArray) -> FloatArray:
        """Values at ``x``; outside the range, those at its ends."""
        x = np.clip(x, self.edges[0], self.edges[-1])
        piece = np.searchsorted(self.edges[1:-1], x)
        begin, end = self.edges[piece], self.edges[piece + 1]
        u = (2 * x - begin - end) / (end - begin)
        # Clenshaw's recurrence
        last, value = np.zeros_like(u), np.zeros_like(u)
        for column in self.coefficients.T[:0:-1]:
            last, value = value, 2 * u * value - last + column[piece]
        return np.asarray(u * value - last + self.coefficients[piece, 0])


@cache
def _law(name: str) -> Any:
    text = (Path(__file__).parent / RESOURCE).read_text(encoding="utf-8")
    return json.loads(text)[name]


@cache
def _pieces(law: str, name: str) -> Pieces:
    return Pieces.of(_law(law)[name])


def _checked(name: str, values: npt.ArrayLike, low: float, high: float, rule: str) -> FloatArray:
    array = np.asarray(values, dtype=float)
    outside = ~((array >= low) & (array <= high))
    if outside.any():
        raise InvalidValueError.of(name, f"must be {rule} (got {array[outside].flat[0]:g})")
    return array


def wall_factor(stiffness_ratio: npt.ArrayLike) -> FloatArray:
    """Greatest force on a flat wall over the peak force of the solitary wave that meets it.

    Parameters
    ----------
    stiffness_ratio : array_like
        kappa, stiffness of the contact with the wall over that of the contacts of the chain, from 0 to 2 sqrt(2).

    Returns
    -------
    numpy.ndarray
        W, of the same shape; for soft walls it is 1.7569 kappa^(2/5).

    Raises
    ------
    InvalidValueError
        If a ratio is out of range.
    """
    kappa = _checked("stiffness_ratio", stiffness_ratio, 0.0, RIGID * (1 + 1e-12), "from 0 to 2 sqrt(2)")
    return np.asarray(kappa**0.4 * _pieces("wall", "factor")(kappa))


def striker_waves(mass_ratio: npt.ArrayLike) -> FloatArray:
    """Peak forces of the first six waves that a striker generates.

    Parameters
    ----------
    mass_ratio : array_like
        mu, mass of the striker over that of a granule, above 0 and up to 1000.

    Returns
    -------
    numpy.ndarray, shape (..., 6)
        Peak forces in units of (m^3 k^2 v^6)^(1/5), leading wave first; 0 for waves that are weaker than 0.4 % of the
        leading wave.

    Raises
    ------
    InvalidValueError
        If a ratio is out of range.
    """
    mu = _checked_mass(mass_ratio)
    x, found = np.log(mu), np.zeros((*mu.shape, WAVES))
    found[..., 0] = 1.0
    for index, given in enumerate(_law("striker")["later"], start=1):
        ratio = _later(index)(x)
        found[..., index] = np.where((x >= given["edges"][0]) & (ratio >= THRESHOLD), ratio, 0.0)
    leading = IMPULSE_LIMIT * (2 * mu / MOMENTUM) ** 1.2 * np.exp(_pieces("striker", "leading")(x))
    return np.asarray(leading[..., None] * found)


@cache
def _later(index: int) -> Pieces:
    return Pieces.of(_law("striker")["later"][index - 1])


def striker_velocity(mass_ratio: npt.ArrayLike) -> FloatArray:
    """Velocity of a striker afterwards over that before, for a mass ratio above 0 and up to 1000.

    It is negative for a striker that rebounds. A striker of more than 1.79 times the mass of a granule pushes the chain
    until its velocity is about 0, which is the result.

    Raises
    ------
    InvalidValueError
        If a ratio is out of range.
    """
    mu = _checked_mass(mass_ratio)
    return np.where(mu > HEAVY, 0.0, 1 - 2 / (1 + mu) * _pieces("striker", "rebound")(np.log(mu)))


def striker_count(mass_ratio: npt.ArrayLike) -> npt.NDArray[np.intp]:
    """Number of waves of at least 0.4 % of the leading wave; beyond the sixth a rough estimate.

    Raises
    ------
    InvalidValueError
        If a ratio is out of range.
    """
    mu, waves = np.asarray(mass_ratio, dtype=float), striker_waves(mass_ratio)
    known = (waves > 0).sum(axis=-1)
    momenta = MOMENTUM * waves ** (5 / 6)
    # Each further wave takes the same fraction of the remaining momentum.
    fraction = momenta[..., -1] / np.maximum(mu - momenta.sum(axis=-1), 1e-3 * mu)
    with np.errstate(divide="ignore", invalid="ignore"):
        more = np.log(waves[..., -1] / (THRESHOLD * waves[..., 0])) / (1.2 * np.log1p(fraction))
    return np.asarray(np.where(known < WAVES, known, WAVES + np.nan_to_num(more)), dtype=np.intp)


def _checked_mass(mass_ratio: npt.ArrayLike) -> FloatArray:
    return _checked("mass_ratio", mass_ratio, 1e-300, MASS_RATIOS[1], f"above 0, at most {MASS_RATIOS[1]:g}")


def damped_decay(contacts: npt.ArrayLike, damping_ratio: npt.ArrayLike) -> FloatArray:
    """Peak force of a wave after a number of contacts in a chain with Kuwabara-Kono damping, over that before.

    Parameters
    ----------
    contacts : array_like
        Number of contacts n that the wave passes, at least 0.
    damping_ratio : array_like
        A/T of the wave at the first of them, from 0 to 0.05: the time A of the model over the characteristic time
        T = m^(1/2) k^(-1/3) F^(-1/6) of its peak force F. Both arrays are broadcast.

    Returns
    -------
    numpy.ndarray
        (T/T_n)^6 with T_n = T + b A n - c A ln(1 + b n A/T), see ``docs/chain-laws.md`` for its validity.

    Raises
    ------
    InvalidValueError
        If a value is out of range.
    """
    n = _checked("contacts", contacts, 0.0, math.inf, "at least 0")
    ratio = _checked("damping_ratio", damping_ratio, 0.0, MOST_DAMPING, f"from 0 to {MOST_DAMPING:g}")
    slope, shortfall = (_law("damping")[name] for name in ("slope", "shortfall"))
    longer = slope * ratio * n
    return np.asarray((1 + longer - shortfall * ratio * np.log1p(longer)) ** -6.0)
