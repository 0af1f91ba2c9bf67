"""Pulses that shocks are specified by, for shockwave: sines, straight lines, the impact of a ball."""
