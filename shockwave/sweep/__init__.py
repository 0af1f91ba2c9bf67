"""Sweeps: all scenes that a scenario stands for, run on many cores, journalled, and their results."""
