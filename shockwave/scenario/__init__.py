"""Scenario files: one shock on one chain, with the settings of prediction and simulation."""
