"""Standard shock-test pulses for shockwave: sines, straight lines, and the impact of a ball."""
