"""The Friedlander pulse, the positive phase of a blast wave."""

from __future__ import annotations

import math

import numpy as np
from attrs import frozen

from shockwave.base.numerics import FloatArray, elementwise
from shockwave.base.quantity_fields import SI, Value, quantity
from shockwave.profiles.exponential import phi
from shockwave.profiles.shock_profile import ShockProfile


@frozen(kw_only=True)
class Friedlander(ShockProfile, Value):
    r"""The positive phase of a blast wave after a short linear rise; n = 1/rise_fraction.

    .. math:: F_1 = s, \quad F_2 = (1 - u) e^{-b u}

    with u = (s - 1)/(n - 1). The front of a blast wave rises in nanoseconds, but a shock of eq. (2) has a rise. The
    areas are a1 = 1/2 and a2 = (n - 1) g(b) with

    .. math:: g(b) = (b - 1 + e^{-b})/b^2

    and g(0) = 1/2. Of the conditions (3) the first one can fail, for a long rise with a fast decay: it holds if
    n >= 1 + 1/(2 g(b)).

    Parameters
    ----------
    decay_coefficient : float
        b, 0 to 100. 1 is Friedlander's own waveform, for peaks of about an atmosphere and less; b is greater for higher
        peaks.
    rise_fraction : float
        Rise time over total duration, 1e-6 to 0.5. The default, 1e-3, increases the simulated peak force of the leading
        wave by 0.1 % at b = 1 and 0.8 % at b = 15.

    References
    ----------
    Friedlander, F. G. (1946). The diffraction of sound pulses I. Proc. R. Soc. Lond. A 186, 322-344.

    Examples
    --------
    >>> import shockwave as sw
    >>> profile = sw.Friedlander(rise_fraction=0.01)
    >>> profile.force([0.5, 1.0, 50.0]).round(3).tolist()
    [0.5, 1.0, 0.308]
    """

    decay_coefficient: SI[float] = quantity("", "b, rate of the decay", at_least=0, at_most=100, default=1.0)
    rise_fraction: SI[float] = quantity("", "rise time over total duration", at_least=1e-6, at_most=0.5, default=1e-3)

    @property
    def duration_ratio(self) -> float:
        return 1 / self.rise_fraction

    def rise(self, s: FloatArray) -> FloatArray:
        return np.array(s)

    def decay(self, s: FloatArray) -> FloatArray:
        left = (self.duration_ratio - s) / (self.duration_ratio - 1)
        return left * elementwise(math.exp, self.decay_coefficient * (left - 1))

    def closed_areas(self) -> tuple[float, float]:
        return 0.5, (self.duration_ratio - 1) * phi(self.decay_coefficient, 1)

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        return np.minimum(s, 1.0) ** 2 / 2 + (self.duration_ratio - 1) * elementwise(self._decay_integral, s)

    def _decay_integral(self, s: float) -> float:
        """F2 as a function of u, integrated from 0 to u: a sum of terms that are not negative."""
        u = min(max((s - 1) / (self.duration_ratio - 1), 0.0), 1.0)
        x = self.decay_coefficient * u
        return float(u * ((1 - u) * phi(x, 0) + u * phi(x, 1)))
