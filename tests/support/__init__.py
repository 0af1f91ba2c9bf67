"""References and generators that tests and the scripts in ``research`` share."""
