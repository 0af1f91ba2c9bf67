"""Collisions: granules that are thrown back, and granules that meet again."""

from __future__ import annotations

import numpy as np

from shockwave.benchmark.stress.case import Case, Finding
from shockwave.benchmark.stress.checks import by_method, faults_of, told
from shockwave.benchmark.stress.scenes import FORCE, power, record
from shockwave.measurement.simulate import simulate
from shockwave.simulation.backend import Backend

__all__ = ["CASES"]

# What a blow throws back, over the velocity that it would give to a single granule.
_RECOILS = (-0.0710850, -0.0302738, -0.0158334, -0.0088857)


def _thrown_back(backend: Backend) -> Finding:
    """Eight granules fly backwards; the first four are known to seven digits."""
    rise_time = 1e-4
    result = simulate(*power(1e-5, 50.0, 1.5, rise_time)(), backend=backend)
    shock = result.shock
    velocity = shock.profile.areas("tanh-sinh").total * shock.rise_time * FORCE / result.chain.granule_mass
    found = np.array(result.recoil_velocities[: len(_RECOILS)]) / velocity
    error = float(np.abs(found / _RECOILS - 1).max()) if len(found) == len(_RECOILS) else 1.0
    bound, faults = 2e-5, faults_of(result)
    if not error <= bound:
        faults.append(f"velocities over that of a single granule are {found.tolist()}")
    shown = ", ".join(f"{share:.6f}" for share in found)
    return Finding(
        outcome=f"{result.ejected_granules} thrown back, at {shown} of the velocity of a single one",
        error=error,
        bound=bound,
        momentum_defect=result.momentum_defect,
        faults=tuple(faults),
    )


def _meeting_again(backend: Backend) -> Finding:
    """What waves, recoil and slow granules carry is the impulse: granules that met were not lost."""
    make = power(1.0, 1.0, 2.0, 1.5, granules=60)
    result = simulate(*make(), backend=backend)
    spalls = result.spall_velocities or ()
    carried = result.chain.granule_mass * sum(spalls) + result.recoil_momentum
    # left out are granules slower than a thousandth of the fastest; the last before them are hardly faster
    error, bound = abs(carried / result.applied_momentum - 1), 1e-3
    faults = faults_of(result)
    if not error <= bound:
        faults.append(f"granules that fly apart carry {carried:g} N s of {result.applied_momentum:g} N s")
    return Finding(
        outcome=f"{len(spalls)} granules fly off the end, {told(result)}",
        error=error,
        bound=bound,
        momentum_defect=result.momentum_defect,
        faults=tuple(faults),
    )


CASES = (
    Case(
        name="steep-decay",
        theme="collisions",
        asked="a pulse that is gone at once, eta2 50 and t0/T0 1e-4: it throws several granules back",
        must="recoil at 7.10850, 3.02738, 1.58334 and 0.88857 % of the velocity of a single granule, to 2e-5",
        check=_thrown_back,
    ),
    Case(
        name="recollisions",
        theme="collisions",
        asked="three blows, 3 and 5 natural times apart, on granules that fly back from the one before",
        must="the peak force of DOP853 to 2e-6",
        check=by_method(record([0, 0.1, 0.2, 3, 3.1, 3.2, 8, 8.1, 8.2], [0, 1, 0, 0, 0.8, 0, 0, 0.6, 0])),
    ),
    Case(
        name="chain-flies-apart",
        theme="collisions",
        asked="sixty granules, till they have met for the last time",
        must="all momentum with granules that fly apart, to 1e-3: slow ones are not listed",
        check=_meeting_again,
    ),
)
