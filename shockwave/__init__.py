"""Prediction and simulation of solitary waves in granular crystals under shocks of finite rise and decay.

The public names below are imported when they are first used, so that ``import shockwave`` is fast.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # type checkers and editors do not run __getattr__
    from shockwave.chain import Chain as Chain
    from shockwave.chain import Material as Material
    from shockwave.chain import SolitaryWave as SolitaryWave
    from shockwave.errors import FileAccessError as FileAccessError
    from shockwave.errors import InvalidValueError as InvalidValueError
    from shockwave.errors import NumericalError as NumericalError
    from shockwave.errors import PluginError as PluginError
    from shockwave.errors import ScenarioError as ScenarioError
    from shockwave.errors import ShockwaveError as ShockwaveError
    from shockwave.errors import UnknownNameError as UnknownNameError
    from shockwave.errors import UsageError as UsageError
    from shockwave.fields import quantity as quantity
    from shockwave.measurement.result import SimulationResult as SimulationResult
    from shockwave.measurement.simulate import simulate as simulate
    from shockwave.measurement.simulate import simulate_many as simulate_many
    from shockwave.prediction.outcome import EjectionOutcome as EjectionOutcome
    from shockwave.prediction.outcome import Outcome as Outcome
    from shockwave.prediction.outcome import SingleOutcome as SingleOutcome
    from shockwave.prediction.outcome import TrainOutcome as TrainOutcome
    from shockwave.prediction.predictor import Predictor as Predictor
    from shockwave.profiles.base import ShockProfile as ShockProfile
    from shockwave.profiles.exponential import Exponential as Exponential
    from shockwave.profiles.power_law import PowerLaw as PowerLaw
    from shockwave.profiles.shock import Shock as Shock
    from shockwave.profiles.tabulated import Tabulated as Tabulated
    from shockwave.profiles.triangular import Triangular as Triangular
    from shockwave.scenario.loader import load_scenario as load_scenario
    from shockwave.scenario.scenario import Scenario as Scenario
    from shockwave.studies.comparison import Comparison as Comparison
    from shockwave.studies.comparison import compare as compare
    from shockwave.studies.design_result import Design as Design
    from shockwave.studies.design_search import design as design
    from shockwave.studies.uncertainty_result import Uncertainty as Uncertainty
    from shockwave.studies.uncertainty_sampling import uncertainty as uncertainty
    from shockwave.studies.universal_curve import UniversalCurve as UniversalCurve
    from shockwave.sweep.report import SweepReport as SweepReport
    from shockwave.sweep.results import SweepResults as SweepResults
    from shockwave.sweep.results import load_sweep as load_sweep
    from shockwave.sweep.runner import run_sweep as run_sweep

__version__ = "0.1.0"
#: Name of the distribution; on the package index, the name ``shockwave`` belongs to another project.
OWN_DISTRIBUTION = "granular-shockwave"

# Module -> its public names.
_PUBLIC = {
    "chain": "Chain Material SolitaryWave",
    "errors": "FileAccessError InvalidValueError NumericalError PluginError ScenarioError ShockwaveError "
    "UnknownNameError UsageError",
    "fields": "quantity",
    "measurement.result": "SimulationResult",
    "measurement.simulate": "simulate simulate_many",
    "prediction.outcome": "EjectionOutcome Outcome SingleOutcome TrainOutcome",
    "prediction.predictor": "Predictor",
    "profiles.base": "ShockProfile",
    "profiles.exponential": "Exponential",
    "profiles.power_law": "PowerLaw",
    "profiles.shock": "Shock",
    "profiles.tabulated": "Tabulated",
    "profiles.triangular": "Triangular",
    "scenario.loader": "load_scenario",
    "scenario.scenario": "Scenario",
    "studies.comparison": "Comparison compare",
    "studies.universal_curve": "UniversalCurve",
    "studies.design_result": "Design",
    "studies.design_search": "design",
    "studies.uncertainty_result": "Uncertainty",
    "studies.uncertainty_sampling": "uncertainty",
    "sweep.report": "SweepReport",
    "sweep.results": "SweepResults load_sweep",
    "sweep.runner": "run_sweep",
}
_HOMES = {name: module for module, names in _PUBLIC.items() for name in names.split()}

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'shockwave' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"shockwave.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
