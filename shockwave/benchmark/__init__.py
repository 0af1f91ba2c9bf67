"""Benchmarks of accuracy against run time, and stress tests with extreme cases."""
