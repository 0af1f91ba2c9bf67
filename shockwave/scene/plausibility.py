"""Usual ranges of quantities, outside which a typing error or a wrong unit is likely; they limit nothing."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from shockwave.base.errors import Fault, dotted_name
from shockwave.base.text import si


class Usual(NamedTuple):
    """A range in the SI unit ``unit``, with the reason for both ends."""

    low: float
    high: float
    unit: str
    reason: str


#: Name of a quantity -> its usual range.
USUAL = {
    # Johnson, Contact Mechanics, section 5.5: adhesion is negligible for large bodies and forces only
    "diameter": Usual(1e-6, 1.0, "m", "smaller granules adhere, larger ones are not elastic spheres"),
    # laser pulses last 1 ps or more; under a force that takes longer than a second to rise, a chain is at rest
    "rise_time": Usual(1e-12, 1.0, "s", "from laser pulses to slow presses"),
    "peak_force": Usual(1e-9, 1e9, "N", "from single grains of powder to explosions at a wall"),
    # at a kilometre per second the pressure rho c v exceeds the strength of every solid
    "velocity": Usual(1e-6, 1e3, "m/s", "slower strikers creep, faster ones shatter or melt"),
    # Kuwabara-Kono times of metals and polymers are of the order of a microsecond or less
    "time": Usual(1e-12, 1e-3, "s", "longer ones belong to liquids and gels"),
    "gap": Usual(1e-12, 0.1, "m", "wider ones are longer than a granule"),
    # osmium 22 590 kg/m^3; the mass of a piston can be lumped into a sphere
    "density": Usual(10.0, 1e5, "kg/m**3", "from foams to spheres that stand for pistons"),
    # diamond 1.2 TPa
    "youngs_modulus": Usual(1e3, 1.3e12, "Pa", "from soft gels to diamond"),
}


def unusual(excitation: Any, chain: Any) -> list[Fault]:
    """Sentences on the unusual values of a shock or an impact and a chain, with their places in a scenario."""
    faults = []
    for place, name, value in _values(excitation, chain):
        low, high, unit, reason = USUAL[name]
        if not low <= value <= high:
            bounds = " to ".join(si(end, unit, 6) for end in (low, high))
            problem = f"is {si(value, unit)}; usual values are {bounds} ({reason}). Check the unit."
            faults.append(Fault(f"{place}.{name}", problem))
    if chain.is_plastic:
        from shockwave.scene.plastic_range import range_warnings  # elastic contacts do not need it

        faults += range_warnings(chain, excitation)
    if chain.elastic_only and _lacks_strength(chain, excitation):
        problem = "refuses every result, because a yield strength is not known. State yield_strength of each material."
        faults.append(Fault("chain.elastic_only", problem))
    return faults


def _lacks_strength(chain: Any, excitation: Any) -> bool:
    """Whether a yield strength at some contact with Hertz's law is not known."""
    if chain.count is None:
        return chain.material.yield_strength is None
    from shockwave.scene.layout import Layout  # endless chains do not need it

    layout = Layout.of(chain, excitation)
    return any(map(math.isnan, layout.strengths[layout.hertz_contacts]))


def unusual_warnings(excitation: Any, chain: Any) -> tuple[str, ...]:
    """The same as warnings, and those on the processing of a record."""
    faults = tuple(f"{fault.path} {fault.problem}" for fault in unusual(excitation, chain))
    return getattr(getattr(excitation, "profile", None), "alarms", ()) + faults


def _values(excitation: Any, chain: Any) -> Iterator[tuple[str, str, float]]:
    """Places, names and values of all quantities that have a usual range."""
    if hasattr(excitation, "rise_time"):
        yield "shock", "peak_force", excitation.peak_force
        yield "shock", "rise_time", excitation.rise_time
    elif hasattr(excitation, "speed"):
        yield "impact", "velocity", excitation.speed(chain.gravity)
        yield from _sphere("impact", excitation)
    yield from _sphere("chain", chain)
    if chain.end is not None:
        yield from _material(
            f"chain.end.{'wall' if hasattr(chain.end, 'stiffness_ratio') else 'bar.material'}", chain.end.material
        )
    if isinstance(chain.granules, tuple):
        from shockwave.scene.segments import each_segment  # equal granules do not need it

        for steps, segment in each_segment(chain.granules):
            yield from _sphere(dotted_name(("chain", "granules", *steps)), segment)


def _sphere(place: str, part: Any) -> Iterator[tuple[str, str, float]]:
    """Diameter, gap, damping and material of a part, as far as it has its own."""
    if part.radius is not None:
        for radius in (part.radius,) if isinstance(part.radius, float) else (part.radius.first, part.radius.last):
            yield place, "diameter", 2 * radius
    if getattr(part, "gap", 0.0):
        yield place, "gap", part.gap
    if time := getattr(getattr(part, "damping", None), "time", 0.0):
        yield f"{place}.damping", "time", time
    yield from _material(f"{place}.material", part.material)


def _material(place: str, material: Any) -> Iterator[tuple[str, str, float]]:
    """Density and modulus of a material; none of a name, or without one."""
    if hasattr(material, "density"):
        yield place, "density", material.density
        yield place, "youngs_modulus", material.youngs_modulus
