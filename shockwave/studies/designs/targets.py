"""Targets: what of the primary a design may ask for, and options, scenes that may meet it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from attrs import asdict, evolve, frozen

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.solitary_wave import SolitaryWave
from shockwave.errors import InvalidValueError, ShockwaveError, nearest
from shockwave.fields import Quantity, text_of
from shockwave.measurement.simulate import simulate
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.units import to_si
from shockwave.studies.curve.response import Exponents, curve_of, duration_of

__all__ = ["TARGETS", "Option", "Simulated", "Target"]

#: What may be asked of the primary -> its SI unit.
TARGETS = {
    "peak_force": "N",
    "amplification": "",
    "momentum": "N*s",
    "energy": "J",
    "speed": "m/s",
    "width": "s",
    "granule_velocity": "m/s",
}
_VERIFIED = 1e-8
# A simulation that differs from the curve by so many times its error is of another scene: of a chain too short for it.
_FAR = 5.0


@frozen
class Target:
    """A quantity of the primary and the value that it is to have.

    Attributes
    ----------
    name : str
        One of `TARGETS`.
    value : float
        In its SI unit.
    """

    name: str
    value: float

    @classmethod
    def of(cls, given: Any) -> Target:
        """The target of a mapping of one name to a number or to text with a unit.

        Raises
        ------
        InvalidValueError
            When the name is unknown or the value is none above 0.
        """
        if not isinstance(given, Mapping) or len(given) != 1:
            example = '{"peak_force": "60 N"}'
            raise InvalidValueError.of(
                "target", f"must be one quantity and its value, {example} (got {text_of(given)})"
            )
        ((name, value),) = given.items()
        if name not in TARGETS:
            hint = nearest(str(name)[:60], TARGETS)
            problem = f"must be a quantity of the primary (got {text_of(name)}; {hint}known: {', '.join(TARGETS)})"
            raise InvalidValueError.of("target", problem)
        path = f"target.{name}"
        try:
            number = to_si(value, TARGETS[name])
        except ValueError as error:
            raise InvalidValueError.of(path, str(error)) from None
        if wrong := Quantity(TARGETS[name], "", above=0).problem(number):
            raise InvalidValueError.of(path, wrong)
        return cls(name, number)

    @property
    def unit(self) -> str:
        """As people write it."""
        return TARGETS[self.name].replace("*", " ")

    def reached(self, peak_force: float, scenario: Scenario) -> float:
        """The quantity in a scene whose primary has this peak force [N]."""
        if self.name == "amplification":
            return peak_force / scenario.shock.peak_force
        return float(getattr(SolitaryWave.of(peak_force, scenario.chain), self.name))

    def distance(self, option: Option) -> float:
        """How far ``option`` is from it: the logarithm of their ratio, without its sign."""
        return abs(math.log(option.reached) - math.log(self.value))

    def power(self, scenario: Scenario) -> float:
        """The power with which it goes with the peak force of the primary alone."""
        return _power(self.reached(2.0, scenario) / self.reached(1.0, scenario))

    def power_of(self, scenario: Scenario, doubled: Scenario) -> float:
        """The power with which it goes with a value at the same amplification, of which one scene has the double."""
        forces = scenario.shock.peak_force, doubled.shock.peak_force
        return _power(self.reached(forces[1], doubled) / self.reached(forces[0], scenario))


def _power(ratio: float) -> float:
    # these are small fractions: what is more is rounding
    return round(math.log2(ratio), 12)


@frozen(kw_only=True)
class Simulated:
    """What a simulation of the scene itself says.

    Attributes
    ----------
    reached : float
        The quantity that is the target.
    peak_force : float
        Of the primary [N].
    error_estimate : float
        Relative, of the peak force.
    """

    reached: float
    peak_force: float
    error_estimate: float


@frozen(kw_only=True)
class Option:
    """A scene that differs from the scenario in one value.

    Attributes
    ----------
    value : float or str
        That value: in SI units, or the name of a material.
    reached : float
        The quantity that is the target.
    peak_force, amplification : float
        Of the primary [N], and over that of the shock.
    error, reached_error : float
        Bounds on the relative error of these two, and of ``reached``.
    momentum, energy, speed, width, granule_velocity : float
        Of the primary [N s], [J], [m/s], [s], [m/s]; as of `SolitaryWave`.
    rise_time : float
        t0/T0, of the shock over the natural time of the chain.
    granule_mass, mass_per_length : float
        Of one granule [kg], of the chain [kg/m].
    chain_mass : float or None
        Of all granules [kg], if their number is known.
    exponents : Exponents
        Powers with which the peak force goes with what makes the scene.
    simulated : Simulated or None
        Of the scene itself, for solutions and for the nearest.
    value_error : float or None
        Of solutions that are numbers: by how much ``value`` may be off, in its unit; None where that is not known.
    """

    value: float | str
    reached: float
    peak_force: float
    amplification: float
    error: float
    reached_error: float
    momentum: float
    energy: float
    speed: float
    width: float
    granule_velocity: float
    rise_time: float
    granule_mass: float
    mass_per_length: float
    chain_mass: float | None
    exponents: Exponents
    simulated: Simulated | None = None
    value_error: float | None = None

    @classmethod
    def of(cls, value: float | str, scenario: Scenario, target: Target, rtol: float, reach: float = 0.0) -> Option:
        """The option that ``scenario`` is, which has ``value``; by a curve that goes on to n t0/T0 = ``reach``."""
        shock, chain = scenario.shock, scenario.chain
        curve = curve_of(shock.profile, rtol, max(duration_of(scenario), reach))
        answer = curve.answer(shock, chain)
        wave = SolitaryWave.of(answer.peak_force, chain)
        return cls(
            value=value,
            reached=target.reached(answer.peak_force, scenario),
            reached_error=abs(target.power(scenario)) * answer.error,
            amplification=answer.amplification,
            error=answer.error,
            peak_force=answer.peak_force,
            momentum=wave.momentum,
            energy=wave.energy,
            speed=wave.speed,
            width=wave.width,
            granule_velocity=wave.granule_velocity,
            rise_time=Scales.of(chain, shock.peak_force).rise_time(shock.rise_time),
            granule_mass=chain.granule_mass,
            mass_per_length=chain.granule_mass / (2 * chain.radius),
            chain_mass=_mass(chain),
            exponents=Exponents.of(scenario, curve),
        )

    def known(self, slope: float, least: float) -> Option:
        """With how well the value is known, which changes by ``slope`` over the share by which the target does."""
        error = slope * max(self.reached_error, least)
        return evolve(self, value_error=error if math.isfinite(error) else None)

    def misses(self, target: Target, rtol: float) -> bool:
        """Whether its simulation misses the target by far more than the curve may err."""
        if self.simulated is None:
            return False
        off = abs(self.simulated.reached / target.value - 1)
        return off > _FAR * max(self.reached_error, rtol) + self.simulated.error_estimate

    def verified(self, scenario: Scenario, target: Target) -> tuple[Option, str]:
        """The option with what its simulation says, or with why there is none."""
        try:
            result = simulate(scenario.shock, scenario.chain, rtol=_VERIFIED, waves="primary")
        except ShockwaveError as error:
            return self, f"no simulation at {self.value}: {error}"
        found = Simulated(
            reached=target.reached(result.peak_force, scenario),
            peak_force=result.peak_force,
            error_estimate=result.error_estimate,
        )
        return evolve(self, simulated=found), ""

    def to_dict(self) -> dict[str, Any]:
        """SI floats by name."""
        return asdict(self)


def _mass(chain: Chain) -> float | None:
    return None if chain.granules is None else chain.granules * chain.granule_mass
