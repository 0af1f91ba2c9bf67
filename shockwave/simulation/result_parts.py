"""Parts of the result of a simulation: waves, passages, train, contact forces, structure, segments, cost."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from attrs import evolve, field, frozen

from shockwave.base.text import round_digits, si
from shockwave.base.units import STANDARD_GRAVITY
from shockwave.engine.search_request import Primary
from shockwave.scene.chain import Scales
from shockwave.scene.force_limit import SPRING, LeavingForce

if TYPE_CHECKING:  # other results do not need it
    from shockwave.simulation.first_pulse import FirstPulse


@frozen(kw_only=True, slots=False)  # faster to make
class Cost:
    """Cost of a result; ``seconds`` [s] vary from run to run and are ignored in comparisons."""

    steps: int
    force_evaluations: int
    seconds: float = field(eq=False)

    def __add__(self, other: Cost) -> Cost:
        evaluations = self.force_evaluations + other.force_evaluations
        seconds = self.seconds + other.seconds
        return Cost(steps=self.steps + other.steps, force_evaluations=evaluations, seconds=seconds)


@frozen(kw_only=True, slots=False)  # faster to make
class LeadingWave:
    """The leading wave far along the chain, as the search found it.

    Attributes
    ----------
    scaled : Primary
        The wave in scaled units, with the balances of momentum and energy.
    scales : Scales
        Units of ``scaled``.
    error_estimate : float
        Relative error estimate of ``peak_force``, from step control, the approach to the limit, and the table of the
        force.
    """

    scaled: Primary
    scales: Scales
    error_estimate: float

    @property
    def peak_force(self) -> float:
        """Peak force [N]."""
        return self.scaled.peak * self.scales.contact_force

    @property
    def applied_energy(self) -> float:
        """Work of the shock [J]."""
        return float(self.scaled.work * self.scales.energy)


@frozen(kw_only=True)
class ContactPeak:
    """Greatest force at a contact.

    Attributes
    ----------
    contact : int
        The contact, counted from 0.
    peak_force : float
        Greatest total contact force [N].
    time : float
        Time of this force [s].
    error_estimate : float
        Estimated error of the force, relative to its dynamic part ``peak_force - static_force``.
    static_force : float
        Force at the contact before the shock arrives [N].
    residual_overlap : float
        Overlap at which the force of an elastic-plastic contact vanishes at the end of the simulated time [m]; zero if
        it has not flowed, and for contacts with other laws, those of plugins included.
    """

    contact: int
    peak_force: float
    time: float
    error_estimate: float
    static_force: float = 0.0
    residual_overlap: float = 0.0
    pulses: Callable[[], Mapping[int, FirstPulse]] | None = field(default=None, eq=False, repr=False)

    @property
    def first(self) -> FirstPulse | Any:
        """The first pulse at the contact, integrated at the first access; None if it could not be computed."""
        return None if self.pulses is None else self.pulses().get(self.contact)

    @property
    def total_error(self) -> float:
        """Estimated error relative to the whole force."""
        return 1 - self.low / self.peak_force if self.peak_force else self.error_estimate

    @property
    def low(self) -> float:
        """The force less its error estimate [N]."""
        return self.peak_force - self.error_estimate * (self.peak_force - self.static_force)

    @property
    def high(self) -> float:
        """The force plus its error estimate [N]."""
        return 2 * self.peak_force - self.low

    def leaving(self, name: str, arrived: bool, later: float) -> LeavingForce:
        """The force as that which a chain transmits; see `LeavingForce.from_simulation`."""
        return LeavingForce.from_simulation(name, self.peak_force, self.peak_force - self.low, arrived, later)


@frozen(kw_only=True)
class Transmitted(ContactPeak):
    """Force on the wall at the end of the chain.

    Attributes
    ----------
    impulse : float
        Integral of the total force minus the static force, from 0 to the end of the simulated time [N s].
    impulse_error : float
        Estimated relative error of the impulse. Late collisions in a long chain amplify errors, and the impulse depends
        on them, unlike the greatest force.
    """

    impulse: float
    impulse_error: float


@frozen(kw_only=True)
class Striker:
    """Striker after its impact.

    Attributes
    ----------
    velocity : float
        Velocity at the end of the simulated time [m/s], negative away from the chain.
    restitution : float or None
        Coefficient of restitution, as of the result.
    """

    velocity: float
    restitution: float | Any


@frozen(kw_only=True)
class Structure:
    """Motion of a movable end: greatest magnitudes within the simulated time.

    Attributes
    ----------
    peak_displacement, peak_acceleration : float or None
        Displacement from the static state [m] and acceleration [m/s^2]; None for an end that is integrated as a fixed
        wall.
    peak_spring_force : float
        Force of spring and dashpot on the ground, k x + c x' [N], without the static load.
    peak_displacement_error, peak_acceleration_error, peak_spring_force_error : float
        Estimated relative errors.
    peak_displacement_time, peak_acceleration_time, peak_spring_force_time : float or None
        Times at which these are reached [s].
    """

    peak_displacement: float | Any
    peak_acceleration: float | Any
    peak_spring_force: float
    peak_displacement_error: float | None
    peak_acceleration_error: float | None
    peak_spring_force_error: float
    peak_displacement_time: float | None
    peak_acceleration_time: float | None
    peak_spring_force_time: float

    @property
    def error_estimate(self) -> float:
        """The largest of the errors."""
        errors = self.peak_displacement_error, self.peak_acceleration_error, self.peak_spring_force_error
        return max(error for error in errors if error is not None)

    def leaving(self, arrived: bool, later: float) -> LeavingForce:
        """The spring force as a force that is limited; see `LeavingForce.from_simulation`."""
        error = self.peak_spring_force_error * self.peak_spring_force
        return LeavingForce.from_simulation(SPRING, self.peak_spring_force, error, arrived, later)

    def facts(self) -> Iterator[tuple[str, str]]:
        """Labels and texts of the motion and the spring force."""
        if self.peak_acceleration is not None:
            displacement = si(self.peak_displacement, "m", error=self.peak_displacement_error)
            acceleration = f"{round_digits(self.peak_acceleration, 5)} m/s^2"
            in_g = f"{round_digits(self.peak_acceleration / STANDARD_GRAVITY, 4)} g"
            yield "structure", f"displacement {displacement}, acceleration {acceleration} ({in_g})"
        if self.peak_spring_force:
            error, time = self.peak_spring_force_error, si(self.peak_spring_force_time, "s", 5)
            force = si(self.peak_spring_force, "N", error=error)
            yield "spring force", f"{force} at {time}, estimated error {error:.0e}"


@frozen(kw_only=True)
class ContactForces:
    """Greatest forces at the contacts within the simulated time.

    Attributes
    ----------
    contacts : tuple of ContactPeak
        Greatest total force at each reported contact, in the order of the contacts; force and time are 0 at a contact
        that never closes.
    greatest : ContactPeak or None
        Greatest force at any contact; None if it is not known.
    leaving : LeavingForce
        The transmitted force, on the wall or at the last contact.
    warnings : tuple of str
        Reason why forces are not known.
    """

    contacts: tuple[ContactPeak, ...] = ()
    greatest: ContactPeak | None = None
    leaving: LeavingForce
    warnings: tuple[str, ...] = ()


@frozen(kw_only=True)
class SegmentEnergy:
    """Energy in a segment of the chain at the end of the simulated time.

    Attributes
    ----------
    first, last : int
        Numbers of its first and its last granule.
    energy : float
        Kinetic energy of its granules and elastic energy of their contacts [J], relative to the static state. Half of
        the energy of a contact between two segments is assigned to each; that of the contact with the wall is assigned
        to the last segment.
    dissipated : float
        Energy dissipated at these contacts [J], assigned in the same way.
    """

    first: int
    last: int
    energy: float
    dissipated: float


@frozen(kw_only=True)
class Dissipated:
    """Energy dissipated within the simulated time [J].

    Attributes
    ----------
    energy : float
        All of it.
    plastic : float
        By plastic flow of contacts.
    damping : float
        By damping of contacts. With the contact law of a plugin, whose stored energy is not known, it includes that of
        the contacts that are closed at the end.
    end : float
        By the dashpot of a movable wall.
    bar : float
        By waves into a bar at the end.
    """

    energy: float
    plastic: float
    damping: float
    end: float
    bar: float = 0.0


@frozen(kw_only=True)
class Train:
    """All waves of a train, and the granules that leave the ends of the chain.

    Attributes
    ----------
    waves : tuple of MeasuredWave
        Waves, strongest first, down to ``wave_threshold`` times the peak force of the leading wave; empty in chains
        without a steady leading wave.
    recoil_momentum, recoil_error : float or None
        Momentum of the rebounding granules [N s], zero or negative; estimate of its error [N s], which includes the
        momentum of granules that had not separated for good. None under precompression or gravity; the error also in
        chains without a steady leading wave.
    recoil_velocities : tuple of float or None
        Velocities of the ejected granules [m/s], first granule first. Ejected granules rebound faster than a
        thousandth of the peak velocity of the granules in the leading wave; without a steady leading wave, of the
        fastest granule.
    spall_velocities : tuple of float or None
        Velocities of the granules that leave the free end [m/s], last granule first; None if the chain is endless
        or the waves were not followed to its end.
    greatest_force : ContactPeak or None
        Greatest contact force; None on an endless chain unless it exceeds that of the leading wave by 1 %.
    cost : Cost
        Cost of the two runs.
    warnings : tuple of str
        Sentences on the limits of the result.
    """

    waves: tuple[MeasuredWave, ...] = ()
    recoil_momentum: float | None = 0.0
    recoil_error: float | None = None
    recoil_velocities: tuple[float, ...] | None = ()
    spall_velocities: tuple[float, ...] | None = None
    greatest_force: ContactPeak | None = None
    cost: Cost = Cost(steps=0, force_evaluations=0, seconds=0.0)
    warnings: tuple[str, ...] = ()

    @property
    def is_integrated(self) -> bool:
        """Whether the waves were measured; otherwise only the leading wave is known."""
        return self.cost.steps > 0


# ---------------------------------------------------------------- waves

# Attribute of a wave -> attribute of `Scales` that is its unit.
_UNITS = {
    "peak_force": "contact_force",
    "momentum": "momentum",
    "energy": "energy",
    "speed": "wave_speed",
    "width": "time",
    "granule_velocity": "velocity",
    "arrival_time": "time",
}


@frozen(kw_only=True)
class MeasuredWave:
    """A wave measured at a contact, in SI units (in scaled units until the result is complete).

    Attributes
    ----------
    peak_force, momentum, energy, width, granule_velocity : float
        As in `SolitaryWave`, measured from the history of the contact force. If only the leading wave was followed, its
        width and granule velocity are those of the exact wave of the same peak force.
    speed : float or None
        Speed of the peak along the chain [m/s]; None if only one contact was passed.
    contact : int
        Contact at which the wave was measured, counted from 0; contact i lies between granules i and i + 1.
    arrival_time : float
        Time of the peak at this contact [s].
    error_estimate : float or None
        Relative error estimate of ``peak_force`` as the limit far along the chain; None for a wave that had not
        settled, or that was found in only one of the two runs.
    foot : float
        Residual force between the wave and its neighbours, over its peak force; approximately the relative error of
        momentum, energy, width and granule velocity.
    """

    peak_force: float
    momentum: float
    energy: float
    speed: float | None
    width: float
    granule_velocity: float
    contact: int
    arrival_time: float
    error_estimate: float | None
    foot: float

    def in_si(self, scales: Scales, error_estimate: float | None) -> MeasuredWave:
        """Convert a wave in scaled units to SI units, with its error estimate."""
        known = {name: value for name in _UNITS if (value := getattr(self, name)) is not None}
        values = {name: value * getattr(scales, _UNITS[name]) for name, value in known.items()}
        return evolve(self, error_estimate=error_estimate, **values)


@frozen(kw_only=True)
class Passage:
    """The leading wave at a contact, in SI units.

    Attributes
    ----------
    contact : int
        The contact, counted from 0.
    arrival_time : float
        Time of the peak [s].
    peak_force : float
        Peak contact force [N].
    exact : bool
        Whether the wave had settled before this contact, so that the values follow from the exact solitary wave.
    error_estimate : float
        Relative error estimate of both time and peak force.
    """

    contact: int
    arrival_time: float
    peak_force: float
    exact: bool
    error_estimate: float

    @classmethod
    def of(cls, scales: Scales, contact: int, time: float, force: float, error: float, exact: bool = False) -> Passage:
        """The passage with this time and force in the units ``scales``."""
        time, force = time * scales.time, force * scales.contact_force
        return cls(contact=contact, arrival_time=time, peak_force=force, exact=exact, error_estimate=error)
