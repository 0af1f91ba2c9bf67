"""Contacts with histories, and chains, for the tests of contact laws."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from shockwave.base.numerics import FloatArray
from shockwave.profiles.triangular import Triangular
from shockwave.scene.chain import Chain
from shockwave.scene.chain_end import Wall
from shockwave.scene.contact_law import AnyContact, BoundLaw, ContactLaw, Hertz, Pairs, PowerContact
from shockwave.scene.impact import Impact
from shockwave.scene.layout import Layout
from shockwave.scene.scene import Excitation
from shockwave.scene.segments import Segment
from shockwave.scene.shock import Shock
from shockwave.testing.known_motions import mixed_shares

# Overlaps, over `hertz_overlap`, and closing velocities, over the greatest one, of a collision that is interrupted and
# of a stronger one; after each of them the contacts have another history.
_PATH = ((0.3, 0.8), (0.6, 0.0), (0.2, -0.5), (-0.1, -0.3), (0.9, 0.2))
# Duration of a collision by Hertz's law, over the ratio of its overlap and velocity.
_DURATION = 2.94
# Rise time and peak force of the shock, over the duration and the greatest force of a collision.
_RISE = 0.3
_FORCE = 1.5
# Largest gap, over the overlap of a collision.
_GAP = 0.2
#: Chains that are simulated: granules, end and excitation. In one of them only some contacts have the law.
SCENES = (
    *("1-free-striker", "1-fixed-striker", "1-fixed-shock", "2-movable-striker", "2-fixed-shock", "5-fixed-striker"),
    *("5-movable-shock", "5-partly-striker", "40-free-striker", "40-fixed-shock"),
)


def hertz_overlap(masses: Any, stiffnesses: Any, velocity: float) -> Any:
    """Greatest overlap in a collision by Hertz's law [m], from reduced masses and stiffnesses."""
    return (1.25 * masses * velocity**2 / stiffnesses) ** 0.4


def scene_of(chain: Chain, law: ContactLaw, top: float, name: str) -> tuple[Excitation, Chain, float]:
    """Excitation and chain of one of the `SCENES`, and the duration of a collision by Hertz's law [s]."""
    granules, end, excitation = name.split("-")
    overlap = hertz_overlap(chain.granule_mass / 2, chain.contact_stiffness, top)
    duration = _DURATION * overlap / top
    rows = [
        Segment(
            radius=(0.7 + 0.6 * share) * chain.radius,
            material=attrs.evolve(chain.material, density=(0.6 + share) * chain.material.density),
            gap=_GAP * share * overlap,
        )
        for share in mixed_shares(int(granules)).tolist()
    ]
    if end == "partly":
        other = PowerContact(exponent=2, stiffness=chain.contact_stiffness / overlap**0.5)
        laws: list[AnyContact] = [Hertz(), law, law, other, Hertz()]
        rows = [attrs.evolve(row, contact=part) for row, part in zip(rows, laws, strict=True)]
    mass = 2 * chain.granule_mass
    movable = Wall(mass=mass, stiffness=mass / duration**2, damping=0.1 * mass / duration)
    ends = {"free": None, "movable": movable}
    chain = attrs.evolve(chain, granules=rows, end=ends.get(end, Wall()), contact=None if end == "partly" else law)
    if excitation == "striker":
        return Impact(velocity=top), chain, duration
    force = _FORCE * attrs.evolve(chain, granules=None, end=None, contact=None).contact_stiffness * overlap**1.5
    return Shock(profile=Triangular(duration_ratio=2), peak_force=force, rise_time=_RISE * duration), chain, duration


