"""Chains of any contacts by the classical Runge-Kutta method with fixed steps: slow and independent of the engine."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from shockwave.base.numerics import FloatArray
from shockwave.engine.chain_assembly import Assembly


class FixedStepRun(NamedTuple):
    """Greatest forces at the ends of the steps, and the state at the end."""

    forces: FloatArray
    x: FloatArray
    v: FloatArray


def loading(chain: Assembly, d: FloatArray, w: FloatArray) -> FloatArray:
    """The published loading curve of elastic-plastic contacts, at most Hertz's force."""
    law, plastic = chain.plastic.loading, chain.plastic
    strengths, radii = np.where(np.isinf(law.strengths), 0.01, law.strengths), law.radii
    q = strengths * np.maximum(1.0, 1 + plastic.rates * np.log(np.maximum(w / plastic.speeds, 1.0)))
    modulus, fitted = 0.75 * law.stiffnesses / np.sqrt(radii), 1.5875e-3
    first, full = radii / 4 * (1.6 * np.pi * q) ** 2, (0.0067 * q - 3.082e-6) * radii / fitted
    pressure = np.pi * (5.487 - 5.972 * q**0.1637) * q * modulus
    area = (3.999e-9 - 4.104e-6 * q) * (radii / fitted) ** 2
    low, high = law.stiffnesses * np.sqrt(first), pressure * (2 * radii + area / full)
    logs = np.log(np.maximum(d, 1e-300) / first) / np.log(full / first)
    force = np.where(d > full, pressure * (2 * radii * d + area), d * (low + (high - low) * logs))
    hertz = law.stiffnesses * d**1.5
    return np.where(d <= first, hertz, np.minimum(force, hertz))


def unloading(chain: Assembly, d: FloatArray, reached: FloatArray, force: FloatArray) -> FloatArray:
    """The force of unloading from a point that a contact has reached."""
    law = chain.plastic.loading
    strengths = np.where(np.isinf(law.strengths), 1e9, law.strengths)
    modulus, radii = 0.75 * law.stiffnesses / np.sqrt(law.radii), law.radii
    first = law.stiffnesses * (radii / 4 * (1.6 * np.pi * strengths) ** 2) ** 1.5
    beyond = np.maximum(force, first)
    flat = 4 * modulus / (3 * beyond) * ((2 * beyond + first) / (3.2 * np.pi * strengths * modulus)) ** 1.5
    stiffness = 4 / 3 * modulus * np.sqrt(flat)
    left = reached - (beyond / stiffness) ** (2 / 3)
    return np.where(force > first, stiffness * np.maximum(d - left, 0.0) ** 1.5, law.stiffnesses * d**1.5)


def runge_kutta(chain: Assembly, until: float, size: float) -> FixedStepRun:
    """The motion of a chain to the time ``until`` with steps of at most ``size``."""
    steps = int(np.ceil(until / size))
    h, bodies, contacts = until / steps, len(chain.inverse_masses), len(chain.overlaps)
    greatest, static = np.zeros(contacts), chain.static_forces
    reached, held = np.maximum(chain.overlaps, 0.0), static.copy()
    yields = np.zeros(contacts, dtype=bool) if chain.plastic is None else np.isfinite(chain.plastic.loading.strengths)

    def forces(y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        x, v = np.append(y[0], 0.0), np.append(y[1], 0.0)
        d, w = chain.overlaps + (x[:-1] - x[1:])[:contacts], (v[:-1] - v[1:])[:contacts]
        closed = np.maximum(d, 0.0)
        f = chain.stiffnesses * closed**chain.exponents + chain.damping * closed**chain.damping_powers * w
        f = np.where(d > 0, np.maximum(f, 0.0), 0.0)
        if not yields.any():
            return f, d, yields
        elastic = unloading(chain, closed, reached, held)
        flow = np.maximum(held, loading(chain, closed, w))
        flows = yields & (w > 0) & (flow <= elastic)
        return np.where(flows, flow, np.where(yields, elastic, f)), d, flows

    def rates(time: float, y: FloatArray) -> FloatArray:
        f = np.zeros(bodies + 1)
        f[1 : contacts + 1] = forces(y)[0] - static
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
        f, d, flows = forces(y)
        reached, held = np.where(flows, d, reached), np.where(flows, f, held)
        greatest = np.maximum(greatest, f)
    return FixedStepRun(greatest, *y)
