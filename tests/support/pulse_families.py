"""Random profiles of several families, with seeded draws of their own."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

import shockwave as sw
from shockwave.base.numerics import FloatArray


def built_in(draw: np.random.Generator) -> sw.ShockProfile:
    """A power law, an exponential or a table."""
    kind, ratio = draw.choice(["power", "exponential", "table"]), 1 + 10 ** draw.uniform(-0.5, 1.5)
    if kind == "power":
        return sw.PowerLaw(
            rise_exponent=float(draw.choice([1e-5, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0])),
            decay_exponent=float(draw.choice([1, 1.5, 2, 3, 5, 8])),
            duration_ratio=ratio,
        )
    if kind == "exponential":
        rates = draw.uniform(0, 8, size=2)
        return sw.Exponential(rise_rate=rates[0], decay_rate=rates[1], duration_ratio=ratio)
    times = np.array([0.0, 0.0])
    while np.min(np.diff(times)) < 1e-3:
        times = np.concatenate(([0], np.sort(draw.uniform(0, 1, 3)), [1], np.sort(draw.uniform(1, ratio, 4)), [ratio]))
    rise, decay = np.sort(draw.uniform(0, 1, 3)), np.sort(draw.uniform(0, 1, 4))[::-1]
    return sw.Tabulated(times=times, forces=np.concatenate(([0], rise, [1], decay, [0])))


def single(draw: np.random.Generator) -> sw.ShockProfile:
    """A steep rise and a straight decay, the shape that forms one wave of the whole impulse most readily."""
    rise, ratio = draw.uniform(0, 0.6), 1 + draw.uniform(0.8, 3)
    return sw.PowerLaw(rise_exponent=rise, decay_exponent=draw.uniform(1, 1.3), duration_ratio=ratio)


# Rises and decays of kinds that are not built in, on 0 to 1; the second argument bends them.
_RISES: dict[str, Callable[[FloatArray, float], FloatArray]] = {
    "sine": lambda u, c: np.sin(np.pi / 2 * u),
    "haversine": lambda u, c: np.sin(np.pi / 2 * u) ** 2,
    "smooth step": lambda u, c: u * u * (3 - 2 * u),
    "circle": lambda u, c: np.sqrt(1 - (1 - u) ** 2),
    # a plateau that rises by so little that the peak is at its end
    "trapezoid": lambda u, c: np.minimum(1, u / (0.05 + 0.9 * c)) * (1 - 1e-9 * (1 - u)),
}
_DECAYS: dict[str, Callable[[FloatArray, float], FloatArray]] = {
    "haversine": lambda u, c: np.cos(np.pi / 2 * u) ** 2,
    "versed sine": lambda u, c: 1 - np.sin(np.pi / 2 * u),
    "blast": lambda u, c: (1 - u) * np.exp(-6 * c * u),
    "bell": lambda u, c: (1 - u) * np.exp(-2 * (6 * c * u) ** 2),
    "resonance": lambda u, c: (1 - u * u) / (1 + (8 * c * u) ** 2),
    "stretched": lambda u, c: (1 - u**4) * np.exp(-((5 * u) ** (0.4 + 1.1 * c))),
}


@attrs.frozen(eq=False)
class Composed(sw.ShockProfile):
    """A profile as in a plugin: a rise and a decay from above, without closed forms."""

    rising: str
    falling: str
    bend: float
    duration_ratio: float

    def rise(self, s: FloatArray) -> FloatArray:
        return np.clip(_RISES[self.rising](s, self.bend), 0, 1)

    def decay(self, s: FloatArray) -> FloatArray:
        return np.clip(_DECAYS[self.falling]((s - 1) / (self.duration_ratio - 1), self.bend), 0, 1)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        knee = (0.05 + 0.9 * self.bend,) if self.rising == "trapezoid" else ()
        return (0.0, *knee, 1.0, self.duration_ratio)


def composed(draw: np.random.Generator) -> sw.ShockProfile:
    """A profile of a kind that is not built in."""
    shape = str(draw.choice(list(_RISES))), str(draw.choice(list(_DECAYS)))
    return Composed(*shape, draw.uniform(0, 1), 1 + 10 ** draw.uniform(-0.3, 1.5))


def recorded(draw: np.random.Generator) -> sw.ShockProfile:
    """A record of 120 samples of such a profile, every other one with noise of 1 % of the force."""
    profile = composed(draw)
    times = np.concatenate((np.linspace(0, 1, 60), np.linspace(1, profile.duration_ratio, 61)[1:]))
    forces = profile.force(times)
    if draw.random() < 0.5:
        forces *= 1 + 0.01 * draw.uniform(-1, 1, len(forces))
    return sw.Tabulated(times=times, forces=forces)


FAMILIES = {"built-in": built_in, "single": single, "composed": composed, "recorded": recorded}
