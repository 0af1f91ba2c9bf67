"""Uncertainty: how the peak force of the primary is distributed where values of a scene are."""
