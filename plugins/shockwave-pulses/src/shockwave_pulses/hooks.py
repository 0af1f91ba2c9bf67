"""What this distribution registers with shockwave."""

from __future__ import annotations

from shockwave.hooks import Entry, hookimpl


@hookimpl
def shockwave_profiles() -> list[Entry]:
    return [
        Entry("half-sine", "shockwave_pulses.half_sine:HalfSine", "half a period of a sine; fails (3)"),
        Entry("haversine", "shockwave_pulses.haversine:Haversine", "square of half a period of a sine"),
        Entry("trapezoid", "shockwave_pulses.trapezoid:Trapezoid", "rise, plateau and fall; fails (3)"),
        Entry(
            "initial-peak-sawtooth",
            "shockwave_pulses.initial_peak_sawtooth:InitialPeakSawtooth",
            "steep rise, long linear fall",
        ),
        Entry(
            "final-peak-sawtooth",
            "shockwave_pulses.final_peak_sawtooth:FinalPeakSawtooth",
            "long linear rise, steep fall; fails (3)",
        ),
        Entry(
            "rectangular",
            "shockwave_pulses.rectangular:Rectangular",
            "constant force, steep ends; fails (3)",
        ),
        Entry(
            "hertz-impact",
            "shockwave_pulses.hertz_impact:HertzImpact",
            "impact of a ball; fails (3)",
        ),
    ]
