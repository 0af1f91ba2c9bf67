"""Universal curves: for one shape of shock the primary depends on t0/T0 alone, so few simulations tell all of it."""

from shockwave.curve.output import write
from shockwave.curve.universal import CurveAnswer, UniversalCurve

__all__ = ["CurveAnswer", "UniversalCurve", "write"]
