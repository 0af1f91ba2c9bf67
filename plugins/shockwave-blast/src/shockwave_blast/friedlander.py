"""The Friedlander pulse of an explosion, by its decay coefficient."""

from __future__ import annotations

import attrs
from attrs import frozen
from shockwave import quantity

from shockwave_blast.waveform import BlastWaveform

__all__ = ["Friedlander"]


@frozen(kw_only=True)
class Friedlander(BlastWaveform):
    """p = p0 (1 - t/td) exp(-b t/td), the positive phase of a blast, behind a short straight rise.

    With s = t/t0 and n = 1/rise_fraction: F1 = s, F2 = (1 - u) exp(-b u), u = (s - 1)/(n - 1). The shape has
    a fixed duration ratio, so give the whole ``duration`` of a shock, which includes the rise.

    Parameters
    ----------
    decay_coefficient : float
        b, 0 to 100; 0 is a straight decay. The default, 1, is Friedlander's own waveform, which fits peaks of
        about an atmosphere and less; for higher peaks b is greater, up to 17 in the curves of Kingery and
        Bulmash.
    rise_fraction : float
        Rise time over total duration, 1e-6 to 0.5. The front of a blast wave rises within nanoseconds, but
        eq. (2) requires a rise. The default, 1e-3, increases the peak force of the leading wave in a
        simulation by 0.1 % at b = 1, 0.2 % at b = 3 and 0.8 % at b = 15; the increase is proportional to the
        fraction.

    Notes
    -----
    The areas are a1 = 1/2 and a2 = (n - 1) g(b), with g(b) = (b - 1 + exp(-b))/b^2, 1/2 at b = 0 and about
    (b - 1)/b^2 for large b. The second and third of the conditions (3) hold for every b:

    ===============  =====================================================
    condition        margin
    ===============  =====================================================
    a2 >= a1         (n - 1) g(b) - 1/2: holds for n >= 1 + 1/(2 g(b))
    a1 >= 1/2        0: holds, with equality
    a2 <= (n-1)/2    (n - 1) (1/2 - g(b)): holds, with equality at b = 0
    ===============  =====================================================

    The first one fails for a long rise with a fast decay: it holds from n = 2 at b = 0, 2.36 at b = 1, 4.13
    at b = 5 and 51.5 at b = 100 upwards; with the default rise it holds for every b, with a margin of at
    least 9.39.

    References
    ----------
    Friedlander, F. G. (1946). The diffraction of sound pulses I. Proc. R. Soc. Lond. A 186, 322-344.

    Dewey, J. M. (2018). The Friedlander equations. In Blast Effects, 37-55. Springer.
    """

    decay_coefficient: float = quantity("", "b of exp(-b t/td)", default=1.0, at_least=0, at_most=100)
    rise_fraction: float = quantity(
        "", "rise time over total duration", default=1e-3, at_least=1e-6, at_most=0.5
    )
    duration_ratio: float = attrs.field(init=False)

    def __attrs_post_init__(self) -> None:
        object.__setattr__(self, "duration_ratio", 1 / self.rise_fraction)
