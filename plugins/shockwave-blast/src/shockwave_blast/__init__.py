"""Blast waves for shockwave: the Friedlander pulse, by its shape or by charge and standoff."""
