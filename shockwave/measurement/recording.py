"""Histories of the chain, kept only when they are asked for."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from attrs import define, field, frozen

from shockwave.errors import InvalidValueError
from shockwave.measurement.passage import checked
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import plan_of, scaled
from shockwave.measurement.train import methods_of
from shockwave.quadrature import FloatArray
from shockwave.simulation.march import march
from shockwave.simulation.problem import contact_forces, overlaps
from shockwave.text import si

__all__ = ["Recording", "record"]

# Samples to a natural time of the wave, and natural times after the passage of the last contact.
_SAMPLES, _AFTER = 10, 5.0
_MOST_NUMBERS = 20_000_000


@frozen(kw_only=True, eq=False)
class Recording:
    """Histories at equal intervals, in SI units; what was not asked for is None.

    Attributes
    ----------
    times : array, shape (k,)
        [s]
    contacts : tuple of int
        Of ``forces``.
    forces : array, shape (k, contacts), or None
        Contact forces [N].
    displacements, velocities : array, shape (k, granules), or None
        Of all granules that have moved by the end [m], [m/s].
    kinetic_energy, contact_energy : array, shape (k,), or None
        Of the chain [J].
    """

    times: FloatArray
    contacts: tuple[int, ...]
    forces: FloatArray | None
    displacements: FloatArray | None
    velocities: FloatArray | None
    kinetic_energy: FloatArray | None
    contact_energy: FloatArray | None

    @property
    def summary(self) -> str:
        """In a line, for people."""
        kept = {
            "forces": self.forces,
            "field": self.displacements,
            "energies": self.kinetic_energy,
        }
        names = ", ".join(name for name, values in kept.items() if values is not None)
        return (
            f"{names}: {len(self.times)} samples, {si(float(self.times[0]), 's')} to {si(float(self.times[-1]), 's')}"
        )

    def to_dict(self) -> dict[str, Any]:
        """Lists of SI floats."""
        arrays = ("times", "forces", "displacements", "velocities", "kinetic_energy", "contact_energy")
        values = {name: getattr(self, name) for name in arrays}
        listed = {name: None if array is None else array.tolist() for name, array in values.items()}
        return {"contacts": list(self.contacts), **listed}


def record(result: SimulationResult) -> Recording:
    """The histories that ``result.options`` ask for; the chain is integrated once more.

    Raises
    ------
    InvalidValueError
        When forces are wanted and no contacts named, or the histories would not fit into memory.
    """
    options, scales = result.options, result.scales
    for contact in options.contacts:
        checked(result, contact)
    until = _end(result)
    interval = 1 / _SAMPLES if options.interval is None else options.interval / scales.time
    count = int(until / interval * (1 + 1e-12)) + 1
    rows = _Rows(options.contacts, set(options.record))
    if count * rows.width(result.primary.contact + until) > _MOST_NUMBERS:
        got = f"got {interval * scales.time:g} s for {until * scales.time:g} s; or give an earlier until"
        problem = f"must be longer, for the histories would have {count} samples ({got})"
        raise InvalidValueError.of("interval", problem)
    problem_, _ = scaled(result.shock, result.chain)
    times = interval * np.arange(count)
    wanted = iter(times.tolist())
    _fill(rows, wanted, march(problem_, methods_of(plan_of(options))(1.0)))
    return Recording(
        times=np.asarray(times * scales.time),
        contacts=options.contacts,
        forces=rows.array(rows.forces, scales.force),
        displacements=rows.array(rows.x, scales.energy / scales.force),
        velocities=rows.array(rows.v, scales.velocity),
        kinetic_energy=rows.array(rows.kinetic, scales.energy),
        contact_energy=rows.array(rows.stored, scales.energy),
    )


def _end(result: SimulationResult) -> float:
    if result.options.until is not None:
        return result.options.until / result.scales.time
    last = max(result.options.contacts, default=0)
    passed = result.passage(last).arrival_time if result.options.contacts else 0.0
    read = 0.0 if result.options.contacts else result.primary.arrival_time
    return max(passed, read) / result.scales.time + _AFTER


def _fill(rows: _Rows, wanted: Iterator[float], spans: Any) -> None:
    time = next(wanted, None)
    while time == 0.0:  # the chain at rest
        rows.add(np.zeros(2), np.zeros(2))
        time = next(wanted, None)
    for span in spans:
        while time is not None and time <= span.end:
            rows.add(*((span.x1, span.v1) if time == span.end else span.at(time)))
            time = next(wanted, None)
        if time is None:
            return


@define
class _Rows:
    """Samples, one row each, in scaled units."""

    contacts: tuple[int, ...]
    asked: set[str]
    forces: list[FloatArray] = field(factory=list)
    x: list[FloatArray] = field(factory=list)
    v: list[FloatArray] = field(factory=list)
    kinetic: list[float] = field(factory=list)
    stored: list[float] = field(factory=list)

    def width(self, granules: float) -> float:
        """Numbers in a row."""
        return len(self.contacts) + 2 + (2 * granules if "field" in self.asked else 0)

    def add(self, x: FloatArray, v: FloatArray) -> None:
        force = contact_forces(x)
        if "forces" in self.asked:
            self.forces.append(np.array([force[i] if i < len(force) else 0.0 for i in self.contacts]))
        if "field" in self.asked:
            self.x.append(x.copy())
            self.v.append(v.copy())
        if "energies" in self.asked:
            self.kinetic.append(0.5 * float(np.sum(v * v)))
            self.stored.append(0.4 * float(np.sum(force * np.maximum(overlaps(x), 0.0))))

    def array(self, rows: list[Any], unit: float) -> FloatArray | None:
        """All rows, those of a shorter window filled up with granules at rest."""
        if not rows:
            return None
        if np.ndim(rows[0]) == 0:
            return np.array(rows) * unit
        filled = np.zeros((len(rows), max(map(len, rows))))
        for index, row in enumerate(rows):
            filled[index, : len(row)] = row
        moved = int(np.max(np.nonzero(np.any(filled != 0, axis=0))[0], initial=0)) + 1
        return filled[:, : moved if rows is not self.forces else None] * unit
