"""The solitary wave of a chain of equal spheres: its exact constants and its properties in SI units.

In scaled units (mass, contact stiffness and peak force 1) the overlap r at a contact satisfies the fixed-point equation
``c^2 r = Tri * r^p``, where p is the exponent of the contact force, Tri is the unit triangle on [-1, 1] as a function
of the granule number and * denotes convolution. The constants below follow from its solution for Hertz's p = 3/2.
"""

from __future__ import annotations

import math
from functools import cached_property, lru_cache

from attrs import asdict, frozen

from shockwave.base.errors import InvalidValueError
from shockwave.base.quantity_fields import Declaration, Number
from shockwave.scene.chain import HERTZ, Chain, Scales

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
#: Numerical coefficient of A in eq. (4c), as printed in the paper.
PAPER_COEFFICIENT = 13 / 3
#: Numerical coefficient of A in eq. (4c), exact value.
EXACT_COEFFICIENT = 4.344507853978653
#: Impulse limit: a shock of vanishing duration gives F = IMPULSE_LIMIT F0 S^(6/5), S = impulse / (A F0^(5/6)), A exact.
IMPULSE_LIMIT = 1.1681817
#: Numerical coefficient of A by name.
MOMENTUM_COEFFICIENTS = {"exact": EXACT_COEFFICIENT, "paper": PAPER_COEFFICIENT}
_PEAK_FORCE = Declaration("N", "peak contact force", above=0)
MOMENTUM_COEFFICIENT = Declaration("", "numerical coefficient of A", at_least=0.01, at_most=1000)


def coefficient_of(choice: str | float) -> float:
    """Numerical coefficient of A, eq. (4c), for ``"exact"``, ``"paper"`` or a number between 0.01 and 1000.

    Raises
    ------
    InvalidValueError
        For any other value.
    """
    if isinstance(choice, str) and choice.lower() in MOMENTUM_COEFFICIENTS:
        return MOMENTUM_COEFFICIENTS[choice.lower()]
    if MOMENTUM_COEFFICIENT.problem(choice) is not None:
        rule = f"must be 'exact', 'paper' or a number {MOMENTUM_COEFFICIENT.rule}"
        raise InvalidValueError.of("momentum_coefficient", f"{rule} (got {choice!r})")
    return float(choice)


@frozen(slots=False)
class WaveLaw:
    """The solitary wave of peak force 1 in scaled units, and its scaling with the peak force.

    Attributes
    ----------
    exponent : float
        p of the contact force d^p.
    speed, momentum, granule_velocity, energy, width : float
        As `SPEED`, `MOMENTUM`, `GRANULE_VELOCITY`, `ENERGY` and `WIDTH`, for this exponent.
    """

    exponent: float
    speed: float
    momentum: float
    granule_velocity: float
    energy: float
    width: float

    @cached_property
    def of_speed(self) -> float:
        """Power of the peak force with which the speed scales, and the duration inversely: (p - 1)/(2p)."""
        return (self.exponent - 1) / (2 * self.exponent)

    @property
    def of_momentum(self) -> float:
        """Power of the peak force with which momentum and granule velocities scale: (p + 1)/(2p)."""
        return (self.exponent + 1) / (2 * self.exponent)

    @property
    def of_energy(self) -> float:
        """Power of the peak force with which the energy scales: (p + 1)/p."""
        return (self.exponent + 1) / self.exponent

    @cached_property
    def spread(self) -> float:
        """Length of the wave over that for Hertz's law, at least 1: near p = 1 waves are long."""
        return max(self.width * self.speed / (WIDTH * SPEED), 1.0)

    def time(self, force: float) -> float:
        """Characteristic time of a wave of this peak force, in which it passes ``speed`` contacts."""
        return math.pow(max(force, 1e-30), -self.of_speed)


#: The wave of a chain with Hertz's contact force.
HERTZ_WAVE = WaveLaw(HERTZ, SPEED, MOMENTUM, GRANULE_VELOCITY, ENERGY, WIDTH)


@lru_cache(maxsize=64)
def wave_law(exponent: float) -> WaveLaw:
    """The solitary wave for contact forces d^p with this exponent p > 1."""
    if exponent == HERTZ:
        return HERTZ_WAVE
    from shockwave.scene.power_law_wave import solve_wave  # Hertz's contact force does not need it

    return WaveLaw(exponent, *solve_wave(exponent))


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

    Examples
    --------
    >>> import shockwave as sw
    >>> chain = sw.Chain(material="bearing-steel-52100", diameter="9.5 mm")
    >>> wave = sw.SolitaryWave.of(100.0, chain)
    >>> f"{wave.speed:.1f} m/s, {1e6 * wave.width:.2f} us"
    '605.7 m/s, 22.14 us'
    """

    peak_force: float
    momentum: float
    energy: float
    speed: float
    width: float
    granule_velocity: float

    @classmethod
    def of(cls, peak_force: Number, chain: Chain, coefficient: float = EXACT_COEFFICIENT) -> SolitaryWave:
        """Make the wave of ``peak_force`` [N] in ``chain``; ``coefficient`` of A gives its momentum, eq. (4b)."""
        force: float = _PEAK_FORCE.check("peak_force", peak_force)
        scales, law = Scales.of(chain, force / chain.contact_share), wave_law(chain.exponent)
        return cls(
            peak_force=force,
            momentum=law.momentum * (coefficient / EXACT_COEFFICIENT) * scales.momentum,
            energy=law.energy * scales.energy,
            speed=law.speed * scales.wave_speed,
            width=law.width * scales.time,
            granule_velocity=law.granule_velocity * scales.velocity,
        )

    def stronger(self, ratio: float, exponent: float = HERTZ) -> SolitaryWave:
        """Make the wave of ``ratio`` times the peak force in the same chain."""
        speed = ratio ** ((exponent - 1) / (2 * exponent))
        velocity = ratio / speed
        force, momentum, energy = ratio * self.peak_force, velocity * self.momentum, velocity * velocity * self.energy
        of_granules = velocity * self.granule_velocity
        return SolitaryWave(force, momentum, energy, speed * self.speed, self.width / speed, of_granules)

    def to_dict(self) -> dict[str, float]:
        """Attributes by name, as SI floats."""
        return asdict(self)
