"""Prediction and simulation of solitary waves in granular crystals under shocks of finite rise and decay.

Each public name is imported when it is first used, so that ``import shockwave`` is fast.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.2.0.dev0"
#: Name of the distribution; on the package index, the name ``shockwave`` belongs to another project.
OWN_DISTRIBUTION = "granular-shockwave"

# Public names by module; ``__init__.pyi`` states them to type checkers.
_NAMES: dict[str, tuple[str, ...]] = {
    "answers": ("compare", "predict", "simulate"),
    "base.errors": (
        "FileAccessError",
        "InvalidValueError",
        "NotCoveredError",
        "NumericalError",
        "PluginError",
        "ScenarioError",
        "ShockwaveError",
        "UnknownNameError",
        "UsageError",
    ),
    "base.quantity_fields": ("quantity",),
    "prediction.outcome": ("Outcome",),
    "prediction.predictor": ("Predictor",),
    "prediction.section4_outcome": ("EjectionOutcome", "SingleOutcome", "TrainOutcome"),
    "profiles.exponential": ("Exponential",),
    "profiles.friedlander": ("Friedlander",),
    "profiles.half_sine": ("HalfSine",),
    "profiles.haversine": ("Haversine",),
    "profiles.power_law": ("PowerLaw",),
    "profiles.rectangular": ("Rectangular",),
    "profiles.sawtooth": ("FinalPeakSawtooth", "InitialPeakSawtooth"),
    "profiles.shock_profile": ("ShockProfile",),
    "profiles.tabulated": ("Tabulated",),
    "profiles.trapezoid": ("Trapezoid",),
    "profiles.triangular": ("Triangular",),
    "scenario.scenario": ("Scenario", "load_scenario"),
    "scene.chain": ("Chain",),
    "scene.chain_end": ("Bar", "Wall"),
    "scene.closed_form_laws": ("damped_decay", "striker_waves", "wall_factor"),
    "scene.contact_law": ("ContactLaw", "ElasticPlastic", "Hertz", "PowerContact"),
    "scene.damping": ("Dashpot", "KuwabaraKono", "Tsuji"),
    "scene.force_limit": ("Limit", "Verdict"),
    "scene.impact": ("Impact",),
    "scene.motion": ("Motion",),
    "scene.material": ("Material", "material"),
    "scene.segments": ("Cell", "Segment", "Taper"),
    "scene.shock": ("Shock",),
    "scene.solitary_wave": ("SolitaryWave",),
    "simulation.shock_spectrum": ("ShockSpectrum", "shock_spectrum"),
    "simulation.simulate": ("simulate_many",),
    "simulation.simulation_result": ("Simulation",),
    "studies.amplification_curve": ("UniversalCurve",),
    "studies.comparison": ("Comparison",),
    "studies.design_result": ("Design",),
    "studies.design_search": ("design",),
    "studies.uncertainty_result": ("Uncertainty",),
    "studies.uncertainty_study": ("uncertainty",),
    "sweep.progress_text": ("SweepReport",),
    "sweep.results": ("SweepResults", "load_sweep"),
    "sweep.runner": ("run_sweep",),
}
# Public modules.
_MODULES = ("hooks", "pictures", "testing")
# Public name -> its module.
_HOMES = {name: f"shockwave.{module}" for module, names in _NAMES.items() for name in names}

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return importlib.import_module(f"shockwave.{name}")
    if name not in _HOMES:
        raise AttributeError(f"module 'shockwave' has no attribute {name!r}")
    value = getattr(importlib.import_module(_HOMES[name]), name)
    if not isinstance(value, type):
        from shockwave.base.arguments import explain_arguments

        value = explain_arguments(value)
        value.__module__ = "shockwave"  # where pickle finds it
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, *_MODULES, "__version__"]
