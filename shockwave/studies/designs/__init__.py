"""Design: which value of a scene makes the primary what it is to be."""
