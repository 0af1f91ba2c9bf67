"""Input and output of the integration of a chain of mixed granules, as arrays that the compiled code shares."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

from attrs import frozen

from shockwave.quadrature import FloatArray
from shockwave.simulation.general_nystroem import GeneralTableau
from shockwave.simulation.problem import ChainProblem


class Status(IntEnum):
    """Status of a run."""

    RUNNING = 0
    DONE = 1
    TOO_LONG = 2
    FAILED = 3


@frozen(eq=False)
class Job:
    """Input and output of a run, as arrays that the compiled code shares.

    Row j of an array with a row for each body belongs to contact j, between bodies j and j + 1; the last one is the
    contact with the wall, the spring of a movable end, or none.

    Attributes
    ----------
    method : GeneralTableau
    problem : ChainProblem or None
        The applied force.
    law : object or None
        Contact law of a plugin.
    settings : array, shape (15,)
        Exponent, damping power, tolerance, until (infinite: found by the run), duration, rise time and peak force,
        first step, longest step under force, number of contacts, stiffness and damping of the end, most steps, most
        work, damped.
    chain : array, shape (9, bodies)
        Inverse masses, stiffnesses, gaps (zero or negative), static overlaps, their roots, static forces, damping
        coefficients, and the least fractions of closing velocity and overlap expected of a contact, over those of the
        contact before.
    x, v : array, shape (bodies + 1,)
        State; the last value is the wall.
    scales : array, shape (2, bodies)
        Closing velocities and overlaps to which the errors are compared.
    peaks : array, shape (2, bodies)
        Greatest force minus static force, and its time.
    sums : array, shape (2, bodies)
        Impulse, and dissipated energy.
    stops, times : array
        Kinks of the applied force; times of samples.
    samples : array, shape (times, 3, bodies + 1)
        x, v and total forces.
    found : array, shape (6,)
        Status, time, arrival (negative: none), work, steps, evaluations.
    """

    method: GeneralTableau
    problem: ChainProblem | None
    law: Any
    settings: FloatArray
    chain: FloatArray
    x: FloatArray
    v: FloatArray
    scales: FloatArray
    peaks: FloatArray
    sums: FloatArray
    stops: FloatArray
    times: FloatArray
    samples: FloatArray
    found: FloatArray
