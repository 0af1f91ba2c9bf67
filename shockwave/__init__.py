"""Solitary waves in granular crystals under shocks of finite rise and decay, predicted and simulated.

The public names below are imported when they are first used, so that ``import shockwave`` costs next to nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from shockwave.chain import Chain, Material, SolitaryWave
    from shockwave.comparison import Comparison, compare
    from shockwave.errors import (
        FileAccessError,
        InvalidValueError,
        NumericalError,
        PluginError,
        ScenarioError,
        ShockwaveError,
        UnknownNameError,
        UsageError,
    )
    from shockwave.fields import quantity
    from shockwave.measurement.result import SimulationResult
    from shockwave.measurement.simulate import simulate, simulate_many
    from shockwave.prediction.outcome import EjectionOutcome, Outcome, SingleOutcome, TrainOutcome
    from shockwave.prediction.predictor import Predictor
    from shockwave.profiles.base import ShockProfile
    from shockwave.profiles.exponential import Exponential
    from shockwave.profiles.power_law import PowerLaw
    from shockwave.profiles.shock import Shock
    from shockwave.profiles.tabulated import Tabulated
    from shockwave.profiles.triangular import Triangular
    from shockwave.scenario.load import Scenario, load_scenario

__version__ = "0.1.0"

_HOMES = {
    "Chain": "chain",
    "Material": "chain",
    "SolitaryWave": "chain",
    "FileAccessError": "errors",
    "InvalidValueError": "errors",
    "NumericalError": "errors",
    "PluginError": "errors",
    "ScenarioError": "errors",
    "ShockwaveError": "errors",
    "UnknownNameError": "errors",
    "UsageError": "errors",
    "quantity": "fields",
    "SimulationResult": "measurement.result",
    "simulate": "measurement.simulate",
    "simulate_many": "measurement.simulate",
    "EjectionOutcome": "prediction.outcome",
    "Outcome": "prediction.outcome",
    "SingleOutcome": "prediction.outcome",
    "TrainOutcome": "prediction.outcome",
    "Predictor": "prediction.predictor",
    "ShockProfile": "profiles.base",
    "Exponential": "profiles.exponential",
    "PowerLaw": "profiles.power_law",
    "Shock": "profiles.shock",
    "Tabulated": "profiles.tabulated",
    "Triangular": "profiles.triangular",
    "Scenario": "scenario.load",
    "load_scenario": "scenario.load",
    "Comparison": "comparison",
    "compare": "comparison",
}

__all__ = [
    "Chain",
    "Comparison",
    "EjectionOutcome",
    "Exponential",
    "FileAccessError",
    "InvalidValueError",
    "Material",
    "NumericalError",
    "Outcome",
    "PluginError",
    "PowerLaw",
    "Predictor",
    "Scenario",
    "ScenarioError",
    "Shock",
    "ShockProfile",
    "ShockwaveError",
    "SimulationResult",
    "SingleOutcome",
    "SolitaryWave",
    "Tabulated",
    "TrainOutcome",
    "Triangular",
    "UnknownNameError",
    "UsageError",
    "compare",
    "load_scenario",
    "quantity",
    "simulate",
    "simulate_many",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'shockwave' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"shockwave.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
