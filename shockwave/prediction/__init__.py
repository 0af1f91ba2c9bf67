"""The left column: the answer a priori, with how far to trust it."""
