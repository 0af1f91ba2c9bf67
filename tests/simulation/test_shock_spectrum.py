"""Shock response spectra of histories: closed values, dense sampling, other codes, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import lsim

import shockwave as sw
from shockwave.base.text import si

#: Pulses of unit peak and duration, and the undamped spectrum over the peak by frequency times duration.
SAMPLED = np.linspace(0, 1, 2001)
CLOSED = {
    "half-sine": (
        (SAMPLED, np.sin(math.pi * SAMPLED)),
        {0.25: 0.9428, 0.5: math.pi / 2, 1.0: math.sqrt(3), 2.0: 1.2681, 0.81: 1.76846},
    ),
    "rectangle": (([0, 1], [1, 1]), {0.25: math.sqrt(2), 0.5: 2, 0.8: 2, 1.0: 2, 37.3: 2}),
    "saw-tooth": (([0, 1], [0, 1]), {0.25: 0.7330, 0.5: 1.1854, 0.65: 1.2596, 0.8: 1.1971, 1.0: 1.0}),
}


@pytest.mark.parametrize("pulse", CLOSED)
def test_undamped_spectra_have_their_closed_values(pulse: str) -> None:
    history, values = CLOSED[pulse]
    spectrum = sw.shock_spectrum(*history, list(values), damping=0)
    # the values have four digits after the point
    assert spectrum.acceleration == pytest.approx(list(values.values()), rel=1e-4)
    assert spectrum.pseudo_velocity == pytest.approx(spectrum.acceleration / (2 * math.pi * spectrum.frequencies))


#: Irregular histories: samples at uneven distances, a jump, and an interval of many periods.
HISTORIES = {
    "uneven": ([0, 0.1, 0.15, 0.5, 1.3], [0, 2, -1, 0.5, 0]),
    "jump": ([0, 0.4, 0.4, 1], [0, 1, -1, 0.2]),
    "short": ([0, 0.05], [1, 1]),
    "slow": ([0, 9, 19], [0, 1, 0]),
}


@pytest.mark.parametrize("damping", [0, 0.3])
@pytest.mark.parametrize("name", HISTORIES)
def test_greatest_responses_are_those_of_dense_samples(name: str, damping: float) -> None:
    times, accelerations = (np.array(each, dtype=float) for each in HISTORIES[name])
    w = 2 * math.pi * 1.7
    spectrum = sw.shock_spectrum(times, accelerations, [1.7], damping)
    # until the first extremum after the end; both sides of a jump are samples, one step apart
    dense = np.linspace(0, times[-1] + 1.0, 40_001)
    base = np.interp(dense, times, accelerations, right=0.0)
    system = [[0, 1], [-w * w, -2 * damping * w]], [[0], [-1]], [[-w * w, -2 * damping * w], [1, 0]], [[0], [0]]
    _, responses, _ = lsim(system, base, dense)
    acceleration, displacement = np.abs(responses).max(axis=0)
    # the jumps of the samples are one step wide
    assert spectrum.acceleration == pytest.approx([acceleration], rel=1e-3 if name in ("jump", "short") else 1e-6)
    assert spectrum.pseudo_velocity == pytest.approx(
        [w * displacement], rel=1e-3 if name in ("jump", "short") else 1e-6
    )


def test_a_blow_leaves_its_velocity_change_at_low_frequencies_and_its_peak_at_high_ones() -> None:
    spectrum = sw.shock_spectrum(SAMPLED, np.sin(math.pi * SAMPLED), [1e-3, 1e3], damping=0)
    assert spectrum.pseudo_velocity[0] == pytest.approx(2 / math.pi, rel=1e-5)
    assert spectrum.acceleration[1] == pytest.approx(1, rel=2e-3)  # it starts with a kink


def test_the_text_has_the_row_of_the_greatest_response_and_all_rows_on_request() -> None:
    spectrum = sw.shock_spectrum(SAMPLED, np.sin(math.pi * SAMPLED))
    peak = f"{si(float(spectrum.frequencies[spectrum.acceleration.argmax()]), 'Hz')} "
    short, full = str(spectrum), spectrum.text()
    assert peak in short
    assert f"({len(spectrum.frequencies)} frequencies; --verbose shows all)" in short
    assert len(full.splitlines()) >= len(spectrum.frequencies)


def test_frequencies_are_twelve_per_octave_within_what_the_history_resolves() -> None:
    spectrum = sw.shock_spectrum(np.linspace(0, 0.1, 1001), np.ones(1001))
    f = spectrum.frequencies
    assert f[12] / f[0] == pytest.approx(2)
    assert f[0] <= 10 < f[1]
    assert f[-2] < 1001 <= f[-1]


def test_pyyeti_agrees() -> None:
    srs = pytest.importorskip("pyyeti.srs")
    times = np.linspace(0, 0.2, 8001)
    accelerations = np.sin(2 * math.pi * 90 * times) * np.exp(-30 * times) + 0.5 * np.sin(2 * math.pi * 430 * times)
    frequencies = np.geomspace(5, 2000, 40)
    other = srs.srs(
        accelerations, 40_000, frequencies, 10, ic="zero", time="total", rolloff="linear", ppc=40, parallel="no"
    )
    # it takes the greatest of at least 40 samples per period, of straight lines as well
    assert sw.shock_spectrum(times, accelerations, frequencies).acceleration == pytest.approx(other, rel=1e-2)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0, 1], [1, 2, 3]), "times: must be at least two numbers in ascending order, and as many as accelerations"),
        (([0, 1], [1, math.nan]), "times: must be at least two numbers"),
        (([0, 2, 1], [1, 2, 3]), "times: must be at least two numbers in ascending order"),
        (([0, 1], [1, 2], [0.0]), "frequencies: must be > 0 Hz"),
        (([0, 1], [1, 2], [1.0], 1.0), "damping: must be >= 0 and < 1"),
    ],
    ids=["lengths", "nan", "order", "frequency", "damping"],
)
def test_what_is_no_history_is_refused(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(sw.InvalidValueError, match=message):
        sw.shock_spectrum(*arguments)  # type: ignore[arg-type]
