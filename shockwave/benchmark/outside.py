"""Codes made elsewhere on the same problem, each behind a small adapter; what is not installed says so.

An adapter makes a solver of the whole chain; compilation happens there, before anything is timed.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import numpy as np
from attrs import frozen
from scipy.integrate import DOP853, RK45, Radau
from scipy.sparse import block_array, diags_array

from shockwave.benchmark.chains import Case, Reading
from shockwave.benchmark.spheres import lammps_run
from shockwave.benchmark.timing import Clock, Limits, Tried, tried
from shockwave.benchmark.whole import Piece, Whole
from shockwave.errors import NumericalError
from shockwave.quadrature import FloatArray

__all__ = ["CODES", "SCIPY", "Code", "ladder"]

Run = Callable[[float, Clock], Reading]

_FAULTS = (Exception, SystemExit)
# Below this SciPy takes no relative tolerance.
_LEAST_RELATIVE = 3e-14
# At rest a solver that looks for a first step finds none.
_FIRST = 1e-6
_TOLERANCES = tuple(10.0**-power for power in range(3, 13))
_QUICK = (1e-3, 1e-6, 1e-9)
_STEPS, _QUICK_STEPS = (0.08, 0.04, 0.02, 0.01, 0.005), (0.08, 0.04)
# The most steps of CyRK; steps for which diffrax keeps room, the least of them for an interval so short.
_MOST_STEPS, _ROOMS, _SHORT = 20_000, (64, 512, 1536), 4.0
# Evaluations of a step, of which the last is the first of the next; and how near to its end a run must come.
_DOPRI8_STAGES, _JOINED = 13, 1e-9


@frozen(eq=False)
class Code:
    """A code made elsewhere: what it is called, the module that must be there, what it is set by, and its runs.

    ``prepare`` compiles what is to be compiled; in a quick round only codes that are ``quick`` to prepare are run.
    """

    name: str
    module: str
    prepare: Callable[[Whole], Run]
    setting: str = "tolerance"
    settings: tuple[float, ...] = _TOLERANCES
    quick: tuple[float, ...] = _QUICK


def ladder(code: Code, case: Case, due: float, limits: Limits, quick: bool) -> Iterator[Tried[Any, Reading]]:
    """The code at each of its settings; one entry that says why, where it cannot be run.

    ``due`` is when the front peaks at the contact, in scaled units.
    """
    if quick and not code.quick:
        yield Tried(None, problem="left out of a quick round: compiling takes too long")
        return
    try:
        importlib.import_module(code.module)
    except ModuleNotFoundError:
        yield Tried(None, problem="not installed")
        return
    except _FAULTS as error:
        yield Tried(None, problem=f"cannot be imported: {type(error).__name__}: {error}"[:200])
        return
    try:
        run = code.prepare(Whole(case, due))
    except NumericalError as error:
        yield Tried(None, problem=str(error))
        return
    except _FAULTS as error:
        yield Tried(None, problem=f"cannot be prepared: {type(error).__name__}: {error}"[:200])
        return
    yield from tried(code.quick if quick else code.settings, run, limits)


# ---------------------------------------------------------------- SciPy


def _scipy(method: Any) -> Callable[[Whole], Run]:
    def prepare(whole: Whole) -> Run:
        more: dict[str, Any] = {"jac_sparsity": _pattern(whole.granules)} if method is Radau else {}

        def run(tolerance: float, clock: Clock) -> Reading:
            def solve(begin: float, end: float, state: FloatArray, tolerance: float) -> Piece:
                relative = max(tolerance, _LEAST_RELATIVE)
                first = min(_FIRST, end - begin)
                solver = method(whole.rates, begin, state, end, rtol=relative, atol=tolerance, first_step=first, **more)
                times, states = [begin], [state]
                while solver.status == "running":
                    clock.check()
                    message = solver.step()
                    if message is not None:
                        raise NumericalError(message)
                    times.append(solver.t)
                    states.append(solver.y)
                return Piece(np.array(times), np.array(states), solver.nfev)

            with np.errstate(over="ignore", invalid="ignore"):
                return whole.run(solve, tolerance, clock)

        return run

    return prepare


def _pattern(granules: int) -> Any:
    """Where the Jacobian is not zero."""
    shape = (granules, granules)
    velocities = diags_array([1.0], offsets=[0], shape=shape)
    neighbours = diags_array([1.0, 1.0, 1.0], offsets=[-1, 0, 1], shape=shape)
    return block_array([[None, velocities], [neighbours, None]], format="csc")


# ---------------------------------------------------------------- CyRK


def _compiled_rates() -> Callable[..., None]:
    """The right-hand side for numba; ``args`` are those of a `PowerPulse`, and the number of granules."""

    def rates(dy, t, y, args):  # type: ignore[no-untyped-def]
        granules = int(args[5])
        s = t / args[0]
        if s <= 1:
            before = args[4] * max(s, 0.0) ** args[2]
        else:
            before = args[4] * (max(args[1] - s, 0.0) / (args[1] - 1)) ** args[3]
        for i in range(granules):
            after = 0.0
            if i < granules - 1:
                overlap = max(y[i] - y[i + 1], 0.0)
                after = overlap * np.sqrt(overlap)
            dy[i] = y[granules + i]
            dy[granules + i] = before - after
            before = after

    return rates


def _cyrk(whole: Whole) -> Run:
    cyrk = importlib.import_module("CyRK")

    # The compiled function must live as long as its address is used.
    rates = cyrk.cyjit(_compiled_rates())
    args = np.array([*whole.power, whole.granules])

    def solve(begin: float, end: float, state: FloatArray, tolerance: float) -> Piece:
        relative = max(tolerance, _LEAST_RELATIVE)
        found = cyrk.nbsolve2_ivp(
            rates.address,
            (begin, end),
            np.ascontiguousarray(state),
            method="DOP853",
            args=args,
            rtol=relative,
            atol=tolerance,
            first_step=min(_FIRST, end - begin),
            max_num_steps=_MOST_STEPS,
        )
        try:
            if not found.success:
                raise NumericalError(str(found.message))
            states = np.array(found.y, dtype=float)
            times = np.array(found.t, dtype=float)
        finally:
            found.free()
        return Piece(times, states if len(states) == len(times) else states.T, None)

    def run(tolerance: float, clock: Clock) -> Reading:
        return whole.run(solve, tolerance, clock)

    _warm_up(run)
    return run


# ---------------------------------------------------------------- diffrax


def _traced_rates(whole: Whole, jnp: Any) -> Callable[[Any, Any, Any], Any]:
    """The right-hand side for JAX."""
    rise_time, ratio, rise, decay, peak = whole.power
    granules = whole.granules

    def rates(time: Any, state: Any, _: Any) -> Any:
        x, v = state[:granules], state[granules:]
        s = time / rise_time
        rising = jnp.maximum(s, 0.0) ** rise
        falling = (jnp.maximum(ratio - s, 0.0) / (ratio - 1)) ** decay
        load = peak * jnp.where(s <= 1, rising, falling)
        overlap = jnp.maximum(x[:-1] - x[1:], 0.0)
        force = jnp.concatenate([load[None], overlap * jnp.sqrt(overlap), jnp.zeros(1)])
        return jnp.concatenate([v, force[:-1] - force[1:]])

    return rates


def _diffrax(whole: Whole) -> Run:
    jax, jnp, diffrax = (importlib.import_module(name) for name in ("jax", "jax.numpy", "diffrax"))
    term, method, kept = (
        diffrax.ODETerm(_traced_rates(whole, jnp)),
        diffrax.Dopri8(),
        diffrax.SaveAt(t0=True, steps=True),
    )

    def solved(begin: Any, end: Any, state: Any, tolerance: Any, first: Any, room: int) -> Any:
        control = diffrax.PIDController(rtol=tolerance, atol=tolerance)
        found = diffrax.diffeqsolve(
            term, method, begin, end, first, state,
            stepsize_controller=control, saveat=kept, max_steps=room, throw=False,
        )  # fmt: skip
        return found.ts, found.ys, found.stats["num_accepted_steps"], found.stats["num_steps"]

    compiled = jax.jit(solved, static_argnums=5)

    def solve(begin: float, end: float, state: FloatArray, tolerance: float) -> Piece:
        relative, first = max(tolerance, _LEAST_RELATIVE), min(_FIRST, end - begin)
        # Room is filled whether it is used or not: as little as will do.
        for room in _ROOMS if end - begin < _SHORT else _ROOMS[1:]:
            times, states, accepted, tries = compiled(begin, end, jnp.asarray(state), relative, first, room)
            count = int(accepted) + 1
            if count > 1 and abs(float(np.asarray(times)[count - 1]) - end) <= _JOINED * end:
                return Piece(np.asarray(times)[:count], np.asarray(states)[:count], _DOPRI8_STAGES * int(tries))
        raise NumericalError(f"not finite, or more than {room} steps")

    def run(tolerance: float, clock: Clock) -> Reading:
        with jax.enable_x64(True):
            return whole.run(solve, tolerance, clock)

    _warm_up(run)
    # With the room that the tightest needs, too.
    _warm_up(lambda _, clock: run(_TOLERANCES[-1], clock))
    return run


def _warm_up(run: Run) -> None:
    """A run that compiles, and need not find anything."""
    with suppress(NumericalError):
        run(_QUICK[0], Clock(Limits(float("inf"), 0.0, 0), 0.0))


#: SciPy's explicit method of high order, which is always there.
SCIPY = Code("scipy DOP853", "scipy", _scipy(DOP853))
#: What is run beside the registered integrators.
CODES = (
    SCIPY,
    Code("scipy RK45", "scipy", _scipy(RK45), quick=(1e-3, 1e-6)),
    Code("scipy Radau", "scipy", _scipy(Radau), quick=(1e-3,)),
    Code("CyRK DOP853", "CyRK", _cyrk, settings=_TOLERANCES[:-2]),
    Code("diffrax Dopri8", "diffrax", _diffrax, quick=()),
    Code("LAMMPS granular hertz", "lammps", lammps_run, "step", _STEPS, _QUICK_STEPS),
)
