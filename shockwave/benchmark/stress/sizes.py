"""Sizes: forces, radii, moduli and times at the ends of what numbers hold. The scaled problem is the same."""

from __future__ import annotations

from typing import Any

from shockwave.benchmark.stress.case import Case
from shockwave.benchmark.stress.checks import against, by_law, by_method, like, refused
from shockwave.benchmark.stress.scenes import Make, power, sized
from shockwave.errors import InvalidValueError, NumericalError
from shockwave.measurement.result import SimulationResult
from shockwave.measurement.simulate import simulate
from shockwave.simulation.backend import Backend

__all__ = ["CASES"]

_OUT_OF_RANGE = "rise_time: must be 1e-30 to 1e+12 times"
_SIZES: dict[str, tuple[str, dict[str, float]]] = {
    "force-1e-15": ("a peak force of 1e-15 N", {"force": 1e-15}),
    "force-1e12": ("a peak force of 1e12 N", {"force": 1e12}),
    "radius-1e-9": ("granules of 1 nm", {"radius": 1e-9}),
    "radius-1e3": ("granules of 1 km", {"radius": 1e3}),
    "modulus-1": ("E 1 Pa", {"modulus": 1.0}),
    "modulus-1e15": ("E 1e15 Pa", {"modulus": 1e15}),
    "poisson-minus-0.99": ("nu -0.99", {"ratio": -0.99}),
    "poisson-0.4999": ("nu 0.4999", {"ratio": 0.4999}),
    "small-weak-stiff": (
        "1e-15 N on granules of 1 nm, E 1e15 Pa",
        {"force": 1e-15, "radius": 1e-9, "modulus": 1e15},
    ),
    "small-strong-soft": ("1e12 N on granules of 1 nm, E 1 Pa", {"force": 1e12, "radius": 1e-9, "modulus": 1.0}),
    "large-strong-soft": ("1e12 N on granules of 1 km, E 1 Pa", {"force": 1e12, "radius": 1e3, "modulus": 1.0}),
    # products of two such energies, or of an energy and a mass, are no numbers any more
    "subnormal-products": (
        "1e-117 N on granules of 1e-12 m, E 1 TPa: energies of 1e-198 J",
        {"force": 1e-117, "radius": 1e-12, "modulus": 1e12},
    ),
}


def _scaled(name: str) -> Case:
    asked, changes = _SIZES[name]
    return Case(
        name=name,
        theme="sizes",
        asked=asked,
        must="amplification and prediction of the paper's beads at the same t0/T0, to 1e-12",
        check=like(lambda: sized(**changes), sized, 1e-12),
    )


def _simulated(**changes: Any) -> Any:
    def call(backend: Backend) -> SimulationResult:
        return simulate(*sized(**changes), backend=backend, waves="primary")

    return call


def _no_size(name: str, asked: str, words: str, theme: str = "sizes", **changes: float) -> Case:
    call = _simulated(**changes)
    must = f"InvalidValueError: '{words}'"
    return Case(name=name, theme=theme, asked=asked, must=must, check=refused(call, InvalidValueError, words))


_REFUSED = (
    _no_size("energy-underflow", "a peak force of 1e-150 N", "energy that a floating-point number", force=1e-150),
    _no_size("energy-overflow", "a peak force of 1e200 N", "energy that a floating-point number", force=1e200),
    _no_size("no-mass", "granules of 1e-200 m", "mass that a floating-point number", radius=1e-200),
    _no_size("poisson-0.5", "nu 0.5, incompressible granules", "poisson_ratio: must be > -1 and < 0.5", ratio=0.5),
    _no_size("infinite-force", "an infinite peak force", "peak_force: must give waves an energy", force=float("inf")),
)


def _short(name: str, asked: str, make: Make) -> Case:
    must = "the law of short shocks to 1e-6, for any shape"
    return Case(name=name, theme="durations", asked=asked, must=must, check=by_law(make))


def _long(name: str, asked: str, pulse: tuple[float, float], reference: float) -> Case:
    ratio, rise_time = pulse
    return Case(
        name=name,
        theme="durations",
        asked=asked,
        # a force that is switched on for ever comes to about 2.33 F0
        must=f"{reference:.7f} F0 to 1e-6, as the method of order 12 finds at rtol 1e-8",
        check=against(power(1.0, 1.0, ratio, rise_time), reference, 1e-6, waves="primary"),
        limit=120.0,
        slow=True,
    )


_DURATIONS = (
    *(
        _short(f"rise-time-{time:g}", f"t0/T0 {time:g}, eta1 0.5, n 3", power(0.5, 1.0, 3.0, time))
        for time in (1e-30, 1e-12, 1e-6)
    ),
    _short("sharp-and-short", "t0/T0 1e-4, eta1 and eta2 1e6", power(1e6, 1e6, 3.0, 1e-4)),
    Case(
        name="rise-time-10",
        theme="durations",
        asked="t0/T0 10, eta1 0.5, n 3",
        must="the peak force of DOP853 to 2e-6",
        check=by_method(power(0.5, 1.0, 3.0, 10.0), waves="primary"),
        slow=True,
    ),
    _long("rise-time-100", "t0/T0 100, triangle, n 1.5: a train of hundreds of waves", (1.5, 100.0), 2.2133460),
    _long("rise-time-1000", "t0/T0 1000, triangle, n 1.2", (1.2, 1000.0), 2.2871662),
    Case(
        name="rise-time-1e4",
        theme="durations",
        asked="t0/T0 1e4, n 3: slower than any wave",
        must="NumericalError that says so",
        check=refused(
            lambda backend: simulate(*power(0.5, 1.0, 3.0, 1e4)(), backend=backend), NumericalError, "matter of statics"
        ),
    ),
    _no_size("rise-time-1e-31", "t0/T0 1e-31", _OUT_OF_RANGE, "durations", rise_time=1e-31),
    _no_size("rise-time-1e13", "t0/T0 1e13", _OUT_OF_RANGE, "durations", rise_time=1e13),
)


CASES = (*(_scaled(name) for name in _SIZES), *_REFUSED, *_DURATIONS)
