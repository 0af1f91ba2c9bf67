"""What this distribution registers with shockwave."""

from __future__ import annotations

from shockwave.hooks import Entry, hookimpl


@hookimpl
def shockwave_profiles() -> list[Entry]:
    return [
        Entry("half-sine", "shockwave_pulses.half_sine:HalfSine", "half a period of a sine, breaks (3)"),
        Entry("haversine", "shockwave_pulses.haversine:Haversine", "square of half a period of a sine"),
    ]
