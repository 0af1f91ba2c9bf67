"""Parameter sweeps: parallel runs of the scenes that a scenario describes, their journal and their results."""
