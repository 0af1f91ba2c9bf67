"""Blast waves for shockwave: the Friedlander pulse of a charge at a distance."""
