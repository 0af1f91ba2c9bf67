"""Shock profiles: the shape of a shock, its integrals, and the conditions (3) on its areas."""
