"""The profile against the contract of `ShockProfile`, at the ends of its ranges."""

from __future__ import annotations

from shockwave.testing import ProfileContract

from shockwave_blast.kingery_bulmash import KingeryBulmash


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
