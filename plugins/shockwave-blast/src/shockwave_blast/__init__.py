"""Pulses of explosions for shockwave: the Friedlander pulse, and the same by charge and standoff."""
