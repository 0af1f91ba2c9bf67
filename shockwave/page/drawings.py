"""The pictures of a page: which of them apply to a scene, and what is said of those that do not."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from attrs import frozen

from shockwave import pictures
from shockwave.chain.chain import Scales
from shockwave.errors import ShockwaveError, UsageError
from shockwave.markup import Html, joined, listed, tag
from shockwave.page.findings import Findings
from shockwave.prediction.outcome import EjectionOutcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.measurement.result import SimulationResult

__all__ = ["Drawing", "drawings", "drawn"]

_LINES = (0, 5, 10, 20, 30, 45)
# A column in print [in]: as wide as a phone shows it in its own size.
_SIZE = (3.4, 2.7)
# A record of more samples is predicted and simulated at few rise times only, as each takes its while.
_LONG_RECORD, _FEW = 20_000, 7
# How many times shorter and longer than its own these are.
_ABOUT = 8.0


@frozen
class Drawing:
    """A picture that applies: its name, title, a sentence on it, and what draws it."""

    name: str
    title: str
    caption: str
    draw: Callable[[Axes], object]


def drawings(found: Findings) -> list[Drawing]:
    """The pictures that apply to a scene, in their order."""
    return [*_of_shock(found), *_of_waves(found), *_of_simulation(found), *_of_rise_time(found)]


def drawn(found: Findings) -> Html:
    """All pictures as figures; and which could not be drawn, with the reason.

    Raises
    ------
    UsageError
        When matplotlib is missing.
    """
    figures, missing = [], _missing(found)
    for drawing in drawings(found):
        figure, (ax,) = pictures.figure(size=_SIZE)
        try:
            drawing.draw(ax)
            element = Html(pictures.svg(figure, drawing.name, f"{drawing.title}. {drawing.caption}"))
        except UsageError:
            raise
        except ShockwaveError as error:
            missing.append(f"{drawing.title}: {error}")
            continue
        figures.append(tag("figure", tag("h3", drawing.title), element, tag("figcaption", drawing.caption)))
    told = joined((tag("p", "Not drawn:", kind="note"), listed(missing))) if missing else Html("")
    return joined((tag("div", *figures, kind="pictures"), told))


def _missing(found: Findings) -> list[str]:
    """Pictures that a simulation has, but not this one."""
    result = found.simulated
    if result is None or result.options.record:
        return []
    return ["Contact forces, their map and the books: the shock is too long for its histories to be kept"]


def _of_shock(found: Findings) -> list[Drawing]:
    shock, told = found.scenario.shock, found.predicted
    chosen = [
        Drawing(
            "pulse",
            "The shock",
            "Force against time, with the areas under rise and decay.",
            lambda ax: pictures.pulse(ax, shock),
        ),
        Drawing(
            "conditions",
            "Conditions (3)",
            "By how much each holds or fails, as a share of both its sides.",
            lambda ax: pictures.conditions(ax, shock),
        ),
    ]
    if isinstance(told, EjectionOutcome):
        caption = "The shock, the virtual shock of (5g), and the area that (5h) adds twice."
        chosen.append(
            Drawing("correction", "Correction area", caption, lambda ax: pictures.correction_area(ax, shock, told))
        )
    return chosen


def _of_waves(found: Findings) -> list[Drawing]:
    compared, result = found.comparison, found.simulated
    chosen = []
    if compared is not None:
        bar = "" if compared.predicted.expected_error is None else "; the bar is where the first is expected"
        caption = f"Peak forces, predicted beside simulated, strongest first{bar}."
        chosen.append(Drawing("train", "Waves", caption, lambda ax: pictures.train(ax, compared)))
    if result is None or not result.options.record:
        return chosen
    return [
        *chosen,
        Drawing(
            "forces",
            "Contact forces",
            "Force against time at some contacts, counted from 0 at the loaded end.",
            lambda ax: pictures.contact_forces(ax, result, _shown(result.options.contacts)),
        ),
        Drawing(
            "map",
            "Along the chain",
            "Contact force over contacts and time; dashed lines are the fronts of the waves as they end up.",
            lambda ax: pictures.space_time(ax, result),
        ),
    ]


def _shown(contacts: tuple[int, ...]) -> tuple[int, ...] | None:
    """The contacts whose forces are drawn as lines; None for what the picture itself chooses."""
    return _LINES if set(_LINES) <= set(contacts) else None


def _of_simulation(found: Findings) -> list[Drawing]:
    result = found.simulated
    if result is None:
        return []
    chosen = [
        Drawing(
            "approach",
            "Approach to the limit",
            "How far the peak force of the primary is from its limit, contact by contact.",
            lambda ax: pictures.approach(ax, result, _approached(result)),
        )
    ]
    if result.options.record:
        chosen += [
            Drawing(
                "energy",
                "Book of energy",
                "Energy of the granules and of their contacts, and the work of the shock.",
                lambda ax: pictures.books(ax, result),
            ),
            Drawing(
                "momentum",
                "Book of momentum",
                "Momentum of granules that move forward and backward, and the impulse of the shock.",
                lambda ax: pictures.books(ax, result, of="momentum"),
            ),
        ]
    return chosen


def _of_rise_time(found: Findings) -> list[Drawing]:
    if found.predicted is None:
        return []
    scenario, shock = found.scenario, found.scenario.shock
    caption = "Primary over shock for other rise times; a band shows where it is expected."

    def draw(ax: Axes) -> object:
        return pictures.amplification(
            ax,
            shock.profile,
            scenario.predictor,
            scenario.chain,
            peak_force=shock.peak_force,
            rise_times=_rise_times(found),
            mark=shock.rise_time,
        )

    return [Drawing("amplification", "Other rise times", caption, draw)]


def _approached(result: SimulationResult) -> range | None:
    """The contacts at which the primary is looked at; None for what the picture itself chooses."""
    if not result.was_measured:
        return None
    # without the search for the primary each of them costs as much as the simulation
    passed = result.primary.contact + 1
    return range(0, passed, -(-passed // _FEW))


def _rise_times(found: Findings) -> list[float] | None:
    """Where to simulate, over the natural time; None for what the picture itself chooses."""
    scenario = found.scenario
    if len(scenario.shock.profile.breakpoints) <= _LONG_RECORD:
        return None
    own = Scales.of(scenario.chain, scenario.shock.peak_force).rise_time(scenario.shock.rise_time)
    chosen: list[float] = np.geomspace(own / _ABOUT, own * _ABOUT, _FEW).tolist()
    return chosen
