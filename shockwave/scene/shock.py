"""The shock: a profile with a peak force and a rise time, eq. (2)."""

from __future__ import annotations

from attrs import field, frozen

from shockwave.base.errors import InvalidValueError
from shockwave.base.quantity_fields import Quantity, quantity, text_of
from shockwave.profiles.profile_contract import examine
from shockwave.profiles.shock_profile import ShockProfile

#: The total duration, which can be given instead of the rise time or the duration ratio.
DURATION = Quantity("s", "total duration n t0, instead of t0 or n", above=0)


@frozen(kw_only=True)
class Shock:
    """A force pulse, F(t) = F0 F1(t/t0) during the rise and F0 F2(t/t0) during the decay, eq. (2).

    Parameters
    ----------
    profile : ShockProfile
        Shape of the shock.
    peak_force : float, optional
        F0 [N], above 0; by default that of the record, for a profile that is one.
    rise_time : float, optional
        t0 [s], above 0; by default that of the record, for a profile that is one.

    Raises
    ------
    InvalidValueError
        If a value is out of range, or missing for a profile that is not a record.
    PluginError
        If a profile that is not built in violates the contract of `ShockProfile`.
    """

    profile: ShockProfile = field()
    peak_force: float = quantity("N", "peak force F0", above=0, optional=True, default=None)
    rise_time: float = quantity("s", "rise time t0", above=0, optional=True, default=None)

    def __attrs_post_init__(self) -> None:
        _check(self.profile)
        for name in ("peak_force", "rise_time"):
            if getattr(self, name) is None:
                recorded = getattr(self.profile, f"recorded_{name}")
                if recorded is None:
                    raise InvalidValueError.of(name, "must be given, because this profile is not a record")
                object.__setattr__(self, name, recorded)

    @classmethod
    def of_duration(cls, *, profile: ShockProfile, duration: float, peak_force: float | None = None) -> Shock:
        """Make a shock from its total duration n t0 [s] instead of its rise time t0.

        Raises
        ------
        InvalidValueError
            If a value is out of range.
        """
        _check(profile)
        rise_time = DURATION.checked("duration", duration) / float(profile.duration_ratio)
        return cls(profile=profile, peak_force=peak_force, rise_time=rise_time)  # type: ignore[arg-type]

    @property
    def duration(self) -> float:
        """Whole duration n t0 [s]."""
        return self.profile.duration_ratio * self.rise_time


def _check(profile: object) -> None:
    if not isinstance(profile, ShockProfile):
        raise InvalidValueError.of("profile", f"must be a ShockProfile (got {text_of(profile)})")
    examine(profile)
