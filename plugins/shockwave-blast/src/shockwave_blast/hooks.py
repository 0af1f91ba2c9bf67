"""Entries that this distribution registers with shockwave."""

from __future__ import annotations

from shockwave.hooks import Entry, hookimpl


@hookimpl
def shockwave_profiles() -> list[Entry]:
    return [
        Entry(
            "kingery-bulmash",
            "shockwave_blast.kingery_bulmash:KingeryBulmash",
            "blast wave of TNT by mass and standoff",
        ),
    ]
