"""Compare random chains of mixed granules with SciPy's DOP853 at 1e-12.

    python docs/check_chain_engine.py

draws chains with a seed, integrates them at several tolerances, and prints for each the shares of chains whose forces
are within it and within their estimates. It takes about ten minutes; ``--count`` changes the number of chains.
"""

from __future__ import annotations

import argparse
import os
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from chain_reference import random_chain, reference

from shockwave.errors import NumericalError
from shockwave.simulation.assembly import ESTIMATE_FACTOR, integrate, tolerances_for

try:
    from shockwave.simulation import _chains as compiled
except ImportError:
    compiled = None

COUNT = 100
MOST = 20
RTOLS = (1e-4, 1e-6, 1e-8)
# End of the simulated time: later collisions amplify the errors of the reference.
LATEST = 20.0
# Accuracy of the reference, and fraction of the greatest force below which the wave has not arrived.
TRUST = 1e-9
ARRIVED = 1e-9


def errors(seed: int) -> list[tuple[float, float]]:
    """Largest relative error of the forces, and its estimate, for each tolerance."""
    chain = random_chain(seed, MOST)
    until = min(integrate(chain, 1e-3, compiled=compiled).end, LATEST)
    true = reference(chain, until).forces
    arrived = true > ARRIVED * true.max()
    found = []
    for rtol in RTOLS:
        fine, coarse = (integrate(chain, each, until=until, compiled=compiled) for each in tolerances_for(rtol))
        scale = np.maximum(true[arrived], 1e-6 * chain.static_forces[arrived])
        error = np.abs(fine.dynamic_forces - true)[arrived] / scale
        estimate = ESTIMATE_FACTOR * np.abs(fine.dynamic_forces - coarse.dynamic_forces)[arrived] / scale
        found.append((float(error.max()), float(estimate.max())))
    return found


def attempt(seed: int) -> list[tuple[float, float]] | str:
    """The errors, or the reason why there are none."""
    try:
        return errors(seed)
    except NumericalError as error:
        return f"chain {seed}: {error}"


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--count", type=int, default=COUNT)
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        found = list(pool.map(attempt, range(options.parse_args().count)))
    for reason in found:
        if isinstance(reason, str):
            print(reason)
    table = np.array([each for each in found if not isinstance(each, str)])
    print(f"{len(table)} chains; error of the reference about {TRUST:g}")
    for rtol, (error, estimate) in zip(RTOLS, table.transpose(1, 2, 0), strict=True):
        within, covered = error <= np.maximum(rtol, TRUST), error <= np.maximum(estimate, TRUST)
        print(f"rtol {rtol:g}: within rtol {within.mean():.3f}, within the estimate {covered.mean():.3f}")
        print(f"  error over rtol: median {np.median(error) / rtol:.2g}, worst {error.max() / rtol:.2g}")
        print(f"  worst chains: {[int(j) for j in np.argsort(error)[-3:]]}")


if __name__ == "__main__":
    main()
