"""Results of simulations of chains beyond equal spheres: forces at the contacts and the wall, energies, velocities."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from attrs import field, frozen

from shockwave.base.result import VERSION
from shockwave.base.text import printed
from shockwave.scene.force_limit import LAST, WALL, WAVE, LeavingForce, plain_verdict
from shockwave.scene.scene import Scene
from shockwave.scene.simulate_options import SimulateOptions
from shockwave.scene.yielding import Yielding
from shockwave.simulation.contact_peaks import ContactPeak, last_force
from shockwave.simulation.recording import Recorded, plain
from shockwave.simulation.wave_result import Cost

# Attributes that the document contains under their names.
_KEYS = (
    *("scenario", "peak_force", "amplification", "error_estimate", "waves", "passages", "contacts", "greatest_force"),
    *("transmitted", "end", "arrival_time", "applied_momentum", "applied_energy", "dissipated_energy"),
    *("recoil_momentum", "recoil_error", "recoil_velocities", "ejected_granules", "spall_velocities"),
    *("velocities", "restitution"),
    *("segments", "end_energy", "momentum_defect", "energy_defect", "recording", "integrator", "backend", "cost"),
)


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
    """

    first: int
    last: int
    energy: float


@frozen(kw_only=True, slots=False, repr=False)
class ChainResult(Recorded):
    """Result of a simulation of a chain beyond equal spheres, from 0 to the end of the simulated time.

    In general the leading wave has no limit in such a chain, so ``peak_force`` and ``amplification`` are None and
    ``waves`` is empty.
    Two results are equal if scene, settings and computed values are equal.

    Attributes
    ----------
    scene, options : Scene, SimulateOptions
        Scene and settings.
    integrator, backend : str
        Name of the integrator; ``compiled`` or ``numpy``, the code that integrated the chain.
    contact_count : int or None
        Number of contacts of the chain, including the contact with a wall, which is the last one; None in an endless
        chain.
    contacts : tuple of ContactPeak
        Greatest total force at each reported contact, in the order of the contacts; force and time are 0 at a contact
        that never closes. Error estimates are relative to the dynamic part of the force.
    greatest_force : ContactPeak
        Greatest force at any contact.
    last_contact : ContactPeak or None
        Greatest force at the last contact, which is that with the wall if there is one; None in an endless chain.
    transmitted : Transmitted or None
        Force on the wall; None if the end is free.
    end : float
        End of the simulated time [s].
    later_force : float
        Bound of the force at the last contact after the end of the simulated time [N], from the energy that can reach
        it; infinite where none is known, and 0 for an endless chain.
    arrival_time : float or None
        Time at which the leading wave reaches the last contact [s]; None if it does not.
    velocities : tuple of float
        Velocities of all granules at the end of the simulated time [m/s], the striker first; in an endless chain, of
        those that the waves have reached.
    recoil_velocities, recoil_momentum : tuple of float or None, float or None
        Velocities [m/s], first granule first, and total momentum [N s] of the granules at the struck end that move
        backwards at the end of the simulated time; None under precompression or gravity.
    spall_velocities : tuple of float or None
        Velocities of the granules that fly off the free end [m/s], last granule first; None with a wall or under
        precompression.
    restitution : float or None
        Coefficient of restitution of a striker that has rebounded: its velocity away from the chain's centre of mass
        or, with a wall, away from the wall, divided by its velocity before the impact. None without a striker, or if
        the striker still touches the first granule. Under gravity, when the striker falls back, it is that of its first
        separation.
    applied_momentum, applied_energy : float
        Impulse and work of the shock, or momentum and energy of the striker, and impulse and work of its weight within
        the simulated time [N s, J].
    dissipated_energy : float
        Energy dissipated by the damping of contacts and of the wall [J]. With the contact law of a plugin, whose stored
        energy is not known, it includes that of the contacts that are closed at the end.
    segments : tuple of SegmentEnergy
        Energy in each segment at the end of the simulated time; a striker is a segment of its own.
    end_energy : float or None
        Kinetic and elastic energy of a movable wall and its spring [J]; None without one.
    yielding : Yielding or None
        First yield of the contacts; None if no yield strength is known.
    momentum_defect : float
        Difference between the momentum of the granules and the applied momentum minus the impulse on the wall,
        relative to the applied momentum.
    energy_defect : float
        Difference between the sum of chain energy and dissipated energy and the applied energy, relative to the applied
        energy.
    characteristic_time : float
        Unit of time in which the tolerance of the times of peak forces is stated [s].
    cost : Cost
        Cost of all runs.
    warnings : tuple of str
        Sentences on the limits of the result.
    on_demand : callable
        Function that computes the ``recording`` when it is accessed, from this name and the result.
    """

    scene: Scene
    options: SimulateOptions
    integrator: str
    backend: str
    contact_count: int | None
    contacts: tuple[ContactPeak, ...]
    greatest_force: ContactPeak
    last_contact: ContactPeak | None
    transmitted: Transmitted | None
    end: float
    later_force: float
    arrival_time: float | None
    velocities: tuple[float, ...]
    recoil_velocities: tuple[float, ...] | None
    recoil_momentum: float | None
    spall_velocities: tuple[float, ...] | None
    restitution: float | None
    applied_momentum: float
    applied_energy: float
    dissipated_energy: float
    segments: tuple[SegmentEnergy, ...]
    end_energy: float | None
    yielding: Yielding | None
    momentum_defect: float
    energy_defect: float
    characteristic_time: float
    cost: Cost
    warnings: tuple[str, ...]
    on_demand: Callable[..., Any] = field(eq=False, repr=False)

    #: The limit of the leading wave in an endless chain of equal granules, which does not exist here.
    peak_force = amplification = recoil_error = None
    waves = passages = ()

    @property
    def error_estimate(self) -> float:
        """Largest error estimate of the reported contacts."""
        return max(peak.error_estimate for peak in self.contacts)

    @property
    def ejected_granules(self) -> int | None:
        """Number of granules that move backwards at the struck end; None under precompression or gravity."""
        return None if self.recoil_velocities is None else len(self.recoil_velocities)

    @property
    def leaving(self) -> LeavingForce:
        """The transmitted force, on the wall, at the last contact, or of the wave in an endless chain."""
        if self.last_contact is None:
            return LeavingForce(name=WAVE, remedy="simulate a finite chain")
        name = LAST if self.transmitted is None else WALL
        return last_force(name, self.last_contact, self.arrival_time is not None, self.later_force)

    @property
    def wave_warnings(self) -> tuple[str, ...]:
        """Warnings of the forces."""
        return (*self.warnings, *(self.yielding.warnings if self.yielding else ()))

    @property
    def all_warnings(self) -> tuple[str, ...]:
        """Warnings of the forces and the histories."""
        return (*self.wave_warnings, *self._recording[1])

    _brief = ("scenario", "greatest_force.peak_force", "transmitted.peak_force", "error_estimate", "contacts", "end")
    _tables = (("contacts", "contact"), ("segments", "segment"), ("recording", "time"))

    def to_dict(self) -> dict[str, Any]:
        """Document printed by ``simulate --json``: SI floats, no NaN."""
        document = {name: plain(getattr(self, name)) for name in _KEYS}
        own = {name: plain(getattr(self.options, name)) for name in ("wave_threshold", "rtol", "step")}
        others = {"yield": plain(self.yielding), "scene": self.scene.summary().to_dict()}
        others["verdict"] = plain_verdict(self)
        return {**VERSION, **document, **own, **others, "warnings": list(self.all_warnings)}

    def __str__(self) -> str:
        return printed(self, "shockwave.simulation.contact_text:chain_text")
