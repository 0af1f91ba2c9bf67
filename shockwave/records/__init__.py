"""A measured record: its file read, converted and processed."""
