"""Keyword arguments of public functions, for type checkers; at run time there is no module of this name.

The keys are the fields of `SimulateOptions`, `Predictor`, `Tabulated` and `RecordFormat`.
"""

from collections.abc import Iterable, Sequence
from typing import Literal, TypedDict

from shockwave.base.quantity_fields import Number
from shockwave.prediction.predictor import Model
from shockwave.prediction.section4 import Alpha
from shockwave.scene.simulate_options import Backend, Recorded, SensorArgument, Waves

class SimulateArguments(TypedDict, total=False):
    integrator: str | None
    step: Number | None
    wave_threshold: Number
    waves: Waves
    backend: Backend
    contacts: Iterable[int]
    record: Iterable[Recorded]
    sensors: Iterable[SensorArgument]
    interval: Number | None
    until: Number | None
    timeout: Number | None

class PredictArguments(SimulateArguments, total=False):
    rtol: Number | None
    model: Model
    momentum_coefficient: Number
    alpha: Alpha
    equal_tolerance: Number
    quadrature: str | None

class RecordArguments(TypedDict, total=False):
    columns: Sequence[int] | None
    skip_rows: int
    encoding: Literal["utf-8", "utf-16", "cp1252"] | None
    decimal: Literal[".", ","] | None
    time_unit: str | None
    interval: Number | None
    unit: str | None
    sign: int
    scale: Number | None
    area: Number | None
    mass: Number | None
    duration_ratio: Number | None
    baseline: Sequence[Number] | None
    low_pass: Number | None
    crop: Sequence[Number] | None
    negative: Literal["keep", "zero"] | None
