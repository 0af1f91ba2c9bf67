"""Histories of a chain as a whole and of its sensors, and the setup of another integration of it from its result."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from attrs import evolve, frozen

from shockwave.base.numerics import FloatArray
from shockwave.engine.chain_arrays import Samples
from shockwave.engine.chain_motion import ChainMotion
from shockwave.scene.sensors import STRUCTURE, WALL, Sensor
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.simulation.contact_setup import ChainSetup
from shockwave.simulation.convergence_runs import accuracies_of, run
from shockwave.simulation.recording import AFTER, Recording, SensorHistory, sample_times
from shockwave.simulation.simulation_result import Simulation


def record_chain(result: Simulation) -> Recording:
    """Histories that the options of ``result`` request, by another integration of the chain.

    Raises
    ------
    InvalidValueError
        If the histories have too many values.
    """
    if result.wave is not None and not result.options.sensors:
        result = evolve(result, options=evolve(result.options, until=_end_of_wave(result)))
    case, end = setup_of_result(result)
    options, scales, count = result.options, case.scales, case.granules
    times = sample_times(options, scales, end, count, result.characteristic_time)
    signals = [Signal.of(sensor, case) for sensor in options.sensors]
    motion = run(case, accuracies_of(case)[0], end, times, None if options.record else rows_of(signals))
    samples, contacts = motion.samples, len(motion.forces)
    if result.chain.count is None:
        count = count_reached(motion.v)
    recorded: dict[str, Any] = {}
    if options.sensors:
        recorded["sensors"] = histories_of(signals, samples)
    if "forces" in options.record:
        forces = scales.contact_force * samples.forces[:, :contacts]
        recorded["forces"] = forces[:, case.reported]
        if case.has_wall:
            recorded["wall_force"] = forces[:, -1]
        if result.scene.motion is not None:
            recorded["applied_force"] = _applied_force(result.scene.motion, case, times * scales.time, forces[:, 0])
    if "field" in options.record:
        recorded["displacements"] = scales.energy / scales.force * samples.x[:, :count]
        recorded["velocities"] = scales.velocity * samples.v[:, :count]
    if "energies" in options.record:
        squares = samples.v**2 / case.assembly.inverse_masses
        recorded["kinetic_energy"] = scales.energy / 2 * np.add.reduce(squares, axis=1)
        if case.layout.law is None:
            released = None if samples.energies is None else samples.energies[:, :contacts]
            stored = np.add.reduce(case.assembly.potentials(samples.x, released), axis=1)
            spring = case.assembly.end_stiffness / 2 * samples.x[:, -1] ** 2
            recorded["contact_energy"] = scales.energy * (stored + spring)
    return Recording(times=times * scales.time, contacts=tuple(case.reported.tolist()), **recorded)


def _end_of_wave(result: Simulation) -> float:
    """Default end of the histories of a leading wave [s]."""
    options = result.options
    if options.until is not None:
        return options.until
    last = result.passage(max(options.contacts)) if options.contacts else result.primary
    return float(last.arrival_time + AFTER * result.characteristic_time)


def _applied_force(motion: Any, case: ChainSetup, times: FloatArray, contact: FloatArray) -> FloatArray:
    """Force that a prescribed motion takes, from that at the first contact."""
    needed = case.layout.masses[0] * motion.course(times, 2) + contact
    return np.where(times <= motion.duration, needed, 0.0)


def chain_options(result: Simulation) -> SimulateOptions:
    """Options for the chain as a whole."""
    options = result.options
    return options if result.wave is None else evolve(options, backend=options.wanted_backend)


def setup_of_result(result: Simulation) -> tuple[ChainSetup, float]:
    """Setup of the chain of a result, of an endless one of the part that the waves reach, and its scaled end."""
    case = ChainSetup.of(chain_options(result), result.scene)
    if result.end is not None:
        return case, result.end / case.scales.time
    until = case.until
    return case, run(case, accuracies_of(case)[1], None).end if until is None else until


def count_reached(v: FloatArray) -> int:
    """Number of granules that the waves have reached."""
    return 1 + int(np.flatnonzero(v).max(initial=0))


# ---------------------------------------------------------------- sensors

# Histories of a movable end, with their SI units.
_OF_END = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2", "spring_force": "N"}


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
    body : int or None
        Granule whose velocity or displacement it is, or the movable end whose motion or spring force it is.
    """

    case: ChainSetup
    name: str
    unit: str
    contacts: npt.NDArray[np.intp]
    body: int | None = None

    @classmethod
    def of(cls, sensor: Sensor, case: ChainSetup) -> Signal:
        """The signal of a sensor; of a movable end, the spring force: that on the wall if it is held still."""
        last, still = len(case.assembly.overlaps) - 1, not case.assembly.movable_end
        at_end = sensor.place == WALL or (sensor.place == STRUCTURE and still)
        contacts = np.array(sensor.contacts or ((last,) if at_end else ()), dtype=np.intp)
        body = None if contacts.size else last + 1 if sensor.place == STRUCTURE else sensor.number
        return cls(case, sensor.name, sensor.unit, contacts, body)

    @property
    def rows(self) -> npt.NDArray[np.intp]:
        """Rows of the samples that it reads: its contacts, or its body and the one before."""
        return self.contacts if self.body is None else np.arange(max(self.body - 1, 0), self.body + 1)

    @property
    def nearby(self) -> npt.NDArray[np.intp]:
        """Contacts on which it depends."""
        last = len(self.case.assembly.overlaps) - 1
        return self.contacts if self.body is None else np.unique(np.clip([self.body - 1, self.body], 0, last))

    @property
    def kind(self) -> str:
        """Quantity measured, the same at each place along the chain; empty at an end that reflects the wave."""
        is_at_end = self.case.has_wall and len(self.case.assembly.overlaps) - 1 in self.nearby
        return "" if is_at_end else "".join(each for each in self.name if not each.isdigit())

    @property
    def static(self) -> float:
        """Static part of a force."""
        forces = self.case.assembly.static_forces[self.contacts] * self.case.scales.contact_force
        return float(forces.mean()) if forces.size else 0.0

    @property
    def position(self) -> float:
        """Distance from the struck end of the chain at rest [m]."""
        layout, packed = self.case.layout, self.case.scene.chain.next_contacts[1]
        begins = np.cumsum(2 * layout.radii) - 2 * layout.radii
        begins -= np.append(0.0, np.cumsum(layout.overlaps))[: len(begins)]
        ends = begins + 2 * layout.radii
        # the mean of two contact forces is that of the granule between them
        body = self.contacts.item(1) if len(self.contacts) == 2 else self.body
        if body is None:
            return float(packed * ends[self.contacts].mean())
        return float(packed * ((begins + ends) / 2)[body] if body < len(ends) else ends[-1])

    def read(self, samples: Samples) -> FloatArray:
        """Values at the times of the samples, with the static part."""
        scales, assembly, columns = self.case.scales, self.case.assembly, np.searchsorted(samples.rows, self.rows)
        if self.body is None:
            return np.asarray(samples.forces[:, columns].mean(axis=1) * scales.contact_force)
        x, v = samples.x[:, columns[-1]], samples.v[:, columns[-1]]
        if self.unit in ("m", "m/s"):
            return np.asarray(scales.energy / scales.force * x if self.unit == "m" else scales.velocity * v)
        spring = assembly.end_stiffness * x + assembly.end_damping * v
        if self.unit == "N":
            return np.asarray(scales.force * spring)
        excess = samples.forces[:, columns[0]] - assembly.static_forces[-1] - spring
        return np.asarray(scales.force / scales.mass * assembly.inverse_masses[-1] * excess)

    def dynamic(self, samples: Samples) -> FloatArray:
        """Values less the static part."""
        return self.read(samples) - self.static

    def greatest(self, motion: ChainMotion) -> float:
        """Greatest dynamic value of the force at a single contact; NaN for others."""
        single = len(self.contacts) == 1
        return float(motion.dynamic_forces[self.contacts[0]] * self.case.scales.contact_force) if single else np.nan

    def integral(self, samples: Samples) -> FloatArray:
        """Integral of a force less its static part [N s]; NaN for the motion of a granule."""
        scales, rows = self.case.scales, self.contacts if self.body is None else np.array([self.body])
        if self.unit != "N":
            return np.full(len(samples.x), np.nan)
        impulses = samples.impulses[:, np.searchsorted(samples.rows, rows)]
        return np.asarray(impulses.mean(axis=1) * scales.contact_force * scales.time)


def rows_of(signals: Sequence[Signal]) -> npt.NDArray[np.intp]:
    """Rows of the samples that these signals read."""
    return np.unique(np.concatenate([signal.rows for signal in signals]))


def histories_of(signals: Sequence[Signal], samples: Samples) -> tuple[SensorHistory, ...]:
    """Histories of sensors.

    A movable end has four, from its static equilibrium; one that spring or dashpot hold still, only the spring force.
    """
    histories = []
    for signal in signals:
        if signal.name != STRUCTURE:
            histories.append(SensorHistory(signal.name, signal.unit, signal.read(samples)))
            continue
        for quantity, unit in (_OF_END if signal.case.assembly.movable_end else {"spring_force": "N"}).items():
            values = evolve(signal, unit=unit).dynamic(samples)
            histories.append(SensorHistory(f"{STRUCTURE}_{quantity}", unit, values))
    return tuple(histories)
