"""Public names and their modules, for type checkers; `__init__.py` imports a name when it is first used."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:  # mypy resolves cycles of imports only here
    from shockwave.answers import compare as compare
    from shockwave.answers import predict as predict
    from shockwave.answers import simulate as simulate
    from shockwave.chain import Chain as Chain
    from shockwave.chain import Material as Material
    from shockwave.chain import SolitaryWave as SolitaryWave
    from shockwave.chain.contact_law import ContactLaw as ContactLaw
    from shockwave.chain.contact_law import PowerContact as PowerContact
    from shockwave.chain.damping import Dashpot as Dashpot
    from shockwave.chain.damping import KuwabaraKono as KuwabaraKono
    from shockwave.chain.damping import Tsuji as Tsuji
    from shockwave.chain.ends import Wall as Wall
    from shockwave.chain.impact import Impact as Impact
    from shockwave.chain.laws import damped_decay as damped_decay
    from shockwave.chain.laws import striker_waves as striker_waves
    from shockwave.chain.laws import wall_factor as wall_factor
    from shockwave.chain.material import material as material
    from shockwave.chain.segments import Cell as Cell
    from shockwave.chain.segments import Segment as Segment
    from shockwave.chain.segments import Taper as Taper
    from shockwave.errors import FileAccessError as FileAccessError
    from shockwave.errors import InvalidValueError as InvalidValueError
    from shockwave.errors import NotCoveredError as NotCoveredError
    from shockwave.errors import NumericalError as NumericalError
    from shockwave.errors import PluginError as PluginError
    from shockwave.errors import ScenarioError as ScenarioError
    from shockwave.errors import ShockwaveError as ShockwaveError
    from shockwave.errors import UnknownNameError as UnknownNameError
    from shockwave.errors import UsageError as UsageError
    from shockwave.fields import quantity as quantity
    from shockwave.limit import Limit as Limit
    from shockwave.limit import Verdict as Verdict
    from shockwave.measurement.chain_result import ChainResult as ChainResult
    from shockwave.measurement.result import SimulationResult as SimulationResult
    from shockwave.measurement.simulate import simulate_many as simulate_many
    from shockwave.prediction.outcome import Outcome as Outcome
    from shockwave.prediction.predictor import Predictor as Predictor
    from shockwave.prediction.section4_outcome import EjectionOutcome as EjectionOutcome
    from shockwave.prediction.section4_outcome import SingleOutcome as SingleOutcome
    from shockwave.prediction.section4_outcome import TrainOutcome as TrainOutcome
    from shockwave.profiles.base import ShockProfile as ShockProfile
    from shockwave.profiles.exponential import Exponential as Exponential
    from shockwave.profiles.power_law import PowerLaw as PowerLaw
    from shockwave.profiles.shock import Shock as Shock
    from shockwave.profiles.tabulated import Tabulated as Tabulated
    from shockwave.profiles.triangular import Triangular as Triangular
    from shockwave.scenario.loader import load_scenario as load_scenario
    from shockwave.scenario.scenario import Scenario as Scenario
    from shockwave.studies.comparison import Comparison as Comparison
    from shockwave.studies.curve import UniversalCurve as UniversalCurve
    from shockwave.studies.design_result import Design as Design
    from shockwave.studies.design_search import design as design
    from shockwave.studies.uncertainty_result import Uncertainty as Uncertainty
    from shockwave.studies.uncertainty_sampling import uncertainty as uncertainty
    from shockwave.sweep.report import SweepReport as SweepReport
    from shockwave.sweep.results import SweepResults as SweepResults
    from shockwave.sweep.results import load_sweep as load_sweep
    from shockwave.sweep.runner import run_sweep as run_sweep

__version__: str
OWN_DISTRIBUTION: str
