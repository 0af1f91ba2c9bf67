"""Measurement of the waves in a simulated chain: peak forces, momentum, energy, rebounding granules, errors."""
