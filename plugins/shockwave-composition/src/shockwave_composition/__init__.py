"""Integrators for shockwave: composition and extrapolation of the velocity Verlet method."""
