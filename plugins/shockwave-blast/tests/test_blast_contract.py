"""Both profiles against the contract of `ShockProfile`, at the ends of their ranges."""

from __future__ import annotations

from shockwave.testing import ProfileContract

from shockwave_blast.friedlander import Friedlander
from shockwave_blast.kingery_bulmash import KingeryBulmash


class TestFriedlander(ProfileContract):
    profiles = [  # noqa: RUF012
        Friedlander(),
        Friedlander(decay_coefficient=0),
        Friedlander(decay_coefficient=100),
        Friedlander(decay_coefficient=5, rise_fraction=1e-6),
        Friedlander(decay_coefficient=2, rise_fraction=0.5),
    ]


class TestKingeryBulmash(ProfileContract):
    profiles = [  # noqa: RUF012
        KingeryBulmash(
            charge_mass=1e-3, standoff=0.1, burst="free-air", loading="reflected", loaded_radius=4.75e-3
        ),
        KingeryBulmash(
            charge_mass=1,
            standoff=30,
            burst="surface",
            loading="incident",
            loaded_radius=0.05,
            rise_fraction=0.05,
        ),
    ]
