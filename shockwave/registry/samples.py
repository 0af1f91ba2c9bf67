"""Names that the sample plugins of the source tree register, for the installation hint."""

from __future__ import annotations

from typing import Final

__all__ = ["SAMPLES"]

_PULSES = (
    "half-sine",
    "haversine",
    "trapezoid",
    "initial-peak-sawtooth",
    "final-peak-sawtooth",
    "rectangular",
    "hertz-impact",
)
_METHODS = ("blanes-moan-4", "blanes-moan-6", "blanes-moan-6-long", "verlet-richardson")

#: (kind, name) -> distribution.
SAMPLES: Final = {
    **{("profiles", name): "shockwave-pulses" for name in _PULSES},
    **{("profiles", name): "shockwave-blast" for name in ("friedlander", "kingery-bulmash")},
    **{("integrators", name): "shockwave-composition" for name in _METHODS},
}
