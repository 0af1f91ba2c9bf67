"""The layout of a finite chain: its granules and contacts, one by one, as arrays in SI units."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt
from attrs import evolve, frozen

from shockwave.base.errors import InvalidValueError, refuse
from shockwave.base.numerics import FloatArray
from shockwave.scene.chain import Chain
from shockwave.scene.chain_end import Bar, Wall
from shockwave.scene.contact_law import AnyContact, ContactLaw, ElasticPlastic, Hertz, Pairs, PlasticPairs, PowerContact
from shockwave.scene.coverage_rules import scene_faults
from shockwave.scene.damping import HERTZ, Damping
from shockwave.scene.elastic_plastic import RANGE, Loading
from shockwave.scene.impact import Impact
from shockwave.scene.material import Material
from shockwave.scene.motion import Motion
from shockwave.scene.segments import Cell, Segment, Taper
from shockwave.scene.yielding import strength_of

_Law = TypeVar("_Law")

#: Index of the segment of a striker.
STRIKER = -1


@frozen(eq=False)
class Layout:
    """Granules and contacts of a finite chain; a striker is granule 0.

    Contact i lies between granules i and i + 1; the contact with a wall is the last one.

    Attributes
    ----------
    masses, radii : ndarray, shape (n_granules,)
        Masses [kg] and radii [m].
    materials : tuple of Material
        Material of each granule.
    segments : tuple of int
        Index in ``Chain.granules`` of the segment of each granule; -1 for a striker.
    pairs : Pairs
        Properties of the contacts.
    static_forces : ndarray, shape (n_contacts,)
        Contact forces of precompression and gravity [N].
    overlaps : ndarray, shape (n_contacts,)
        Initial overlaps [m]: the static overlap, or minus the gap.
    damping_coefficients : ndarray, shape (n_contacts,)
        c of the damping force c d^q d' [N s/m^(q + 1)], zeros without damping.
    damping_powers : ndarray, shape (n_contacts,)
        q.
    wall : Wall, Bar or None
        The wall, with its material resolved.
    velocity, top_speed, weight : float
        Initial velocity [m/s] of granule 0, if it is a striker or moves as prescribed, its greatest speed [m/s], and
        the weight [N] of a striker.
    law : ContactLaw or None
        Contact law that replaces the power law of ``pairs`` at some contacts.
    law_contacts, hertz_contacts : ndarray of bool, shape (n_contacts,)
        Where it does, and where the law is Hertz's, which may be limited by plastic flow.
    plastic : PlasticPairs or None
        Properties of elastic-plastic contacts; None if there are none.
    """

    masses: FloatArray
    radii: FloatArray
    materials: tuple[Material, ...]
    segments: tuple[int, ...]
    pairs: Pairs
    static_forces: FloatArray
    overlaps: FloatArray
    damping_coefficients: FloatArray
    damping_powers: FloatArray
    wall: Wall | Bar | None
    velocity: float
    top_speed: float
    weight: float
    law: ContactLaw | None
    law_contacts: npt.NDArray[np.bool_]
    hertz_contacts: npt.NDArray[np.bool_]
    plastic: PlasticPairs | None = None

    @classmethod
    def of(cls, chain: Chain, excitation: object) -> Layout:
        """Make the layout of a chain under a shock or an impact.

        Raises
        ------
        InvalidValueError
            If the chain is not finite, has a single granule, or a static overlap is not representable as a float.
        """
        refuse(scene_faults(chain, excitation))
        velocity = excitation.speed(chain.gravity) if isinstance(excitation, Impact) else 0.0
        if isinstance(excitation, Motion):
            velocity = float(excitation.course(0.0, 1))
        rows = [*_striker(chain, excitation), *_granules(chain)]
        segments, materials, radii, gaps, contacts, dampings = zip(*rows, strict=True)
        sizes = np.array(radii)
        masses = 4 / 3 * math.pi * np.array([one.density for one in materials]) * sizes * sizes * sizes
        wall = chain.end
        if wall is not None and wall.material == "same":
            wall = evolve(wall, material=materials[-1])
        pairs = _pairs(chain, materials, sizes, masses, wall)
        laws = _group_laws(contacts[: len(pairs.stiffnesses)])
        for law, at in laws:
            if isinstance(law, PowerContact):
                pairs.stiffnesses[at], pairs.exponents[at] = law.stiffness, law.exponent
        static = _static_forces(chain, masses, isinstance(excitation, Impact), len(pairs.stiffnesses))
        plastic = _plastic(laws, materials, sizes, wall)
        overlaps = _static_overlaps(pairs, static, plastic) - np.array(gaps)[: len(static)]
        if not np.isfinite(overlaps).all():
            problem = f"must give static overlaps that floating-point numbers can hold (got {chain.precompression:g} N)"
            raise InvalidValueError.of("chain.precompression", problem)
        coefficients, powers = np.zeros((2, *static.shape))
        for damping, at in _group_laws(dampings[: len(static)]):
            if damping is not None:
                coefficients[at], powers[at] = damping.coefficients(pairs)[at], damping.powers(pairs)[at]
        return cls(
            masses=masses,
            radii=sizes,
            materials=materials,
            segments=segments,
            pairs=pairs,
            static_forces=static,
            overlaps=overlaps,
            damping_coefficients=coefficients,
            damping_powers=powers,
            wall=wall,
            velocity=velocity,
            top_speed=excitation.top_speed if isinstance(excitation, Motion) else velocity,
            weight=chain.gravity * float(masses[0]) if isinstance(excitation, Impact) else 0.0,
            law=next((law for law, _ in laws if isinstance(law, ContactLaw)), None),
            law_contacts=_contacts_with(laws, ContactLaw),
            hertz_contacts=~_contacts_with(laws, ContactLaw, PowerContact),
            plastic=plastic,
        )

    @property
    def bodies(self) -> list[Material | str]:
        """Materials of the granules and of the wall."""
        return [*self.materials, *([] if self.wall is None else [self.wall.material])]

    @property
    def strengths(self) -> FloatArray:
        """Smaller yield strength at each contact [Pa], shape (n_contacts,); NaN where one is not known."""
        strengths = np.array([strength_of(each) for each in self.bodies])
        return np.asarray(np.minimum(strengths[:-1], strengths[1:]))

    def describe_contact(self, contact: int) -> str:
        """Number and bodies of a contact."""
        pair = enumerate(self.segments[contact : contact + 2], contact)
        labels = ["the striker" if each == STRIKER else f"granule {index}" for index, each in pair]
        end = f"the {self.wall.word}" if self.wall else ""
        bodies = zip([*labels, end], self.bodies[contact : contact + 2], strict=False)
        names = [f"{label} ({material_name(body)})" for label, body in bodies]
        return f"at contact {contact}, between {' and '.join(names)}"


# Index of the segment, material, radius [m], gap behind it [m]; law and damping of the contact behind it.
_Row = tuple[int, Material, float, float, AnyContact | None, Damping | None]


def _striker(chain: Chain, excitation: object) -> Iterator[_Row]:
    if isinstance(excitation, Impact):
        material, radius = excitation.material or chain.material, excitation.radius or chain.radius
        yield STRIKER, material, radius, 0.0, chain.contact, chain.damping


def _granules(chain: Chain) -> Iterator[_Row]:
    if isinstance(chain.granules, int):
        yield from [(0, chain.material, chain.radius, 0.0, chain.contact, chain.damping)] * chain.granules
    for index, part in enumerate(chain.granules if isinstance(chain.granules, tuple) else ()):
        for segment in part.cell * part.repeat if isinstance(part, Cell) else (part,):
            yield from _segment_rows(chain, index, segment)


def _segment_rows(chain: Chain, index: int, segment: Segment) -> Iterator[_Row]:
    material, radius = segment.material or chain.material, segment.radius or chain.radius
    laws = segment.contact or chain.contact, segment.damping or chain.damping
    for size in radius.sizes(segment.count) if isinstance(radius, Taper) else [radius] * segment.count:
        yield index, material, size, segment.gap, *laws


def _group_laws(laws: Sequence[_Law]) -> list[tuple[_Law, npt.NDArray[np.bool_]]]:
    """Each of the laws of the contacts, and where it holds."""
    numbers = np.array([id(law) for law in laws])
    return [(law, numbers == number) for number, law in {id(law): law for law in laws}.items()]


def _contacts_with(laws: Sequence[tuple[object, npt.NDArray[np.bool_]]], *kinds: type) -> npt.NDArray[np.bool_]:
    """Where one of the grouped laws is of these kinds."""
    return np.asarray(np.logical_or.reduce([at & isinstance(law, kinds) for law, at in laws]))


def _pairs(
    chain: Chain, materials: tuple[Material, ...], radii: FloatArray, masses: FloatArray, wall: Wall | Bar | None
) -> Pairs:
    """Properties of all contacts, by Hertz's law: E* and R* of two bodies, k = 4/3 E* sqrt(R*), and reduced masses."""
    inverse = np.zeros((3, len(radii) + (wall is not None)))  # compliances, curvatures, inverse masses
    inverse[:, : len(radii)] = [material.compliance for material in materials], 1 / radii, 1 / masses
    if wall is not None:
        inverse[0, -1] = wall.material.compliance if isinstance(wall.material, Material) else 0.0
        inverse[2, -1] = 0.0 if wall.mass is None else 1 / wall.mass
    moduli, reduced, shared = 1 / (inverse[:, :-1] + inverse[:, 1:])
    contacts, cosine = chain.next_contacts
    stiffnesses = 4 / 3 * moduli * np.sqrt(reduced) * (contacts * math.pow(cosine, 2.5))
    return Pairs(moduli, reduced, shared, stiffnesses, np.full(reduced.shape, HERTZ))


