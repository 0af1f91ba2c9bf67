"""Entries that this distribution registers with shockwave."""

from __future__ import annotations

from shockwave.hooks import Entry, hookimpl


@hookimpl
def shockwave_profiles() -> list[Entry]:
    return [Entry("hertz-impact", "shockwave_pulses.hertz_impact:HertzImpact", "impact of a ball; fails (3)")]
