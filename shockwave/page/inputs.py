"""What was asked: shock and chain in SI units with prefixes, and the conditions (3)."""

from __future__ import annotations

from collections.abc import Iterator

import attrs
import numpy as np

from shockwave.chain.chain import Scales
from shockwave.errors import ShockwaveError
from shockwave.fields import quantity_of
from shockwave.markup import Html, density, facts, formula, joined, quantity, table, tag
from shockwave.page.provenance import profile_name
from shockwave.profiles.conditions import TOLERANCE, Condition, conditions
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_hash import parameters

__all__ = ["asked", "judged"]

# A longer text of a parameter is cut.
_LONGEST = 200


def asked(scenario: Scenario) -> Html:
    """Shock and chain."""
    shock = joined((tag("h3", "Shock"), facts(_shock(scenario))))
    chain = joined((tag("h3", "Chain"), facts(_chain(scenario))))
    return tag("div", tag("div", shock), tag("div", chain), kind="columns")


def judged(scenario: Scenario) -> Html:
    """The conditions (3) with their margins."""
    areas, n = scenario.shock.profile.areas(), float(scenario.shock.profile.duration_ratio)
    told = joined(
        (
            "Areas in rise times: ",
            formula("a1"),
            " = ",
            quantity(areas.rise.value, ""),
            " under the rise, ",
            formula("a2"),
            " = ",
            quantity(areas.decay.value, ""),
            " under the decay.",
        )
    )
    rows = [(formula(one.statement), *_verdict(one, n)) for one in conditions(areas, n)]
    caption = "Margins are in rise times, and negative where a condition fails."
    return joined((tag("p", told), table(("condition", "margin", ""), rows, caption)))


def _verdict(condition: Condition, n: float) -> tuple[Html, Html]:
    # a margin within the tolerance is none
    margin = condition.margin if abs(condition.margin) > TOLERANCE * n else 0.0
    shown = quantity(margin, "", 4)
    return (Html(f"+{shown}") if margin > 0 else shown), (
        tag("span", "holds") if condition.holds else tag("span", "fails", kind="fails")
    )


def _shock(scenario: Scenario) -> Iterator[tuple[str, str]]:
    shock = scenario.shock
    yield "profile", profile_name(shock.profile)
    yield from _parameters(scenario)
    yield "peak force", quantity(shock.peak_force, "N")
    yield "rise time", quantity(shock.rise_time, "s")
    yield "duration", quantity(shock.duration, "s")
    yield "duration over rise time", quantity(float(shock.profile.duration_ratio), "")
    yield "impulse", quantity(shock.profile.areas().total * shock.peak_force * shock.rise_time, "N s")


def _parameters(scenario: Scenario) -> Iterator[tuple[str, str]]:
    profile = scenario.shock.profile
    cls: type = type(profile)
    declared = attrs.fields_dict(cls) if attrs.has(cls) else {}
    for name, value in parameters(profile).items():
        if name == "duration_ratio":
            continue
        spec = quantity_of(declared[name]) if name in declared else None
        yield name.replace("_", " "), _value(value, spec.unit if spec is not None else "")


def _value(value: object, unit: str) -> str:
    if isinstance(value, np.ndarray | list | tuple):
        return f"{len(value)} samples"
    if isinstance(value, int | float) and not isinstance(value, bool):
        return quantity(value, unit)
    text = str(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def _chain(scenario: Scenario) -> Iterator[tuple[str, str]]:
    chain, material = scenario.chain, scenario.chain.material
    if material.name:
        yield "material", material.name
    yield "Young's modulus", quantity(material.youngs_modulus, "Pa")
    yield "Poisson's ratio", quantity(material.poisson_ratio, "")
    yield "density", density(material.density)
    yield "diameter of the granules", quantity(2 * chain.radius, "m")
    yield "mass of a granule", quantity(1e3 * chain.granule_mass, "g")
    yield "granules", "as many as the answer needs" if chain.granules is None else str(chain.granules)
    try:
        scales = Scales.of(chain, scenario.shock.peak_force)
    except ShockwaveError:
        return
    yield "natural time", quantity(scales.time, "s")
    yield "rise time over natural time", quantity(scenario.shock.rise_time / scales.time, "")
