"""Answers of the explorer: results and pictures of a scenario, as parts of the page."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import shockwave as sw
from attrs import frozen
from markupsafe import Markup
from shockwave.chain.layout import Layout
from shockwave.pictures.drawing import BLACK, BLUE, GREEN, GREY, VERMILION
from shockwave.text import html_of, si

from .charts import Series, beads, chart, field_map
from .controls import controls
from .scene import loaded

_TEMPLATE = Path(__file__).with_name("parts.html.jinja")
_TIME, _CONTACT = ("time", "s"), ("contact, from the struck end", "")
# Colours of histories, and so their number.
_COLOURS = (BLUE, VERMILION, GREEN, BLACK)
# Most contacts with histories; first contacts of an endless chain that have one.
_MOST_CONTACTS = 120
_FIRST_CONTACTS = 60
# Waves whose forces are listed.
_MOST_WAVES = 6
# Least relative error that a text shows.
_LEAST_ERROR = 1e-4


@frozen
class Figure:
    """A picture of the page."""

    title: str
    picture: Markup
    caption: str = ""


@lru_cache(maxsize=8)
def answered(text: str) -> tuple[sw.Scenario, sw.Outcome]:
    """The scenario in ``text`` and its outcome, whose simulation records the histories that are drawn.

    Raises
    ------
    ShockwaveError
        As `loaded` and `shockwave.predict`.
    """
    scenario = loaded(text)
    count = scenario.chain.count
    contacts = range(_FIRST_CONTACTS if count is None else min(_FIRST_CONTACTS, count - 1))
    if not scenario.chain.is_uniform:
        contacts = range(0, count - 1, -(-count // _MOST_CONTACTS))
    recorded = {"record": ("forces", "field"), "contacts": contacts, "interval": None, "until": None}
    return scenario, sw.predict(scenario, **recorded)


def parts_of(text: str, *names: str) -> dict[str, str]:
    """The parts ``names`` of the page for the scenario in ``text``, as HTML: controls, headline, results, figures."""
    scenario, outcome = answered(text)
    values: dict[str, object] = {
        "groups": controls(scenario) if "controls" in names else {},
        "forces": list(_forces(outcome)),
        "facts": list(_facts(outcome)),
        "outcome": outcome,
        "figures": list(figures(scenario, outcome)) if "figures" in names else [],
    }
    return {name: html_of(_TEMPLATE, (), part=name, **values) for name in names}


def _forces(outcome: sw.Outcome) -> Iterator[tuple[str, str, str]]:
    """Name, value and accuracy of the forces in the headline."""
    named = [("Force on the wall", outcome.transmitted)]
    named.append(("Leading wave" if outcome.waves else "Greatest force", outcome))
    for name, force in named:
        if force is not None and force.peak_force is not None:
            error = (force.high - force.low) / 2 / (force.peak_force or 1.0)
            yield name, si(force.peak_force, "N", error=max(error, _LEAST_ERROR)), f"estimated error {error:.0e}"


def _facts(outcome: sw.Outcome) -> Iterator[tuple[str, str]]:
    """Label and text of each result."""
    if outcome.verdict is not None:
        yield "verdict", str(outcome.verdict)
    if outcome.amplification is not None:
        yield "amplification", f"{outcome.amplification:.4g} times the peak force of the shock"
    if outcome.waves:
        shown = [si(wave.peak_force, "N", 4) for wave in outcome.waves[:_MOST_WAVES]]
        yield "waves", f"{len(outcome.waves)}: " + ", ".join([*shown, "..."][: len(outcome.waves)])
    yield "applied momentum", si(outcome.applied_momentum, "N*s", 4)
    paper = outcome.section4
    if paper is None:
        yield "section 4", f"does not apply: {outcome.section4_reason}"
    else:
        error = "" if paper.error is None else f", error {100 * paper.error:+.2g} %"
        yield "section 4", f"{si(paper.peak_force, 'N', 4)}{error}; regime: {paper.regime}"


# ---------------------------------------------------------------- pictures


def figures(scenario: sw.Scenario, outcome: sw.Outcome) -> Iterator[Figure]:
    """The animation of the beads and the charts of a scene."""
    result = outcome.simulated if outcome.peak_force is not None else None
    kept: Any = None if result is None else result.recording
    if kept is not None:
        yield _animation(scenario, kept)
    if scenario.impact is None:
        yield _pulse(scenario.shock)
    if kept is not None:
        yield Figure("Space-time map", field_map(kept.times, kept.contacts, kept.forces, _CONTACT[0]))
        if kept.wall_force is not None:
            yield _wall(scenario, kept)
    if outcome.waves:
        yield _train(outcome, scenario.shock.peak_force)
    elif result is not None:
        contacts = [peak.contact for peak in result.contacts]
        peaks = Series(contacts, [peak.peak_force for peak in result.contacts], colour=VERMILION)
        picture = chart([peaks], _CONTACT, ("greatest force", "N"), max(contacts[-1], 1))
        yield Figure("Greatest force along the chain", picture)
    if kept is not None:
        yield _histories(kept)


def _animation(scenario: sw.Scenario, kept: Any) -> Figure:
    chain = scenario.chain
    radii = np.full(kept.displacements.shape[1], chain.radius)
    if not chain.is_uniform:
        radii = Layout.of(chain, scenario.excitation).radii
    return Figure("Beads", *beads(radii, kept.times, kept.displacements, kept.velocities, kept.wall_force is not None))


def _pulse(shock: sw.Shock) -> Figure:
    times = np.linspace(0, shock.duration, 600)
    times = np.union1d(times, shock.rise_time * np.asarray(shock.profile.breakpoints, dtype=float))
    pulse = Series(times, shock.peak_force * shock.profile.force(times / shock.rise_time), kind="area")
    return Figure("Pulse", chart([pulse], _TIME, ("force", "N"), shock.duration))


def _wall(scenario: sw.Scenario, kept: Any) -> Figure:
    end = float(kept.times[-1])
    lines = [Series(kept.times, kept.wall_force, colour=VERMILION)]
    if (limit := scenario.limit) is not None:
        lines.append(Series((0.0, end), (limit.force, limit.force), "limit", "dashed", BLACK))
    return Figure("Force on the wall", chart(lines, _TIME, ("force on the wall", "N"), end))


def _train(outcome: sw.Outcome, shock: float) -> Figure:
    """Peak forces of the waves, simulated and by section 4."""
    trains = {"simulated": (outcome.waves, "squares", VERMILION)}
    if outcome.section4 is not None:
        trains["section 4"] = (outcome.section4.waves, "dots", BLUE)
    ends = 0.5, max(len(waves) for waves, *_ in trains.values()) + 0.5
    series = [Series(ends, (shock, shock), "shock", "dashed", GREY)]
    for name, (waves, *look) in trains.items():
        series.append(Series(np.arange(1, len(waves) + 1), [wave.peak_force for wave in waves], name, *look))
    return Figure("Wave train", chart(series, ("wave", ""), ("peak force", "N"), ends[1], whole=True))


def _histories(kept: Any) -> Figure:
    chosen = np.unique(np.linspace(0, len(kept.contacts) - 1, len(_COLOURS)).astype(int))
    lines = [
        Series(kept.times, kept.forces[:, column], f"contact {kept.contacts[column]}", colour=colour)
        for column, colour in zip(chosen, _COLOURS, strict=False)
    ]
    return Figure("Contact forces", chart(lines, _TIME, ("contact force", "N"), float(kept.times[-1])))