def _plastic(
    laws: Sequence[tuple[object, npt.NDArray[np.bool_]]],
    materials: tuple[Material, ...],
    radii: FloatArray,
    wall: Wall | Bar | None,
) -> PlasticPairs | None:
    """Properties of elastic-plastic contacts, from the softer body; None if no contact has this law."""
    contacts = _contacts_with(laws, ElasticPlastic)
    if not contacts.any():
        return None
    bodies = [*materials, *([] if wall is None else [wall.material])]
    reach = np.append(radii, [0.0] * (wall is not None))
    strengths = np.array([getattr(body, "yield_strength", None) or math.inf for body in bodies])
    constants = np.array([getattr(body, "rate_constant", 0.0) for body in bodies])
    softer = np.minimum(strengths[:-1], strengths[1:])
    behind = (strengths[1:] < strengths[:-1]) | ((strengths[1:] == softer) & (constants[1:] < constants[:-1]))
    return PlasticPairs(
        contacts=contacts,
        strengths=np.where(contacts, softer, math.inf),
        rate_constants=np.where(behind, constants[1:], constants[:-1]),
        lengths=reach[:-1] + reach[1:],
    )


def _static_forces(chain: Chain, masses: FloatArray, striker: bool, contacts: int) -> FloatArray:
    """Precompression, and the weight of the granules above without a striker, at each contact [N]."""
    own = masses[1:] if striker else masses
    forces = chain.precompression + chain.gravity * np.add.accumulate(own)
    return np.append([0.0] * striker, forces)[:contacts]


