"""A universal curve as plain data, and its JSON format."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from attrs import Attribute, asdict, field, frozen

from shockwave.errors import Fault, InvalidValueError
from shockwave.fields import quantity, text_of
from shockwave.studies.chebyshev_fit import Piece
from shockwave.studies.profile_shape import Shape

_HEADER = {"format": "shockwave universal curve", "version": 1}
_RULES = {float: "a number", int: "a whole number"}


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
    made_with: Mapping[str, str] = field(hash=False)
    short: ShortLaw
    pieces: tuple[Piece, ...] = field()

    @pieces.validator
    def _adjoin(self, attribute: Attribute[Any], pieces: tuple[Piece, ...]) -> None:
        joints = [self.short.end, *(piece.end for piece in pieces)]
        if [piece.begin for piece in pieces] != joints[:-1] or joints[-1] < math.log(self.longest):
            rule = f"must adjoin from short.end, {joints[0]!r}, to ln of longest"
            raise InvalidValueError.of(attribute.name, f"{rule} (got joints at {text_of(joints[1:])})")


def unstructured(data: CurveData) -> dict[str, Any]:
    """The curve as JSON holds it: floats keep all their digits, and the shape stands beside the rest."""
    document = asdict(data)
    return {**_HEADER, **document.pop("shape"), **document}


def structured(document: Any) -> CurveData:
    """The curve that `unstructured` has written.

    Raises
    ------
    InvalidValueError
        When it holds no curve, with the path of every value at fault.
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
        parts = [message.rpartition(" @ ") for message in transform_error(error, "", _rule)]
        rules = (f"{path.removeprefix('.shape')}{message}".lstrip(".") for message, _, path in parts)
        raise InvalidValueError(Fault("", message) for message in rules) from None


def _rule(error: BaseException, kind: Any) -> str:
    """A rule behind the path at which cattrs found the error."""
    if isinstance(error, InvalidValueError):
        return f".{error}"
    if isinstance(error, KeyError):
        return ": must be there (got nothing; is this the file of a curve?)"
    return f": must be {_RULES.get(kind, 'a list or a mapping')} (got {error})"
