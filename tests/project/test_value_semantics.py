"""Results and settings are values: they pickle, copy and compare."""

import copy
import pickle
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any

import attrs
import pytest

import shockwave as sw
from support.scenes import CHAIN, lasting, power, power_law, triangle

SHOCK = power(0.5)
WALLED = sw.Chain(material=CHAIN.material, radius=CHAIN.radius, granules=5, end=sw.Wall())
SWEEP = """
chain: {material: copper, radius: 1 mm}
shock: {profile: triangular, peak_force: 1 N, rise_time: 1 us, duration_ratio: 2}
sweep: {grid: {shock.duration_ratio: [2, 3]}}
"""
# Exponents and duration ratio -> duration in characteristic times; each law generates waves of another regime.
REGIMES = {(3, 0.5, 1): 1.8, (3, 1 / 9, 1): 2.73, (10, 1, 5): 10.0}
TAPER = sw.Taper(first=1e-3, last=2e-3)
SEGMENTS = (sw.Segment(count=2, radius=TAPER), sw.Cell(repeat=2, cell=(sw.Segment(),)))
SETTINGS: dict[str, Any] = {
    "chain": sw.Chain(
        material="copper", radius=1e-3, granules=SEGMENTS, end=sw.Wall(mass=1.0), damping=sw.Dashpot(coefficient=1.0)
    ),
    "exponential": sw.Shock(
        profile=sw.Exponential(rise_rate=1, decay_rate=1, duration_ratio=2), peak_force=1.0, rise_time=1e-6
    ),
    "bar": sw.Bar(material="steel-4340", impedance=1e4),
    "guided": (sw.Motion(velocity=1.0, until=1e-5), sw.Motion(times=[0, 1e-6], values=[0, 1], quantity="velocity")),
    "law": sw.PowerContact(exponent=2.0, stiffness=1e7),
    "laws": (sw.Hertz(), sw.ElasticPlastic()),
    "predictor": sw.Predictor(model="section-4"),
    "pulses": (sw.HalfSine(), sw.Haversine(), sw.InitialPeakSawtooth(), sw.FinalPeakSawtooth()),
    "plateaus": (sw.Trapezoid(), sw.Rectangular(), sw.Friedlander()),
    "record": sw.Shock(profile=sw.Tabulated(times=[0, 1e-6, 2e-6], forces=[0, 1, 0])),
    "restitution": sw.Tsuji(restitution=0.9),
    "triangle": triangle(1.0),
    "viscoelastic": sw.KuwabaraKono(time=1e-6),
    "wave": sw.SolitaryWave.of(1.0, CHAIN),
}


@cache
def values() -> dict[str, Any]:
    """One value of each kind that users hold, results with all of their parts computed."""
    striker = sw.Impact(velocity=0.5)
    recorded = sw.simulate(SHOCK, CHAIN, rtol=1e-4, record=("forces",), contacts=(1, 2))
    folder = Path(tempfile.mkdtemp())
    (folder / "sweep.yaml").write_text(SWEEP)
    scenario = sw.load_scenario(folder / "sweep.yaml")
    with ThreadPoolExecutor(1) as executor:
        report = sw.run_sweep(scenario, folder / "out", executor=executor)
    whole = {
        "scenario": scenario,
        "report": report,
        "sweep": sw.load_sweep(folder / "out"),
        "leading wave": recorded,
        "contact forces": sw.simulate(striker, WALLED, record=("field",)),
        "prediction": sw.predict(SHOCK, CHAIN, limit=10.0),
        "prediction of a striker": sw.predict(striker, WALLED, limit=10.0),
        "section 4": sw.predict(SHOCK, CHAIN, model="section-4"),
        "comparison": sw.compare(SHOCK, CHAIN, rtol=1e-4),
        "comparison of a striker": sw.compare(striker, WALLED),
        "recording": recorded.recording,
        "spectrum": sw.simulate(SHOCK, WALLED).spectrum(mass=1.0, low=1e3, high=2e3),
        "curve": sw.UniversalCurve(SHOCK.profile, rtol=1e-2, longest=1.0),
        "design": sw.design(
            SHOCK, CHAIN, vary="shock.rise_time", between=("1 us", "30 us"), target="amplification = 0.7"
        ),
        "uncertainty": sw.uncertainty(SHOCK, CHAIN, {"shock.rise_time": {"sd": "0.1 us"}}, draws=256),
        "verdict": sw.simulate(striker, WALLED, limit=10.0).verdict,
    }
    for value in whole.values():
        value.to_dict() if hasattr(value, "to_dict") else str(value)
    sections = {
        f"section 4 of {law}": sw.predict(lasting(power_law(*law), duration), CHAIN).section4
        for law, duration in REGIMES.items()
    }
    return whole | sections | SETTINGS | {"limit": sw.Limit(force=1.0), "impact": striker, "material": CHAIN.material}


COPIES: dict[str, Callable[[Any], Any]] = {
    "pickle": lambda value: pickle.loads(pickle.dumps(value)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}


@pytest.mark.parametrize("way", COPIES)
def test_a_copy_equals_its_original_and_has_its_document(way: str) -> None:
    for name, value in values().items():
        copied = COPIES[way](value)
        assert copied == value, name
        if hasattr(value, "to_dict"):
            assert str(copied.to_dict()) == str(value.to_dict()), name


def test_every_public_class_is_among_them() -> None:
    abstract = {"ContactLaw", "ShockProfile"}
    classes = {name: each for name in sw.__all__ if isinstance(each := getattr(sw, name), type)}
    errors = {name for name, each in classes.items() if issubclass(each, Exception)}  # tested with the errors
    wholes = [each for value in values().values() for each in (value if isinstance(value, tuple) else (value,))]
    held = [value for whole in wholes for value in (whole, *_parts(whole))]
    absent = {name for name, each in classes.items() if not any(isinstance(value, each) for value in held)}
    assert absent <= abstract | errors


def test_results_of_other_scenes_differ() -> None:
    whole = values()
    assert whole["leading wave"] != sw.simulate(SHOCK, WALLED)
    assert whole["recording"] != sw.simulate(SHOCK, CHAIN, record=("forces",), contacts=(1,)).recording
    assert whole["prediction"] != sw.predict(SHOCK, CHAIN, limit=11.0)


def _parts(value: Any) -> list[Any]:
    """Fields of a value, and the items of its tuples."""
    if not attrs.has(type(value)):
        return []
    fields = [getattr(value, field.name, None) for field in attrs.fields(type(value))]
    items = [item for field in fields if isinstance(field, tuple) for item in field]
    return [part for field in [*fields, *items] for part in (field, *_parts(field))]
