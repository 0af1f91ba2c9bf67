"""Elastic-plastic contacts of a chain of mixed granules: their properties, and what remains of them after a run."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from attrs import frozen

from shockwave.base.numerics import FloatArray
from shockwave.engine.chain_arrays import LARGEST, Job
from shockwave.engine.chain_forces import FASTEST, FINER, Contacts
from shockwave.engine.chain_modes import ROWS, Mode, Plasticity
from shockwave.scene.elastic_plastic import FULL, Curve, Loading

# Degree of a piece of a loading curve. Its error is 1e-13 for the softest contacts of the law, less for metals.
_DEGREE = 4


@frozen(eq=False, slots=False)
class PlasticContacts:
    """Properties of the contacts of a chain in scaled units, as arrays of shape (contacts,).

    Attributes
    ----------
    loading : Loading
        The loading curves without rate.
    rates : array
        Rate constant K.
    speeds : array
        Closing velocity above which the strength grows.
    """

    loading: Loading
    rates: FloatArray
    speeds: FloatArray

    @cached_property
    def curves(self) -> tuple[FloatArray, FloatArray]:
        """Pieces of the loading curves, as polynomials of the increase of the strength, and the first of each contact.

        The coefficients, of shape (pieces, 5, 4), are those of a + b ln e and c + d e, by which a force between cap and
        full plasticity is e times the first, then the second.
        """
        faster = np.isfinite(self.loading.strengths) & (self.rates > 0)
        strengths, places = np.unique(self.loading.strengths[faster], return_inverse=True)
        count, first = int(FINER * FASTEST * self.rates[faster].max(initial=0.0)) + 1, np.zeros(len(faster))
        nodes = 0.5 - 0.5 * np.cos(np.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1))
        curve = Curve.of(strengths[:, None, None] * (1 + (np.arange(count)[:, None] + nodes) / FINER))
        values = curve.ratio - curve.bend * np.log(curve.first), curve.bend, curve.level, curve.slope
        first[faster] = count * places
        coefficients = np.linalg.solve(np.vander(nodes, increasing=True), np.stack(values, axis=-1))
        return np.asarray(coefficients.reshape(-1, _DEGREE + 1, 4)), np.asarray(first)

    def at_rest(self, overlaps: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Forces after slow first loading to these overlaps; stiffnesses and residual overlaps of unloading."""
        forces = self.loading.force(overlaps)
        return forces, self.loading.unloading_stiffness(forces), self.loading.residual(overlaps, forces)

    def table(self, overlaps: FloatArray, bodies: int) -> FloatArray:
        """The rows of a `Job` for contacts at rest at these overlaps, shape (26, bodies + 1)."""
        law, count = self.loading, len(overlaps)
        forces, _stiffnesses, left = self.at_rest(overlaps)
        elastic = np.isinf(law.strengths)
        flowed = ~elastic & (forces > law.first_forces)
        table = np.zeros((len(ROWS), bodies + 1))
        table[ROWS.index("limit")] = LARGEST
        limits = np.where(flowed, 0.0, law.first_overlaps - np.maximum(overlaps, 0.0))
        properties = law.first_overlaps, law.cap_overlaps, law.full_overlaps, *law.middle, *law.straight
        wider = FULL / FINER * law.strengths * law.radii
        rows = [law.softness, 1 / law.radii, np.where(elastic, 0.0, FINER * self.rates), 1 / self.speeds]
        rows += [self.curves[1], wider, law.stiffnesses, overlaps, *properties, law.first_forces, law.units]
        rows += [np.where(flowed, Mode.ELASTIC, Mode.CAPPED), np.where(flowed, overlaps, 0.0), forces, left]
        table[: len(rows), :count] = np.minimum(rows, LARGEST)
        table[len(rows), :count] = np.where(elastic, LARGEST, limits)
        return table


class Rest(NamedTuple):
    """Contacts after a run, as arrays of shape (contacts,).

    Attributes
    ----------
    residual : array
        Residual overlaps.
    reached : array
        Overlaps from which contacts unloaded last; zero where one has not flowed.
    energies : array
        Energies that unloading releases.
    """

    residual: FloatArray
    reached: FloatArray
    energies: FloatArray


def settle(job: Job) -> Rest:
    """Let contacts that flow at the end of a run turn there, and complete their losses."""
    chain = Contacts(job)
    flow, count = Plasticity(chain, job), chain.contacts
    u, d = (values[:count] for values in chain.overlaps(job.x, 0, chain.bodies))
    for j in np.flatnonzero((flow.mode[:count] != Mode.ELASTIC) & (u > flow.limit[:count])).tolist():
        force = 0.0 if flow.curved[j] > 1 else flow.load(j, int(flow.mode[j]), (float(d[j]), 0.0, 0.0), 0.0)[0]
        flow.change_mode(j, Mode.ELASTIC, (float(d[j]), 0.0, 0.0), force)
    d = chain.overlaps(job.x, 0, chain.bodies)[1][:count]
    energies = [flow.stored_energy(j, each) for j, each in enumerate((d + flow.left[:count]).tolist())]
    return Rest(flow.left[:count], flow.reached[:count], np.array(energies))
