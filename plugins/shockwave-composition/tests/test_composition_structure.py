"""What the methods keep: the symplectic form, the way back, the energy over long times, the momentum."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from attrs import define
from shockwave.hooks import Attempt, OneStep

from shockwave_composition.blanes_moan import BlanesMoan4, BlanesMoan6, BlanesMoan6Long
from shockwave_composition.verlet_richardson import VerletRichardson

SPLITTING = [BlanesMoan4, BlanesMoan6, BlanesMoan6Long]
GRANULES, SIZE = 4, 0.3

splitting = pytest.mark.parametrize("method", SPLITTING, ids=lambda method: method.name)


@define
class Rk4(OneStep):
    """The classical method of Runge and Kutta, which is not symplectic."""

    name = "rk4"
    order = 4
    adaptive = False

    def attempt(self, acceleration: Any, time: Any, size: Any, x: Any, v: Any, a: Any) -> Attempt:
        middle, end = time + size / 2, time + size
        v2, a2 = v + size / 2 * a, acceleration(middle, x + size / 2 * v)
        v3, a3 = v + size / 2 * a2, acceleration(middle, x + size / 2 * v2)
        v4, a4 = v + size * a3, acceleration(end, x + size * v3)
        x = x + size / 6 * (v + 2 * v2 + 2 * v3 + v4)
        v = v + size / 6 * (a + 2 * a2 + 2 * a3 + a4)
        return Attempt(x, v, acceleration(end, x), 0.0)


def _compressed(time: Any, x: np.ndarray) -> np.ndarray:
    """Eq. (1) for granules between walls, pressed together by 1, with a force that depends on the time."""
    overlaps = 1 - np.diff(x, prepend=0.0, append=0.0)
    force = overlaps**1.5
    acceleration = force[:-1] - force[1:]
    acceleration[0] += np.sin(2 * time)
    return acceleration


def _state() -> tuple[np.ndarray, np.ndarray]:
    return np.array([0.1, -0.05, 0.2, 0.0]), np.array([0.3, -0.2, 0.1, 0.4])


def _jacobian(method: type[OneStep]) -> np.ndarray:
    """Derivative of a step by the state, exact to rounding: the step of a state moved by 1e-30 i."""
    columns = []
    for index in range(2 * GRANULES):
        moved = np.concatenate(_state()).astype(complex)
        moved[index] += 1e-30j
        x, v = moved[:GRANULES], moved[GRANULES:]
        x, v, *_ = method().attempt(_compressed, 0.4, SIZE, x, v, _compressed(0.4, x))
        columns.append(np.concatenate((x, v)).imag / 1e-30)
    return np.array(columns).T


def _form_defect(method: type[OneStep]) -> float:
    unit, nothing = np.eye(GRANULES), np.zeros((GRANULES, GRANULES))
    form = np.block([[nothing, unit], [-unit, nothing]])
    jacobian = _jacobian(method)
    return float(np.max(np.abs(jacobian.T @ form @ jacobian - form)))


@splitting
def test_a_step_keeps_the_symplectic_form(method: type[OneStep]) -> None:
    # the rounding of some hundred operations
    assert _form_defect(method) < 1e-13


@pytest.mark.parametrize("method", [VerletRichardson, Rk4], ids=lambda method: method.name)
def test_other_methods_do_not(method: type[OneStep]) -> None:
    assert _form_defect(method) > 1e-9


def _there_and_back(method: type[OneStep]) -> float:
    """How far from the beginning a step leads that is taken back from its end."""
    x, v = _state()
    there = method().attempt(_compressed, 0.4, SIZE, x, v, _compressed(0.4, x))
    back = method().attempt(_compressed, 0.4 + SIZE, -SIZE, *there[:3])
    return float(np.max(np.abs(np.subtract(back[:2], (x, v)))))


@splitting
def test_a_step_backwards_returns_to_the_initial_state(method: type[OneStep]) -> None:
    # rounding
    assert _there_and_back(method) < 1e-14


@splitting
def test_a_run_with_velocities_turned_round_returns(method: type[OneStep]) -> None:
    def pendulums(_: Any, x: np.ndarray) -> np.ndarray:
        return -np.sin(x)

    *_, there = method(size=0.2).steps(pendulums, 0.0, 20.0, *_state(), None)
    *_, back = method(size=0.2).steps(pendulums, 0.0, 20.0, there.x, -there.v, None)
    # rounding grows with the time, the error of the method does not come in: it is 1e-6 and more
    assert np.allclose((back.x, -back.v), _state(), rtol=0, atol=1e-12)


def test_a_step_of_another_kind_does_not_lead_back() -> None:
    assert _there_and_back(Rk4) > 1e-9


def _drift(method: type[OneStep], size: float) -> float:
    """Change of a pendulum's mean energy from the first tenth of 2000 units of time to the last."""
    integrator = method(size=size)
    run = integrator.steps(lambda _, x: -np.sin(x), 0.0, 2000.0, np.array([2.0]), np.zeros(1), None)
    energies = np.array([step.v[0] ** 2 / 2 - np.cos(step.x[0]) for step in run])
    tenth = len(energies) // 10
    return abs(float(np.mean(energies[-tenth:]) - np.mean(energies[:tenth])))


@splitting
def test_energy_does_not_drift(method: type[OneStep]) -> None:
    # what the swing within a period leaves in means over periods that are not complete
    assert _drift(method, 0.5) < 2e-7


def test_energy_drifts_in_a_method_that_is_not_symplectic() -> None:
    assert _drift(Rk4, 0.2) > 1e-3


@pytest.mark.parametrize("method", [*SPLITTING, VerletRichardson], ids=lambda method: method.name)
def test_momentum_is_kept_to_rounding(method: type[OneStep]) -> None:
    def hertz(_: Any, x: np.ndarray) -> np.ndarray:
        force = np.maximum(x[:-1] - x[1:], 0.0) ** 1.5
        return np.append(0.0, force) - np.append(force, 0.0)

    v = np.zeros(12)
    v[0] = 1.0
    *_, last = method(tolerance=1e-6).steps(hertz, 0.0, 8.0, np.zeros(12), v, None)
    assert np.sum(last.v) == pytest.approx(1.0, abs=1e-13)
