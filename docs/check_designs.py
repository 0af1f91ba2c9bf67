"""Check of optimal designs on random problems of two parameters and one inequality, against dense scans.

``python docs/check_designs.py [PROBLEMS] [POINTS]`` prints, for each problem, the mass of the answer relative to the
best scene of a scan of POINTS times POINTS scenes, and how many answers are feasible and within 1 % of it.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np

import shockwave as sw
from shockwave.chain.layout import mass_and_length
from shockwave.scenario.scene_family import Family
from shockwave.studies.optimal_design import optimal_design

_SEED = 19
_RTOL = 1e-5
# Shares of the scanned scenes that meet the inequality; with the first, none does.
_SHARES = (-0.05, 0.6)
_ENDS = {
    "chain.granules[0].diameter": (2e-3, 16e-3),
    "chain.granules[1].diameter": (2e-3, 16e-3),
    "chain.granules[1].count": (3, 25),
    "chain.damping.time": (1e-8, 5e-6),
    "chain.precompression": (0.0, 20.0),
}
_SCENE = """
chain:
  material: {first}
  diameter: 8 mm
  granules:
    - {{count: {counts[0]}, diameter: 8 mm}}
    - {{count: {counts[1]}, material: {second}, diameter: 6 mm}}
  end: {{wall: same}}
  damping: {{model: kuwabara-kono, time: 1 us}}
shock: {{profile: power-law, peak_force: {force} N, rise_time: {rise} s, duration_ratio: {ratio},
  parameters: {{rise_exponent: {exponents[0]}, decay_exponent: {exponents[1]}}}}}
"""


def problem(rng: np.random.Generator) -> tuple[sw.Scenario, dict[str, tuple[float, float]]]:
    """A random scene with a wall, and two parameters with the ends of their intervals."""
    first, second = rng.choice(["paper-steel", "ptfe", "brass-260", "nylon-66"], 2)
    text = _SCENE.format(
        first=first,
        second=second,
        counts=rng.integers(3, 12, 2),
        force=10 ** rng.uniform(0, 3),
        rise=10 ** rng.uniform(-5.3, -4.3),
        ratio=rng.uniform(2, 8),
        exponents=rng.uniform(0.5, 4, 2),
    )
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.yaml"
        file.write_text(text, encoding="utf-8")
        scenario = sw.load_scenario(file)
    size = str(rng.choice(["chain.granules[0].diameter", "chain.granules[1].diameter"]))
    other = str(rng.choice([name for name in _ENDS if name != size]))
    return scenario, {name: _ENDS[name] for name in (size, other)}


def scanned(scenario: sw.Scenario, ends: Mapping[str, tuple[float, float]], points: int) -> np.ndarray:
    """Wall force and mass of the scenes of a regular grid, shape (scenes, 2)."""
    family = Family(scenario)
    axes = [np.linspace(*end, points) for end in ends.values()]
    axes = [np.unique(np.round(axis)) if "count" in name else axis for name, axis in zip(ends, axes, strict=True)]
    found = []
    for values in np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, len(ends)).tolist():
        scene = family.scenario(dict(zip(ends, values, strict=True)))
        wall = sw.simulate(scene.excitation, scene.chain, rtol=_RTOL).transmitted
        found.append((wall.peak_force, mass_and_length(scene.chain)[0]))
    return np.array(found)


def main(problems: int = 50, points: int = 30) -> None:
    rng = np.random.default_rng(_SEED)
    good, times = [], []
    for index in range(problems):
        scenario, ends = problem(rng)
        forces, masses = scanned(scenario, ends, points).T
        share = rng.uniform(*_SHARES)
        limit = 0.8 * forces.min() if share <= 0 else float(np.quantile(forces, share))
        begin = time.process_time()
        found = optimal_design(scenario, vary=ends, targets=[f"transmitted.peak_force <= {limit} N"])
        times.append(time.process_time() - begin)
        feasible = forces <= limit
        if found.best is None:
            good.append(not feasible.any())
            says = found.why
        else:
            best = masses[feasible].min() if feasible.any() else np.inf
            good.append(found.best.least <= 1.01 * best and found.best.quantities["transmitted.peak_force"] <= limit)
            says = f"mass {found.best.least / best - 1:+.2%} of the scan's best"
        print(f"{index} {' '.join(ends)}: {'good' if good[-1] else 'MISSED'}, {says}, {times[-1]:.1f} s", flush=True)
    print(f"{sum(good)} of {problems} as required; {np.median(times):.1f} s in the median, {max(times):.1f} s at most")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
