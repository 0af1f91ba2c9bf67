"""The solitary wave of a chain of equal spheres: its exact constants, its shape, and its Pade form (4a).

In scaled units (mass, contact stiffness and peak force 1) the overlap r at a contact solves the fixed point
``c^2 r = Tri * r^(3/2)``, with Tri the unit triangle on [-1, 1] over the granule number and * a convolution.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from attrs import asdict, frozen

from shockwave.chain.chain import Chain, Scales

if TYPE_CHECKING:
    import numpy.typing as npt

    from shockwave.quadrature import FloatArray

__all__ = [
    "ENERGY",
    "EXACT_COEFFICIENT",
    "GRANULE_VELOCITY",
    "IMPULSE_LIMIT",
    "MOMENTUM",
    "PAPER_COEFFICIENT",
    "SPEED",
    "WIDTH",
    "SolitaryWave",
    "WaveShape",
    "pade_force",
]

#: Speed in granules per unit of time; scales as F^(1/6).
SPEED = 0.905515776419121
#: Momentum, the integral of the contact force over time; scales as F^(5/6).
MOMENTUM = 1.652066518648
#: Peak velocity of a granule, in force times time over mass; scales as F^(5/6).
GRANULE_VELOCITY = 0.989278419818
#: Energy, kinetic and potential as 5 to 4; scales as F^(5/3).
ENERGY = 1.046516203461019
#: Full width at half maximum of the contact force, in time; scales as F^(-1/6).
WIDTH = 1.559253174056145
#: Leading number of A in eq. (4c), as printed and exactly.
PAPER_COEFFICIENT = 13 / 3
EXACT_COEFFICIENT = 4.344507853978653
#: A shock of vanishing duration and impulse L makes F = IMPULSE_LIMIT F0 S^(6/5), S = L / (A F0^(5/6)), A exact.
IMPULSE_LIMIT = 1.1681817

_PADE = (0.439, 0.0994, 0.0147, 0.0013)


@frozen
class SolitaryWave:
    """One solitary wave, in SI units.

    Attributes
    ----------
    peak_force : float
        Peak contact force [N].
    momentum, energy : float
        What the wave carries [N s], [J].
    speed : float
        Of the wave along the chain [m/s].
    width : float
        Full width at half maximum of the contact force in time [s].
    granule_velocity : float
        Peak velocity of the granules that it passes [m/s].
    """

    peak_force: float
    momentum: float
    energy: float
    speed: float
    width: float
    granule_velocity: float

    @classmethod
    def of(cls, peak_force: float, chain: Chain, coefficient: float = EXACT_COEFFICIENT) -> SolitaryWave:
        """The exact wave of ``peak_force`` [N] in ``chain``; its momentum by A with ``coefficient``, eq. (4b)."""
        scales = Scales.of(chain, peak_force)
        return cls(
            peak_force=peak_force,
            momentum=MOMENTUM * (coefficient / EXACT_COEFFICIENT) * scales.momentum,
            energy=ENERGY * scales.energy,
            speed=SPEED * scales.wave_speed,
            width=WIDTH * scales.time,
            granule_velocity=GRANULE_VELOCITY * scales.velocity,
        )

    def to_dict(self) -> dict[str, float]:
        """SI floats by name."""
        return asdict(self)


@frozen(eq=False)
class WaveShape:
    """The exact shape: contact overlap against distance from the crest, peak 1, solved on a grid.

    ``position`` [granules] and ``overlap`` have shape (points,); ``speed`` is what the fixed point gave.
    """

    position: FloatArray
    overlap: FloatArray
    speed: float

    @classmethod
    def solve(cls, granules: int = 24, points: int = 4096) -> WaveShape:
        """Solve the fixed point spectrally on a periodic domain.

        Parameters
        ----------
        granules : int
            Length of the domain; the tail is doubly exponential, 16 is enough for all digits.
        points : int
            Grid points, a power of two.
        """
        import numpy as np

        position = (np.arange(points) - points // 2) * (granules / points)
        wavenumber = np.fft.rfftfreq(points, granules / points)
        triangle = np.sinc(wavenumber) ** 2
        overlap = np.exp(-(position**2))
        square_of_speed = 1.0
        # The map contracts by about 0.5 a turn once the crest is held at 1; 80 turns reach rounding.
        for _ in range(80):
            overlap = np.fft.irfft(triangle * np.fft.rfft(np.maximum(overlap, 0.0) ** 1.5), points)
            square_of_speed = float(overlap[points // 2])
            overlap = overlap / square_of_speed
        return cls(position.astype(float), overlap, math.sqrt(square_of_speed))

    def force(self, time: npt.ArrayLike) -> FloatArray:
        """Contact force over its peak at ``time`` from the crest, in units of T0 of the wave's own peak force."""
        import numpy as np

        xi = self.speed * np.asarray(time, dtype=float)
        step = self.position[1] - self.position[0]
        spectrum = np.fft.rfft(np.fft.ifftshift(self.overlap))
        wave = 2 * np.pi * np.fft.rfftfreq(len(self.overlap), step)
        # The overlap is band-limited to rounding, so its Fourier series is exact between grid points too.
        weights = np.where(wave == 0, 1.0, 2.0) * spectrum / len(self.overlap)
        overlap = np.real(np.exp(1j * np.multiply.outer(xi, wave)) @ weights)
        overlap = np.where(np.abs(xi) <= -self.position[0], np.maximum(overlap, 0.0), 0.0)
        return np.asarray(overlap * np.sqrt(overlap))


def pade_force(time: npt.ArrayLike) -> FloatArray:
    """The Pade form (4a) of the contact force over its peak, at ``time`` from the crest in units of T0.

    T0 is that of the wave's own peak force: the paper's (B/R)^(1/4) t / beta. Its momentum is 7 % low.
    """
    import numpy as np

    square = np.asarray(time, dtype=float) ** 2
    series = 1 + square * (_PADE[0] + square * (_PADE[1] + square * (_PADE[2] + square * _PADE[3])))
    return np.asarray(series**-3.0)
