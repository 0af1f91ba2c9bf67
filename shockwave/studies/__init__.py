"""Studies: analyses that require many predictions or simulations."""
