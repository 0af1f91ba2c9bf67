"""Predictions of the leading wave without integration of the equations of motion, with their expected errors."""
