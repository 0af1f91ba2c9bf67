"""What a curve knows of its shape: enough to evaluate it, to tell other shapes from it, and to say what it was."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np
from attrs import frozen

from shockwave.fields import text_of
from shockwave.prediction.short_shock_law import correction
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.contract import examine
from shockwave.profiles.guard import trusted

__all__ = ["Shape"]

# Shapes whose integrals agree to this are the same: a record in other units differs by roundings.
_SAME = 1e-8


@frozen
class Shape:
    """A shape of shock by name and by number.

    Attributes
    ----------
    kind : str
        Address of its class, ``module:name``.
    parameters : mapping
        Its fields, as JSON can hold them; empty for a class without attrs.
    duration_ratio : float
        n.
    area : float
        a1 + a2, the impulse over F0 t0.
    centroid : float
        Of the force, in units of t0.
    correction : float
        As of `shockwave.prediction.short_shock_law.correction`.
    """

    kind: str
    parameters: Mapping[str, Any] = attrs.field(hash=False)
    duration_ratio: float
    area: float
    centroid: float
    correction: float

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
        kind = f"{type(profile).__module__}:{type(profile).__qualname__}"
        return cls(kind, _parameters(profile), n, area, centroid, correction(profile))

    def fits(self, profile: ShockProfile) -> bool:
        """Whether ``profile`` has this shape."""
        kind = f"{type(profile).__module__}:{type(profile).__qualname__}"
        # Of these classes the parameters are numbers, and all there is: no integral is needed.
        if trusted(profile) and kind == self.kind and _parameters(profile) == self.parameters:
            return True
        other = Shape.of(profile)
        pairs = [(getattr(self, name), getattr(other, name)) for name in ("duration_ratio", "area", "centroid")]
        alike = all(math.isclose(own, its, rel_tol=_SAME) for own, its in pairs)
        return alike and math.isclose(self.correction, other.correction, rel_tol=1e-6)

    def __str__(self) -> str:
        name = self.kind.rpartition(":")[2]
        return f"{name}({', '.join(f'{key}={_shown(value)}' for key, value in self.parameters.items())})"


def _shown(value: Any) -> str:
    if isinstance(value, list) and len(value) > 6:
        return f"[{len(value)} values]"
    return f"{value:g}" if isinstance(value, float) else text_of(value)


def _parameters(profile: ShockProfile) -> dict[str, Any]:
    cls: type = type(profile)
    if not attrs.has(cls):
        return {}
    given = {field.name: getattr(profile, field.name) for field in attrs.fields(cls) if field.init}
    return {name.lstrip("_"): _plain(value) for name, value in given.items()}


def _plain(value: Any) -> Any:
    """``value`` as JSON can hold it, with all its digits."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if value is None or isinstance(value, bool | int | str) or (isinstance(value, float) and math.isfinite(value)):
        return value
    return text_of(value)
