"""Tools that know no physics: errors, fields, units, text, tables, files, progress, numerics."""
