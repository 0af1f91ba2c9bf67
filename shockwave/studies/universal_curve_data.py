"""A universal curve and the shape that it is of as plain data, and its JSON format."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np
from attrs import asdict, frozen

from shockwave.errors import InvalidValueError
from shockwave.fields import quantity, text_of
from shockwave.prediction.short_shock_law import correction
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.contract import examine
from shockwave.profiles.guard import trusted
from shockwave.studies.chebyshev_fit import Piece

_HEADER = {"format": "shockwave universal curve", "version": 1}
# Shapes whose integrals agree to this are the same: a record in other units differs by rounding. The correction is a
# quadrature of its own.
_SAME = {"duration_ratio": 1e-8, "area": 1e-8, "centroid": 1e-8, "correction": 1e-6}


@frozen
class Shape:
    """A shape of shock by name and by number: enough to evaluate a curve and to recognise its shocks.

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

    @classmethod
    def of(cls, profile: ShockProfile) -> Shape:
        """The shape of ``profile``.

        Raises
        ------
        PluginError
            When the profile is not shockwave's own and breaks the contract of `ShockProfile`.
        """
        examine(profile)
        n = float(profile.duration_ratio)
        area = float(profile.areas().total)
        centroid = n - float(profile.double_integral(n)) / area
        return cls(_description(profile), n, area, centroid, correction(profile))

    def fits(self, profile: ShockProfile) -> bool:
        """Whether ``profile`` has this shape."""
        # Of these classes the parameters are numbers, and all there is: no integral is needed.
        if trusted(profile) and _description(profile) == self.profile:
            return True
        other = Shape.of(profile)
        return all(math.isclose(getattr(self, name), getattr(other, name), rel_tol=_SAME[name]) for name in _SAME)

    def __str__(self) -> str:
        parameters = (f"{key}={_shown(value)}" for key, value in self.profile["parameters"].items())
        return f"{self.profile['class'].rpartition(':')[2]}({', '.join(parameters)})"


def _shown(value: Any) -> str:
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


@frozen(kw_only=True)
class ShortLaw:
    """The law of short shocks, g = -q (t0/T0)^3 + w (t0/T0)^6 with q known beforehand.

    Attributes
    ----------
    second_correction : float
        w.
    end : float
        Logarithm of n t0/T0 up to which it is used.
    error : float
        Bound on its relative error there.
    """

    second_correction: float
    end: float
    error: float = quantity("", "bound on the relative error at the end", above=0)


@frozen(kw_only=True)
class CurveData:
    """A universal curve as plain data; see `UniversalCurve`."""

    shape: Shape
    rtol: float = quantity("", "relative error allowed", above=0)
    longest: float = quantity("", "longest n t0/T0", above=0)
    simulations: int = quantity("", "simulations made", at_least=0, whole=True)
    made_with: Mapping[str, str] = attrs.field(hash=False)
    short: ShortLaw
    pieces: tuple[Piece, ...]


def unstructured(data: CurveData) -> dict[str, Any]:
    """The curve as JSON holds it: floats keep all their digits, and the shape stands beside the rest."""
    document = asdict(data)
    return {**_HEADER, **document.pop("shape"), **document}


def structured(document: Any) -> CurveData:
    """The curve that `unstructured` has written.

    Raises
    ------
    InvalidValueError
        When it holds none.
    """
    from cattrs import BaseValidationError, structure, transform_error

    if not isinstance(document, dict):
        raise InvalidValueError.of("document", f"must be that of a curve (got {text_of(document)})")
    for key, known in _HEADER.items():
        if document.get(key) != known:
            raise InvalidValueError.of(key, f"must be {known!r} (got {text_of(document.get(key))})")
    try:
        return structure({**document, "shape": document}, CurveData)
    except BaseValidationError as error:
        problems = "; ".join(transform_error(error, "document", _problem))
        raise InvalidValueError.of("document", f"must be that of a curve (got {problems})") from None


def _problem(error: BaseException, kind: Any) -> str:
    from cattrs.v import format_exception

    return str(error) if isinstance(error, InvalidValueError) else format_exception(error, kind)
