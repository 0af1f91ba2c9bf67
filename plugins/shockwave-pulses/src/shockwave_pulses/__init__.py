"""Pulses of shock testing for shockwave: half-sine and haversine."""
