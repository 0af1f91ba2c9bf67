"""The extremes as a catalogue: what is asked, what must happen, and whether it does on this machine."""
