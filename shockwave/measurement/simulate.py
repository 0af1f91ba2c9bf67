"""Direct simulation, from a shock and a chain to a result with an error estimate."""

from __future__ import annotations

import time

from attrs import evolve

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.solitary_wave import MOMENTUM
from shockwave.errors import NumericalError
from shockwave.measurement.result import Cost, MeasuredWave, SimulationResult
from shockwave.measurement.run import EJECTED, Demand, Run, run
from shockwave.options import SimulateOptions
from shockwave.profiles.shock import Shock
from shockwave.registry import load
from shockwave.scene import Scene
from shockwave.simulation.problem import ChainProblem
from shockwave.text import si

__all__ = ["simulate"]

# An absolute error per step, in units of the wave, leads to a relative error of the peak some 100 times as large.
_FINE = 3e-4
_COARSE = 3e-3
# Below this step control gains nothing: rounding is all that is left.
_LEAST_TOLERANCE = 1e-13
# Shares of the tolerance that the approach to the limit may use up.
_PRIMARY_DOUBT = 0.2
_LATER_DOUBT = 2.0
# However loose the tolerance, a wave that has not settled to this is not yet itself.
_MOST_DOUBT = 3e-4
_ROUNDING = 1e-12
# An error estimate above this is none.
_UNSETTLED = 0.1
_DIGITS = 13
# The longest chain: so many contacts, and so many for each unit of time that the force lasts.
_MOST_CONTACTS = 1000
_MOST_RATE = 10


def simulate(
    shock: Shock,
    chain: Chain,
    rtol: float = 1e-6,
    integrator: str = "dop853",
    wave_threshold: float = 5e-3,
) -> SimulationResult:
    """Integrate eq. (1) and measure the waves that come out.

    Two runs are made, one with a ten times looser step control; their difference and the approach of the peaks to
    their limits along the chain give the error estimate. Without ``chain.granules`` the chain is as long as that
    takes. With it, the waves are read before they feel the free end.

    Parameters
    ----------
    shock : Shock
        Profile, peak force, rise time.
    chain : Chain
        Material, radius, and the number of granules or None.
    rtol : float
        Relative error asked of the primary's peak force, 1e-9 to 1e-2.
    integrator : str
        Name of a registered integrator.
    wave_threshold : float
        Waves weaker than this share of the primary's peak force are not counted.

    Returns
    -------
    SimulationResult
        In SI units.

    Raises
    ------
    InvalidValueError, UnknownNameError
        When a setting is out of range or a name unknown.
    NumericalError
        When the integrator fails or no wave leaves the loaded end.
    """
    SimulateOptions(integrator=integrator, rtol=rtol, wave_threshold=wave_threshold)
    method = load("integrators", integrator)
    begin = time.perf_counter()
    scaled, scales = _scaled(shock, chain)
    most = int(_MOST_CONTACTS + _MOST_RATE * scaled.duration)
    demand = Demand(
        wave_threshold, min(_PRIMARY_DOUBT * rtol, _MOST_DOUBT), min(_LATER_DOUBT * rtol, _MOST_DOUBT), most
    )
    fine = run(scaled, method(tolerance=max(_FINE * rtol, _LEAST_TOLERANCE)), demand)
    coarse = run(scaled, method(tolerance=max(_COARSE * rtol, 10 * _LEAST_TOLERANCE)), demand)
    if not fine.waves or not coarse.waves:
        raise NumericalError(
            f"no wave was found within {most} contacts: the shock is too slow for its peak force"
            " (shorten it, or raise the peak force)"
        )
    result = _result(shock, chain, scales, fine, coarse, rtol, integrator, wave_threshold)
    return evolve(result, cost=evolve(result.cost, seconds=time.perf_counter() - begin))


def _scaled(shock: Shock, chain: Chain) -> tuple[ChainProblem, Scales]:
    """The problem in units of the wave to come: of F0, or of what a short shock makes of it if that is less."""
    natural = Scales.of(chain, shock.peak_force)
    # One number governs everything. Its last digits are the rounding of units: cut off, so that the same scene
    # in other units, or scaled to another chain, is the same problem to the last bit.
    ratio = float(f"{natural.rise_time(shock.rise_time):.{_DIGITS}g}")
    strength = ratio * shock.profile.areas().total / MOMENTUM
    force = min(1.0, strength**1.2)
    scales = Scales.of(chain, shock.peak_force * force)
    return ChainProblem(shock.profile, ratio * force ** (1 / 6), 1 / force, chain.granules), scales


