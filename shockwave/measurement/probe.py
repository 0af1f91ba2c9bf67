"""A probe: the history of one contact, and the wave that passes it."""

from __future__ import annotations

import numpy as np
from attrs import define, field, frozen

from shockwave.measurement.peaks import Peak, PeakLog
from shockwave.quadrature import FloatArray
from shockwave.simulation.march import Span

__all__ = ["PassingWave", "Probe"]

# Samples on each side of a crossing or a maximum that its polynomial goes through.
_NEIGHBOURS = 4
# Over how many contacts the speed is taken.
_SPEED_BASE = 4


@frozen
class PassingWave:
    """What one wave did at one contact, in scaled units.

    ``speed`` is None where only one contact was passed. ``foot`` is the force left between the wave and its
    neighbours, over its peak: momentum, energy and width are the wave's own to about as much.
    """

    contact: int
    time: float
    peak_force: float
    momentum: float
    energy: float
    speed: float | None
    width: float
    granule_velocity: float
    foot: float


@define
class Probe:
    """Samples of the force at ``contact`` and of the granule behind it, at Gauss nodes of every step."""

    contact: int
    _blocks: list[FloatArray] = field(factory=list)

    def observe(self, span: Span) -> None:
        """Sample ``span``, unless the contact has not been reached."""
        if self.contact + 1 >= len(span.x1) or not span.x1[self.contact]:
            return
        samples = span.samples
        pair = samples.x[:, self.contact : self.contact + 2]
        force = np.maximum(pair[:, 0] - pair[:, 1], 0.0) ** 1.5
        self._blocks.append(np.array((samples.times, force, samples.v[:, self.contact + 1], samples.weights)))

    def wave(self, peak: Peak, log: PeakLog) -> PassingWave:
        """The wave whose maximum at this contact is ``peak``: from the least force before it to the least after."""
        time, force, velocity, weight = np.concatenate(self._blocks, axis=1)
        others = [other.time for other in log.peaks[self.contact] if other.force > 0]
        before = max((t for t in others if t < peak.time), default=time[0])
        after = min((t for t in others if t > peak.time), default=time[-1])
        top = int(np.argmin(np.abs(time - peak.time)))
        left, right = int(np.searchsorted(time, before)), int(np.searchsorted(time, after))
        begin = left + int(np.argmin(force[left : top + 1]))
        end = top + int(np.argmin(force[top : max(right, top + 1)]))
        inside = slice(begin, end + 1)
        rise = _crossing(time[begin : top + 1], force[begin : top + 1], peak.force / 2)
        fall = _crossing(time[top : end + 1][::-1], force[top : end + 1][::-1], peak.force / 2)
        return PassingWave(
            contact=self.contact,
            time=peak.time,
            peak_force=peak.force,
            momentum=float(weight[inside] @ force[inside]),
            energy=float(weight[inside] @ (force[inside] * velocity[inside])),
            speed=_speed(log.history(peak, _SPEED_BASE)),
            width=fall - rise,
            granule_velocity=_maximum(time[inside], velocity[inside]),
            foot=float(max(force[begin], force[end])) / peak.force,
        )


def _speed(trail: list[Peak]) -> float | None:
    """Granules per unit of time, over the last contacts."""
    base = len(trail) - 1
    return None if base == 0 else base / (trail[0].time - trail[base].time)


def _crossing(time: FloatArray, force: FloatArray, level: float) -> float:
    """Time at which the rising samples pass ``level``, by inverse interpolation."""
    last = len(force) - int(np.argmax(force[::-1] < level)) if np.any(force < level) else 0
    if last in (0, len(force)):
        return float(time[0])  # the force jumps past the level between two samples
    near = slice(max(last - _NEIGHBOURS, 0), last + _NEIGHBOURS)
    ordinates, abscissae = force[near], time[near] - time[last]
    # Lagrange's polynomial of time as a function of force.
    values = [
        abscissa * np.prod([(level - other) / (own - other) for other in ordinates if other != own])
        for own, abscissa in zip(ordinates, abscissae, strict=True)
    ]
    return float(time[last] + np.sum(values))


def _maximum(time: FloatArray, values: FloatArray) -> float:
    """Greatest value of a smooth function, from a polynomial through the samples around the greatest."""
    top = int(np.argmax(values))
    near = slice(max(top - _NEIGHBOURS, 0), top + _NEIGHBOURS + 1)
    if len(values[near]) < 2 * _NEIGHBOURS + 1:
        return float(values[top])
    origin, scale = time[top], time[near][-1] - time[near][0]
    fit = np.polynomial.Polynomial.fit((time[near] - origin) / scale, values[near], 2 * _NEIGHBOURS - 2)
    roots = [root.real for root in fit.deriv().roots() if abs(root.imag) < 1e-9 and abs(root.real) <= 1]
    return float(max((fit(root) for root in roots), default=values[top]))
