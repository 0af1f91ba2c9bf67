"""Bounds of the forces after the simulated time, from the energy that is left then."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from shockwave.base.numerics import FloatArray, bracketed_root
from shockwave.base.text import round_bound, si
from shockwave.engine.chain_assembly import approaches
from shockwave.engine.chain_motion import ChainMotion
from shockwave.scene.force_limit import FALLING, UNBOUNDED, UNDAMPED
from shockwave.simulation.contact_setup import ChainSetup

# Time in which a second blow passes, over that of the arrival of the first.
_PASSED = 3.0

Flags: TypeAlias = npt.NDArray[np.bool_]


def offsets(case: ChainSetup, motion: ChainMotion) -> FloatArray:
    """Overlaps of the contacts in the initial state, less those at which they carry no force at the end, scaled."""
    residual = motion.residual_overlaps
    return case.assembly.overlaps if residual is None else case.assembly.overlaps - residual


def stiffnesses(case: ChainSetup, motion: ChainMotion) -> FloatArray:
    """Stiffnesses with which the contacts unload at the end, scaled."""
    plastic = case.assembly.plastic
    return case.assembly.stiffnesses if plastic is None else plastic.loading.unloading_stiffness(motion.forces)


def are_apart(x: FloatArray, v: FloatArray, overlaps: FloatArray) -> Flags:
    """Whether each contact between these bodies is open, and they do not approach each other."""
    gaps = x[1:] - x[:-1] - overlaps[: len(x) - 1]
    return np.asarray((gaps >= 0) & (v[:-1] <= v[1:]))


def later_force(case: ChainSetup, motion: ChainMotion) -> float:
    """Bound of the force at the last contact after the end of the simulated time [N]; infinite where none is known.

    The energy above that of the chain at rest, loaded by the weight of a striker, may all be stored in this contact,
    except that of bodies that move away from the others.
    """
    assembly, force, v = case.assembly, case.assembly.force, motion.v
    has_ended = force is None or motion.end >= force.duration
    # the energy of the law of a plugin is not known, and a wall without a spring gives way under the weight
    if not has_ended or assembly.law is not None or _gives_way(case):
        return math.inf
    masses, apart = 1 / assembly.inverse_masses, are_apart(motion.x, v, offsets(case, motion))
    static_forces, p = assembly.static_forces + assembly.weight, float(assembly.exponents[-1])
    # nothing holds the last body: a granule, or a wall without a spring
    flat = int(assembly.impedance > 0)  # of a bar: without mass, it stores no energy
    is_free = not (assembly.fixed_wall or assembly.end_stiffness or assembly.end_damping or flat)
    granules = len(v) if is_free else case.granules
    remains = v[:granules] > 0
    remains[:-1] |= ~apart[: granules - 1]
    first, last, frame = _first(remains), len(v) - flat, 0.0
    if static_forces.any():  # what it acts on returns; a striker without a weight does not
        first = min(first, int(force is None and not assembly.weight))
    elif is_free and first < last:  # what counts is the motion relative to that of the whole
        frame = _mean(v[first:], masses[first:])
        last -= _first(~(np.append(True, apart) & (v >= frame))[first:][::-1])
        frame = min(frame, _mean(v[first:last], masses[first:last]))
    kinetic = 0.5 * masses[first:last] * (v[first:last] - frame) ** 2
    energy = math.fsum(kinetic.tolist()) + _stored_energy(case, motion)
    k, static = float(stiffnesses(case, motion)[-1]), float(static_forces[-1])
    at_rest = (static / k) ** (1 / p)

    def excess(overlap: float) -> float:
        stored = k * (overlap ** (p + 1) - at_rest ** (p + 1)) / (p + 1) - static * (overlap - at_rest)
        return float(stored - energy)

    # half of the elastic energy at this overlap is enough for each of the two other terms
    upper = max((2 * (p + 1) / k * energy) ** (1 / (p + 1)), (2 * (p + 1)) ** (1 / p) * at_rest)
    overlap = max(((p + 1) / k * energy) ** (1 / (p + 1)), at_rest)
    if static and energy > 0:
        overlap = bracketed_root(excess, at_rest, upper, "the greatest later overlap")
    behind = case.granules - 1 - (not case.has_wall)
    closing = math.sqrt(2 * energy) * float(np.sum(np.sqrt(assembly.inverse_masses[behind : behind + 2 - flat])))
    damping = float(assembly.damping[-1]) * overlap ** float(assembly.damping_powers[-1]) * closing
    return float(case.scales.force * (k * overlap**p + damping))


def later_spring_force(case: ChainSetup, motion: ChainMotion) -> float:
    """Bound of the spring force after the end of the simulated time [N]; infinite where none is known.

    The greatest k x + c v for an energy E = k x^2/2 + M v^2/2 is sqrt(2 E (k + c^2/M)), beside the weight of a striker.
    Bodies that fly away from the wall bring none.
    """
    assembly, force, x, v = case.assembly, case.assembly.force, motion.x, motion.v
    if not assembly.movable_end:
        return 0.0
    if assembly.law is not None or _gives_way(case) or (force is not None and motion.end < force.duration):
        return math.inf
    away = are_apart(x, v, offsets(case, motion)) & (v[:-1] <= 0) & (not assembly.static_forces.any())
    first = int(np.argmin(np.append(away, False)))
    energy = math.fsum(motion.kinetic[first:]) + _stored_energy(case, motion)
    stiffness = assembly.end_stiffness + assembly.end_damping**2 * float(assembly.inverse_masses[-1])
    return float(case.scales.force * (math.sqrt(2 * energy * stiffness) + assembly.weight))


def later_remedy(case: ChainSetup, motion: ChainMotion, later: float) -> str:
    """What lowers the bound of the ``later`` force."""
    if _gives_way(case) and not case.assembly.impedance:
        return FALLING
    if later == math.inf and not case.is_undamped:
        unfinished = case.assembly.force is not None and motion.end < case.assembly.force.duration
        return later_end(case, motion) if unfinished else UNBOUNDED
    return UNDAMPED if case.is_undamped else later_end(case, motion, again=True)


def longer_time(end: float, wall: Any, least: float = 0.0) -> str:
    """The setting of a later ``end`` [s], by ``least`` and more than half a period of a movable wall on its spring."""
    half = math.pi * math.sqrt(wall.mass / wall.stiffness) if wall is not None and wall.stiffness else 0.0
    return f"set simulate.until: {si(round_bound(end + max(end, half, least), up=True, digits=1), 's')}"


def later_end(case: ChainSetup, motion: ChainMotion, again: bool = False) -> str:
    """The setting of a later end of a simulation; a shock ends before it.

    With ``again``, it is late enough for granules that fall back under gravity to strike the chain again.
    """
    end = motion.end if case.assembly.force is None else max(motion.end, case.assembly.force.duration)
    least = _time_of_fall(case, motion) + _PASSED * (motion.arrival or 0.0) * case.scales.time if again else 0.0
    return longer_time(end * case.scales.time, case.layout.wall, least)


def advice(case: ChainSetup, motion: ChainMotion, again: bool = False) -> str:
    """Hint in a warning of waves after the end of the simulated time; see `later_end`."""
    return "(without damping, waves never cease)" if case.is_undamped else f"({later_end(case, motion, again)})"


def _time_of_fall(case: ChainSetup, motion: ChainMotion) -> float:
    """Time after which the last granule above its initial place is back there under gravity [s]."""
    g, length = case.scene.chain.gravity, case.scales.energy / case.scales.force
    if not g:
        return 0.0
    up, height = -case.scales.velocity * motion.v[: case.granules], -length * motion.x[: case.granules]
    return max(float((up + np.sqrt(np.maximum(up * up + 2 * g * height, 0.0))).max()) / g, 0.0)


def _gives_way(case: ChainSetup) -> bool:
    """Whether a striker lies on a wall that nothing holds."""
    assembly = case.assembly
    return bool(assembly.weight) and not (assembly.fixed_wall or assembly.end_stiffness)


def _stored_energy(case: ChainSetup, motion: ChainMotion) -> float:
    """Elastic energy of contacts and end above that of the chain at rest under its static forces.

    Contacts that flow later only take from it. A spring at the end carries the weight of a striker.
    """
    assembly, k = case.assembly, stiffnesses(case, motion)
    static, powers = assembly.static_forces + assembly.weight, assembly.exponents + 1
    at_rest = (static / k) ** (1 / assembly.exponents)
    overlaps = offsets(case, motion) + approaches(motion.x)[: len(at_rest)]
    energies = k / powers * (np.maximum(overlaps, 0.0) ** powers - at_rest**powers) - static * (overlaps - at_rest)
    end = motion.end_energy
    if assembly.weight and not assembly.fixed_wall:
        end += assembly.weight * float(assembly.weight / (2 * assembly.end_stiffness) - motion.x[-1])
    return max(math.fsum(energies.tolist()), 0.0) + max(end, 0.0)


def _mean(v: FloatArray, masses: FloatArray) -> float:
    """Velocity of the centre of mass, at least 0."""
    return max(float(np.average(v, weights=masses)), 0.0) if len(v) else 0.0


def _first(marks: Flags) -> int:
    """Index of the first mark that is set; their number if there is none."""
    return int(np.argmax(marks)) if marks.any() else len(marks)
