"""Chains: two and three granules, contacts far away, and slow forces that explicit methods need many steps for."""

from __future__ import annotations

from attrs import evolve

from shockwave.benchmark.stress.case import Case, Finding
from shockwave.benchmark.stress.checks import BOOK, by_method, faults_of, judged, like, refused
from shockwave.benchmark.stress.scenes import FORCE, UNITS, Make, power
from shockwave.chain.solitary_wave import SPEED
from shockwave.errors import InvalidValueError
from shockwave.measurement.simulate import plan_of, scaled, simulate
from shockwave.options import SimulateOptions
from shockwave.simulation.backend import Backend
from shockwave.simulation.primary import find_primaries

__all__ = ["CASES"]

_SHORT = 1e-6


def _two_after_a_blow(backend: Backend) -> Finding:
    """Half of the kinetic energy goes through the contact: 2/5 F^(5/3) = L^2/4 in units of mass and stiffness."""
    make = power(1.0, 1.0, 3.0, _SHORT, granules=2)
    result = simulate(*make(), backend=backend)
    impulse = 1.5 * _SHORT
    faults = []
    expected = FORCE * impulse * UNITS.time / result.chain.granule_mass
    if not result.spall_velocities or abs(result.spall_velocities[0] / expected - 1) > 1e-6:
        faults.append(f"the second granule should leave with {expected:g} m/s, the velocity of the first before")
    return judged(result, (5 / 8 * impulse**2) ** 0.6, 1e-6, "", *faults)


def _far_passage(backend: Backend) -> Finding:
    """At contact 1e5 the error of the peak force has gone into the speed, as its sixth part."""
    contact, make = 100_000, power(0.5, 1.0, 3.0, 2.0)
    result = simulate(*make(), backend=backend, contacts=[contact], waves="primary")
    tight = simulate(*make(), backend=backend, contacts=[contact], waves="primary", rtol=1e-11)
    time, reference = (each.passages[0].arrival_time for each in (result, tight))
    error = abs(time / reference - 1)
    faults = faults_of(result)
    bound = min(result.passages[0].error_estimate, 1e-6)
    if not error <= bound:
        faults.append(f"it arrives after {time:g} s, it should after {reference:g} s")
    shown = f"arrives after {time / UNITS.time:.9g} T0, known by the exact wave"
    return Finding(
        outcome=shown,
        error=error,
        bound=bound,
        momentum_defect=result.momentum_defect,
        faults=tuple(faults),
    )


def _integrated_passage(backend: Backend) -> Finding:
    """No limit is near enough for a doubt of nothing: the search goes on to the longest chain that it allows."""
    contact, bound = 15_000, 1e-8
    shock, chain = power(0.5, 1.0, 3.0, 2.0)()
    options = SimulateOptions(rtol=1e-8, backend=backend, waves="primary")
    known = simulate(shock, chain, rtol=1e-8, backend=backend, waves="primary")
    plan, (problem, scales) = plan_of(options), scaled(shock, chain)
    assert plan.search is not None
    request = evolve(plan.request(problem, contacts=(contact,)), doubt=1e-300)
    (walked,) = find_primaries([request], plan.search, plan.compiled)
    time = known.found.time + (contact - known.found.contact) / (SPEED * known.found.peak ** (1 / 6))
    faults = faults_of(known)
    if not walked.passages:
        return Finding(outcome=f"the front was lost at contact {walked.contact:g}", faults=("no passage was read",))
    error = abs(walked.passages[0].time / time - 1)
    if not error <= bound:
        faults.append(f"it arrives after {walked.passages[0].time:.9g}, the exact wave after {time:.9g}")
    if not walked.momentum_defect <= BOOK:
        faults.append(f"the book of momentum is open by {walked.momentum_defect:.1e} at the end")
    return Finding(
        outcome=f"arrives after {walked.passages[0].time * scales.time / UNITS.time:.9g} T0, {walked.steps:g} steps",
        error=error,
        bound=bound,
        momentum_defect=walked.momentum_defect,
        faults=tuple(faults),
    )


