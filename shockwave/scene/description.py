"""Description of chains and impacts as plain data, in the form of a scenario file in SI units, and as text."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import attrs

from shockwave.base.quantity_fields import declaration_of
from shockwave.base.text import si
from shockwave.registry.registry import entry_of
from shockwave.scene.chain import Chain
from shockwave.scene.chain_end import Bar, Wall
from shockwave.scene.material import Material
from shockwave.scene.segments import Taper

# Items of a list that the text shows.
_MOST_ITEMS = 12
# Classes whose arguments have other names than their keys.
_KEYS = {Taper: {"first": "from", "last": "to"}, Wall: {"material": "wall"}}


def plain(part: Any, names: bool = True) -> Any:
    """A chain, an impact or one of their parts in the form of a scenario block, without default values.

    With ``names``, materials include their names and sources.
    """
    if isinstance(part, tuple):
        return [plain(one, names) for one in part]
    if not attrs.has(type(part)):
        return part
    keys = _KEYS.get(type(part), {})
    hidden = () if names or not isinstance(part, Material) else ("name", "source")
    form = {keys.get(name, name): plain(value, names) for name, value, _ in _list_stated(part) if name not in hidden}
    entry = entry_of("contacts", type(part))
    if isinstance(part, Wall | Bar):
        return {"wall": "same", **form} if isinstance(part, Wall) else {"bar": form}
    return {"model": entry.name, **form} if entry else form


def lines(chain: Chain) -> list[tuple[str, str]]:
    """Label and text of the granules and of every further feature."""
    stated = {name: text(value, unit) for name, value, unit in _list_diameters(chain) if not isinstance(value, int)}
    count = "1 granule" if chain.count == 1 else "endless" if chain.count is None else f"{chain.count} granules"
    head = f"{count}, diameter {stated.pop('diameter')}, {stated.pop('material')}"
    return [("chain", head), *stated.items()]


def _list_stated(part: Any) -> Iterator[tuple[str, Any, str]]:
    """Name, value and unit of the fields that differ from their defaults."""
    for field in attrs.fields(type(part)):
        value, spec = getattr(part, field.name), declaration_of(field)
        if value != field.default:
            yield field.name, value, spec.unit if spec is not None else ""


def _list_diameters(part: Any) -> Iterator[tuple[str, Any, str]]:
    """As `_list_stated`, with diameters in place of radii."""
    for name, value, unit in _list_stated(part):
        if name == "radius" and isinstance(value, Taper):
            yield "diameter", attrs.evolve(value, first=2 * value.first, last=2 * value.last), unit
        else:
            yield ("diameter", 2 * value, unit) if name == "radius" else (name, value, unit)


def text(value: Any, unit: str = "") -> str:
    """A value, an impact or another part in one line."""
    if isinstance(value, tuple):
        rest = [f"{len(value) - _MOST_ITEMS} more"] if len(value) > _MOST_ITEMS else []
        return "; ".join([*map(text, value[:_MOST_ITEMS]), *rest])
    if isinstance(value, Material):
        constants = f"E {si(value.youngs_modulus, 'Pa')}, nu {value.poisson_ratio:.4g}, rho {value.density:.5g} kg/m^3"
        strength = f", yield strength {si(value.yield_strength, 'Pa')}" if value.yield_strength else ""
        return value.name or constants + strength
    if isinstance(value, Taper):
        return f"{si(value.first, 'm')} to {si(value.last, 'm')}, {value.spacing}"
    if attrs.has(type(value)):
        keys = _KEYS.get(type(value), {})
        fields = [f"{keys.get(name, name)} {text(each, of)}" for name, each, of in _list_diameters(value)]
        entry = entry_of("contacts", type(value))
        defaults = (
            "bar"
            if isinstance(value, Bar)
            else "wall of the same material"
            if isinstance(value, Wall) and value.material == "same"
            else ""
        )
        return ", ".join(filter(None, (entry.name if entry else defaults, *fields))) or "count 1"
    return si(value, unit) if isinstance(value, float) else str(value)
