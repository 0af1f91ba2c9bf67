"""Elastic-plastic contacts of a chain of mixed granules: their properties, and what remains of them after a run."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from attrs import frozen

from shockwave.base.numerics import FloatArray
from shockwave.engine.mixed_chain_arrays import LARGEST, Job
from shockwave.engine.mixed_chain_forces import Contacts
from shockwave.engine.mixed_chain_modes import ROWS, Mode, Plasticity
from shockwave.scene import elastic_plastic
from shockwave.scene.elastic_plastic import Loading
from shockwave.scene.yielding import PRESSURE

# Constants of the law, in the order of the compiled code.
_LAW = np.array(
    [
        math.pi,
        PRESSURE,
        elastic_plastic.FULL,
        elastic_plastic.FULL_LESS,
        elastic_plastic.HARDNESS,
        elastic_plastic.SOFTENING,
        elastic_plastic.SOFTENING_POWER,
        elastic_plastic.AREA,
        elastic_plastic.AREA_LESS,
    ]
)


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

    @property
    def constants(self) -> FloatArray:
        """Constants of the law."""
        return _LAW

    def at_rest(self, overlaps: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Forces after slow first loading to these overlaps; stiffnesses and residual overlaps of unloading."""
        forces = self.loading.force(overlaps)
        return forces, self.loading.unloading(forces), self.loading.residual(overlaps, forces)

    def table(self, overlaps: FloatArray, bodies: int) -> FloatArray:
        """The rows of a `Job` for contacts at rest at these overlaps, shape (23, bodies + 1)."""
        law, count = self.loading, len(overlaps)
        forces, _stiffnesses, left = self.at_rest(overlaps)
        elastic = np.isinf(law.strengths)
        flowed = ~elastic & (forces > law.first_forces)
        table = np.zeros((len(ROWS), bodies + 1))
        table[ROWS.index("limit")] = LARGEST
        limits = np.where(flowed, np.maximum(overlaps - left, 0.0), law.first_overlaps)
        properties = law.first_overlaps, law.cap_overlaps, law.full_overlaps, *law.middle, *law.straight
        rows = [np.where(elastic, 0.0, law.strengths), law.radii, np.where(elastic, 0.0, self.rates), self.speeds]
        rows += [law.stiffnesses, overlaps, *properties, law.first_forces, law.units]
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
    d = chain.overlaps(job.x, 0, chain.bodies)[1][:count]
    for j in np.flatnonzero((flow.mode[:count] != Mode.ELASTIC) & (d > flow.limit[:count])).tolist():
        force = 0.0 if flow.curved[j] > 1 else flow.load(j, int(flow.mode[j]), float(d[j]), None)
        flow.change_mode(j, Mode.ELASTIC, (float(d[j]), 0.0, 0.0), force)
    d = chain.overlaps(job.x, 0, chain.bodies)[1][:count]
    energies = [flow.stored(j, each) for j, each in enumerate((d + flow.left[:count]).tolist())]
    return Rest(flow.left[:count], flow.reached[:count], np.array(energies))
