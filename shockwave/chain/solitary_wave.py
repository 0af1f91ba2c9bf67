"""The solitary wave of a chain of equal spheres: its exact constants and its properties in SI units.

In scaled units (mass, contact stiffness and peak force 1) the overlap r at a contact satisfies the fixed-point equation
``c^2 r = Tri * r^(3/2)``, where Tri is the unit triangle on [-1, 1] as a function of the granule number and * denotes
convolution. The constants below follow from its solution.
"""

from __future__ import annotations

from attrs import asdict, frozen

from shockwave.chain.chain import Chain, Scales

#: Speed in granules per unit of time; it scales as F^(1/6).
SPEED = 0.905515776419121
#: Momentum, the integral of the contact force over time; it scales as F^(5/6).
MOMENTUM = 1.652066518648
#: Peak velocity of a granule, in units of force times time over mass; it scales as F^(5/6).
GRANULE_VELOCITY = 0.989278419818
#: Energy, kinetic and potential in the ratio 5 to 4; it scales as F^(5/3).
ENERGY = 1.046516203461019
#: Full width at half maximum of the contact force in time; it scales as F^(-1/6).
WIDTH = 1.559253174056145
#: Leading number of A in eq. (4c), as printed in the paper.
PAPER_COEFFICIENT = 13 / 3
#: Leading number of A in eq. (4c), exact value.
EXACT_COEFFICIENT = 4.344507853978653
#: Impulse limit: a shock of vanishing duration gives F = IMPULSE_LIMIT F0 S^(6/5), S = impulse / (A F0^(5/6)), A exact.
IMPULSE_LIMIT = 1.1681817


@frozen
class SolitaryWave:
    """A solitary wave in SI units.

    Attributes
    ----------
    peak_force : float
        Peak contact force [N].
    momentum, energy : float
        Momentum [N s] and energy [J] of the wave.
    speed : float
        Speed of the wave along the chain [m/s].
    width : float
        Full width at half maximum of the contact force in time [s].
    granule_velocity : float
        Peak velocity of the granules [m/s].
    """

    peak_force: float
    momentum: float
    energy: float
    speed: float
    width: float
    granule_velocity: float

    @classmethod
    def of(cls, peak_force: float, chain: Chain, coefficient: float = EXACT_COEFFICIENT) -> SolitaryWave:
        """Make the wave of ``peak_force`` [N] in ``chain``; ``coefficient`` of A gives its momentum, eq. (4b)."""
        scales = Scales.of(chain, peak_force / chain.contact_share)
        return cls(
            peak_force=peak_force,
            momentum=MOMENTUM * (coefficient / EXACT_COEFFICIENT) * scales.momentum,
            energy=ENERGY * scales.energy,
            speed=SPEED * scales.wave_speed,
            width=WIDTH * scales.time,
            granule_velocity=GRANULE_VELOCITY * scales.velocity,
        )

    def stronger(self, ratio: float) -> SolitaryWave:
        """Make the wave of ``ratio`` times the peak force in the same chain."""
        speed = ratio ** (1 / 6)
        velocity = ratio / speed
        force, momentum, energy = ratio * self.peak_force, velocity * self.momentum, velocity * velocity * self.energy
        of_granules = velocity * self.granule_velocity
        return SolitaryWave(force, momentum, energy, speed * self.speed, self.width / speed, of_granules)

    def to_dict(self) -> dict[str, float]:
        """Attributes by name, as SI floats."""
        return asdict(self)