@attrs.frozen(eq=False)
class Sample:
    """A contact law at many contacts, with their overlaps [m], closing velocities [m/s] and states."""

    law: ContactLaw
    overlap: FloatArray
    velocity: FloatArray
    state: FloatArray
    pairs: Pairs

    @classmethod
    def of(
        cls, chain: Chain, top: float, overlaps: Any, velocities: Any, path: Sequence[tuple[float, float]] = _PATH
    ) -> Sample:
        """All combinations of the contacts of a chain with histories, and with overlaps and velocities as fractions.

        The histories are that of no contact, and those after each part of ``path``.
        """
        layout = Layout.of(chain, Impact(velocity=top))
        assert layout.law is not None
        pairs = layout.pairs
        reach = hertz_overlap(pairs.masses, pairs.stiffnesses, top)
        few = cls(layout.law, reach, reach, np.zeros((layout.law.states, len(reach))), pairs)
        states = [few.state]
        for overlap, velocity in path:
            few = attrs.evolve(few, overlap=overlap * reach, velocity=np.full(reach.shape, velocity * top))
            few = attrs.evolve(few, state=few.updates())
            states.append(few.state)
        sizes = len(states), len(overlaps), len(velocities), len(reach)
        history, row, column, pair = (index.ravel() for index in np.indices(sizes))
        overlap, velocity = np.asarray(overlaps)[row] * reach[pair], np.asarray(velocities)[column] * top
        return cls(layout.law, overlap, velocity, np.array(states)[history, :, pair].T.copy(), _at(pairs, pair))

    @property
    def arguments(self) -> tuple[FloatArray, FloatArray, FloatArray, Pairs]:
        """Arguments of the methods of the law."""
        return self.overlap, self.velocity, self.state, self.pairs

    def forces(self, more: float | FloatArray = 0.0, faster: float | FloatArray = 0.0) -> FloatArray:
        """Forces that count [N], with additions to overlaps and velocities."""
        return BoundLaw(self.law, self.pairs, 1.0, 1.0, 1.0).force(
            self.overlap + more, self.velocity + faster, self.state
        )

    def updates(self) -> FloatArray:
        """States after steps that end with these overlaps and velocities."""
        return BoundLaw(self.law, self.pairs, 1.0, 1.0, 1.0).update(*self.arguments[:3])

    def take(self, places: Any) -> Sample:
        """A copy with some of the contacts."""
        overlap, velocity, state = (each[..., places].copy() for each in self.arguments[:3])
        return Sample(self.law, overlap, velocity, state, _at(self.pairs, places))

    def equals(self, other: Sample) -> bool:
        """Whether all arguments are the same."""
        return all(map(np.array_equal, _arrays(self), _arrays(other)))

    def work(self, turns: Sequence[float], points: int) -> tuple[Sample, FloatArray, FloatArray]:
        """The contacts after a path from one turn to the next, the work received, and that of approach alone [J].

        ``turns`` are over the overlaps of the sample; the magnitudes of its velocities are kept.
        """
        contacts, received, loading = self, np.zeros(self.overlap.shape), np.zeros(self.overlap.shape)
        for begin, end in pairwise(turns):
            velocity = np.sign(end - begin) * self.velocity
            step = (end - begin) / points
            # the middles of the steps are the same in both directions: elastic contacts return exactly what they got
            for share in begin + step * np.arange(points):
                middle = attrs.evolve(contacts, overlap=(share + step / 2) * self.overlap, velocity=velocity)
                work = step * self.overlap * middle.forces()
                received, loading = received + work, loading + np.maximum(work, 0.0)
                reached = attrs.evolve(middle, overlap=(share + step) * self.overlap)
                contacts = attrs.evolve(reached, state=reached.updates())
        return attrs.evolve(self, state=contacts.state), received, loading

    def check(self, holds: npt.NDArray[np.bool_], values: FloatArray, problem: str, unit: str = "N") -> None:
        """Fail if something does not hold at a contact; ``problem`` has placeholders for value and contact."""
        if holds.all():
            return
        worst = int(np.argmax(np.where(holds, -np.inf, np.abs(values))))
        state = f" and the state {self.state[:, worst].tolist()}" if len(self.state) else ""
        velocity = f"a closing velocity of {self.velocity[worst]:.6g} m/s"
        place = f"at an overlap of {self.overlap[worst]:.6g} m, {velocity}{state}"
        raise AssertionError(problem.format(f"{values[worst]:.4g} {unit}", place))


def _arrays(sample: Sample) -> tuple[FloatArray, ...]:
    return *sample.arguments[:3], *attrs.astuple(sample.pairs, recurse=False)


def _at(pairs: Pairs, places: Any) -> Pairs:
    return Pairs(*(each[places].copy() for each in attrs.astuple(pairs, recurse=False)))
