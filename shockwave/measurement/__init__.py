"""Reading waves off a simulated chain: peaks, limits, momentum, energy, recoil, and how far to trust them."""
