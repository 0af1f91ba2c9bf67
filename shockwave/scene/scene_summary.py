"""Summary of a scene: the numbers that a result was computed for, in SI units, and their text."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

from shockwave.base.text import si
from shockwave.scene.chain import Chain
from shockwave.scene.shock import Shock


class SceneSummary(NamedTuple):
    """Numbers of a scene, and their text.

    Attributes
    ----------
    numbers : dict
        Shock, impact and chain in SI units, as in a document of a result.
    lines : tuple of (str, str)
        Label and text of the shock or the impact, and of the parts of the chain.
    """

    numbers: dict[str, Any]
    lines: tuple[tuple[str, str], ...]


def summary_of(excitation: object, chain: Chain, uniform: bool) -> SceneSummary:
    """Summary of a scene; ``uniform`` states whether it is a shock on equal granules with free ends."""
    if isinstance(excitation, Shock) and uniform:
        return _summarise_equal_granules(excitation, chain)
    from shockwave.scene.description import lines, plain, text  # for other scenes only

    name = type(excitation).__name__.lower()
    if isinstance(excitation, Shock):
        line, values = _shock_text(excitation), _shock_numbers(excitation)
    else:
        line, values = text(excitation), plain(excitation)
    numbers = {"shock": None, "impact": None, name: values, "chain": plain(chain), "granules": chain.count}
    return SceneSummary(numbers, ((name, line), *lines(chain)))


def _summarise_equal_granules(shock: Shock, chain: Chain) -> SceneSummary:
    contact = None
    if chain.contact is not None:
        from shockwave.scene.description import plain  # for such chains only

        contact = plain(chain.contact)
    material = chain.material
    numbers = _shock_numbers(shock) | {
        "radius": chain.radius,
        "youngs_modulus": material.youngs_modulus,
        "poisson_ratio": material.poisson_ratio,
        "density": material.density,
        "granules": chain.count,
        "contact": contact,
    }
    length = "endless" if chain.count is None else f"{chain.count} granules"
    stiffness = f"E {si(material.youngs_modulus, 'Pa')}, nu {material.poisson_ratio:.4g}"
    text = f"diameter {si(2 * chain.radius, 'm')}, {stiffness}, rho {material.density:.5g} kg/m^3, {length}"
    if chain.packing:
        numbers["packing"] = chain.packing
        text += f", packing {chain.packing}: forces per contact, shock per bead"
    lines = [("shock", _shock_text(shock)), ("chain", text)]
    if contact:
        law = ", ".join(f"{name} {value:.5g}" for name, value in contact.items() if name != "model")
        lines.append(("contact", law))
    return SceneSummary(numbers, tuple(lines))


def _shock_numbers(shock: Shock) -> dict[str, Any]:
    """Class of the profile, F0 [N], t0 [s] and n; read off the record where there is one."""
    return {
        "profile": type(shock.profile).__name__,
        "peak_force": shock.peak_force,
        "rise_time": shock.rise_time,
        "duration_ratio": float(shock.profile.duration_ratio),
    }


def _shock_text(shock: Shock) -> str:
    ratio = float(shock.profile.duration_ratio)
    duration = f"{si(shock.rise_time * ratio, 's')} (n = {ratio:.5g})"
    kind = "-".join(re.findall("[A-Z][^A-Z]*", type(shock.profile).__name__)).lower()  # as in the registry
    return f"{kind}, peak {si(shock.peak_force, 'N')}, rise {si(shock.rise_time, 's')}, duration {duration}"
