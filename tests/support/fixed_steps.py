"""Chains of any contacts by the classical Runge-Kutta method with fixed steps: slow and independent of the engine."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from shockwave.base.numerics import FloatArray
from shockwave.engine.mixed_chain_assembly import Assembly


class Course(NamedTuple):
    """Greatest forces at the ends of the steps, and the state at the end."""

    forces: FloatArray
    x: FloatArray
    v: FloatArray


def runge_kutta(chain: Assembly, until: float, size: float) -> Course:
    """The motion of a chain to the time ``until`` with steps of at most ``size``."""
    steps = int(np.ceil(until / size))
    h, bodies, contacts = until / steps, len(chain.inverse_masses), len(chain.overlaps)
    greatest, static = np.zeros(contacts), chain.static_forces

    def forces(y: FloatArray) -> FloatArray:
        x, v = np.append(y[0], 0.0), np.append(y[1], 0.0)
        d = chain.overlaps + (x[:-1] - x[1:])[:contacts]
        closed = np.maximum(d, 0.0)
        f = chain.stiffnesses * closed**chain.exponents
        f += chain.damping * closed**chain.damping_powers * (v[:-1] - v[1:])[:contacts]
        return np.where(d > 0, np.maximum(f, 0.0), 0.0)

    def rates(time: float, y: FloatArray) -> FloatArray:
        f = np.zeros(bodies + 1)
        f[1 : contacts + 1] = forces(y) - static
        f[0] = chain.weight
        if contacts < bodies:
            f[-1] = chain.end_stiffness * y[0, -1] + chain.end_damping * y[1, -1]
        if chain.force is not None and time < chain.force.duration:
            around = np.clip([time - 1e-4, time + 1e-4], 0.0, chain.force.duration)
            f[0] += np.diff([chain.force.free(float(at))[1] for at in around])[0] / np.diff(around)[0]
        return np.array([y[1], chain.inverse_masses * (f[:-1] - f[1:])])

    y = np.zeros((2, bodies))
    y[1, 0] = chain.velocity
    for step in range(steps):
        time = step * h
        k1 = rates(time, y)
        k2 = rates(time + h / 2, y + h / 2 * k1)
        k3 = rates(time + h / 2, y + h / 2 * k2)
        k4 = rates(time + h, y + h * k3)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        greatest = np.maximum(greatest, forces(y))
    return Course(greatest, *y)
