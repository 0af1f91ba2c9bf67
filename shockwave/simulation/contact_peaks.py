"""Greatest forces at contacts."""

from __future__ import annotations

from attrs import evolve, frozen

from shockwave.scene.force_limit import LATER, LeavingForce


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
    """

    contact: int
    peak_force: float
    time: float
    error_estimate: float
    static_force: float = 0.0

    @property
    def low(self) -> float:
        """The force less its error estimate [N]."""
        return self.peak_force - self.error_estimate * (self.peak_force - self.static_force)

    @property
    def high(self) -> float:
        """The force plus its error estimate [N]."""
        return 2 * self.peak_force - self.low


def last_force(name: str, peak: ContactPeak | None, arrived: bool = True, later: float = 0.0) -> LeavingForce:
    """The force that a chain transmits, from its last contact; ``peak`` is None if it is not known.

    Before the leading wave has ``arrived`` there is no upper end. After the end of the simulated time the force is
    less than ``later`` [N].
    """
    if peak is None:
        return LeavingForce(name=name, remedy="simulate with a longer timeout")
    error = peak.error_estimate * (peak.peak_force - peak.static_force)
    found = LeavingForce.measured(name, peak.peak_force, error)
    return evolve(found, later=later) if arrived else evolve(found, high=None, remedy=LATER)
