"""Results do not depend on the processor: on the vector instructions of NumPy, or on the kernels of OpenBLAS.

Run as a program, this file prints the results as JSON, for the processes that the tests start.
"""

import json
import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.__config__ import CONFIG

import shockwave as sw
from support.scenes import CHAIN, FORCE, TRUTH, UNITS, shock_of

RTOLS = (1e-4, 1e-6, 1e-8, 1e-10)
#: Profiles of which the free path is fitted, or read off a record, as longer and longer pulses.
PROFILES = {
    "exponential": sw.Exponential(rise_rate=-3.0, decay_rate=2.0, duration_ratio=2.5),
    "fast-exponential": sw.Exponential(rise_rate=6.0, decay_rate=0.5, duration_ratio=8.0),
    "tabulated": sw.Tabulated(times=[0, 1, 2, 3, 5, 6], forces=[0, 0.4, 1, 0.3, 0.7, 0]),
}
DURATIONS = (0.4, 2.0, 10.0, 40.0)
#: Of these pulses all waves are integrated; some granules rebound.
TRAINS = (1, 4, 6)


#: The environment in which NumPy and OpenBLAS compute as on an old processor.
OLD = {
    "NPY_DISABLE_CPU_FEATURES": " ".join(CONFIG.get("SIMD Extensions", {}).get("found", [])),
    "OPENBLAS_CORETYPE": "Nehalem",
}


def shocks() -> dict[str, sw.Shock]:
    found = {f"reference-{index}": shock_of(case) for index, case in enumerate(TRUTH)}
    for name, profile in PROFILES.items():
        for duration in DURATIONS:
            rise_time = duration / profile.duration_ratio * UNITS.time
            found[f"{name}-{duration:g}"] = sw.Shock(profile=profile, peak_force=FORCE, rise_time=rise_time)
    return found


def primaries() -> dict[str, list[float]]:
    """Peak force, error estimate and contact of the primary for each shock, tolerance and backend."""
    found = {}
    for name, shock in shocks().items():
        for rtol in RTOLS:
            # NumPy alone takes long for long pulses
            slow = rtol != RTOLS[1] or shock.duration > 6 * UNITS.time
            for backend in ("auto",) if slow else ("auto", "numpy"):
                result = sw.simulate(shock, CHAIN, rtol=rtol, waves="primary", backend=backend)
                contact = result.waves[0].contact
                found[f"{name} {rtol:g} {backend}"] = [result.peak_force, result.error_estimate, contact]
    return found


def trains() -> list[list[float]]:
    """Contact, peak force, momentum, energy and velocity of granules of all waves."""
    waves = [wave for index in TRAINS for wave in sw.simulate(shock_of(TRUTH[index]), CHAIN).waves]
    return [[wave.contact, wave.peak_force, wave.momentum, wave.energy, wave.granule_velocity] for wave in waves]


def predictions() -> list[list[Any]]:
    """Regime, relation and peak forces of all waves by section 4."""
    outcomes = [sw.Predictor().section4(shock, CHAIN) for shock in shocks().values()]
    return [[o.regime, o.relation, *(wave.peak_force for wave in o.waves)] for o in outcomes]


def results(environment: dict[str, str]) -> dict[str, Any]:
    """The results in a process of its own with these variables."""
    others = {key: value for key, value in os.environ.items() if not key.startswith(("NPY_", "OPENBLAS_"))}
    # a safe path leaves out the folder of the program
    others["PYTHONPATH"] = str(Path(__file__).parents[1])
    done = subprocess.run([sys.executable, __file__], env=others | environment, check=True, capture_output=True)
    return dict(json.loads(done.stdout))


@pytest.mark.skipif(platform.machine().lower() not in ("x86_64", "amd64"), reason="kernels of another architecture")
def test_results_are_the_same_on_another_processor() -> None:
    here, there = results({}), results(OLD)
    peaks, estimates, contacts = zip(*here["primaries"].values(), strict=True)
    other_peaks, other_estimates, other_contacts = zip(*there["primaries"].values(), strict=True)
    assert other_contacts == contacts
    # roundings of some hundred steps; an estimate may be a rounding itself
    np.testing.assert_allclose(other_peaks, peaks, rtol=1e-12)
    np.testing.assert_allclose(other_estimates, estimates, rtol=0.01)
    assert [wave[0] for wave in there["trains"]] == [wave[0] for wave in here["trains"]]
    np.testing.assert_allclose(there["trains"], here["trains"], rtol=1e-12)
    for prediction, expected in zip(there["predictions"], here["predictions"], strict=True):
        assert prediction[:2] == expected[:2]
        # later waves sum the roundings of those before
        assert prediction[2:] == pytest.approx(expected[2:], rel=1e-10)


if __name__ == "__main__":
    json.dump({"primaries": primaries(), "trains": trains(), "predictions": predictions()}, sys.stdout)
