"""The pulse against the numbered contract of `ShockProfile`, by shockwave's own kit."""

from __future__ import annotations

from shockwave.testing import ProfileContract

from shockwave_pulses.hertz_impact import HertzImpact


class TestHertzImpact(ProfileContract):
    profiles = [
        HertzImpact(),
        HertzImpact(
            ball_mass=1e-4,
            ball_speed=2.0,
            ball_radius=1.5e-3,
            ball_youngs_modulus=193e9,
            ball_poisson_ratio=0.3,
            struck_youngs_modulus=72e9,
            struck_poisson_ratio=0.22,
        ),
    ]
