"""Results of simulations: waves, passages, histories and cost."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from attrs import field, frozen

from shockwave.base.errors import NumericalError
from shockwave.base.result import VERSION, cached_property
from shockwave.base.text import printed
from shockwave.engine.scaled_problem import Primary
from shockwave.scene.chain import Scales
from shockwave.scene.force_limit import LAST, WAVE, LeavingForce, plain_verdict
from shockwave.scene.plausibility import unusual_warnings
from shockwave.scene.scene import Scene
from shockwave.scene.shock import Shock
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.scene.solitary_wave import SolitaryWave
from shockwave.scene.yielding import Yielding, yielding_of
from shockwave.simulation.contact_peaks import ContactPeak, last_force
from shockwave.simulation.measured_wave import MeasuredWave, Passage
from shockwave.simulation.recording import Recorded, plain

# Attributes that the document contains under their names.
_KEYS = (
    *("scenario", "peak_force", "amplification", "error_estimate", "waves", "passages", "contacts", "greatest_force"),
    *("applied_momentum", "momentum_defect", "energy_defect", "recording", "integrator", "backend", "rtol", "cost"),
    *("transmitted", "end", "arrival_time", "applied_energy", "velocities", "restitution", "segments", "end_energy"),
    "dissipated_energy",
)
# JSON keys for the granules that leave the ends of the chain.
_ENDS = ("recoil_momentum", "recoil_error", "recoil_velocities", "ejected_granules", "spall_velocities")


@frozen(kw_only=True)
class Cost:
    """Cost of a result; ``seconds`` [s] vary from run to run and are ignored in comparisons."""

    steps: int
    force_evaluations: int
    seconds: float = field(eq=False)

    def __add__(self, other: Cost) -> Cost:
        evaluations = self.force_evaluations + other.force_evaluations
        seconds = self.seconds + other.seconds
        return Cost(steps=self.steps + other.steps, force_evaluations=evaluations, seconds=seconds)


@frozen(kw_only=True)
class Train:
    """All waves of a train, and the granules that leave the ends of the chain.

    Attributes
    ----------
    waves : tuple of MeasuredWave
        Waves, strongest first, down to ``wave_threshold`` times the peak force of the leading wave.
    recoil_momentum, recoil_error : float
        Momentum of the rebounding granules [N s], zero or negative; estimate of its error [N s], which includes the
        momentum of granules that had not separated for good.
    recoil_velocities : tuple of float
        Velocities of the ejected granules [m/s], first granule first. Ejected granules rebound faster than a
        thousandth of the peak velocity of the granules in the leading wave.
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

    waves: tuple[MeasuredWave, ...]
    recoil_momentum: float = 0.0
    recoil_error: float
    recoil_velocities: tuple[float, ...] = ()
    spall_velocities: tuple[float, ...] | None = None
    greatest_force: ContactPeak | None = None
    cost: Cost = Cost(steps=0, force_evaluations=0, seconds=0.0)
    warnings: tuple[str, ...] = ()

    @property
    def is_integrated(self) -> bool:
        """Whether the waves were measured; otherwise only the leading wave is known."""
        return self.cost.steps > 0


