"""Results of simulations: waves, passages, histories, cost."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

from attrs import asdict, evolve, field, frozen

from shockwave.chain.chain import Chain, Scales
from shockwave.chain.solitary_wave import SolitaryWave
from shockwave.errors import NumericalError
from shockwave.options import SimulateOptions
from shockwave.profiles.shock import Shock
from shockwave.quadrature import FloatArray
from shockwave.scene_summary import Scene
from shockwave.simulation.problem import Primary
from shockwave.text import printed

# Quantity of a wave -> its unit among `Scales`.
_UNITS = {
    "peak_force": "force",
    "momentum": "momentum",
    "energy": "energy",
    "speed": "wave_speed",
    "width": "time",
    "granule_velocity": "velocity",
    "arrival_time": "time",
}
# Figures of the granules that leave the ends of the chain.
_ENDS = ("recoil_momentum", "recoil_error", "recoil_velocities", "ejected_granules", "spall_velocities")


def _plain(value: Any) -> Any:
    """A tuple or array as a list, anything else as it is."""
    return value.tolist() if hasattr(value, "tolist") else list(value) if isinstance(value, tuple) else value


@frozen(kw_only=True)
class MeasuredWave:
    """One wave as it passed a contact, in SI units (in scaled ones before the result is made).

    Attributes
    ----------
    peak_force, momentum, energy, width, granule_velocity : float
        As in `SolitaryWave`, measured from the history of the contact force. Width and granule velocity of a primary
        that was followed alone are those of the exact wave of its peak force.
    speed : float or None
        Of the peak along the chain [m/s]; None where only one contact was passed.
    contact : int
        Where it was read, counted from 0: contact i lies between granules i and i + 1.
    arrival_time : float
        Of its peak there [s].
    error_estimate : float or None
        Relative, of ``peak_force`` as the limit far along the chain; None for a wave that had not settled, or that
        was found in one of the two runs only.
    foot : float
        Force left between the wave and its neighbours, over its peak: momentum, energy, width and granule velocity
        are the wave's own to about as much.
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
        """This wave, so far in scaled units, in SI units and with its error estimate."""
        known = {name: getattr(self, name) for name in _UNITS if getattr(self, name) is not None}
        values = {name: value * getattr(scales, _UNITS[name]) for name, value in known.items()}
        return evolve(self, error_estimate=error_estimate, **values)


@frozen(kw_only=True)
class Passage:
    """The primary at a contact, in SI units.

    ``exact`` says that the wave had come to its limit before: it is the exact solitary wave from there on, and was
    not integrated further. ``error_estimate`` is relative, of time and peak force alike.
    """

    contact: int
    arrival_time: float
    peak_force: float
    exact: bool
    error_estimate: float


@frozen(kw_only=True)
class Cost:
    """Work that a result took; ``seconds`` vary from run to run and are left out of comparisons."""

    steps: int
    force_evaluations: int
    seconds: float = field(eq=False)

    def __add__(self, other: Cost) -> Cost:
        evaluations = self.force_evaluations + other.force_evaluations
        seconds = self.seconds + other.seconds
        return Cost(steps=self.steps + other.steps, force_evaluations=evaluations, seconds=seconds)


@frozen(kw_only=True)
class Train:
    """All waves, and the granules that leave the ends.

    Attributes
    ----------
    waves : tuple of MeasuredWave
        Strongest first; weaker than ``wave_threshold`` times the primary are not counted.
    recoil_momentum, recoil_error : float
        Of the granules that fly backwards [N s], zero or negative; and an estimate of its error [N s], with what
        granules hold that had not come apart for good.
    recoil_velocities : tuple of float
        Of the ejected granules [m/s], first granule first: those that fly backwards faster than a thousandth of the
        granules in the primary.
    spall_velocities : tuple of float or None
        Of the granules that fly off the free end [m/s], last granule first; None in a chain without end, or one whose
        end the waves had not reached.
    cost : Cost
        Of the two runs.
    warnings : tuple of str
        Notes to read before using the figures.
    """

    waves: tuple[MeasuredWave, ...]
    recoil_momentum: float = 0.0
    recoil_error: float
    recoil_velocities: tuple[float, ...] = ()
    spall_velocities: tuple[float, ...] | None = None
    cost: Cost = Cost(steps=0, force_evaluations=0, seconds=0.0)
    warnings: tuple[str, ...] = ()


