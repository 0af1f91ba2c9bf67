"""The right column: the equations of motion (1), integrated."""
