"""Entries that this distribution registers with shockwave."""

from __future__ import annotations

from shockwave.hooks import Entry, hookimpl


@hookimpl
def shockwave_contacts() -> list[Entry]:
    summary = "elastic, perfectly plastic contact of Thornton (1997)"
    return [Entry("thornton", "shockwave_plasticity.thornton:Thornton", summary)]
