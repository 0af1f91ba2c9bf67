"""Work and precision: what accuracy costs; and extreme cases with what must happen."""
