"""Documents: safe reading of YAML into plain data with source positions, values with units, files, HTML."""
