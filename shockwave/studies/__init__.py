"""Studies: questions about a scene that take many predictions or simulations."""
