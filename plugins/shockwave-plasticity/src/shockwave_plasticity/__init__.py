"""Elastic-plastic contacts for shockwave."""
