"""Scenarios: one file, one shock on one chain, and what is asked about it."""
