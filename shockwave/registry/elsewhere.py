"""Names that are not built in but known: which distribution to install for them."""

from __future__ import annotations

from typing import Final

__all__ = ["ELSEWHERE"]

_NAMES = {
    "shockwave-pulses": {
        "profiles": [
            "half-sine",
            "haversine",
            "trapezoid",
            "initial-peak-sawtooth",
            "final-peak-sawtooth",
            "rectangular",
            "hertz-impact",
        ]
    },
    "shockwave-blast": {"profiles": ["friedlander", "kingery-bulmash"]},
    "shockwave-composition": {
        "integrators": ["blanes-moan-4", "blanes-moan-6", "blanes-moan-6-long", "verlet-richardson"]
    },
}

#: (kind, name) -> distribution.
ELSEWHERE: Final = {
    (kind, name): distribution
    for distribution, kinds in _NAMES.items()
    for kind, names in kinds.items()
    for name in names
}
