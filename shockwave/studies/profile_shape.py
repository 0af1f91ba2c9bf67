"""The shape of a shock, by name and by integrals: enough to evaluate a curve and to recognise its shocks."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np
from attrs import frozen

from shockwave.errors import InvalidValueError
from shockwave.fields import quantity, text_of
from shockwave.prediction.short_shock_law import correction
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.contract import examine
from shockwave.profiles.guard import trusted

# Shapes whose integrals agree to this are the same: a record in other units differs by rounding.
_SAME = 1e-8
# The correction is a quadrature of its own.
_SAME_CORRECTION = 1e-6


@frozen
class Shape:
    """A shape of shock by name and by number.

    Attributes
    ----------
    profile : mapping
        ``class``, the address ``module:name``, and ``parameters``, its fields as JSON can hold them.
    duration_ratio : float
        n.
    area : float
        a1 + a2, the impulse over F0 t0.
    centroid : float
        Of the force, in units of t0.
    correction : float
        As of `shockwave.prediction.short_shock_law.correction`.
    """

    profile: Mapping[str, Any] = attrs.field(hash=False)
    duration_ratio: float = quantity("", "n", above=1)
    area: float = quantity("", "impulse over F0 t0", above=0)
    centroid: float = quantity("", "centroid of the force over t0", above=0)
    correction: float = quantity("", "leading correction of short shocks", above=0)

    @profile.validator
    def _is_named(self, attribute: attrs.Attribute[Any], profile: Mapping[str, Any]) -> None:
        if not isinstance(profile.get("class"), str) or not isinstance(profile.get("parameters"), Mapping):
            raise InvalidValueError.of(attribute.name, f"must hold class and parameters (got {text_of(profile)})")

    @classmethod
    def of(cls, profile: ShockProfile) -> Shape:
        """The shape of ``profile``.

        Raises
        ------
        PluginError
            When the profile is not shockwave's own and breaks the contract of `ShockProfile`.
        """
        examine(profile)
        n, area = float(profile.duration_ratio), float(profile.areas().total)
        centroid = n - float(profile.double_integral(n)) / area
        return cls(_description(profile), n, area, centroid, correction(profile))

    def fits(self, profile: ShockProfile) -> bool:
        """Whether ``profile`` has this shape."""
        # Of these classes the parameters are numbers, and all there is: no integral is needed.
        if trusted(profile) and _description(profile) == self.profile:
            return True
        other = Shape.of(profile)
        return math.isclose(self.correction, other.correction, rel_tol=_SAME_CORRECTION) and all(
            math.isclose(getattr(self, name), getattr(other, name), rel_tol=_SAME)
            for name in ("duration_ratio", "area", "centroid")
        )

    def __str__(self) -> str:
        name, parameters = self.profile["class"].rpartition(":")[2], self.profile["parameters"]
        return f"{name}({', '.join(f'{key}={_shown(value)}' for key, value in parameters.items())})"


def _shown(value: Any) -> str:
    if isinstance(value, list) and len(value) > 6:
        return f"[{len(value)} values]"
    return f"{value:g}" if isinstance(value, float) else text_of(value)


def _description(profile: ShockProfile) -> dict[str, Any]:
    """Its class, and its fields as JSON gives them back, with all their digits."""
    cls: type = type(profile)
    fields = attrs.fields(cls) if attrs.has(cls) else ()
    given = {field.name.lstrip("_"): getattr(profile, field.name) for field in fields if field.init}
    parameters = json.loads(json.dumps(given, default=_plain), parse_constant=str)
    return {"class": f"{cls.__module__}:{cls.__qualname__}", "parameters": parameters}


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else text_of(value)
