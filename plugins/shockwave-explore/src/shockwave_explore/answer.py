"""Answers of the explorer: results and pictures of a scenario, as parts of the page."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
import shockwave as sw
from attrs import frozen
from markupsafe import Markup
from shockwave import report
from shockwave.base.text import html_of, render_on_screen
from shockwave.pictures.picture_elements import BLACK, COLOURS, METHODS, si_label
from shockwave.prediction.outcome_text import feature_text, features_text, lead_text
from shockwave.report.number_text import formula, percent, quantity, typeset
from shockwave.scene.layout import Layout
from shockwave.scene.sensors import Sensor

from .charts import Series, draw_beads, draw_chart, draw_map
from .controls import list_controls
from .scene import load_text

_TEMPLATE = Path(__file__).with_name("parts.html.jinja")
_PARTS = "controls", "headline", "results", "figures", "decision"
# Filters of the templates of the report.
_FILTERS = formula, percent, quantity, typeset
_TIME, _CONTACT = ("time", "s"), ("contact, from the struck end", "")
# Colours of histories, and so their number.
_COLOURS = COLOURS[:4]
# Units of sensors, and titles of their charts.
_SENSORS = {"N": "Force", "m/s": "Velocity", "m": "Displacement", "m/s^2": "Acceleration"}
# Distance of markers from the number of their wave.
_ASIDE = 0.12
# Samples of histories up to a given time.
_SAMPLES = 2000
# Most contacts with histories; first contacts of an endless chain that have one.
_MOST_CONTACTS = 120
_FIRST_CONTACTS = 60


@frozen
class Figure:
    """A picture of the page."""

    title: str
    picture: Markup
    caption: str = ""
    moves: bool = False


def predict_text(text: str) -> tuple[sw.Scenario, sw.Outcome]:
    """The scenario in ``text`` and its outcome, whose simulation records the histories that are drawn.

    Raises
    ------
    ShockwaveError
        As `load_text` and `shockwave.predict`.
    """
    scenario = load_text(text)
    count, end = scenario.scene.contact_count, scenario.chain.end
    contacts = range(_FIRST_CONTACTS)
    if count is not None:
        count -= end is not None  # that with the wall has a history of its own
        all_contacts = range(0, count, max(1, -(-count // _MOST_CONTACTS)))
        contacts = range(min(_FIRST_CONTACTS, count)) if scenario.chain.is_uniform else all_contacts
    until = scenario.simulate.until
    interval = None if until is None else until / _SAMPLES
    drawn = sorted({*contacts, *scenario.simulate.contacts})
    histories: dict[str, Any] = {"record": ("forces", "field"), "contacts": drawn, "interval": interval}
    if isinstance(end, sw.Wall) and end.mass is not None:
        asked = scenario.simulate.sensors
        histories["sensors"] = asked if Sensor("structure") in asked else (*asked, Sensor("structure"))
    return scenario, sw.predict(scenario, **histories)


def parts_of(text: str) -> dict[str, str]:
    """The parts of the page for the scenario in ``text``, as HTML: controls, headline, results, figures, decision."""
    scenario, outcome = predict_text(text)
    _, *lines = render_on_screen(outcome, columns=sys.maxsize).split("\n")
    if outcome.simulated is not None:
        lines += [f"! {warning}" for warning in outcome.simulated.warnings if warning.startswith("No histories")]
    faults = outcome.section4_faults
    keys, words = features_text(faults), ", ".join(map(feature_text, faults))
    values: dict[str, object] = {
        "groups": list_controls(scenario, outcome),
        "lead": _lead(scenario, outcome),
        "facts": [line.replace(keys, words).strip().partition("  ") for line in lines],
        "figures": list(draw_figures(scenario, outcome)),
        "decision": _write_decision(outcome),
    }
    return {name: html_of(_TEMPLATE, _FILTERS, part=name, **values) for name in _PARTS}


def _lead(scenario: sw.Scenario, outcome: sw.Outcome) -> tuple[str, str, str]:
    """The answer and its accuracy; or why there is none, in words of the page."""
    lead = lead_text(outcome)
    if "the time limit was reached" in lead:
        limit = f"the limit of {scenario.simulate.timeout:g} s of this page"
        lead = f"no answer: the simulation reached {limit}; shorten the shock or set until"
    return lead.partition(", ") if outcome.reason is None else (lead, "", "")


def _write_decision(outcome: sw.Outcome) -> Markup:
    """The decision of section 4 and the conditions on the shock, as in the report; empty if it does not apply."""
    paper, parts = outcome.section4, ""
    for name in ("decision", "conditions") if paper is not None else ():
        values = {"p": paper, "conditions": paper.conditions, "areas": paper.areas}
        template = Path(report.__file__).with_name(f"{name}.html.jinja")
        parts += html_of(template, _FILTERS, applied_momentum=outcome.applied_momentum, **values)
    return Markup(parts)


# ---------------------------------------------------------------- pictures


def draw_figures(scenario: sw.Scenario, outcome: sw.Outcome) -> Iterator[Figure]:
    """The animation of the beads and the charts of a scene."""
    result = outcome.simulated
    recording: Any = None if result is None else result.recording
    if recording is not None:
        yield _draw_animation(scenario, recording)
    if scenario.scene.shock is not None:
        yield _draw_shock(scenario.scene.shock)
    if recording is not None:
        contacts, forces = recording.contacts, recording.forces
        if recording.wall_force is not None:
            contacts, forces = (*contacts, contacts[-1] + 1), np.column_stack((forces, recording.wall_force))
        yield Figure("Space-time diagram", draw_map(recording.times, contacts, forces, _CONTACT[0]))
        if recording.wall_force is not None:
            yield _draw_wall(scenario, recording)
    if waves := _waves_of(outcome):
        yield _draw_train(waves, outcome.section4, scenario.shock.peak_force)
    elif result is not None:
        peaks, wall = {peak.contact: peak.peak_force for peak in result.contacts}, result.transmitted
        if wall is not None:
            peaks[wall.contact] = wall.peak_force
        series = [Series(list(peaks), list(peaks.values()), colour=METHODS["simulation"])]
        if wall is not None:
            series.append(Series([wall.contact], [wall.peak_force], "wall", "squares", METHODS["simulation"]))
        picture = draw_chart(series, _CONTACT, ("greatest force", "N"), max(peaks) + 0.5, -0.5)
        yield Figure("Greatest forces", picture)
    if recording is not None:
        yield _draw_histories(recording, scenario.simulate.contacts)
        yield from _draw_sensors(result)


def _draw_sensors(result: Any) -> Iterator[Figure]:
    """Histories of the sensors, one chart per unit, with the figures of their first pulses below."""
    recording, pulses = result.recording, {pulse.sensor: pulse for pulse in result.sensors}
    for unit, title in _SENSORS.items():
        drawn = [history for history in recording.sensors if history.unit == unit]
        lines = [
            Series(recording.times, history.values, history.name.replace("_", " "), colour=colour)
            for history, colour in zip(drawn, cycle(_COLOURS), strict=False)
        ]
        texts = [_state_pulse(pulses[history.name]) for history in drawn if history.name in pulses]
        if lines:
            picture = draw_chart(lines, _TIME, (title.lower(), unit), float(recording.times[-1]))
            yield Figure(f"{title} at sensors", picture, f"First pulses: {'; '.join(texts)}." if texts else "")


def _state_pulse(pulse: Any) -> str:
    """Peak, width and speed of a first pulse."""
    figures = ("peak", ""), ("width", "width "), ("speed", "speed ")
    known = ", ".join(
        label + si_label(value, pulse.units[name], pulse.digits_of(name, 3))
        for name, label in figures
        if (value := getattr(pulse, name))
    )
    return f"{pulse.sensor.replace('_', ' ')}: {known or 'no pulse'}"


def _draw_animation(scenario: sw.Scenario, recording: Any) -> Figure:
    chain = scenario.chain
    radii = np.full(recording.displacements.shape[1], chain.radius)
    if chain.count is not None and not chain.is_uniform:
        radii = Layout.of(chain, scenario.excitation).radii
    wall = recording.wall_force is not None
    picture, caption = draw_beads(radii, recording.times, recording.displacements, recording.velocities, wall)
    return Figure("Granules", picture, caption, moves=True)


def _draw_shock(shock: sw.Shock) -> Figure:
    times = np.linspace(0, shock.duration, 600)
    times = np.union1d(times, shock.rise_time * np.asarray(shock.profile.breakpoints, dtype=float))
    pulse = Series(times, shock.peak_force * shock.profile.force(times / shock.rise_time), "", "area", METHODS["shock"])
    return Figure("The shock", draw_chart([pulse], _TIME, ("force", "N"), shock.duration))


def _draw_wall(scenario: sw.Scenario, recording: Any) -> Figure:
    end = float(recording.times[-1])
    lines = [Series(recording.times, recording.wall_force, colour=METHODS["simulation"])]
    if (limit := scenario.limit) is not None and limit.at != "spring":
        lines.append(Series((0.0, end), (limit.force, limit.force), "limit", "dashed", BLACK))
    return Figure("Force on the wall", draw_chart(lines, _TIME, ("force on the wall", "N"), end))


def _waves_of(outcome: sw.Outcome) -> tuple[Any, ...]:
    """All waves that the simulation measures, or the leading one if the others cannot be measured."""
    try:
        return tuple(outcome.waves if outcome.simulated is None else outcome.simulated.waves)
    except sw.NumericalError:
        return outcome.waves


def _draw_train(simulated: tuple[Any, ...], paper: Any, shock: float) -> Figure:
    """Peak forces of the waves, simulated and by section 4."""
    trains: dict[str, tuple[Any, ...]] = {"simulated": (simulated, "squares", METHODS["simulation"])}
    if paper is not None:
        trains["section 4"] = (paper.waves, "dots", METHODS["section 4"])
    ends = 0.5, max(len(waves) for waves, *_ in trains.values()) + 0.5
    series = [Series(ends, (shock, shock), "shock", "dashed", METHODS["shock"])]
    for name, (waves, *look) in trains.items():
        at = np.arange(1, len(waves) + 1) + (_ASIDE if name == "simulated" else -_ASIDE)
        series.append(Series(at, [wave.peak_force for wave in waves], name, *look))
    return Figure("Waves", draw_chart(series, ("wave", ""), ("peak force", "N"), ends[1], ends[0]))


def _draw_histories(recording: Any, contacts: tuple[int, ...]) -> Figure:
    """Forces at the contacts of the scenario, or at some from end to end."""
    columns = [recording.contacts.index(contact) for contact in contacts] or range(len(recording.contacts))
    chosen = np.unique(np.linspace(0, len(columns) - 1, len(_COLOURS)).astype(int))
    lines = [
        Series(
            recording.times, recording.forces[:, columns[k]], f"contact {recording.contacts[columns[k]]}", colour=colour
        )
        for k, colour in zip(chosen, _COLOURS, strict=False)
    ]
    return Figure("Contact forces", draw_chart(lines, _TIME, ("contact force", "N"), float(recording.times[-1])))
