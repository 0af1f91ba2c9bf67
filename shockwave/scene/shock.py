"""The shock: a profile with a peak force and a rise time, eq. (2)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from inspect import signature
from typing import Any

from attrs import evolve, field, frozen

from shockwave.base.arguments import explain_arguments
from shockwave.base.errors import Fault, InvalidValueError, locate
from shockwave.base.quantity_fields import Declaration, Number, Value, quantity, text_of
from shockwave.base.text import si
from shockwave.base.units import to_si
from shockwave.profiles.contract_check import examine
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.registry.registry import blame, load

#: The total duration, which can be given instead of the rise time or the duration ratio.
DURATION = Declaration("s", "total duration n t0, instead of t0 or n", above=0)
_RISE_TIME = Declaration("s", "rise time t0", above=0)
_OWN_RATIO = "because the profile has its own duration ratio"


@frozen(kw_only=True, init=False)
class Shock(Value):
    """A force pulse, eq. (2): ``F0 F1(t/t0)`` during the rise and ``F0 F2(t/t0)`` during the decay.

    Parameters
    ----------
    profile : ShockProfile or str
        Shape of the shock, or the name of a registered profile.
    peak_force : float, optional
        F0 [N], above 0; by default that of the record, for a profile that is one.
    rise_time : float, optional
        t0 [s], above 0; by default that of the record, for a profile that is one.
    duration : float, optional
        Total duration n t0 [s], above 0, instead of the rise time; for a profile given by its name, also beside it,
        instead of the duration ratio.
    duration_ratio : float, optional
        n of a profile given by its name.
    parameters : mapping, optional
        Other parameters of a profile given by its name, as in a scenario; a ``file`` is relative to the current folder.

    Raises
    ------
    InvalidValueError
        If a value is out of range, is not used, or is missing for a profile that is not a record.
    UnknownNameError
        If no profile has the name.
    PluginError
        If a profile that is not built in violates the contract of `ShockProfile`.

    Examples
    --------
    >>> import shockwave as sw
    >>> shock = sw.Shock(
    ...     profile="triangular", duration_ratio=3, peak_force="50 N", rise_time="20 us"
    ... )
    >>> f"{1e6 * shock.duration:.0f} us"
    '60 us'
    >>> pulse = sw.Shock(profile=sw.HalfSine(), peak_force="50 N", duration="100 us")
    >>> f"{1e6 * pulse.rise_time:.0f} us"
    '50 us'
    """

    profile: ShockProfile = field()
    peak_force: float = quantity("N", "peak force F0", above=0, optional=True, default=None)
    rise_time: float = quantity("s", "rise time t0", above=0, optional=True, default=None)

    def __init__(
        self,
        *,
        profile: ShockProfile | str,
        peak_force: Number | None = None,
        rise_time: Number | None = None,
        duration: Number | None = None,
        duration_ratio: Number | None = None,
        parameters: Mapping[str, Any] | None = None,
    ) -> None:
        if isinstance(profile, str):
            make: Any = load("profiles", profile)
            takes_ratio = "duration_ratio" in signature(make).parameters
            if duration is not None and rise_time is not None and duration_ratio is None:
                if not takes_ratio:
                    raise InvalidValueError.of("duration", f"must be left out if rise_time is given, {_OWN_RATIO}")
                duration_ratio, duration = _ratio(duration, rise_time), None
            elif duration_ratio is not None and not takes_ratio:
                rule = f"must be left out, because profile {profile!r} has its own"
                raise InvalidValueError.of("duration_ratio", f"{rule} (got {to_si(duration_ratio):g})")
            profile = _profile(make, duration_ratio, parameters or {})
        else:
            _refuse("for a profile that is an object", duration_ratio=duration_ratio, parameters=parameters)
        if not isinstance(profile, ShockProfile):
            raise InvalidValueError.of("profile", f"must be a ShockProfile or the name of one (got {text_of(profile)})")
        examine(profile)
        if duration is not None:
            why = _OWN_RATIO if duration_ratio is None else "because duration_ratio is given, too"
            _refuse(f"if duration is given, {why}", rise_time=rise_time)
            rise_time = DURATION.check("duration", duration) / float(profile.duration_ratio)
        self.__attrs_init__(profile=profile, peak_force=peak_force, rise_time=rise_time)  # type: ignore[arg-type]

    def __attrs_post_init__(self) -> None:
        for name in ("peak_force", "rise_time"):
            if getattr(self, name) is None:
                recorded = getattr(self.profile, f"recorded_{name}")
                if recorded is None:
                    raise InvalidValueError.of(name, "must be given, because this profile is not a record")
                object.__setattr__(self, name, recorded)

    @property
    def duration(self) -> float:
        """Whole duration n t0 [s]."""
        return self.profile.duration_ratio * self.rise_time


def _ratio(duration: Number, rise_time: Number) -> float:
    """Duration ratio of a duration and a rise time."""
    whole, rise = DURATION.check("duration", duration), _RISE_TIME.check("rise_time", rise_time)
    if whole <= rise:
        raise InvalidValueError.of(
            "rise_time", f"must be shorter than the duration, {si(whole, 's')} (got {si(rise, 's')})"
        )
    return float(whole / rise)


def _refuse(why: str, **values: object) -> None:
    """Refuse ``values`` that are not None."""
    for name, value in values.items():
        if value is not None:
            raise InvalidValueError.of(name, f"must be left out {why} (got {text_of(value)})")


def _profile(make: Any, duration_ratio: Number | None, parameters: Mapping[str, Any]) -> Any:
    """Make a registered profile."""
    if not isinstance(parameters, Mapping):
        raise InvalidValueError.of("parameters", f"must be a mapping of names to values (got {text_of(parameters)})")
    values = dict(parameters)
    with blame("profiles", make), locate(_place_in_block):
        if "file" in values and hasattr(make, "from_file"):  # a record
            make = partial(make.from_file, values.pop("file"))
        if duration_ratio is not None:
            values["duration_ratio"] = duration_ratio
        return explain_arguments(make)(**values)


def _place_in_block(fault: Fault) -> Fault:
    if fault.path != "duration_ratio":
        return fault.below("parameters")
    return evolve(fault, problem=fault.problem.replace("(got nothing)", "(got nothing; or give duration)"))
