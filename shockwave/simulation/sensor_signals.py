"""Signals of sensors, from the states and forces at sampled times of a chain."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from attrs import frozen

from shockwave.base.numerics import FloatArray
from shockwave.engine.mixed_chain_problem import Motion
from shockwave.scene.sensors import STRUCTURE, WALL, Sensor
from shockwave.simulation.contact_setup import ChainSetup
from shockwave.simulation.recording import SensorHistory

_UNITS = {"force": "N", "velocity": "m/s", "displacement": "m"}


@frozen(eq=False)
class Signal:
    """What a sensor measures, in SI units.

    Attributes
    ----------
    case : ChainSetup
        The chain.
    name, unit : str
        Name of the column, and unit.
    contacts : array of int
        Contacts whose mean force it is.
    granule : int or None
        Granule whose velocity or displacement it is.
    """

    case: ChainSetup
    name: str
    unit: str
    contacts: npt.NDArray[np.intp]
    granule: int | None = None

    @classmethod
    def of(cls, sensor: Sensor, case: ChainSetup) -> Signal:
        """The signal of a sensor; of a movable end, the force on it."""
        contacts = sensor.contacts or ((len(case.assembly.overlaps) - 1,) if sensor.place in (WALL, STRUCTURE) else ())
        granule = sensor.number if sensor.quantity != "force" else None
        return cls(case, sensor.name, _UNITS[sensor.quantity], np.array(contacts, dtype=np.intp), granule)

    @property
    def static(self) -> float:
        """Static part of a force."""
        forces = self.case.assembly.static_forces[self.contacts] * self.case.scales.contact_force
        return float(forces.mean()) if forces.size else 0.0

    def read(self, motion: Motion) -> FloatArray:
        """Values at the times of the samples, with the static part."""
        scales = self.case.scales
        if self.granule is None:
            return np.asarray(motion.samples_forces[:, self.contacts].mean(axis=1) * scales.contact_force)
        if self.unit == "m":
            return np.asarray(scales.energy / scales.force * motion.samples_x[:, self.granule])
        return np.asarray(scales.velocity * motion.samples_v[:, self.granule])


def histories_of(case: ChainSetup, motion: Motion) -> tuple[SensorHistory, ...]:
    """Histories of all sensors of the options; a movable end has several."""
    histories = []
    for sensor in case.options.sensors:
        if sensor.place == STRUCTURE:
            histories += end_histories(case, motion)
        else:
            signal = Signal.of(sensor, case)
            histories.append(SensorHistory(signal.name, signal.unit, signal.read(motion)))
    return tuple(histories)


def end_histories(case: ChainSetup, motion: Motion) -> list[SensorHistory]:
    """Displacement, velocity, acceleration and spring force of a movable end, from its static equilibrium."""
    scales, end = case.scales, case.layout.wall
    assert end is not None
    assert end.mass is not None
    x, v = scales.energy / scales.force * motion.samples_x[:, -1], scales.velocity * motion.samples_v[:, -1]
    spring = end.stiffness * x + end.damping * v
    force = scales.force * (motion.samples_forces[:, -1] - case.assembly.static_forces[-1])
    columns = ("displacement", "m", x), ("velocity", "m/s", v), ("acceleration", "m/s^2", (force - spring) / end.mass)
    return [
        SensorHistory(f"{STRUCTURE}_{name}", unit, values)
        for name, unit, values in (*columns, ("spring_force", "N", spring))
    ]
