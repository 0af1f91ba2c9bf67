"""Documents: YAML text read safely into plain data that knows where it stands, and units taken off values."""
