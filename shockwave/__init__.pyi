"""Public names and their modules, for type checkers; `__init__.py` imports a name when it is first used."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:  # mypy resolves cycles of imports only here
    from shockwave import hooks as hooks
    from shockwave import pictures as pictures
    from shockwave import testing as testing
    from shockwave.answers import compare as compare
    from shockwave.answers import predict as predict
    from shockwave.answers import simulate as simulate
    from shockwave.base.errors import FileAccessError as FileAccessError
    from shockwave.base.errors import InvalidValueError as InvalidValueError
    from shockwave.base.errors import NotCoveredError as NotCoveredError
    from shockwave.base.errors import NumericalError as NumericalError
    from shockwave.base.errors import PluginError as PluginError
    from shockwave.base.errors import ScenarioError as ScenarioError
    from shockwave.base.errors import ShockwaveError as ShockwaveError
    from shockwave.base.errors import UnknownNameError as UnknownNameError
    from shockwave.base.errors import UsageError as UsageError
    from shockwave.base.quantity_fields import quantity as quantity
    from shockwave.prediction.outcome import Outcome as Outcome
    from shockwave.prediction.predictor import Predictor as Predictor
    from shockwave.prediction.section4_outcome import EjectionOutcome as EjectionOutcome
    from shockwave.prediction.section4_outcome import SingleOutcome as SingleOutcome
    from shockwave.prediction.section4_outcome import TrainOutcome as TrainOutcome
    from shockwave.profiles.exponential import Exponential as Exponential
    from shockwave.profiles.friedlander import Friedlander as Friedlander
    from shockwave.profiles.half_sine import HalfSine as HalfSine
    from shockwave.profiles.haversine import Haversine as Haversine
    from shockwave.profiles.power_law import PowerLaw as PowerLaw
    from shockwave.profiles.rectangular import Rectangular as Rectangular
    from shockwave.profiles.sawtooth import FinalPeakSawtooth as FinalPeakSawtooth
    from shockwave.profiles.sawtooth import InitialPeakSawtooth as InitialPeakSawtooth
    from shockwave.profiles.shock_profile import ShockProfile as ShockProfile
    from shockwave.profiles.tabulated import Tabulated as Tabulated
    from shockwave.profiles.trapezoid import Trapezoid as Trapezoid
    from shockwave.profiles.triangular import Triangular as Triangular
    from shockwave.scenario.scenario import Scenario as Scenario
    from shockwave.scenario.scenario import load_scenario as load_scenario
    from shockwave.scene.chain import Chain as Chain
    from shockwave.scene.chain_end import Bar as Bar
    from shockwave.scene.chain_end import Wall as Wall
    from shockwave.scene.closed_form_laws import damped_decay as damped_decay
    from shockwave.scene.closed_form_laws import striker_waves as striker_waves
    from shockwave.scene.closed_form_laws import wall_factor as wall_factor
    from shockwave.scene.contact_law import ContactLaw as ContactLaw
    from shockwave.scene.contact_law import ElasticPlastic as ElasticPlastic
    from shockwave.scene.contact_law import Hertz as Hertz
    from shockwave.scene.contact_law import PowerContact as PowerContact
    from shockwave.scene.damping import Dashpot as Dashpot
    from shockwave.scene.damping import KuwabaraKono as KuwabaraKono
    from shockwave.scene.damping import Tsuji as Tsuji
    from shockwave.scene.force_limit import Limit as Limit
    from shockwave.scene.force_limit import Verdict as Verdict
    from shockwave.scene.impact import Impact as Impact
    from shockwave.scene.material import Material as Material
    from shockwave.scene.material import material as material
    from shockwave.scene.motion import Motion as Motion
    from shockwave.scene.segments import Cell as Cell
    from shockwave.scene.segments import Segment as Segment
    from shockwave.scene.segments import Taper as Taper
    from shockwave.scene.shock import Shock as Shock
    from shockwave.scene.solitary_wave import SolitaryWave as SolitaryWave
    from shockwave.simulation.shock_spectrum import ShockSpectrum as ShockSpectrum
    from shockwave.simulation.shock_spectrum import shock_spectrum as shock_spectrum
    from shockwave.simulation.simulate import simulate_many as simulate_many
    from shockwave.simulation.simulation_result import Simulation as Simulation
    from shockwave.studies.amplification_curve import UniversalCurve as UniversalCurve
    from shockwave.studies.comparison import Comparison as Comparison
    from shockwave.studies.design_result import Design as Design
    from shockwave.studies.design_search import design as design
    from shockwave.studies.uncertainty_result import Uncertainty as Uncertainty
    from shockwave.studies.uncertainty_study import uncertainty as uncertainty
    from shockwave.sweep.progress_text import SweepReport as SweepReport
    from shockwave.sweep.results import SweepResults as SweepResults
    from shockwave.sweep.results import load_sweep as load_sweep
    from shockwave.sweep.runner import run_sweep as run_sweep

__version__: str
OWN_DISTRIBUTION: str
