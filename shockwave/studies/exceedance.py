"""Probability that the force that leaves the chain exceeds a limit."""

from __future__ import annotations

import numpy as np

from shockwave.limit import Exceedance, LeavingForce, Limit, Verdict, verdict
from shockwave.quadrature import FloatArray
from shockwave.studies.sampling import estimates

# Draws that a fraction is uncertain by at least: with 95 % confidence an event seen never has a probability below 3/n.
_LEAST_DRAWS = 3.0
# Probabilities of the ends of the range of the verdict.
_RANGE = (0.01, 0.99)


def exceedance(limit: Limit, name: str, batches: FloatArray, error: float) -> tuple[Exceedance, Verdict]:
    """Probability and verdict for forces of shape (batches, draws of a batch) with this relative error.

    The range of the verdict contains 98 % of the scenes.
    """

    def share(factor: float) -> tuple[float, float]:
        """Fraction of the forces times a factor that reach the limit, and its sampling error."""
        value, sampling = estimates(lambda forces: np.mean(factor * forces >= limit.force), batches).tolist()
        return value, sampling

    least, most, (value, _) = share(1 - error), share(1 + error), share(1.0)
    floor = _LEAST_DRAWS / batches.size
    low, high = least[0] - max(least[1], floor), most[0] + max(most[1], floor)
    found = Exceedance(limit=limit.force, probability=value, low=max(low, 0.0), high=min(high, 1.0))
    middle, first, last = np.quantile(batches, [0.5, *_RANGE]).tolist()
    force = LeavingForce(
        name=name, value=middle, low=first * (1 - error), high=last * (1 + error), remedy="narrow the distributions"
    )
    return found, verdict(limit, force)
