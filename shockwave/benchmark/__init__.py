"""Work and precision: what accuracy costs, for quadratures, predictors, integrators and codes made elsewhere."""

from __future__ import annotations
