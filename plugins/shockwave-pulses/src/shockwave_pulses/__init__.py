"""Impact of a ball on a fixed body, as a shock profile for shockwave."""