@frozen(kw_only=True, slots=False, repr=False)
class SimulationResult(Recorded):
    """Result of a direct simulation of eq. (1).

    The leading wave is computed at once. The rest of the train is integrated when one of its parts is first accessed
    (``train``, ``waves``, ``recoil_momentum``, ``print``, ``to_dict``), and then kept; likewise the histories
    (``recording``). Two results are equal if scene, settings and computed values are equal.

    Attributes
    ----------
    scene, options : Scene, SimulateOptions
        Scene and settings; ``options`` contains the integrator and the backend that were used.
    scales : Scales
        Units of ``found``.
    found : Primary
        Leading wave in scaled units, with the balances of momentum and energy.
    error_estimate : float
        Relative error estimate of ``peak_force``, from step control, the approach to the limit, and the table of the
        force.
    seconds : float
        Run time [s], which varies from run to run and is ignored in comparisons.
    search_warnings : tuple of str
        Warnings of the search for the leading wave.
    on_demand : callable
        Function that computes the ``train``, ``passages`` or the ``recording`` when it is accessed.
    measured : Train or None
        The train, if the leading wave was measured on the whole chain instead of by the search for it.
    """

    scene: Scene
    options: SimulateOptions
    scales: Scales
    found: Primary
    error_estimate: float
    search_warnings: tuple[str, ...]
    seconds: float = field(eq=False, repr=False)
    on_demand: Callable[..., Any] = field(eq=False, repr=False)
    measured: Train | None = field(default=None, eq=False, repr=False)

    # attributes of `ChainResult` that do not apply to equal spheres
    transmitted = end = arrival_time = restitution = velocities = segments = None
    applied_energy = dissipated_energy = end_energy = None

    @property
    def peak_force(self) -> float:
        """Peak force of the leading wave [N]."""
        return self.found.peak * self.scales.contact_force

    @property
    def amplification(self) -> float:
        """Peak force of the leading wave over that of the shock."""
        return self.peak_force / (self.shock.peak_force * self.chain.contact_share)

    @property
    def applied_momentum(self) -> float:
        """Impulse of the shock [N s]."""
        return self.found.impulse * self.scales.momentum

    @property
    def momentum_defect(self) -> float:
        """Relative difference of the final momentum of the chain from the impulse."""
        return self.found.momentum_defect

    @property
    def energy_defect(self) -> float:
        """Relative difference of the final energy of the chain from the work of the shock."""
        return self.found.energy_defect

    @property
    def integrator(self) -> str:
        """Name of the integrator."""
        return self.options.integrator or ""

    @property
    def backend(self) -> str:
        """Backend that integrated the chain, ``compiled`` or ``numpy``."""
        return self.options.backend

    @property
    def shock(self) -> Shock:
        """The shock."""
        return cast(Shock, self.scene.shock)

    @cached_property
    def primary(self) -> MeasuredWave:
        """Leading wave at the contact where it was measured."""
        if self.measured is not None:
            return self.measured.waves[0]
        found, scales = self.found, self.scales
        exact = SolitaryWave.of(self.peak_force, self.chain)
        return MeasuredWave(
            peak_force=self.peak_force,
            momentum=found.momentum * scales.momentum,
            energy=found.energy * scales.energy,
            speed=found.speed * scales.wave_speed,
            width=exact.width,
            granule_velocity=exact.granule_velocity,
            contact=int(found.contact),
            arrival_time=found.time * scales.time,
            error_estimate=self.error_estimate,
            foot=found.foot / found.peak,
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
            If the leading wave has no peak at this contact, because the force still rises there.
        """
        passage: Passage | NumericalError = self.on_demand("passages", self, (contact,))[0]
        if isinstance(passage, NumericalError):
            raise passage
        return passage

    @property
    def passages(self) -> tuple[Passage, ...]:
        """Leading wave at the requested contacts, without those at which it has no peak."""
        return self._passages[0]

    @cached_property
    def train(self) -> Train:
        """All waves and the rebounding granules, integrated at the first access."""
        return self.measured or self.on_demand("train", self)

    @property
    def waves(self) -> tuple[MeasuredWave, ...]:
        """Waves, strongest first; only the leading wave if the option ``waves`` is ``primary``."""
        return (self.primary,) if self.options.waves == "primary" else self.train.waves

    @property
    def recoil_momentum(self) -> float:
        """Momentum of the rebounding granules [N s]."""
        return self.train.recoil_momentum

    @property
    def recoil_error(self) -> float:
        """Estimate of the error of ``recoil_momentum`` [N s]."""
        return self.train.recoil_error

    @property
    def recoil_velocities(self) -> tuple[float, ...]:
        """Velocities of the ejected granules [m/s], first granule first."""
        return self.train.recoil_velocities

    @property
    def ejected_granules(self) -> int:
        """Number of granules that rebound faster than a thousandth of the granule velocity of the leading wave."""
        return len(self.recoil_velocities)

    @property
    def spall_velocities(self) -> tuple[float, ...] | None:
        """Velocities of the granules that leave the free end [m/s], last granule first."""
        return self.train.spall_velocities

    @property
    def contacts(self) -> tuple[ContactPeak, ...]:
        """Greatest force at each reported contact of a finite chain within the simulated time; else empty."""
        return self._contacts[0]

    @property
    def greatest_force(self) -> ContactPeak | None:
        """Greatest contact force; None on an endless chain unless it exceeds that of the leading wave by 1 %.

        With the option ``until``, or if ``waves`` is ``primary``, it is the greatest one within the simulated time of
        `contacts`.
        """
        if self.options.waves == "primary" or (self.chain.granules is not None and self.options.until is not None):
            return self._contacts[1]
        return self.train.greatest_force

    @property
    def leaving(self) -> LeavingForce:
        """The transmitted force, at the last contact, or of the leading wave in an endless chain."""
        if self.chain.granules is None:
            return LeavingForce.measured(WAVE, self.peak_force, self.error_estimate * self.peak_force)
        return self._contacts[2]

    @property
    def yielding(self) -> Yielding | None:
        """First yield of the contacts; None if the yield strength is not known.

        The peak force is that of the leading wave or, if the option ``waves`` is ``train``, a greater contact force.
        """
        if self.chain.material.yield_strength is None:
            return None
        top = self.greatest_force if self.options.waves == "train" else None
        return yielding_of(self.chain, max(self.peak_force, 0.0 if top is None else top.peak_force))

    @cached_property
    def _passages(self) -> tuple[tuple[Passage, ...], tuple[str, ...]]:
        """Passages at the requested contacts, and a warning for each that could not be computed."""
        contacts = self.options.contacts
        try:
            answers = self.on_demand("passages", self, contacts) if contacts else []
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
    def _contacts(self) -> tuple[tuple[ContactPeak, ...], ContactPeak | None, LeavingForce, tuple[str, ...]]:
        """Peaks at the reported contacts, the greatest one, the last force, and warnings."""
        unknown = last_force(LAST, None)
        if self.chain.granules is None:
            return (), None, unknown, ()
        try:
            peaks: tuple[Any, Any, Any, tuple[str, ...]] = self.on_demand("contacts", self)
            return peaks
        except NumericalError as error:
            return (), None, unknown, (f"No forces at the contacts: {error}.",)

    @property
    def cost(self) -> Cost:
        """Cost of the leading wave, and of the train once it has been integrated."""
        own = Cost(steps=int(self.found.steps), force_evaluations=int(self.found.evaluations), seconds=self.seconds)
        return own + self.train.cost if "train" in self.__dict__ and self.measured is None else own

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of changes to a record, unusual values, the accuracy of the leading wave, and its first yield.

        `all_warnings` has also those of the train, the passages and the histories.
        """
        beyond = yielding_of(self.chain, self.peak_force)
        return (*self._own_warnings, *(beyond.warnings if beyond else ()))

    @property
    def _own_warnings(self) -> tuple[str, ...]:
        return (*self.shock.profile.notes, *unusual_warnings(self.shock, self.chain), *self.search_warnings)

    @property
    def wave_warnings(self) -> tuple[str, ...]:
        """Warnings of the leading wave and of forces beyond first yield, and of the train if it was requested."""
        train = () if self.options.waves == "primary" else self.train.warnings
        return (*self._own_warnings, *train, *(self.yielding.warnings if self.yielding else ()))

    @property
    def all_warnings(self) -> tuple[str, ...]:
        """Warnings of the waves, the passages and the histories."""
        return (*self.wave_warnings, *self._passages[1], *self._recording[1])

    _brief = ("scenario", "peak_force", "amplification", "error_estimate", "integrator", "backend")
    _tables = (("waves", "wave"), ("contacts", "contact"), ("passages", "contact"), ("recording", "time"))

    def to_dict(self) -> dict[str, Any]:
        """Document printed by ``simulate --json``: SI floats, no NaN."""
        train = self.options.waves == "train"
        known = train and self.recoil_error < self.applied_momentum
        ends = {name: plain(getattr(self, name)) if known else None for name in _ENDS}
        options = {"wave_threshold": self.options.wave_threshold, "step": self.options.step}
        others = {"yield": plain(self.yielding), "scene": self.scene.summary().to_dict()}
        others["verdict"] = plain_verdict(self)
        document = VERSION | {name: plain(getattr(self, name)) for name in _KEYS}
        return {**document, **ends, **options, **others, "warnings": [*self.all_warnings, *self._contacts[3]]}

    def __str__(self) -> str:
        return printed(self, "shockwave.simulation.wave_text:result_text")
