"""Universal curves: for one shape of shock the primary depends on t0/T0 alone, so few simulations tell all of it."""

from shockwave.studies.curve.output import write
from shockwave.studies.curve.universal import CurveAnswer, UniversalCurve

__all__ = ["CurveAnswer", "UniversalCurve", "write"]
