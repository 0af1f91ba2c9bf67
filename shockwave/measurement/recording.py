"""Histories of a simulation, sampled at equal time intervals."""

from __future__ import annotations

from typing import Any

from attrs import asdict, frozen

from shockwave.quadrature import FloatArray


def plain(value: Any) -> Any:
    """``value``, with tuples and arrays converted to lists."""
    return value.tolist() if hasattr(value, "tolist") else list(value) if isinstance(value, tuple) else value


@frozen(kw_only=True, eq=False)
class Recording:
    """Histories at equal time intervals, in SI units; histories that were not requested are None.

    Attributes
    ----------
    times : array, shape (k,)
        Times [s].
    contacts : tuple of int
        Contacts of the columns of ``forces``.
    forces : array, shape (k, contacts), or None
        Contact forces [N].
    displacements, velocities : array, shape (k, granules), or None
        Displacements [m] and velocities [m/s] of all granules that have moved by the end.
    kinetic_energy, contact_energy : array, shape (k,), or None
        Kinetic energy and contact energy of the chain [J].
    """

    times: FloatArray
    contacts: tuple[int, ...]
    forces: FloatArray | None = None
    displacements: FloatArray | None = None
    velocities: FloatArray | None = None
    kinetic_energy: FloatArray | None = None
    contact_energy: FloatArray | None = None

    def to_dict(self) -> dict[str, Any]:
        """Attributes by name, with arrays as lists of SI floats."""
        return {name: plain(value) for name, value in asdict(self).items()}
