"""The solitary wave of a chain of equal spheres: its exact constants, and its quantities in SI units.

In scaled units (mass, contact stiffness and peak force 1) the overlap r at a contact solves the fixed point
``c^2 r = Tri * r^(3/2)``, with Tri the unit triangle on [-1, 1] over the granule number and * a convolution. The
constants below are those of its solution.
"""

from __future__ import annotations

from attrs import asdict, frozen

from shockwave.chain.chain import Chain, Scales

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


@frozen
class SolitaryWave:
    """One solitary wave, in SI units.

    Attributes
    ----------
    peak_force : float
        Peak contact force [N].
    momentum, energy : float
        Carried by the wave [N s], [J].
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
