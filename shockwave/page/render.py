"""The page as HTML, from the template ``report.html.jinja`` beside this file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import attrs
import numpy as np
from markupsafe import Markup

from shockwave import pictures
from shockwave.chain.chain import Scales
from shockwave.fields import quantity_of
from shockwave.page.drawings import drawn
from shockwave.page.number_text import digits_of, formula, percent, quantity, small
from shockwave.page.provenance import parts_in_use, profile_name, versions
from shockwave.page.results import Findings, findings
from shockwave.profiles.base import ShockProfile
from shockwave.profiles.conditions import conditions
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_hash import parameters, scene_hash
from shockwave.text import admitted

# Characters of a parameter that are shown.
_LONGEST = 200


def page(scenario: Scenario) -> str:
    """One page on ``scenario``, as HTML that needs nothing from elsewhere.

    A prediction or a simulation that fails is reported in the page. To simulate in another way than the scenario
    says, give it other options: ``attrs.evolve(scenario, simulate=...)``. The same scenario makes the same page, to
    the byte.

    Parameters
    ----------
    scenario : Scenario
        The scenario. The text of its file is shown if it can be read.

    Raises
    ------
    UsageError
        When matplotlib is missing.
    """
    pictures.figure()  # before anything is computed
    return written(findings(scenario))


def written(found: Findings) -> str:
    """The page of the results of a scenario.

    Raises
    ------
    UsageError
        When matplotlib is missing.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=_admitted,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    for name in (digits_of, formula, percent, quantity, small):
        environment.filters[name.__name__] = name
    shock, chain = found.scenario.shock, found.scenario.chain
    areas = shock.profile.areas()
    figures, not_drawn = drawn(found)
    text = environment.get_template("report.html.jinja").render(
        found=found,
        profile=profile_name(shock.profile),
        parameters=list(_parameters(shock.profile)),
        areas=areas,
        characteristic_time=Scales.of(chain, shock.peak_force).time,
        conditions=conditions(areas, float(shock.profile.duration_ratio)),
        figures=figures,
        not_drawn=not_drawn,
        svg=pictures.svg,
        versions=versions(found),
        hash=scene_hash(found.scenario),
        parts=list(parts_in_use(found)),
    )
    return text.lstrip()


def _admitted(value: object) -> object:
    return admitted(value) if isinstance(value, str) and not isinstance(value, Markup) else value


def _parameters(profile: ShockProfile) -> Iterator[tuple[str, str]]:
    """Names and values of a profile's parameters, with their units."""
    cls: type = type(profile)
    declared = attrs.fields_dict(cls) if attrs.has(cls) else {}
    for name, value in parameters(profile).items():
        if name == "duration_ratio":
            continue
        spec = quantity_of(declared[name]) if name in declared else None
        if isinstance(value, np.ndarray | list | tuple):
            text = f"{len(value)} samples"
        elif isinstance(value, int | float) and not isinstance(value, bool):
            text = quantity(value, spec.unit if spec is not None else "")
        else:
            text = str(value)[:_LONGEST]
        yield name.replace("_", " "), text
