"""Solitary waves in granular crystals under shocks of finite rise and decay, predicted and simulated.

The public names below are imported when they are first used, so that ``import shockwave`` costs next to nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from shockwave.chain import Chain, Material, SolitaryWave
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
    from shockwave.scenario.loader import load_scenario
    from shockwave.scenario.scenario import Scenario
    from shockwave.studies.comparison import Comparison, compare
    from shockwave.studies.curve import UniversalCurve
    from shockwave.studies.designs.design import Design, design
    from shockwave.studies.uncertainties.result import Uncertainty
    from shockwave.studies.uncertainties.uncertainty import uncertainty
    from shockwave.sweep.report import SweepReport
    from shockwave.sweep.results import SweepResults, load_sweep
    from shockwave.sweep.runner import run_sweep

__version__ = "0.1.0"
#: Name of the distribution; on the package index, the name ``shockwave`` belongs to another project.
OWN_DISTRIBUTION = "granular-shockwave"

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
    "Scenario": "scenario.scenario",
    "load_scenario": "scenario.loader",
    "SweepReport": "sweep.report",
    "SweepResults": "sweep.results",
    "load_sweep": "sweep.results",
    "run_sweep": "sweep.runner",
    "Comparison": "studies.comparison",
    "compare": "studies.comparison",
    "UniversalCurve": "studies.curve",
    "Design": "studies.designs.design",
    "design": "studies.designs.design",
    "Uncertainty": "studies.uncertainties.result",
    "uncertainty": "studies.uncertainties.uncertainty",
}

__all__ = [
    "Chain",
    "Comparison",
    "Design",
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
    "SweepReport",
    "SweepResults",
    "Tabulated",
    "TrainOutcome",
    "Triangular",
    "Uncertainty",
    "UniversalCurve",
    "UnknownNameError",
    "UsageError",
    "compare",
    "design",
    "load_scenario",
    "load_sweep",
    "quantity",
    "run_sweep",
    "simulate",
    "simulate_many",
    "uncertainty",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'shockwave' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"shockwave.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
