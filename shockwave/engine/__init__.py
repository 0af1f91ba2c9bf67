"""Numerical integration of the equations of motion (1)."""
