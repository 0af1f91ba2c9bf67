"""Predictions: simulated values, and the relations of section 4."""
