"""Entries that this distribution registers with shockwave."""

from __future__ import annotations

from shockwave.hooks import Entry, hookimpl


@hookimpl
def shockwave_profiles() -> list[Entry]:
    return [
        Entry("friedlander", "shockwave_blast.friedlander:Friedlander", "blast wave, (1 - u) exp(-b u)"),
        Entry(
            "kingery-bulmash",
            "shockwave_blast.kingery_bulmash:KingeryBulmash",
            "blast wave of TNT by mass and standoff",
        ),
    ]
