"""The explorer of shockwave: a page with sliders on loopback."""
