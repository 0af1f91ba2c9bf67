"""The result of a simulation: waves, contact forces, histories and cost, of every chain."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from attrs import evolve, field, frozen

from shockwave.base.errors import NumericalError
from shockwave.base.result import cached_property
from shockwave.base.text import render
from shockwave.scene.force_limit import LAST, WAVE, LeavingForce
from shockwave.scene.plausibility import unusual_warnings
from shockwave.scene.scene import Scene
from shockwave.scene.scene_result import SceneResult
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.scene.solitary_wave import SolitaryWave
from shockwave.scene.yielding import Yielding, find_yielding, warn_beyond
from shockwave.simulation.recording import Recording
from shockwave.simulation.result_parts import (
    ContactForces,
    ContactPeak,
    Cost,
    Dissipated,
    LeadingWave,
    MeasuredWave,
    Passage,
    SegmentEnergy,
    Striker,
    Structure,
    Train,
    Transmitted,
)
from shockwave.simulation.simulation_document import document_of

if TYPE_CHECKING:  # other results do not need it
    from shockwave.base.quantity_fields import Number
    from shockwave.simulation.first_pulse import FirstPulse
    from shockwave.simulation.shock_spectrum import ShockSpectrum


@frozen(kw_only=True, slots=False, repr=False)
class Simulation(SceneResult):
    """Result of a simulation of eq. (1).

    On a uniform chain the leading wave has a limit (``wave``), which is computed at once. The rest of the train is
    integrated when one of its parts is first accessed (``train``, ``waves``, ``print``), and then kept; likewise the
    forces at the contacts and the histories (``recording``). On other chains the forces at the contacts (``forces``)
    are the result, and ``wave`` is None. Whatever a chain does not have is None or empty; it is typed ``| Any``, so
    that a program that knows its chain needs no check. Two results are equal if scene, settings and computed values are
    equal.

    Attributes
    ----------
    scene, options : Scene, SimulateOptions
        Scene and settings, with all defaults filled in.
    integrator, backend : str
        Name of the integrator; ``compiled`` or ``numpy``, the code that integrated the chain.
    wave : LeadingWave or None
        The leading wave far along the chain.
    applied_momentum, applied_energy : float, float or None
        Impulse and work of the shock, or momentum and energy of the striker, and impulse and work of its weight within
        the simulated time [N s, J]; the energy is None on uniform chains.
    momentum_defect : float
        Momentum of the granules less the applied momentum and that of the wall, relative to the applied momentum.
    energy_defect : float
        Energy of the chain and dissipated energy less the applied energy, relative to the applied energy.
    characteristic_time : float
        Unit of time of the computation [s].
    run_cost : Cost
        Cost of the runs that were made at once.
    run_warnings : tuple of str
        Sentences on the limits of these runs.
    computation : callable
        Computes another part: called with its name, the result and further arguments.
    measured : Train or None
        Waves and rebounding granules, if they were measured at once.
    forces : ContactForces or None
        Greatest forces at the contacts, if they were computed at once.
    transmitted, structure : Transmitted, Structure or None
        Force on the wall, and greatest motion of a movable end; None without one.
    end, arrival_time : float or None
        End of the simulated time, and time at which the leading wave reaches the last contact, if it does [s].
    velocities : tuple of float or None
        Velocities of all granules at the end of the simulated time [m/s], the striker first; in an endless chain, of
        those that the waves have reached.
    restitution : float or None
        Coefficient of restitution of a striker that has rebounded: its velocity away from the chain's centre of mass
        or, with a wall, away from the wall, divided by its velocity before the impact. None without a striker, or if
        the striker still touches the first granule. Under gravity, when the striker falls back, it is that of its first
        separation.
    segments : tuple of SegmentEnergy or None
        Energy in each segment at the end of the simulated time; a striker is a segment of its own.
    dissipated : Dissipated or None
        Energy dissipated by contacts and by the wall.
    end_energy : float or None
        Kinetic and elastic energy of a movable wall and its spring [J]; None without one.
    first_yield : Yielding or None
        First yield of the contacts, if it was judged at once.
    """

    scene: Scene
    options: SimulateOptions
    integrator: str
    backend: str
    wave: LeadingWave | Any
    applied_momentum: float
    momentum_defect: float
    energy_defect: float
    characteristic_time: float
    run_cost: Cost
    run_warnings: tuple[str, ...]
    computation: Callable[..., Any] = field(eq=False)
    measured: Train | None = field(default=None, eq=False)
    forces: ContactForces | None = None
    transmitted: Transmitted | Any = None
    structure: Structure | Any = None
    end: float | Any = None
    arrival_time: float | Any = None
    velocities: tuple[float, ...] | Any = None
    restitution: float | Any = None
    segments: tuple[SegmentEnergy, ...] | Any = None
    applied_energy: float | Any = None
    dissipated: Dissipated | Any = None
    end_energy: float | Any = None
    first_yield: Yielding | None = None

    @property
    def rtol(self) -> float | None:
        """Requested relative error; None for a fixed-step method."""
        return self.options.rtol

    @property
    def peak_force(self) -> float | Any:
        """Peak force of the leading wave far along the chain [N]; None where it has no limit."""
        return None if self.wave is None else self.wave.peak_force

    @property
    def amplification(self) -> float | Any:
        """Peak force of the leading wave over that of the shock."""
        if self.wave is None or self.shock is None:
            return None
        return self.wave.peak_force / (self.shock.peak_force * self.chain.contact_share)

    @property
    def error_estimate(self) -> float:
        """Relative error estimate of ``peak_force``; without one, the largest of reported contacts and structure."""
        if self.wave is None:
            return max(float(part.error_estimate) for part in (*self._forces.contacts, self.structure) if part)
        return self.wave.error_estimate

    @cached_property
    def primary(self) -> MeasuredWave | Any:
        """Leading wave at the contact where it was measured."""
        if self.wave is None:
            return None
        if self.measured is not None:
            return self.measured.waves[0]
        scaled_wave, scales = self.wave.scaled, self.wave.scales
        exact = SolitaryWave.of(self.wave.peak_force, self.chain)
        return MeasuredWave(
            peak_force=self.wave.peak_force,
            momentum=scaled_wave.momentum * scales.momentum,
            energy=scaled_wave.energy * scales.energy,
            speed=scaled_wave.speed * scales.wave_speed,
            width=exact.width,
            granule_velocity=exact.granule_velocity,
            contact=int(scaled_wave.contact),
            arrival_time=scaled_wave.time * scales.time,
            error_estimate=self.wave.error_estimate,
            foot=scaled_wave.foot / scaled_wave.peak,
        )

    def passage(self, contact: int) -> Passage:
        """Compute the leading wave at ``contact``, counted from 0.

        Beyond the contact where the wave was measured, the result follows from the exact wave at no cost. For earlier
        contacts the chain is integrated again up to there.

        Raises
        ------
        InvalidValueError
            If the chain has no such contact.
        NumericalError
            If the leading wave has no peak at this contact, because the force still rises there, or no limit.
        """
        if self.wave is None:
            raise NumericalError("the leading wave has no limit along this chain (read contacts instead)")
        passage: Passage | NumericalError = self.computation("passages", self, (contact,))[0]
        if isinstance(passage, NumericalError):
            raise passage
        return passage

    @property
    def striker(self) -> Striker | Any:
        """Striker at the end of the simulated time; None without one."""
        struck = self.scene.impact is not None
        return Striker(velocity=self.velocities[0], restitution=self.restitution) if struck else None

    @property
    def passages(self) -> tuple[Passage, ...]:
        """Leading wave at the requested contacts, without those at which it has no peak."""
        return self._passages[0]

    @cached_property
    def train(self) -> Train:
        """All waves and the rebounding granules, integrated at the first access."""
        return self.measured or self.computation("train", self)

    @property
    def waves(self) -> tuple[MeasuredWave, ...]:
        """Waves, strongest first; only the leading wave if the option ``waves`` is ``primary``."""
        if self.options.waves == "train":
            return self.train.waves
        return () if self.primary is None else (self.primary,)

    @property
    def recoil_momentum(self) -> float | Any:
        """Momentum of the rebounding granules [N s]; None under precompression or gravity."""
        return self.train.recoil_momentum

    @property
    def recoil_error(self) -> float | Any:
        """Estimate of the error of ``recoil_momentum`` [N s]."""
        return self.train.recoil_error

    @property
    def recoil_velocities(self) -> tuple[float, ...] | Any:
        """Velocities of the ejected granules [m/s], first granule first."""
        return self.train.recoil_velocities

    @property
    def ejected_granules(self) -> int | Any:
        """Number of granules that rebound faster than a thousandth of the granule velocity of the leading wave."""
        return None if self.recoil_velocities is None else len(self.recoil_velocities)

    @property
    def spall_velocities(self) -> tuple[float, ...] | Any:
        """Velocities of the granules that leave the free end [m/s], last granule first."""
        return self.train.spall_velocities

    @property
    def contacts(self) -> tuple[ContactPeak, ...]:
        """Greatest force at each reported contact of a finite chain within the simulated time; else empty."""
        return tuple(evolve(peak, pulses=partial(getattr, self, "_contact_pulses")) for peak in self._forces.contacts)

    @property
    def sensors(self) -> tuple[FirstPulse, ...]:
        """First pulses of the sensors that the options name, integrated at the first access."""
        return self._sensors[0]

    @property
    def greatest_force(self) -> ContactPeak | Any:
        """Greatest contact force; None on an endless chain unless it exceeds that of the leading wave by 1 %.

        On a uniform chain with the option ``until``, or if ``waves`` is ``primary``, it is the greatest one within the
        simulated time of `contacts`.
        """
        ends = self.chain.count is not None and self.options.until is not None
        if self.wave is None or self.options.waves == "primary" or ends:
            return self._forces.greatest
        return self.train.greatest_force

    @property
    def leaving(self) -> LeavingForce:
        """The transmitted force, on the wall, at the last contact, or of the leading wave in an endless chain."""
        if self.wave is None or self.chain.count is not None:
            return self._forces.leaving
        return LeavingForce.from_simulation(WAVE, self.wave.peak_force, self.wave.error_estimate * self.wave.peak_force)

    @property
    def yielding(self) -> Yielding | None:
        """First yield of the contacts; None if the yield strength is not known.

        On a uniform chain the peak force is that of the leading wave or, if the option ``waves`` is ``train``, a
        greater contact force.
        """
        if self.wave is None or self.chain.material.yield_strength is None:
            return self.first_yield
        top = self.greatest_force if self.options.waves == "train" else None
        return find_yielding(self.chain, max(self.wave.peak_force, 0.0 if top is None else top.peak_force))

    @property
    def recording(self) -> Recording | Any:
        """Requested histories, integrated at the first access; None if they could not be computed."""
        return self._recording[0]

    def spectrum(
        self, mass: Number | None = None, damping: Number = 0.05, low: Number | None = None, high: Number | None = None
    ) -> ShockSpectrum:
        """Compute the shock response spectrum behind a finite chain, from ``low`` to ``high`` [Hz].

        The base is a movable end, or ``mass`` [kg] under the dynamic force on a wall or at the last contact.
        """
        from shockwave.simulation.transmitted_spectrum import spectrum_of  # needed only here

        return spectrum_of(self, mass, damping, low, high)

    @property
    def cost(self) -> Cost:
        """Cost of the runs that were made at once, and of the train once it has been integrated."""
        later = "train" in self.__dict__ and self.measured is None
        return self.run_cost + self.train.cost if later else self.run_cost

    @property
    def first_warnings(self) -> tuple[str, ...]:
        """Warnings of unusual values, the accuracy of the first numbers, and their first yield."""
        beyond = self.first_yield if self.wave is None else find_yielding(self.chain, self.wave.peak_force)
        return (*self._run_warnings, *warn_beyond(beyond, self.chain))

    @property
    def wave_warnings(self) -> tuple[str, ...]:
        """Warnings of the first numbers and of forces beyond first yield, and of the train if it was requested."""
        train = self.train.warnings if self.options.waves == "train" else ()
        return (*self._run_warnings, *train, *warn_beyond(self.yielding, self.chain))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings on all numbers and the requested options; those on unusual values and first yield come first."""
        first = unusual_warnings(self.scene.excitation, self.chain) + warn_beyond(self.yielding, self.chain)
        later = (*self._passages[1], *self._sensors[1], *self._recording[1])
        return tuple(dict.fromkeys((*first, *self.value_with_yield, *self.wave_warnings, *later)))

    @cached_property
    def value_with_yield(self) -> tuple[str, ...]:
        """Sentence on the forces with elastic-plastic contacts, where warnings name them and the chain is short."""
        return self.computation("value_with_yield", self) if warn_beyond(self.yielding, self.chain) else ()

    @property
    def _run_warnings(self) -> tuple[str, ...]:
        return (*unusual_warnings(self.scene.excitation, self.chain), *self.run_warnings)

    @cached_property
    def _passages(self) -> tuple[tuple[Passage, ...], tuple[str, ...]]:
        """Passages at the requested contacts, and a warning for each that could not be computed."""
        contacts = () if self.wave is None else self.options.contacts
        try:
            answers = self.computation("passages", self, contacts) if contacts else []
        except NumericalError as error:
            answers = [error] * len(contacts)
        passages, warnings = [], []
        for contact, passage in zip(contacts, answers, strict=True):
            if isinstance(passage, NumericalError):
                warnings.append(f"No passage at contact {contact}: {passage}.")
                continue
            passages.append(passage)
            if self.rtol is not None and passage.error_estimate > self.rtol:
                missed = f"the error of the passage at contact {contact} is {passage.error_estimate:.1e}"
                warnings.append(f"The tolerance was not met: {missed}, not {self.rtol:.1e}.")
        return tuple(passages), tuple(warnings)

    @cached_property
    def _forces(self) -> ContactForces:
        """Greatest forces at the contacts; of equal granules, integrated at the first access."""
        if self.forces is not None:
            return self.forces
        unknown = LeavingForce(name=LAST, remedy="simulate with a longer timeout")
        if self.chain.count is None:
            return ContactForces(leaving=unknown)
        try:
            forces: ContactForces = self.computation("forces", self)
            return forces
        except NumericalError as error:
            return ContactForces(leaving=unknown, warnings=(f"No forces at the contacts: {error}.",))

    @cached_property
    def _sensors(self) -> tuple[tuple[FirstPulse, ...], Sequence[str]]:
        """First pulses of the sensors, and warnings."""
        return self.computation("first_pulses", self, None) if self.options.sensors else ((), ())

    @cached_property
    def _contact_pulses(self) -> dict[int, FirstPulse]:
        contacts = [peak.contact for peak in self._forces.contacts]
        return dict(zip(contacts, self.computation("first_pulses", self, contacts)[0], strict=False))

    @cached_property
    def _recording(self) -> tuple[Recording | None, tuple[str, ...]]:
        """Histories, and a warning if they could not be computed."""
        try:
            return (self.computation("recording", self) if self.options.is_recorded else None), ()
        except NumericalError as error:
            return None, (f"No histories: {error}.",)

    _brief = (
        *("scenario", "peak_force", "amplification", "forces.greatest.peak_force", "transmitted.peak_force"),
        *("error_estimate", "forces.contacts", "integrator", "backend", "end"),
    )
    _tables = (
        *(("sensors", "sensor"), ("waves", "wave"), ("contacts", "contact"), ("passages", "contact")),
        *(("segments", "segment"), ("recording", "time")),
    )

    def to_dict(self) -> dict[str, Any]:
        """Document printed by ``simulate --json``: SI floats, no NaN."""
        return document_of(self)

    def __str__(self) -> str:
        return render(self, "shockwave.simulation.simulation_text:simulation_text")
