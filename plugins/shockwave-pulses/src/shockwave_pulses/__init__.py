"""Standard pulses of shock testing for shockwave: sines, straight lines, and the impact of a ball."""