def _result(
    shock: Shock,
    chain: Chain,
    scales: Scales,
    fine: Run,
    coarse: Run,
    rtol: float,
    integrator: str,
    wave_threshold: float,
) -> SimulationResult:
    waves = _waves(fine, coarse, scales)
    primary = waves[0]
    fastest = primary.granule_velocity
    ejected = tuple(u * scales.velocity for u in fine.recoils if -u * scales.velocity > EJECTED * fastest)
    result = SimulationResult(
        peak_force=primary.peak_force,
        amplification=primary.peak_force / shock.peak_force,
        error_estimate=1.0 if primary.error_estimate is None else primary.error_estimate,
        waves=waves,
        wave_threshold=wave_threshold,
        applied_momentum=fine.books.impulse * scales.momentum,
        recoil_momentum=sum(fine.recoils) * scales.momentum,
        recoil_error=(abs(sum(fine.recoils) - sum(coarse.recoils)) + fine.unfinished_recoil) * scales.momentum,
        recoil_velocities=ejected,
        ejected_granules=len(ejected),
        momentum_defect=abs(fine.books.momentum / fine.books.impulse - 1),
        energy_defect=abs(fine.books.energy / fine.books.work - 1),
        integrator=integrator,
        rtol=rtol,
        cost=Cost(
            steps=fine.steps + coarse.steps,
            force_evaluations=fine.evaluations + coarse.evaluations,
            seconds=0.0,
        ),
        warnings=shock.profile.notes,
        scene=Scene.of(shock, chain),
    )
    return evolve(result, warnings=(*result.warnings, *_warnings(fine, result, scales)))


def _waves(fine: Run, coarse: Run, scales: Scales) -> tuple[MeasuredWave, ...]:
    """Strongest first; the error of each: difference of the two runs, its own doubt, and the energy gone astray."""
    # Peak force goes with the 3/5 power of energy. The defect sees what both runs may miss: a contact that opens.
    astray = 0.6 * abs(fine.books.energy / fine.books.work - 1)
    measured = []
    for wave, doubt in zip(fine.waves, fine.doubts, strict=True):
        difference = min(abs(other.peak_force / wave.peak_force - 1) for other in coarse.waves)
        error = difference + doubt + astray + _ROUNDING
        measured.append(
            MeasuredWave(
                peak_force=wave.peak_force * scales.force,
                momentum=wave.momentum * scales.momentum,
                energy=wave.energy * scales.energy,
                speed=None if wave.speed is None else wave.speed * scales.wave_speed,
                width=wave.width * scales.time,
                granule_velocity=wave.granule_velocity * scales.velocity,
                contact=wave.contact,
                arrival_time=wave.time * scales.time,
                error_estimate=error if error < _UNSETTLED else None,
                foot=wave.foot,
            )
        )
    return tuple(sorted(measured, key=lambda wave: -wave.peak_force))


def _warnings(fine: Run, result: SimulationResult, scales: Scales) -> list[str]:
    warnings = []
    if result.error_estimate > result.rtol:
        warnings.append(
            f"the tolerance was not met: the primary's peak force is known to {result.error_estimate:.1e},"
            f" {result.rtol:.1e} was asked for"
        )
    if fine.reached_end:
        top = fine.strongest
        warnings.append(
            "the waves reach the free end before they are known to be steady: they are read at contact"
            f" {result.waves[0].contact} of this chain; its greatest contact force is"
            f" {si(top.force * scales.force, 'N')}, at contact {top.contact}"
        )
    elif not fine.settled or any(wave.error_estimate is None for wave in result.waves):
        warnings.append(
            "the tail had not come to rest when the last wave was read: waves near the threshold may lack or change"
            " (a higher wave_threshold leaves them out)"
        )
    return warnings
