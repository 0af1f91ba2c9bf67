"""Errors of section 4 against simulation for random shocks, and whether they lie in the ranges told.

    python tests/measure_trust.py --seed 33 --count 1000

prints, for each family of shocks and each regime, how many of ``count`` errors lie in the range that the outcome told,
how wide the ranges are, and how many shocks were told none. The draws are seeded, and by another program than those
from which the ranges were made.
"""

from __future__ import annotations

import argparse
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator

import attrs
import numpy as np

import shockwave as sw
from scenes import CHAIN, FORCE, UNITS
from shockwave.quadrature import FloatArray

#: Shocks are as long as these powers of ten, in natural times.
_SHORTEST, _LONGEST = -2.0, 1.75
_TOLERANCE = 1e-3


@attrs.frozen
class Verdict:
    """A shock's regime, the error, the range told or None, and what the simulation is in doubt of."""

    regime: str
    error: float
    told: tuple[float, float] | None
    doubt: float

    @property
    def holds(self) -> bool:
        """Whether the error lies in the range, as far as simulation knows it."""
        assert self.told is not None
        return self.told[0] - self.doubt <= self.error <= self.told[1] + self.doubt


# ---------------------------------------------------------------- families of shocks


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
    """A steep rise and a straight decay, which make one wave of the whole impulse if anything does."""
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
    """A profile such as a plugin brings: a rise and a decay from above, and no closed form."""

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


# ---------------------------------------------------------------- verdicts


def draws(family: str, seed: int) -> Iterator[tuple[sw.Shock, sw.Outcome]]:
    """Random shocks of a family that meet (3), without end, and what is predicted of them."""
    draw = np.random.default_rng(seed)
    while True:
        profile = FAMILIES[family](draw)
        duration = draw.uniform(2.2, 3.4) if family == "single" else 10 ** draw.uniform(_SHORTEST, _LONGEST)
        shock = sw.Shock.of_duration(profile=profile, peak_force=FORCE, duration=duration * UNITS.time)
        outcome = sw.Predictor().predict(shock, CHAIN)
        met = all(condition.holds for condition in outcome.conditions)
        if met and (family != "single" or outcome.regime == "single"):
            yield shock, outcome


def judge(pairs: list[tuple[sw.Shock, sw.Outcome]]) -> list[Verdict]:
    """What simulation says of shocks and their outcomes."""
    found = sw.simulate_many([shock for shock, _ in pairs], CHAIN, rtol=_TOLERANCE, waves="primary")
    verdicts = []
    for (_, outcome), result in zip(pairs, found, strict=True):
        if isinstance(result, sw.ShockwaveError):
            raise result
        error = outcome.peak_force / result.peak_force - 1
        doubt = (1 + error) * result.error_estimate
        verdicts.append(Verdict(outcome.regime, error, outcome.expected_error, doubt))
    return verdicts


def told(family: str, seed: int, count: int) -> tuple[list[Verdict], Counter[str]]:
    """Verdicts on ``count`` shocks that were told a range, and of each regime how many were drawn that were not."""
    chosen: list[tuple[sw.Shock, sw.Outcome]] = []
    untold: Counter[str] = Counter()
    for shock, outcome in draws(family, seed):
        if outcome.expected_error is None:
            untold[outcome.regime] += 1
        else:
            chosen.append((shock, outcome))
        if len(chosen) == count:
            break
    return judge(chosen), untold


def main() -> None:
    """Print the tally."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=33)
    parser.add_argument("--count", type=int, default=1000)
    options = parser.parse_args()
    print(f"{'family':9} {'regime':9} {'told':>5} {'hold':>5}  {'width: median':>14} {'19 of 20':>9} {'not told':>9}")
    for family in FAMILIES:
        verdicts, untold = told(family, options.seed, options.count)
        by_regime = defaultdict(list)
        for verdict in verdicts:
            by_regime[verdict.regime].append(verdict)
        for regime, own in sorted(by_regime.items()):
            widths = [each.told[1] - each.told[0] for each in own if each.told is not None]
            middle, most = np.quantile(widths, [0.5, 0.95])
            holding = sum(each.holds for each in own)
            print(f"{family:9} {regime:9} {len(own):5} {holding:5}  {middle:14.2%} {most:9.1%} {untold[regime]:9}")


if __name__ == "__main__":
    main()
