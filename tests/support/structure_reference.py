"""Motion of the movable end of a chain, by an independent integration with DOP853 of SciPy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import shockwave as sw
from shockwave.scene.layout import Layout

# Longest step [s]: contacts open and close within it.
STEP = 1e-6
SAMPLES = 20_001
# Intervals of a sample in which a maximum is sampled again.
FINER = 401
Array = NDArray[np.float64]


def greatest_motion(impact: sw.Impact, chain: sw.Chain, end: float) -> dict[str, float]:
    """Greatest displacement, acceleration and spring force of a movable wall until the time ``end`` [s]."""
    layout, wall = Layout.of(chain, impact), chain.end
    assert wall is not None
    assert wall.mass is not None
    masses, bodies = np.append(layout.masses, wall.mass), len(layout.masses) + 1

    def spring(x: Array, v: Array) -> Array:
        return wall.stiffness * x + wall.damping * v

    def rates(_: float, state: Array) -> Array:
        x, v = state[..., :bodies], state[..., bodies:]
        closed = np.maximum(layout.overlaps + x[..., :-1] - x[..., 1:], 0.0)
        damping = layout.damping_coefficients * closed**layout.damping_powers * (v[..., :-1] - v[..., 1:])
        forces = np.maximum(layout.pairs.stiffnesses * closed**1.5 + damping, 0.0) - layout.static_forces
        net = np.zeros(x.shape)
        net[..., 0] = layout.weight
        net[..., 1:] += forces
        net[..., :-1] -= forces
        net[..., -1] -= spring(x[..., -1], v[..., -1])
        return np.concatenate((v, net / masses), axis=-1)

    start = np.zeros(2 * bodies)
    start[bodies] = layout.velocity
    solution = solve_ivp(
        rates, (0, end), start, method="DOP853", rtol=1e-12, atol=1e-18, max_step=STEP, dense_output=True
    )

    def motion(times: Array) -> Array:
        states = solution.sol(times)
        accelerations = rates(0.0, states.T)[:, -1]
        x, v = states[bodies - 1], states[-1]
        return np.abs([x, accelerations, spring(x, v)])

    times = np.linspace(0, end, SAMPLES)
    greatest = []
    for row, top in enumerate(motion(times).argmax(axis=1).tolist()):
        near = np.linspace(times[max(top - 1, 0)], times[min(top + 1, SAMPLES - 1)], FINER)
        greatest.append(float(motion(near)[row].max()))
    return dict(zip(("peak_displacement", "peak_acceleration", "peak_spring_force"), greatest, strict=True))
