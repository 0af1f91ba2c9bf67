"""Damping at contacts: a force proportional to the closing velocity."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import numpy as np
from attrs import frozen

from shockwave.base.numerics import FloatArray, bracketed_root
from shockwave.base.quantity_fields import SI, Value, quantity
from shockwave.scene.contact_law import Pairs

#: Exponent of Hertz's law.
HERTZ = 1.5
# Loss -ln e that is a rounding error of e.
_ROUNDING = 1e-15


class Damping(ABC):
    """A force ``c d^q d'`` at each contact, added to the elastic force; their sum is cut off at zero."""

    @abstractmethod
    def powers(self, pairs: Pairs) -> FloatArray:
        """Exponents q, of shape (contacts,)."""

    @abstractmethod
    def coefficients(self, pairs: Pairs) -> FloatArray:
        """Coefficients c [N s/m^(q + 1)], of shape (contacts,)."""


@frozen(kw_only=True)
class KuwabaraKono(Damping, Value):
    """Viscoelastic contact of Kuwabara and Kono (1987).

    The force is ``p k A d^(p-1) d'`` with the exponent p of the contact law, for Hertz's ``(3/2) k A d^(1/2) d'``.

    Parameters
    ----------
    time : float
        A [s], a property of the materials, at least 0.

    Examples
    --------
    >>> import shockwave as sw
    >>> damping = sw.KuwabaraKono(time="1 us")
    >>> row = sw.Chain(material="delrin", radius="5 mm", granules=20, damping=damping)
    >>> result = sw.simulate(sw.Impact(velocity="0.1 m/s"), row, contacts=[0, 10])
    >>> [f"{contact.peak_force:.3f} N" for contact in result.contacts]
    ['1.031 N', '0.761 N']
    """

    time: SI[float] = quantity("s", "viscous time A of Kuwabara and Kono", at_least=0, at_most=1e30)

    def powers(self, pairs: Pairs) -> FloatArray:
        """q = p - 1."""
        return pairs.exponents - 1

    def coefficients(self, pairs: Pairs) -> FloatArray:
        """c = p k A."""
        return pairs.exponents * self.time * pairs.stiffnesses


@frozen(kw_only=True)
class Dashpot(Damping, Value):
    """A linear dashpot, with the force ``c d'``.

    Parameters
    ----------
    coefficient : float
        c [N s/m], at least 0.

    Examples
    --------
    >>> import shockwave as sw
    >>> damping = sw.Dashpot(coefficient="0.1 N*s/m")
    >>> row = sw.Chain(material="delrin", radius="5 mm", granules=20, damping=damping)
    >>> result = sw.simulate(sw.Impact(velocity="0.1 m/s"), row, contacts=[0, 10])
    >>> [f"{contact.peak_force:.3f} N" for contact in result.contacts]
    ['1.044 N', '0.831 N']
    """

    coefficient: SI[float] = quantity("N*s/m", "coefficient c of the dashpot", at_least=0, at_most=1e30)

    def powers(self, pairs: Pairs) -> FloatArray:
        """q = 0."""
        return np.zeros(pairs.exponents.shape)

    def coefficients(self, pairs: Pairs) -> FloatArray:
        """c, the same at all contacts."""
        return np.full(pairs.stiffnesses.shape, self.coefficient)


@frozen(kw_only=True)
class Tsuji(Damping, Value):
    """Damping of Tsuji, Tanaka and Ishida (1992), with a restitution independent of the velocity.

    The force is ``c d^(1/4) d'``.

    Parameters
    ----------
    restitution : float
        Coefficient of restitution of a collision of the two granules of a contact, above 0 and at most 1. A collision
        ends when the total force vanishes.

    Examples
    --------
    >>> import shockwave as sw
    >>> damping = sw.Tsuji(restitution=0.8)
    >>> bead = sw.Chain(material="delrin", radius="5 mm", granules=1, damping=damping)
    >>> result = sw.simulate(sw.Impact(velocity="0.1 m/s"), bead)
    >>> f"{result.restitution:.3f}"
    '0.800'
    """

    restitution: SI[float] = quantity("", "coefficient of restitution", above=0, at_most=1)

    def powers(self, pairs: Pairs) -> FloatArray:
        """q = 1/4; `Chain` refuses elastic forces other than Hertz's."""
        return np.full(pairs.exponents.shape, 0.25)

    def coefficients(self, pairs: Pairs) -> FloatArray:
        """``c = sqrt(5) z sqrt(m* k)``, with the damping ratio z of `tsuji_ratio`."""
        return math.sqrt(5) * tsuji_ratio(self.restitution) * np.sqrt(pairs.masses * pairs.stiffnesses)


def tsuji_ratio(restitution: float) -> float:
    """Damping ratio z of Tsuji's force for a coefficient of restitution e.

    With w = d^(5/4), m d'' = -k d^(3/2) - c d^(1/4) d' becomes the equation of a linear oscillator with the damping
    ratio z = c/sqrt(5 m k). The collision ends when the total force, and hence the acceleration, vanishes (Schwager and
    Poeschel 2007, for the linear dashpot). With z = cos(x), ln e = -2 x cot(x); above z = 1, at e < exp(-2),
    z = cosh(x) and ln e = -2 x coth(x).
    """
    loss = -math.log(restitution)
    if loss < _ROUNDING:
        return 0.0
    tangent, cosine, upper = (math.tan, math.cos, math.pi / 2) if loss < 2 else (math.tanh, math.cosh, loss / 2)
    return cosine(bracketed_root(lambda x: (2 * x / tangent(x) if x else 2.0) - loss, 0.0, upper, "damping ratio"))