@frozen(kw_only=True, eq=False)
class Recording:
    """Histories at equal intervals, in SI units; what was not asked for is None.

    Attributes
    ----------
    times : array, shape (k,), [s]
    contacts : tuple of int
        Of ``forces``.
    forces : array, shape (k, contacts), or None
        Contact forces [N].
    displacements, velocities : array, shape (k, granules), or None
        Of all granules that have moved by the end [m], [m/s].
    kinetic_energy, contact_energy : array, shape (k,), or None
        Of the chain [J].
    """

    times: FloatArray
    contacts: tuple[int, ...]
    forces: FloatArray | None = None
    displacements: FloatArray | None = None
    velocities: FloatArray | None = None
    kinetic_energy: FloatArray | None = None
    contact_energy: FloatArray | None = None

    def to_dict(self) -> dict[str, Any]:
        """Lists of SI floats."""
        return {name: _plain(value) for name, value in asdict(self).items()}


@frozen(kw_only=True, slots=False)
class SimulationResult:
    """Result of a direct simulation of eq. (1).

    The primary is known when the result is made. The rest of the train is integrated when something of it is first
    looked at (``train``, ``waves``, ``recoil_momentum``, ``print``, ``to_dict``), and kept; so are histories
    (``recording``). Results are equal when the same was asked of the same scene and the same found.

    Attributes
    ----------
    shock, chain, options : Shock, Chain, SimulateOptions
        Scene and settings; ``options`` name the integrator and the backend that were used.
    scales : Scales
        Units in which ``found`` is written.
    found : Primary
        The primary in scaled units, with the balances of momentum and energy.
    error_estimate : float
        Relative, of ``peak_force``: from step control, the approach to the limit, and the table of the force.
    seconds : float
        Wall time; differs from run to run, and is left out of comparisons.
    warnings : tuple of str
        Notes to read before using the figures of the primary; the train has its own.
    on_demand : callable
        Computes the ``train``, a ``passage`` or the ``recording`` of a result when it is looked at.
    scenario : str or None
        Name of the scenario, if it came from one.
    measured : Train or None
        The train, where the primary was measured on the whole chain and not by the search for it.
    """

    shock: Shock
    chain: Chain
    options: SimulateOptions
    scales: Scales
    found: Primary
    error_estimate: float
    warnings: tuple[str, ...]
    seconds: float = field(eq=False, repr=False)
    on_demand: Callable[..., Any] = field(eq=False, repr=False)
    scenario: str | None = None
    measured: Train | None = field(default=None, eq=False, repr=False)

    @property
    def peak_force(self) -> float:
        """Of the primary [N]."""
        return self.found.peak * self.scales.force

    @property
    def amplification(self) -> float:
        """Peak force of the primary over that of the shock."""
        return self.peak_force / self.shock.peak_force

    @property
    def applied_momentum(self) -> float:
        """Impulse of the shock [N s]."""
        return self.found.impulse * self.scales.momentum

    @property
    def momentum_defect(self) -> float:
        """Momentum of the granules at the end against the impulse, relative."""
        return self.found.momentum_defect

    @property
    def energy_defect(self) -> float:
        """Energy of the granules at the end against the work of the force, relative."""
        return self.found.energy_defect

    @property
    def integrator(self) -> str:
        """Name of the method."""
        return self.options.integrator or ""

    @property
    def backend(self) -> str:
        """Which code has stepped the chain: compiled or numpy."""
        return self.options.backend

    @property
    def rtol(self) -> float | None:
        """Relative error asked for; None for a method of fixed step."""
        return self.options.rtol

    @property
    def notes(self) -> tuple[str, ...]:
        """The same as ``warnings``."""
        return self.warnings

    @property
    def wave_threshold(self) -> float:
        """Weakest wave that counts, over the primary."""
        return self.options.wave_threshold

    @property
    def scene(self) -> Scene:
        """Shock and chain as they were understood."""
        return Scene.of(self.shock, self.chain)

    @property
    def primary(self) -> MeasuredWave:
        """The primary where it was read."""
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
        """The primary at a contact, counted from 0.

        Beyond the contact where it was read the answer follows from the exact wave, at no cost; before, the chain is
        integrated up to there once more.

        Raises
        ------
        InvalidValueError
            When the chain has no such contact.
        NumericalError
            When the front has no peak there of its own.
        """
        passage: Passage = self.on_demand("passage", self, contact)
        return passage

    @property
    def passages(self) -> tuple[Passage, ...]:
        """The primary at the contacts that were asked for, where it has a peak of its own."""
        return self._passages[0]

    @cached_property
    def train(self) -> Train:
        """All waves and the recoil; integrated when first asked for."""
        return self.measured or self.on_demand("train", self)

    @property
    def waves(self) -> tuple[MeasuredWave, ...]:
        """Strongest first; the primary alone if no more was asked for."""
        return (self.primary,) if self.options.waves == "primary" else self.train.waves

    @property
    def recoil_momentum(self) -> float:
        """Of the granules that fly backwards [N s]."""
        return self.train.recoil_momentum

    @property
    def recoil_error(self) -> float:
        """Estimate of the error of ``recoil_momentum`` [N s]."""
        return self.train.recoil_error

    @property
    def recoil_velocities(self) -> tuple[float, ...]:
        """Of the ejected granules [m/s], first granule first."""
        return self.train.recoil_velocities

    @property
    def ejected_granules(self) -> int:
        """Number of granules that fly backwards faster than a thousandth of the granules in the primary."""
        return len(self.recoil_velocities)

    @property
    def spall_velocities(self) -> tuple[float, ...] | None:
        """Of the granules that fly off the free end [m/s], last granule first."""
        return self.train.spall_velocities

    @property
    def recording(self) -> Recording | None:
        """The histories that were asked for, if they could be computed."""
        return self._recording[0]

    @cached_property
    def _passages(self) -> tuple[tuple[Passage, ...], tuple[str, ...]]:
        """The passages, and a warning for each that could not be computed."""
        passages, warnings = [], []
        for contact in self.options.contacts:
            try:
                passages.append(self.passage(contact))
            except NumericalError as error:
                warnings.append(f"no passage at contact {contact}: {error}")
        return tuple(passages), tuple(warnings)

    @cached_property
    def _recording(self) -> tuple[Recording | None, tuple[str, ...]]:
        """The histories, and a warning if they could not be computed."""
        try:
            return (self.on_demand("recording", self) if self.options.record else None), ()
        except NumericalError as error:
            return None, (f"no histories: {error}",)

    @property
    def cost(self) -> Cost:
        """Work so far: for the primary, and for the train once it has been integrated."""
        own = Cost(steps=int(self.found.steps), force_evaluations=int(self.found.evaluations), seconds=self.seconds)
        return own + self.train.cost if "train" in self.__dict__ and self.measured is None else own

    @property
    def wave_warnings(self) -> tuple[str, ...]:
        """Those of the primary, and of the train if it was asked for."""
        return self.warnings if self.options.waves == "primary" else (*self.warnings, *self.train.warnings)

    @property
    def all_warnings(self) -> tuple[str, ...]:
        """Those of the waves, of the passages, and of the histories."""
        return (*self.wave_warnings, *self._passages[1], *self._recording[1])

    def to_dict(self) -> dict[str, Any]:
        """The object that ``simulate --json`` prints: SI floats, no NaN."""
        ends = {name: _plain(getattr(self, name)) if self.options.waves == "train" else None for name in _ENDS}
        return {
            "scenario": self.scenario,
            "peak_force": self.peak_force,
            "amplification": self.amplification,
            "error_estimate": self.error_estimate,
            "waves": [asdict(wave) for wave in self.waves],
            "wave_threshold": self.options.wave_threshold,
            "passages": [asdict(passage) for passage in self.passages],
            "applied_momentum": self.applied_momentum,
            **ends,
            "momentum_defect": self.momentum_defect,
            "energy_defect": self.energy_defect,
            "recording": self.recording and self.recording.to_dict(),
            "integrator": self.integrator,
            "backend": self.backend,
            "rtol": self.rtol,
            "step": self.options.step,
            "cost": asdict(self.cost),
            "warnings": list(self.all_warnings),
            "scene": self.scene.to_dict(),
        }

    def __str__(self) -> str:
        return printed(self, "shockwave.measurement.result_text:result_text")