def _short_chain(name: str, asked: str, make: Make) -> Case:
    return Case(name=name, theme="chains", asked=asked, must="the peak force of DOP853 to 2e-6", check=by_method(make))


_CHAINS = (
    Case(
        name="two-granules-blow",
        theme="chains",
        asked="two granules, t0/T0 1e-6",
        must="the peak force of a collision of equal spheres, (5 L^2/8)^(3/5), to 1e-6; all velocity goes on",
        check=_two_after_a_blow,
    ),
    _short_chain("two-granules", "two granules, t0/T0 2", power(0.5, 1.0, 3.0, 2.0, granules=2)),
    _short_chain("three-granules", "three granules, t0/T0 2", power(0.5, 1.0, 3.0, 2.0, granules=3)),
    _short_chain("three-granules-blow", "three granules, t0/T0 1e-6", power(0.5, 1.0, 3.0, 1e-6, granules=3)),
    _short_chain("nine-granules", "nine granules: the free end is felt at once", power(1.0, 2.0, 4.0, 3.0, granules=9)),
    Case(
        name="billion-granules",
        theme="chains",
        asked="1e9 granules, the most there may be",
        must="the answer of a chain without end, to the last bit",
        check=like(power(0.5, 1.0, 3.0, 0.5, granules=10**9), power(0.5, 1.0, 3.0, 0.5), 0.0, waves="primary"),
    ),
    Case(
        name="one-granule",
        theme="chains",
        asked="a chain of one granule",
        must="InvalidValueError: it has no contact",
        check=refused(
            lambda backend: power(1.0, 1.0, 3.0, 1.0, granules=1)(),
            InvalidValueError,
            "granules: must be a whole number >= 2",
        ),
        twice=False,
    ),
)

_FAR = (
    Case(
        name="arrival-at-1e5",
        theme="far away",
        asked="when the primary passes contact 100 000",
        must="the time of a run at rtol 1e-11, to the error that is told and to 1e-6",
        check=_far_passage,
    ),
    Case(
        name="arrival-integrated",
        theme="far away",
        asked="contact 15 000, step by step and by the exact wave, at rtol 1e-8",
        must="the same time to 1e-8",
        check=_integrated_passage,
        limit=120.0,
        slow=True,
    ),
    Case(
        name="contact-beyond-the-end",
        theme="far away",
        asked="contact 99 of a chain of 100 granules, which has 99",
        must="InvalidValueError that tells the last",
        check=refused(
            lambda backend: simulate(*power(1.0, 1.0, 3.0, 1.0, granules=100)(), backend=backend).passage(99),
            InvalidValueError,
            "at most 98, the last of this chain",
        ),
    ),
)

# A push that takes 6000 natural times on three granules, whose two swings have periods of 6 and 3 of them at its peak.
# All methods follow the swings. The first contact passes on two thirds of a push that is slow. Found at rtol 1e-10 by
# the method of order 12, and at 1e-9 by DOP853, to the digits shown.
_SLOW_PUSH = power(2.0, 2.0, 2.0, 3000.0, granules=3)
_SLOW_PEAK = 0.66688428


def _stiff(method: str, kind: str, rtol: float) -> Case:
    known_to_c = method.startswith("rkn")

    def check(backend: Backend) -> Finding:
        code = backend if known_to_c else "auto"
        result = simulate(*_SLOW_PUSH(), integrator=method, rtol=rtol, backend=code)
        # the reference has eight digits
        return judged(result, _SLOW_PEAK, rtol + 1e-8, f"known to {result.error_estimate:.0e}")

    return Case(
        name=f"slow-push-{method}",
        theme="slow push",
        asked=f"6000 natural times on three granules, by {method} ({kind}) at rtol {rtol:g}",
        must=f"{_SLOW_PEAK} F0 to {rtol:g}",
        check=check,
        limit=120.0,
        slow=True,
        twice=known_to_c,
    )


CASES = (
    *_CHAINS,
    *_FAR,
    _stiff("rkn86", "explicit, for x'' = a", 1e-6),
    _stiff("dop853", "explicit, first-order system", 1e-6),
    _stiff("radau", "implicit", 1e-4),
)
