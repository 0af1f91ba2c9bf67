"""Declarations of a plugin's class, checked before a scenario is held against them."""

from __future__ import annotations

import attrs

from shockwave.fields import quantity_of
from shockwave.scenario.units import to_si


def check_declared(cls: type) -> None:
    """Check what the fields of ``cls`` declare: units that exist, defaults within their range.

    Raises
    ------
    TypeError
        When the class declares fields and was not made by attrs.
    ValueError
        When a field is declared wrongly.
    """
    loose = [name for name, value in vars(cls).items() if type(value).__name__ == "_CountingAttr"]
    if loose:
        raise TypeError(f"must be decorated with attrs.frozen, as it declares the field {loose[0]}")
    for attribute in attrs.fields(cls) if attrs.has(cls) else ():
        spec = quantity_of(attribute)
        if spec is None or spec.samples:
            continue
        try:
            to_si(f"1 {spec.unit}", spec.unit)
        except ValueError:
            raise ValueError(f"field {attribute.name} has the unit {spec.unit!r}, which does not exist") from None
        default = attribute.default
        known = default is not attrs.NOTHING and not isinstance(default, attrs.Factory)  # type: ignore[arg-type]
        if known and spec.problem(default) is not None:
            raise ValueError(f"the default of field {attribute.name} {spec.problem(default)}")
