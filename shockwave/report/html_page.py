"""Rendering of the page as HTML from the template ``report.html.jinja``, with its pictures."""

from __future__ import annotations

import platform
from collections.abc import Callable, Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from shockwave import __version__, pictures
from shockwave.base.errors import ShockwaveError
from shockwave.base.progress import track
from shockwave.base.quantity_fields import declaration_of
from shockwave.base.text import html_of
from shockwave.pictures.figure_files import UNMARKED, add_description
from shockwave.pictures.picture_elements import Axes
from shockwave.pictures.waves import find_borders
from shockwave.prediction.section4_outcome import EjectionOutcome
from shockwave.profiles.area_conditions import evaluate_conditions
from shockwave.profiles.shock_profile import ShockProfile
from shockwave.registry.built_ins import Entry
from shockwave.registry.registry import entry_of, find
from shockwave.report.number_text import formula, percent, quantity, small, typeset
from shockwave.report.page_results import PageResults, compute_results
from shockwave.scenario.scenario import Scenario
from shockwave.scenario.scene_hash import parameters, scene_hash
from shockwave.scene.chain import HERTZ, Chain, Scales
from shockwave.scene.shock import Shock
from shockwave.simulation.simulation_text import answer, balances, choose_items, greatest_text, lead_text, span
from shockwave.studies.amplification_curve import UniversalCurve


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
        "contact": dict(scenario.scene.summary().lines).get("contact"),
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
        spec = declaration_of(declared[name]) if name in declared else None
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


# ---------------------------------------------------------------- pictures

# A function that draws a picture.
_Draw = Callable[[Axes], object]

# Longest shocks of the curve of amplifications, as a rule and at most [T0].
_LONGEST = 50.0
_LONGEST_OF_ALL = 1000.0
# Pictures that answer the question of the page, the first that applies beside its first lines.
_ANSWERS = ("wall", "peaks", "forces", "train", "pulse")
# Width and height [in]: a column in print, legible on a phone.
_SIZE = (3.4, 2.5)


def draw_pictures(results: PageResults) -> Iterator[tuple[str, str, str]]:
    """Draw the pictures of a scene.

    Yields
    ------
    str, str, str
        Name and SVG element of each picture, and the reason why it could not be drawn; one of the two is empty.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    for name, draw in track("pictures", list(choose_pictures(results).items())):
        figure, (ax,) = pictures.figure(size=_SIZE)
        UNMARKED.add(figure)
        try:
            draw(ax)
        except ShockwaveError as error:
            yield name, "", str(error)
        else:
            yield name, pictures.svg(figure, name), ""


def choose_pictures(results: PageResults) -> dict[str, _Draw]:
    """Return the functions that draw the pictures of a scene, the answer first; their titles are in the template."""
    chosen, limit = _pictures_of(results), results.scenario.limit
    answers = ("sensors", *_ANSWERS) if limit is not None and limit.at == "spring" else _ANSWERS
    lead = next((name for name in answers if name in chosen), None)
    return dict(sorted(chosen.items(), key=lambda item: item[0] != lead))


def _pictures_of(results: PageResults) -> dict[str, _Draw]:
    shock, compared = results.scenario.shock, results.comparison
    predicted = results.predicted and results.predicted.section4
    result: Any = results.simulated
    chosen: dict[str, _Draw] = {}
    if shock is not None:
        chosen["pulse"] = lambda ax: pictures.pulse(shock, ax=ax)
    if results.is_beyond and result is not None:
        chosen["peaks"] = lambda ax: pictures.peak_forces(result, ax=ax)
        chosen["chain-map"] = lambda ax: pictures.chain_map(result, ax=ax)
        if result.transmitted is not None:
            chosen["wall"] = lambda ax: pictures.wall_force(result, ax=ax)
        if result.structure is not None and result.structure.peak_acceleration is not None:
            chosen["structure"] = lambda ax: pictures.sensors(result, "m/s^2", ax=ax)
            chosen["spectrum"] = lambda ax: pictures.shock_spectrum(result.spectrum(), ax=ax)
    if result is not None and any(sensor.unit == "N" for sensor in result.options.sensors):
        chosen["sensors"] = lambda ax: pictures.sensors(result, "N", ax=ax)
    if results.is_beyond:
        return chosen
    if isinstance(predicted, EjectionOutcome):
        chosen["correction"] = lambda ax: pictures.correction_area(shock, predicted, ax=ax)
    if compared is not None:
        chosen["train"] = lambda ax: pictures.train(compared, ax=ax)
    if result is not None:
        chosen["approach"] = lambda ax: pictures.approach(result, ax=ax)
        if result.options.record:
            chosen["forces"] = lambda ax: pictures.contact_forces(result, ax=ax)
            chosen["map"] = lambda ax: pictures.space_time(result, ax=ax)
            chosen["energy"] = lambda ax: pictures.balance(result, ax=ax)
    if predicted is not None and results.scenario.chain.exponent == HERTZ:
        chosen["amplification"] = lambda ax: _amplification(ax, shock, results.scenario.chain)
    return chosen


def _amplification(ax: Axes, shock: Shock, chain: Chain) -> None:
    ratio = Scales.of(chain, shock.peak_force).rise_time(shock.rise_time)
    longest = min(max(_LONGEST, 2 * ratio * float(shock.profile.duration_ratio)), _LONGEST_OF_ALL)
    pictures.universal_curves({"simulation": UniversalCurve(shock.profile, longest=longest)}, mark=ratio, ax=ax)
