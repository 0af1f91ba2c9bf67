"""Prediction of the waves that a striker generates in a chain of equal granules, by the law of strikers."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

from attrs import evolve, frozen

from shockwave.chain.chain import Chain
from shockwave.chain.coverage import predictable
from shockwave.chain.impact import Impact
from shockwave.chain.solitary_wave import EXACT_COEFFICIENT, SolitaryWave
from shockwave.plausibility import unusual_warnings
from shockwave.prediction.chain_laws import MASS_RATIOS, RIGID, striker_count, striker_velocity, striker_waves
from shockwave.prediction.expected_error import warning_of
from shockwave.prediction.model_interface import Regime
from shockwave.prediction.outcome import Accuracy, Estimate, Outcome, first_yield
from shockwave.scene_summary import ChainScene, check_scene
from shockwave.text import printed

# The law, as a model of its own.
_NAME = "striker"
# Relative half-width of the range: a constant, and a factor of |log2(k_s/k)|^1.4 for a contact of the striker with the
# stiffness k_s in place of k.
_LAW_ERROR = 1e-4
# Additional error in shorter chains than those in which the leading wave forms to that of the law.
_SHORT_ERROR = 3e-3
_STIFFNESS_ERROR = 0.03
_STIFFNESS_POWER = 1.4
# Relative increase of the mass of the first granule in its collision with a heavy striker, for k_s = k, and the power
# of the share of the striker in the mass of both. The force is then within 0.2 % of simulations for k_s >= k. Under a
# heavy striker it is low by at most 9 % for k_s = k/2 and 25 % for k/4, where the first granule is struck again.
_SUPPORT = 0.06
_SUPPORT_POWER = 1.6
# Largest mass ratio for which the later waves, which are nearly as strong, do not increase the force on a wall.
_HEAVIEST = 50.0
# Ratios k_s/k for which it holds.
_STIFFNESSES = (0.25, RIGID)
# Fewest granules in which the leading wave forms to either error, their additional ones, and power of the mass ratio.
_FORMED = (40, 10, 0.65)
_NEARLY = (10, 6, 0.5)


@frozen(kw_only=True, slots=False, repr=False)
class StrikerOutcome(Outcome):
    """Waves that a striker generates.

    Attributes
    ----------
    mass_ratio, stiffness_ratio : float
        Mass of the striker over that of a granule; stiffness of its contact over that of the others.
    velocity : float
        Velocity of the striker afterwards [m/s].
    wave_count : int
        Number of waves of at least 0.4 % of the leading wave, of which ``waves`` has the first six.
    """

    mass_ratio: float
    stiffness_ratio: float
    velocity: float
    wave_count: int

    @property
    def regime(self) -> Regime:
        """``single`` or ``train``."""
        return "single" if self.wave_count == 1 else "train"

    def to_dict(self) -> dict[str, Any]:
        document = super().to_dict()
        own = ("mass_ratio", "stiffness_ratio", "velocity", "wave_count")
        return document | {"striker": {name: document.pop(name) for name in own}}

    def __str__(self) -> str:
        return printed(self, "shockwave.prediction.outcome_text:striker_text")


def striker_outcome(impact: Impact, chain: Chain, method: str) -> StrikerOutcome:
    """Predict the waves of ``impact``; messages name ``method``.

    Raises
    ------
    InvalidValueError
        If ``impact`` is neither a shock nor an Impact, or ``chain`` not a Chain.
    NotCoveredError
        If the chain has features beyond equal granules with free ends or a fixed wall.
    """
    if not (isinstance(impact, Impact) and isinstance(chain, Chain)):
        check_scene(impact, chain)
    equal = predictable(chain, impact, method)
    radius, material = impact.radius or chain.radius, impact.material or chain.material
    mass = 4 / 3 * math.pi * material.density * radius**3
    ratio = mass / equal.granule_mass
    contact = 2 / (1 + material.compliance / equal.material.compliance)
    stiffness = contact * math.sqrt(2 * radius / (radius + equal.radius))
    within = min(ratio, MASS_RATIOS[1])
    # (m^3 k^2 v^6)^(1/5), factor by factor so that no intermediate power overflows
    unit = equal.granule_mass**0.6 * equal.contact_stiffness**0.4 * impact.velocity**1.2
    # collision of the striker with the first granule, whose mass is greater by a little because the chain supports it
    supported = 1 + _SUPPORT / stiffness * (ratio / (1 + ratio)) ** _SUPPORT_POWER
    on_striker = unit * stiffness**0.4 * (1.25 / (1 / ratio + 1 / supported)) ** 0.6
    one = SolitaryWave.of(unit, equal)
    waves = tuple(one.stronger(force) for force in striker_waves(within).tolist() if force)
    peak = waves[0].peak_force
    error = _LAW_ERROR + _STIFFNESS_ERROR * abs(math.log2(stiffness)) ** _STIFFNESS_POWER
    if equal.count is not None and equal.count < _granules(_FORMED, ratio):
        error += _SHORT_ERROR
    problem = _problem(ratio, stiffness, equal.count, chain.end is not None)
    known = Accuracy(
        None if problem else Estimate(peak, peak * (1 - error), peak * (1 + error), _NAME),
        problem or None,
        None if problem else (-error, error),
        (*unusual_warnings(impact, chain), *(warning_of(problem),) * bool(problem)),
    )
    return StrikerOutcome(
        model=_NAME,
        method=_NAME,
        relation=None,
        peak_force=peak,
        amplification=None,
        waves=waves,
        applied_momentum=mass * impact.velocity,
        conditions=(),
        trace=(),
        exponents=None,
        areas=None,
        momentum_coefficient=EXACT_COEFFICIENT,
        scene=ChainScene.of(impact, chain),
        wall=None if chain.end is None else chain.end.stiffness_ratio(equal.material),
        first_yield=partial(first_yield, evolve(equal, end=chain.end), striker=(impact, on_striker)),
        on_demand=lambda: known,
        mass_ratio=ratio,
        stiffness_ratio=stiffness,
        velocity=float(striker_velocity(within)) * impact.velocity,
        wave_count=int(striker_count(within)),
    )


def _problem(mass_ratio: float, stiffness: float, granules: int | None, has_wall: bool) -> str:
    """Reason why there is no estimate; empty if there is one."""
    if has_wall and mass_ratio > _HEAVIEST:
        return f"the waves of a striker of {mass_ratio:.4g} times the mass of a granule add up at a wall; simulate"
    if mass_ratio > MASS_RATIOS[1]:
        return f"the striker has {mass_ratio:.4g} times the mass of a granule, more than {MASS_RATIOS[1]:g}; simulate"
    low, high = _STIFFNESSES
    if not low <= stiffness <= high:
        return f"the contact of the striker is {stiffness:.3g} times as stiff as the others, below {low:g}; simulate"
    needed = _granules(_NEARLY, mass_ratio)
    where = f"in a chain of {granules} granules"
    short = f"{where} the leading wave may not form (it needs {needed} granules); simulate"
    return short * (granules is not None and granules < needed)


def _granules(terms: tuple[float, float, float], mass_ratio: float) -> int:
    least, more, power = terms
    return math.ceil(least + more * math.pow(mass_ratio, power))