def _static_overlaps(pairs: Pairs, static: FloatArray, plastic: PlasticPairs | None) -> FloatArray:
    """Overlaps that the static forces reach by slow loading [m]."""
    with np.errstate(over="ignore"):
        overlaps: FloatArray = (static / pairs.stiffnesses) ** (1 / pairs.exponents)
    if plastic is None or not static.any():
        return overlaps
    ratios = plastic.strengths / pairs.moduli
    limited = np.isfinite(ratios)  # elsewhere no strength limits the law of the contact
    loading = Loading(pairs.stiffnesses, pairs.radii, np.where(limited, np.clip(ratios, *RANGE), math.inf))
    return np.where(limited, loading.overlap(static), overlaps)


def mass_and_length(chain: Chain, hint: str = "") -> tuple[float, float]:
    """Mass [kg] and length [m] of the granules of a finite chain, with the gaps, without a striker.

    ``hint`` is added to the error for an endless chain.

    Raises
    ------
    InvalidValueError
        If the chain is not finite.
    """
    if chain.count is None:
        raise InvalidValueError.of("chain.granules", f"must be given for its mass and length (got nothing{hint})")
    rows = [*_granules(chain)]
    mass = 4 / 3 * math.pi * math.fsum(material.density * radius**3 for _, material, radius, *_ in rows)
    return mass, math.fsum(2 * radius + gap for _, _, radius, gap, *_ in rows)


def change_laws(chain: Chain, change: Callable[[Any], AnyContact | None]) -> Chain:
    """The chain with other contact laws: ``change`` returns that of the chain, or of a segment."""

    def change_part(part: Any) -> Any:
        if isinstance(part, Cell):
            return evolve(part, cell=[*map(change_part, part.cell)])
        return evolve(part, contact=change(part))

    granules = [*map(change_part, chain.granules)] if isinstance(chain.granules, tuple) else chain.granules
    return evolve(chain, granules=granules, contact=change(chain))


def elastic_chain(chain: Chain) -> Chain:
    """The chain with Hertz's law at its elastic-plastic contacts."""
    return change_laws(chain, lambda part: Hertz() if isinstance(part.contact, ElasticPlastic) else part.contact)


def plastic_chain(chain: Chain) -> Chain:
    """The chain with elastic-plastic contacts in place of those with Hertz's law and without damping."""

    def change(part: Any) -> AnyContact | None:
        law = part.contact or chain.contact or Hertz()
        return ElasticPlastic() if isinstance(law, Hertz) and not part.damping else law

    return change_laws(chain, change)


def material_name(body: Material | str) -> str:
    """Name of a material; without one, its modulus."""
    return body if isinstance(body, str) else body.name or f"E {body.youngs_modulus / 1e9:g} GPa"
