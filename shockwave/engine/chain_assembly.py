"""Chains of mixed granules in scaled units."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.base.numerics import FloatArray
from shockwave.engine.chain_arrays import LARGEST
from shockwave.engine.chain_forces import FAR
from shockwave.engine.scaled_problem import ScaledProblem
from shockwave.scene.contact_law import BoundLaw

if TYPE_CHECKING:  # chains without such contacts do not need it
    from shockwave.engine.chain_plastic import PlasticContacts

# Least fraction of closing velocity and overlap at one contact that is expected at the next, and of their estimates at
# the first one.
_EXPECTED = 0.1
# Least scale of errors, over that at the first contact.
_LEAST = 1e-60
# First step, over the time in which the first contact closes.
_FIRST_STEP = 0.05
# Rate in characteristic times beyond which it makes the steps short.
_FAST = 30.0
# Gauss-Legendre rule on (0, 1) for the energy of contacts with a static overlap: nodes and weights.
_RULE = (np.polynomial.legendre.leggauss(12) + np.array([[1.0], [0.0]])) / 2


@frozen(eq=False, slots=False)
class Assembly:
    """A chain of mixed granules, in scaled units.

    Positions x are displacements from the initial ones. Contact j lies between bodies j and j + 1, the last one between
    the last body and the wall if there is a fixed one. With the overlap d = d0 + x_j - x_{j+1} its force is
    F = max(k d^p + c d^q d', 0) where d > 0, else 0. Static forces k d0^p are balanced by constant forces.

    Attributes
    ----------
    inverse_masses : array, shape (bodies,)
        The last body is the end if that is movable.
    stiffnesses : array, shape (contacts,)
        k.
    overlaps : array, shape (contacts,)
        d0, negative for a gap.
    exponents : array, shape (contacts,)
        p.
    fixed_wall : bool
        Whether the last contact is with a fixed flat: then there are as many contacts as bodies, else one less.
    damping : array, shape (contacts,)
        c.
    damping_powers : array, shape (contacts,)
        q.
    end_stiffness, end_damping : float
        Spring and dashpot between the last body and the ground.
    force : ScaledProblem or None
        The applied force on body 0; its ``granules`` are not used.
    velocity, weight : float
        Initial velocity of body 0, and a constant force on it: the weight of a striker.
    law : BoundLaw or None
        Contact law of a plugin, which replaces stiffness and damping ...
    law_contacts : array of bool, shape (contacts,), or None
        ... at these contacts.
    plastic : PlasticContacts or None
        Elastic-plastic contacts, whose ``stiffnesses`` are those of Hertz's law.
    movable_end : bool
        Whether the last body is a movable end, whose motion is observed.
    guided : bool
        Whether ``force`` is the acceleration of body 0, which follows it whatever the contacts do, until its duration.
    top_speed : float
        Greatest speed of a guided body.
    impedance : float
        Z of a bar at the end, 0 without one: the last body is its flat, without mass, and its inverse mass 1/Z.
    """

    inverse_masses: FloatArray
    stiffnesses: FloatArray
    overlaps: FloatArray
    exponents: FloatArray
    fixed_wall: bool
    damping: FloatArray
    damping_powers: FloatArray
    end_stiffness: float = 0.0
    end_damping: float = 0.0
    force: ScaledProblem | None = None
    velocity: float = 0.0
    weight: float = 0.0
    law: BoundLaw | None = None
    law_contacts: npt.NDArray[np.bool_] | None = None
    plastic: PlasticContacts | None = None
    movable_end: bool = False
    guided: bool = False
    top_speed: float = 0.0
    impedance: float = 0.0

    @cached_property
    def depends_on_rate(self) -> bool:
        """Whether forces depend on velocities during plastic flow."""
        return self.plastic is not None and bool(self.plastic.rates.any())

    @cached_property
    def is_damped(self) -> bool:
        """Whether forces depend on velocities at all times."""
        return self.law is not None or self.end_damping > 0 or self.impedance > 0 or bool(np.any(self.damping > 0))

    @property
    def dissipates(self) -> npt.NDArray[np.bool_]:
        """Whether each contact dissipates energy, shape (contacts,)."""
        dissipates = self.damping > 0
        if self.law_contacts is not None:
            dissipates = dissipates | self.law_contacts
        return dissipates if self.plastic is None else dissipates | np.isfinite(self.plastic.loading.strengths)

    @cached_property
    def static_forces(self) -> FloatArray:
        """Static contact forces, shape (contacts,)."""
        if self.plastic is not None:
            elastic = self.stiffnesses * np.maximum(self.overlaps, 0.0) ** self.exponents
            return np.where(np.isinf(self.plastic.loading.strengths), elastic, self.plastic.at_rest(self.overlaps)[0])
        return np.asarray(self.stiffnesses * np.maximum(self.overlaps, 0.0) ** self.exponents)

    @cached_property
    def powers_of_contacts(self) -> FloatArray:
        """Exponents, and powers of the damping, shape (2, bodies).

        Without a coefficient, the power of a contact is that of others: equal powers take less time.
        """
        used = self.damping > 0
        shared = self.damping_powers[np.argmax(used)]
        powers = np.empty((2, len(self.inverse_masses)))
        powers[:, -1] = self.exponents[-1], shared
        powers[:, : len(used)] = self.exponents, np.where(used, self.damping_powers, shared)
        return powers

    @cached_property
    def at_rest(self) -> tuple[FloatArray, FloatArray]:
        """Stiffnesses and overlaps, less residual ones, at the beginning."""
        if self.plastic is None:
            return self.stiffnesses, self.overlaps
        _forces, stiffnesses, left = self.plastic.at_rest(self.overlaps)
        elastic = np.isinf(self.plastic.loading.strengths)
        return np.where(elastic, self.stiffnesses, stiffnesses), self.overlaps - left

    @property
    def _first_scales(self) -> tuple[float, float]:
        """Orders of magnitude of closing velocity and force, minus the static one, at the first contact."""
        p, (k, overlap) = float(self.exponents[0]), (float(each[0]) for each in self.at_rest)
        linear = p * k * max(overlap, 0.0) ** (p - 1)
        mass = 1 / float(np.sum(self.inverse_masses[:2]))
        if self.guided:
            velocity, mass = self.top_speed, 1 / float(self.inverse_masses[:2][-1])
            reached = ((p + 1) / 2 * mass * velocity**2 / k) ** (1 / (p + 1))
            return velocity, k * reached**p
        force = self.weight if self.force is None else self.force.peak_force
        overlap = min((force / k) ** (1 / p), force / linear if linear else math.inf)
        velocity = math.sqrt(overlap * force / mass)
        if self.force is None:
            velocity, force = max(self.velocity, velocity), math.inf
        else:
            velocity = min(velocity, self.force.free(self.force.duration)[1] * float(self.inverse_masses[0]))
        reached = ((p + 1) / 2 * mass * velocity**2 / k) ** (1 / (p + 1))
        return velocity, min(force, max(k * reached**p, velocity * math.sqrt(mass * linear)))

    @cached_property
    def beginning(self) -> tuple[FloatArray, FloatArray, float]:
        """Rows of a `Job` that describe the chain, the scales of errors at the beginning, and the first step."""
        inverse = np.asarray(self.inverse_masses, dtype=float)
        bodies, contacts = len(inverse), len(self.overlaps)
        p = self.powers_of_contacts[0]
        k, offsets, c, still = np.zeros((4, bodies))
        k[:contacts], offsets[:contacts] = self.at_rest
        c[:contacts], still[:contacts] = self.damping, self.static_forces
        offsets[contacts:] = -FAR
        base, gap = np.maximum(offsets, 0.0), np.minimum(offsets, 0.0)
        velocity, force = self._first_scales
        # overlap of each contact under the force at the first one
        extent = np.minimum((force / np.where(k > 0, k, 1.0)) ** (1 / p), _ratio(force, p * k * base ** (p - 1)))
        reach = np.ones((2, bodies))
        reach[:, 1:] = 2 * inverse[1:] / (inverse[:-1] + inverse[1:]), extent[1:] / extent[:-1]
        reach = np.minimum(reach, 1.0)
        reach[:, 1:] *= _EXPECTED
        scales = np.multiply.accumulate(reach, axis=1)
        scales = np.maximum(scales, _LEAST) * (_EXPECTED * np.array([[velocity], [extent[0]]]))
        reach[:, 0] = _EXPECTED
        scales[:, contacts:] = LARGEST
        first = _FIRST_STEP * float(scales[1, 0] / scales[0, 0])
        return np.array([inverse, k, gap, base, np.sqrt(base), still, c, *reach]), scales, first

    def cause_of_work(self) -> str:
        """Keys of the scenario that make the steps of a run short or many."""
        inverse, p, last = self.inverse_masses, self.exponents, float(self.inverse_masses[-1])
        lighter = np.maximum(inverse, np.append(inverse[1:], 0.0))[: len(self.overlaps)]
        force = self._first_scales[1] + float(self.static_forces.max())
        overlaps = (force / self.stiffnesses) ** (1 / p)
        elastic = np.sqrt(p * force / overlaps * lighter)
        rates = {
            f"the mass or the stiffness at contact {np.argmax(elastic)} (chain.granules, chain.end)": elastic.max(),
            "chain.damping": (self.damping * overlaps**self.damping_powers * lighter).max(),
            "chain.end.stiffness and the mass of the wall": math.sqrt(self.end_stiffness * last),
            "chain.end.damping and the mass of the wall": self.end_damping * last,
        }
        cause = max(rates, key=lambda each: float(rates[each]))
        long = "simulate.until, the duration of the shock, or the length of the chain"
        return cause if rates[cause] > _FAST else long

    def potential(self, x: FloatArray) -> FloatArray:
        """Integral of the contact force minus its static part from the initial state to ``x``, shape (contacts,).

        Elastic-plastic contacts are those of the beginning.
        Zero for the law of a plugin: its energy depends on the history, and counts as dissipated.
        """
        potential = self._elastic_potential(x)
        return potential if self.law_contacts is None else np.where(self.law_contacts, 0.0, potential)

    def _elastic_potential(self, x: FloatArray) -> FloatArray:
        changes = approaches(x)[: len(self.overlaps)]
        stiffnesses, overlaps = self.at_rest
        static, p = np.maximum(overlaps, 0.0), self.exponents
        closed = np.maximum(overlaps + changes, 0.0)
        if not static.any():
            return np.asarray(stiffnesses * (closed ** (p + 1) / (p + 1)))
        whole = (closed ** (p + 1) - static ** (p + 1)) / (p + 1) - static**p * changes
        # Gauss-Legendre quadrature of a force that is nearly linear avoids the difference of large numbers
        shares, weights = _RULE[:, :, None]
        strain = changes / np.where(static > 0, static, 1.0)
        near = (static > 0) & (np.abs(strain) < 0.5)
        inner = np.where(near, strain, 0.0) * shares
        slight = np.add.reduce(weights * np.expm1(p * np.log1p(inner)), axis=0) * static**p * changes
        return np.asarray(stiffnesses * np.where(near, slight, whole))

    def changed_potential(self, x: FloatArray, residual: FloatArray, energies: FloatArray) -> FloatArray:
        """`potential` with the residual overlaps and releasable energies of elastic-plastic contacts after a run."""
        flowed = residual != self.overlaps - self.at_rest[1]
        return np.where(flowed, self.released_potential(x, energies), self.potential(x))

    def potentials(self, x: FloatArray, energies: FloatArray | None) -> FloatArray:
        """`potential` of several states, with energies that contacts release; shape (times, contacts)."""
        states = [self.potential(each) for each in x]
        if self.plastic is None or energies is None:
            return np.array(states)
        elastic = np.isinf(self.plastic.loading.strengths)
        released = [self.released_potential(*each) for each in zip(x, energies, strict=True)]
        return np.where(elastic, np.array(states), np.array(released))

    def released_potential(self, x: FloatArray, energies: FloatArray) -> FloatArray:
        """`potential` from the energies that elastic-plastic contacts release."""
        stiffnesses, overlaps = self.at_rest
        before = stiffnesses / 2.5 * np.maximum(overlaps, 0.0) ** 2.5
        changes = approaches(x)[: len(self.overlaps)]
        return np.asarray(energies - before - self.static_forces * changes)


def approaches(x: FloatArray) -> FloatArray:
    """Displacement of each body minus that of the next; what follows the last body is at rest."""
    changes = x.copy()
    changes[:-1] -= x[1:]
    return changes


def _ratio(one: float, others: FloatArray) -> FloatArray:
    """Quotients, infinite where a divisor is zero."""
    return np.asarray(np.divide(one, others, out=np.full(others.shape, math.inf), where=others > 0))
