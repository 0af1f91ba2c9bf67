"""Every pulse against the numbered contract of `ShockProfile`, by shockwave's own kit."""

from __future__ import annotations

from shockwave.testing import ProfileContract

from shockwave_pulses.final_peak_sawtooth import FinalPeakSawtooth
from shockwave_pulses.half_sine import HalfSine
from shockwave_pulses.haversine import Haversine
from shockwave_pulses.hertz_impact import HertzImpact
from shockwave_pulses.initial_peak_sawtooth import InitialPeakSawtooth
from shockwave_pulses.rectangular import Rectangular
from shockwave_pulses.trapezoid import Trapezoid


class TestHalfSine(ProfileContract):
    profiles = [HalfSine()]


class TestHaversine(ProfileContract):
    profiles = [Haversine()]


class TestTrapezoid(ProfileContract):
    profiles = [
        Trapezoid(),
        Trapezoid(rise_fraction=0.2, fall_fraction=0),
        Trapezoid(rise_fraction=0.3, fall_fraction=0.7),
        Trapezoid(rise_fraction=0.999, fall_fraction=0.0005),
    ]


class TestInitialPeakSawtooth(ProfileContract):
    profiles = [
        InitialPeakSawtooth(),
        InitialPeakSawtooth(rise_fraction=1e-6),
        InitialPeakSawtooth(rise_fraction=0.5),
    ]


class TestFinalPeakSawtooth(ProfileContract):
    profiles = [
        FinalPeakSawtooth(),
        FinalPeakSawtooth(fall_fraction=1e-6),
        FinalPeakSawtooth(fall_fraction=0.499),
    ]


class TestRectangular(ProfileContract):
    profiles = [
        Rectangular(),
        Rectangular(rise_fraction=1e-6, fall_fraction=0),
        Rectangular(rise_fraction=0.1, fall_fraction=1e-6),
    ]


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
