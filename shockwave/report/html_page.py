"""Rendering of the page as HTML from the template ``report.html.jinja``."""

from __future__ import annotations

import platform
from collections.abc import Callable, Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from shockwave import __version__, pictures
from shockwave.base.quantity_fields import quantity_of
from shockwave.base.text import html_of
from shockwave.pictures.figure_files import add_description
from shockwave.pictures.finite_chains import find_borders
from shockwave.profiles.area_conditions import evaluate_conditions
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.registry.built_ins import Entry
from shockwave.registry.registry import entry_of, find
from shockwave.report.number_text import formula, percent, quantity, small, typeset
from shockwave.report.page_pictures import draw_pictures
from shockwave.report.page_results import PageResults, compute_results
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_hash import parameters, scene_hash
from shockwave.scene.chain import Scales
from shockwave.simulation.simulation_text import answer, balances, choose_items, greatest_text, lead_text, span


def page(scenario: Scenario) -> str:
    """Predict and simulate ``scenario``, and return a self-contained HTML page.

    A failure of the prediction or the simulation is reported in the page. To simulate with other options, replace
    them with ``attrs.evolve(scenario, simulate=...)``. The same scenario gives the same page to the byte.

    Parameters
    ----------
    scenario : Scenario
        The scenario. If it has a file, its text is shown.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    pictures.figure()  # fails early without matplotlib
    return render_page(compute_results(scenario))


def render_page(results: PageResults) -> str:
    """Return the page of the results of a scenario.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    simulated = (answer, balances, choose_items, greatest_text, lead_text, span)
    filters: tuple[Callable[..., object], ...] = (formula, percent, quantity, small, typeset, *simulated)
    return html_of(
        Path(__file__).with_name("report.html.jinja"),
        filters,
        results=results,
        scene=results.scenario.scene.summary(),
        **({"conditions": ()} if results.is_beyond else _shock_facts(results.scenario)),
        pictures=list(draw_pictures(results)),
        add_description=add_description,
        has_borders=results.is_beyond and results.simulated is not None and bool(find_borders(results.simulated)),
        versions=_versions(results),
        hash=scene_hash(results.scenario),
        parts=list_parts(results),
    )


def _shock_facts(scenario: Scenario) -> dict[str, Any]:
    """Statements of the page about the shock and the conditions on it."""
    shock = scenario.shock
    areas = shock.profile.areas()
    profile = entry_of("profiles", type(shock.profile))
    return {
        "profile": profile.name if profile else type(shock.profile).__name__,
        "parameters": _parameters(shock.profile),
        "areas": areas,
        "contact": dict(scenario.scene.summary().facts()).get("contact"),
        "characteristic_time": Scales.of(scenario.scene.line, shock.peak_force).time,
        "conditions": evaluate_conditions(areas, float(shock.profile.duration_ratio)),
    }


# ---------------------------------------------------------------- parameters and provenance


def _parameters(profile: ShockProfile) -> Iterator[tuple[str, str]]:
    """Names and values of the parameters of a profile, with units."""
    cls: type = type(profile)
    declared = attrs.fields_dict(cls) if attrs.has(cls) else {}
    for name, value in parameters(profile).items():
        if name == "duration_ratio" or value is None:
            continue
        spec = quantity_of(declared[name]) if name in declared else None
        if isinstance(value, np.ndarray | list | tuple):
            text = f"{len(value)} samples"
        elif isinstance(value, bool):
            text = "yes" if value else "no"
        elif isinstance(value, int | float):
            text = quantity(value, spec.unit if spec is not None else "")
        else:
            text = str(value)
        yield name.replace("_", " "), text


def _versions(results: PageResults) -> Iterator[tuple[str, str]]:
    """Names and versions of the software, and the backend of the simulation."""
    yield "shockwave", __version__
    yield "Python", platform.python_version()
    for name in ("NumPy", "SciPy", "matplotlib"):
        yield name, metadata.version(name)
    if results.simulated is not None:
        yield "backend", results.simulated.backend


def list_parts(results: PageResults) -> Iterator[tuple[str, str, str]]:
    """Yield kind, name and distribution of each registered object in use."""
    used: list[tuple[str, Entry | None]] = []
    if results.scenario.shock is not None:
        used.append(("profile", entry_of("profiles", type(results.scenario.shock.profile))))
    if results.simulated is not None:
        used.append(("integrator", find("integrators", results.simulated.integrator)))
    for kind, part in used:
        if part is not None:
            yield kind, part.name, f"{part.distribution} {metadata.version(part.distribution)}"
