"""The chain of spheres, and the scales of the dimensionless equations of motion of equal spheres, eq. (1)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from attrs import field, frozen
from attrs.validators import optional

from shockwave.base.errors import InvalidValueError
from shockwave.base.quantity_fields import SI, Converted, Declaration, Number, Value, one_of, quantity, tuple_repr
from shockwave.scene.material import Diameter, MaterialField, check_material, halve, material_of, set_radius

if TYPE_CHECKING:  # a chain of equal spheres does not need them
    from shockwave.scene.chain_end import Bar, Wall
    from shockwave.scene.contact_law import AnyContact, PowerContact
    from shockwave.scene.damping import Damping
    from shockwave.scene.segments import Cell, Segment

# Range of the energy scale [J] for which the energies of the weakest and the strongest wave are floats.
_ENERGIES = (1e-200, 1e250)
#: Exponent p of Hertz's contact force F = k d^p.
HERTZ = 1.5
# Range of t0/T0 for which the double integrals of the shock and powers of it are floats.
_RATIOS = (1e-30, 1e12)
# Range of peak forces [N] outside which the peak force, not the rise time, is reported; T0 scales as F0^(-1/6).
_FORCES = (1e-30, 1e30)


# Packing -> number of contacts of a bead with the next layer, and cosine of their angle to the direction of travel.
_PACKINGS = {"hexagonal": (2, math.sqrt(3) / 2), "fcc-111": (3, math.sqrt(2 / 3))}
Packing = Literal["hexagonal", "fcc-111"]

GRANULES = Declaration("", "number of granules", at_least=1, at_most=1e9, whole=True, optional=True)


def _granules(value: Any) -> Any:
    if isinstance(value, Sequence) and not isinstance(value, str):
        from shockwave.scene.segments import check_segments  # a chain of equal granules does not need it

        return check_segments(value)
    return GRANULES.check("granules", value)


def _contact(value: Any) -> Any:
    if value is None:
        return None
    from shockwave.scene.contact_law import Hertz  # a chain of equal granules does not need it

    return None if isinstance(value, Hertz) else value


@frozen(kw_only=True, slots=False)
class Chain(Value):
    """A row of elastic spheres; by default they are equal and touch without compression, and both ends are free.

    All features beyond equal spheres need a finite chain, except a precompression and another power of the overlap as
    contact force.

    Parameters
    ----------
    material : Material or str
        Default material of the granules, or its name.
    radius, diameter : float
        Default size of the granules [m], above 0; exactly one of the two must be given.
    granules : int or sequence of Segment and Cell, optional
        Number of equal granules, or the segments of the chain, starting at the struck end. By default the chain is
        endless. A single granule needs a striker or a wall.
    end : Wall or Bar, optional
        Wall or bar behind the last granule. By default the end is free.
    precompression : float
        Static force on the first granule and, if the end is free, on the last one [N], default 0. It does not act on a
        striker.
    gravity : float
        Acceleration of gravity along the chain, towards the wall [m/s^2], default 0. It needs a wall. It acts on a
        striker from the first touch on.
    damping : KuwabaraKono, Dashpot or Tsuji, optional
        Damping at all contacts.
    contact : PowerContact, ElasticPlastic or ContactLaw, optional
        Contact law, by default Hertz's.
    elastic_only : bool
        Whether to refuse results with forces beyond first yield, default False.
    packing : "hexagonal" or "fcc-111", optional
        Regular packing in which a plane wave travels along a close-packed normal, layer by layer. The chain is then a
        line of beads of successive layers; it has no other features. The peak force of a shock is the force on each
        bead of the first layer, and all resulting forces are those of single contacts.

    Raises
    ------
    InvalidValueError
        If a value is out of range, the mass or stiffness of a granule is not representable as a float, or features
        exclude each other; of these all are listed.

    Examples
    --------
    >>> import shockwave as sw
    >>> endless = sw.Chain(material="stainless-steel-302", diameter="9.5 mm")
    >>> f"{1e3 * endless.granule_mass:.3f} g"
    '3.529 g'
    >>> row = sw.Chain(
    ...     material="delrin", radius=5e-3, granules=20, end=sw.Wall(material="rigid")
    ... )
    >>> row.count
    20
    """

    material: MaterialField = field(converter=material_of, validator=check_material)
    radius: Converted[float, Number | None] = quantity("m", "radius R of the granules", above=0, default=None)
    _diameter: Diameter = field(default=None, alias="diameter", converter=halve, eq=False, repr=False)
    granules: Converted[int | tuple[Segment | Cell, ...] | None, int | str | Sequence[Segment | Cell] | None] = field(
        default=None, converter=_granules, repr=tuple_repr, metadata=GRANULES.metadata
    )
    end: Wall | Bar | None = None
    precompression: SI[float] = quantity("N", "static contact force", at_least=0, default=0.0)
    gravity: SI[float] = quantity("m/s**2", "acceleration of gravity towards the wall", at_least=0, default=0.0)
    damping: Damping | None = None
    contact: AnyContact | None = field(default=None, converter=_contact)
    elastic_only: bool = field(default=False, validator=one_of(False, True))
    packing: Packing | None = field(default=None, validator=optional(one_of(*_PACKINGS)))

    def __attrs_post_init__(self) -> None:
        set_radius(self)
        if self.radius is None:
            raise InvalidValueError.of("radius", "must be given (got nothing; or give diameter)")
        for name, value in (("mass", self.granule_mass), ("stiffness", self.contact_stiffness)):
            if not (math.isfinite(value) and value > 0):
                problem = f"must give granules a {name} that a floating-point number can hold (got {value:g})"
                raise InvalidValueError.of("radius", problem)
        if self.is_uniform:
            return
        features = {name: getattr(self, name) for name in ("end", "precompression", "gravity", "damping", "contact")}
        if self.packing is None:
            from shockwave.scene.feature_rules import check_features  # needed only here

            check_features(self.granules, self.elastic_only, **features)
        elif any(features.values()) or isinstance(self.granules, tuple):
            problem = f"must be left out for a chain with further features (got {self.packing!r})"
            raise InvalidValueError.of("packing", problem)

    @cached_property
    def is_uniform(self) -> bool:
        """Whether the chain is described by material, radius and number of granules, at least 2, alone."""
        parts = (self.end, self.damping, self.contact, self.packing)
        plain = parts == (None, None, None, None) and not (self.precompression or self.gravity)
        return plain and not isinstance(self.granules, tuple) and self.granules != 1

    @cached_property
    def count(self) -> int | None:
        """Number of granules; None for an endless chain."""
        if isinstance(self.granules, tuple):
            return sum(part.granules for part in self.granules)
        return self.granules

    @property
    def end_word(self) -> str:
        """What is at the end in texts, ``wall`` or ``bar``; empty for a free end."""
        return "" if self.end is None else self.end.word

    @cached_property
    def granule_mass(self) -> float:
        """Mass of one granule, m = 4/3 pi R^3 rho [kg]."""
        # An overflowing product is infinite, which is reported above; a power would raise.
        return 4 / 3 * math.pi * self.material.density * self.radius * self.radius * self.radius

    @property
    def plane_strain_modulus(self) -> float:
        """Plane-strain modulus ``E/(1 - nu^2)`` [Pa], which determines the contact stiffness."""
        return self.material.youngs_modulus / (1 - self.material.poisson_ratio**2)

    @cached_property
    def exponent(self) -> float:
        """Exponent p of the contact force ``F = k d^p``."""
        power = self._power_contact
        return HERTZ if power is None else power.exponent

    @property
    def is_damped(self) -> bool:
        """Whether forces may depend on velocities outside plastic flow: by damping, or by the law of a plugin."""
        if self.is_uniform:
            return False
        from shockwave.scene.feature_rules import is_damped  # equal granules do not need it

        return is_damped(self)

    @property
    def is_plastic(self) -> bool:
        """Whether some contacts are elastic-plastic."""
        if self.is_uniform:
            return False
        from shockwave.scene.feature_rules import is_plastic  # equal granules do not need it

        return is_plastic(self.granules, self.contact)

    @cached_property
    def contact_stiffness(self) -> float:
        """Stiffness k of ``F = k d^p`` between equal spheres [N/m^p]; Hertz's is ``sqrt(2 R) E/(3 (1 - nu^2))``.

        In a packing it is that of a bead and the next layer, z cos(theta)^(5/2) times as much.
        """
        if (power := self._power_contact) is not None:
            return power.stiffness
        contacts, cosine = self.next_contacts
        bundle = contacts * cosine * cosine * math.sqrt(cosine)
        return math.sqrt(2 * self.radius) * self.plane_strain_modulus / 3 * bundle

    @cached_property
    def time_at_unit_force(self) -> float:
        """Unit of time of the `Scales` for a force of 1 N, m^(1/2) k^(-1/(2p)) [s]."""
        p, mass = self.exponent, math.sqrt(self.granule_mass)
        if p == HERTZ:
            return mass / math.cbrt(self.contact_stiffness)
        return float(mass * self.contact_stiffness ** (-0.5 / p))

    @property
    def _power_contact(self) -> PowerContact | None:
        if self.contact is None:
            return None
        from shockwave.scene.contact_law import PowerContact  # a chain with Hertz's law does not need it

        return self.contact if isinstance(self.contact, PowerContact) else None

    @property
    def next_contacts(self) -> tuple[int, float]:
        """Contacts z of a granule with the next ones, and cosine of their angle theta to the direction of travel."""
        return (1, 1.0) if self.packing is None else _PACKINGS[self.packing]

    @cached_property
    def contact_share(self) -> float:
        """Force at a contact over that between a granule and the next ones, 1 / (z cos(theta))."""
        contacts, cosine = self.next_contacts
        return 1 / (contacts * cosine)

    @cached_property
    def spacing(self) -> float:
        """Distance of neighbouring granules or layers, 2 R cos(theta) [m]."""
        return 2 * self.radius * self.next_contacts[1]

    def momentum_parameter(self, coefficient: float) -> float:
        """Momentum parameter A of eq. (4c) [N^(1/6) s]: a solitary wave of peak force F has the momentum ``A F^(5/6)``.

        ``coefficient`` is the numerical coefficient of A: 13/3 in the paper, 4.344507853978653 exactly.
        """
        # Multiplied factor by factor so that no intermediate power overflows.
        density, radius = self.material.density, self.radius
        contacts, cosine = self.next_contacts
        modulus = self.plane_strain_modulus * (contacts * cosine * cosine * math.sqrt(cosine))
        per_size = math.cbrt(density / modulus) * math.pow(density, 1 / 6)
        return coefficient * per_size * radius * math.cbrt(radius)


@frozen
class Scales:
    """Units in which granule mass, contact stiffness and a chosen force are 1.

    Eq. (1) is invariant under x -> l x, t -> l^(-1/4) t, F -> l^(3/2) F, so that one scaled problem covers all
    chains. The attributes are the SI values of the scaled units: force [N], time [s], mass [kg] and granule spacing
    [m]; and the force at a contact over that on a granule, which differs from 1 in packings.
    """

    force: float
    time: float
    mass: float
    granule_spacing: float
    contact_share: float = 1.0

    @classmethod
    def of(cls, chain: Chain, force: float) -> Scales:
        """Make the scales of ``chain`` with ``force`` F0 [N] as the unit.

        The unit of time is T0 = m^(1/2) k^(-1/(2p)) F0^(-(p-1)/(2p)), for Hertz's law sqrt(m) k^(-1/3) F0^(-1/6).

        Raises
        ------
        InvalidValueError
            If the energies of waves are not representable as floats.
        """
        p, unit = chain.exponent, chain.time_at_unit_force
        time = unit / force ** (1 / 6) if p == HERTZ else unit * force ** (-0.5 * (p - 1) / p)
        scales = cls(force, time, chain.granule_mass, chain.spacing, chain.contact_share)
        if not _ENERGIES[0] < force * time * force * time / scales.mass < _ENERGIES[1]:
            problem = f"must give waves an energy that a floating-point number can hold (got {force:g} N)"
            raise InvalidValueError.of("peak_force", problem)
        return scales

    def rise_time(self, seconds: float) -> float:
        """Scaled rise time t0/T0 of a rise time [s].

        Raises
        ------
        InvalidValueError
            If t0/T0 is outside 1e-30 to 1e12, where its powers are not representable as floats.
        """
        ratio = seconds / self.time
        least, most = _RATIOS
        if not least <= ratio <= most:
            limits, unit = f"{least:g} to {most:g}", "characteristic times of the chain"
            if not _FORCES[0] <= self.force <= _FORCES[1]:
                problem = f"must give a rise time of {limits} {unit} (got {self.force:g} N, which gives {ratio:.3g})"
                raise InvalidValueError.of("peak_force", problem)
            raise InvalidValueError.of("rise_time", f"must be {limits} {unit}, {self.time:g} s (got {seconds:g} s)")
        return ratio

    @property
    def contact_force(self) -> float:
        """Force at a contact where that on a granule is the unit of force [N]."""
        return self.force * self.contact_share

    @property
    def momentum(self) -> float:
        """Unit of momentum [N s]."""
        return self.force * self.time

    @property
    def velocity(self) -> float:
        """Unit of granule velocity [m/s]."""
        return self.momentum / self.mass

    @property
    def energy(self) -> float:
        """Unit of energy [J]."""
        return self.momentum * self.velocity

    @property
    def wave_speed(self) -> float:
        """SI value of the wave speed of one granule per unit of time [m/s]."""
        return self.granule_spacing / self.time
