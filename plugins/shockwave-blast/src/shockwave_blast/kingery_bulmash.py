"""The force of an explosion on the first sphere of a chain, by charge and standoff."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from typing import Any, get_args

import attrs
from attrs import frozen
from scipy.optimize import brentq
from shockwave import Friedlander, InvalidValueError, ShockProfile, quantity
from shockwave.hooks import FloatArray

from shockwave_blast.curves import FARTHEST, NEAREST, BlastWave, Burst, Loading, blast_wave

__all__ = ["KingeryBulmash"]

# Error of the decay coefficient, absolute and relative: the least that `brentq` admits.
_ACCURACY = 4 * sys.float_info.epsilon


def _one_of(names: Sequence[str]) -> Callable[[Any, attrs.Attribute[Any], Any], None]:
    """Validator of a field whose value is one of ``names``."""

    def check(_: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
        if not (isinstance(value, str) and value in names):
            listed = " or ".join(repr(name) for name in names)
            raise InvalidValueError.of(attribute.name, f"must be {listed} (got {value!r})")

    return check


@frozen(kw_only=True)
class KingeryBulmash(ShockProfile):
    """The Friedlander pulse of a TNT charge on a sphere, by the curves of Kingery and Bulmash.

    The curves give peak pressure p, duration td and impulse I at the scaled distance Z = R/W^(1/3). The shape
    is that of `Friedlander` with n = 1/rise_fraction; n t0 = td, and b is chosen so that the whole pulse,
    including the rise, has the impulse I: p td (r/2 + (1 - r) g(b)) = I, with r = rise_fraction and g(b) = (b
    - 1 + exp(-b))/b^2. As r goes to 0 this is the usual I = p td (1/b - (1 - exp(-b))/b^2).

    The peak force is F0 = p pi a^2 with a = loaded_radius. The profile defines F0 and t0: omit
    ``peak_force``, ``rise_time`` and ``duration``.

    Parameters
    ----------
    charge_mass : float
        W [kg TNT], above 0; for another explosive, its TNT equivalent.
    standoff : float
        R [m], from the centre of the charge to the sphere; 0.178 to 40 m/kg^(1/3) times W^(1/3) for a surface
        burst, from 0.147 for a free-air burst, the range in which the curves give a duration.
    burst : {"surface", "free-air"}
        A hemisphere of TNT on hard ground, or a sphere of TNT far from any surface. There is no default,
        because a surface burst has about the effect of 1.8 times the charge.
    loading : {"reflected", "incident"}
        Pressure on a large wall that faces the charge, or in the undisturbed wave (side-on). There is no
        default, because they differ by a factor of 2 (far) to more than 10 (near).
    loaded_radius : float
        Radius a [m] of the spheres of the chain, above 0, which is unknown to a profile.
    rise_fraction : float
        Rise time over total duration, 1e-6 to 0.05. The front itself rises within nanoseconds.

    Attributes
    ----------
    wave : BlastWave
        p [Pa], td [s] and I [Pa s].
    decay_coefficient : float
        b.

    Raises
    ------
    InvalidValueError
        When a value is out of range, or when the wave has a larger impulse than a straight decay with its
        peak and duration, as the incident wave of a free-air burst has beyond Z = 33.47.

    Notes
    -----
    Assumptions: the pressure acts on the projected area pi a^2, uniformly and instantaneously. The model
    neglects the diffraction of the wave around a sphere that is small compared with it, clearing (which takes
    about 3 a over the speed of sound), the pressure behind the sphere, the drag of the wind, the negative
    phase, fragments and the fireball. A reflected pulse on a small sphere is an upper bound; an incident
    pulse neglects the reflection.

    Accuracy: Swisdak's fits of the same curves agree within 1 %, and the pieces of a curve differ by up to
    1.81 % where they meet (duration of a surface burst at Z = 1.01). These are errors of the fit. The surface
    curves are based on tests with 5 to 500 tons of TNT; single tests scatter by much more, most of all near
    the charge, and results for grams rest on cube-root scaling alone.

    The conditions (3) hold for all accepted values, with the margins that `Friedlander` states: b is at most
    17.1 with the default rise, where a2 - a1 is above 54, and at most 30 with the longest rise, where it is
    above 0.11.

    References
    ----------
    Kingery, C. N. and Bulmash, G. (1984). Airblast parameters from TNT spherical air burst and hemispherical
    surface burst. ARBRL-TR-02555.

    Swisdak, M. M. (1994). Simplified Kingery airblast calculations. 26th DoD Explosives Safety Seminar.
    """

    charge_mass: float = quantity("kg", "mass of TNT", above=0, example="1 g")
    standoff: float = quantity("m", "distance from the centre of the charge", above=0, example="10 cm")
    burst: Burst = attrs.field(validator=_one_of(get_args(Burst)))
    loading: Loading = attrs.field(validator=_one_of(get_args(Loading)))
    loaded_radius: float = quantity("m", "radius of the spheres of the chain", above=0, example="4.75 mm")
    rise_fraction: float = quantity(
        "", "rise time over total duration", default=1e-3, at_least=1e-6, at_most=0.05
    )
    wave: BlastWave = attrs.field(init=False, repr=False)
    _pulse: Friedlander = attrs.field(init=False, repr=False)

    def __attrs_post_init__(self) -> None:
        self._check_distance()
        wave = blast_wave(self.charge_mass, self.standoff, self.burst, self.loading)
        object.__setattr__(self, "wave", wave)
        object.__setattr__(self, "_pulse", self._fit_pulse(wave))

    @property
    def duration_ratio(self) -> float:
        return self._pulse.duration_ratio

    @property
    def decay_coefficient(self) -> float:
        """Coefficient b."""
        return self._pulse.decay_coefficient

    def rise(self, s: FloatArray) -> FloatArray:
        return self._pulse.rise(s)

    def decay(self, s: FloatArray) -> FloatArray:
        return self._pulse.decay(s)

    def closed_areas(self) -> tuple[float, float]:
        return self._pulse.closed_areas()

    def closed_running_impulse(self, s: FloatArray) -> FloatArray:
        return self._pulse.closed_running_impulse(s)

    @property
    def scaled_distance(self) -> float:
        """Z = R/W^(1/3) [m/kg^(1/3)]."""
        return self.standoff / math.cbrt(self.charge_mass)

    @property
    def recorded_peak_force(self) -> float:
        """F0 = p pi a^2 [N]."""
        return self.wave.pressure * math.pi * self.loaded_radius**2

    @property
    def recorded_rise_time(self) -> float:
        """t0 = td/n [s]."""
        return self.wave.duration * self.rise_fraction

    @property
    def notes(self) -> tuple[str, ...]:
        return (
            f"the {self.loading} pressure acts uniformly and instantaneously on the projected area of the"
            f" sphere, {math.pi * self.loaded_radius**2:.4g} m^2; diffraction, clearing and drag are"
            " neglected",
            f"curves of Kingery and Bulmash at {self.scaled_distance:.4g} m/kg^(1/3): other fits agree within"
            " 1 %, but single explosions scatter by much more",
        )

    def _check_distance(self) -> None:
        nearest, distance = NEAREST[self.burst], self.scaled_distance
        if nearest <= distance <= FARTHEST:
            return
        root = math.cbrt(self.charge_mass)
        rule = (
            f"must be {nearest * root:.4g} m to {FARTHEST * root:.4g} m from {self.charge_mass:g} kg in a"
            f" {self.burst} burst, scaled {nearest:g} to {FARTHEST:g} m/kg^(1/3)"
        )
        got = f"got {self.standoff:g} m, scaled {distance:.4g} m/kg^(1/3); the curves end there"
        raise InvalidValueError.of("standoff", f"{rule} ({got})")

    def _fit_pulse(self, wave: BlastWave) -> Friedlander:
        """The pulse with the impulse of the wave."""
        rise = self.rise_fraction
        area = (wave.impulse / (wave.pressure * wave.duration) - rise / 2) / (1 - rise)
        if area > 0.5:
            problem = (
                "must be in the range where the impulse is at most that of a straight decay"
                f" (got {self.standoff:g} m, scaled {self.scaled_distance:.4g} m/kg^(1/3), where it has"
                f" {2 * area:.4g} times that; reduce the standoff or use the reflected pressure)"
            )
            raise InvalidValueError.of("standoff", problem)

        def decay_area(b: float) -> float:
            """Integral of (1 - u) exp(-b u) over 0 <= u <= 1."""
            return Friedlander(decay_coefficient=b, rise_fraction=0.5).closed_areas()[1]

        # it is below 1/b for every b
        b = brentq(lambda b: decay_area(b) - area, 0.0, 1 / area, xtol=_ACCURACY, rtol=_ACCURACY)
        return Friedlander(decay_coefficient=float(b), rise_fraction=rise)
