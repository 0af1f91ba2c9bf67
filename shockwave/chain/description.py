"""Description of chains and impacts as plain data, in the form of a scenario file, with numbers in SI units."""

from __future__ import annotations

from typing import Any

import attrs

from shockwave.chain.chain import Chain
from shockwave.chain.impact import Impact
from shockwave.chain.material import Material
from shockwave.chain.segments import Cell, Segment, Taper
from shockwave.fields import quantity_of
from shockwave.registry import entry_of
from shockwave.text import si

# Lines of segments; the number of further granules is stated.
_MOST_LINES = 12
# Arguments of a taper whose keys have other names.
_ENDS = {"first": "from", "last": "to"}


def chain_data(chain: Chain, names: bool = True) -> dict[str, Any]:
    """The ``chain`` block of a chain; with ``names``, those of its materials as well."""
    form = _block(chain, names)
    if isinstance(chain.granules, tuple):
        form["granules"] = [_part(part, names) for part in chain.granules]
    if chain.end is not None:
        own = _block(chain.end, names)
        form["end"] = {"wall": own.pop("material", "same"), **own}
    for name, law in (("damping", chain.damping), ("contact", chain.contact)):
        if law is not None:
            entry = entry_of("contacts", type(law))
            model = entry.name if entry else f"{type(law).__module__}:{type(law).__qualname__}"
            form[name] = {"model": model, **_block(law, names)}
    return form


def impact_data(impact: Impact, names: bool = True) -> dict[str, Any]:
    """The ``impact`` block of an impact."""
    return _block(impact, names)


def _part(part: Segment | Cell, names: bool) -> dict[str, Any]:
    form = _block(part, names)
    if isinstance(part, Cell):
        form["cell"] = [_block(segment, names) for segment in part.cell]
    return form


def _block(owner: Any, names: bool) -> dict[str, Any]:
    """Fields of an object that differ from their defaults."""
    form = {}
    for field in attrs.fields(type(owner)):
        value = getattr(owner, field.name)
        if value != field.default:
            form[_ENDS.get(field.name, field.name)] = _value(value, names)
    return form


def _value(value: Any, names: bool) -> Any:
    if isinstance(value, Material):
        form = _block(value, names)
        return form if names else {name: own for name, own in form.items() if name not in ("name", "source")}
    return _block(value, names) if isinstance(value, Taper) else value


# ---------------------------------------------------------------- text


def impact_line(impact: Impact, chain: Chain) -> str:
    """The impact in one line."""
    striker = _granule(impact.material or chain.material, impact.radius or chain.radius)
    return f"{si(impact.velocity, 'm/s')}, {striker}"


def chain_lines(chain: Chain) -> list[tuple[str, str]]:
    """Label and text of the granules and of every further feature."""
    parts = chain.granules if isinstance(chain.granules, tuple) else (Segment(count=chain.granules or 1),)
    lines = [("chain" if not index else "", _part_text(chain, part)) for index, part in enumerate(parts)]
    if len(lines) > _MOST_LINES:
        rest = sum(part.granules for part in parts[_MOST_LINES - 1 :])
        lines[_MOST_LINES - 1 :] = [("", f"and {rest} more in {len(parts) - _MOST_LINES + 1} segments")]
    end = chain.end
    if end is None:
        lines.append(("end", "free"))
    else:
        kind = end.material if isinstance(end.material, str) else _material(end.material)
        lines.append(("end", f"wall, {kind}{_fields(end)}"))
    lines += [(name, _number(chain, name)) for name in ("precompression", "gravity") if getattr(chain, name)]
    data = chain_data(chain)
    for name, law in (("damping", chain.damping), ("contact", chain.contact)):
        if law is not None:
            lines.append((name, f"{data[name]['model']}{_fields(law)}"))
    return lines


def _part_text(chain: Chain, part: Segment | Cell) -> str:
    if isinstance(part, Cell):
        return f"{part.repeat} cells of " + " + ".join(_part_text(chain, segment) for segment in part.cell)
    own = _granule(part.material or chain.material, part.radius or chain.radius)
    gap = f", gap {si(part.gap, 'm')}" if part.gap else ""
    return f"{part.count} granule{'s' * (part.count > 1)}, {own}{gap}"


def _granule(material: Material, radius: float | Taper) -> str:
    if isinstance(radius, Taper):
        size = f"R {si(radius.first, 'm')} to {si(radius.last, 'm')} ({radius.spacing})"
    else:
        size = f"R {si(radius, 'm')}"
    return f"{size}, {_material(material)}"


def _material(material: Material) -> str:
    stiffness = f"E {si(material.youngs_modulus, 'Pa')}, nu {material.poisson_ratio:.4g}"
    return material.name or f"{stiffness}, rho {material.density:.5g} kg/m^3"


def _fields(owner: Any) -> str:
    """Numbers of an object that differ from their defaults."""
    names = [field.name for field in attrs.fields(type(owner)) if getattr(owner, field.name) != field.default]
    return "".join(f", {name} {_number(owner, name)}" for name in names if name != "material")


def _number(owner: Any, name: str) -> str:
    spec = quantity_of(attrs.fields_dict(type(owner))[name])
    value = getattr(owner, name)
    return str(value) if spec is None else si(value, spec.unit)
