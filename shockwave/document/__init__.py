"""Documents: YAML text read safely into plain data that knows where it stands, units taken off values, files, HTML."""
