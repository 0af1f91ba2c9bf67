"""The pictures of a page: which of them apply to a scene, and their SVG."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np
from attrs import frozen

from shockwave import pictures
from shockwave.chain.chain import Scales
from shockwave.errors import ShockwaveError
from shockwave.page.results import Findings
from shockwave.prediction.outcome import EjectionOutcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.measurement.result import SimulationResult

__all__ = ["Drawing", "drawings", "drawn"]

# Contacts whose forces are drawn, where they were recorded.
_LINES = (0, 5, 10, 20, 30, 45)
# Width and height [in]: a column in print, which a phone shows in its own size.
_SIZE = (3.4, 2.7)
# A record of more samples is predicted and simulated at few rise times only, as each takes long.
_LONG_RECORD = 20_000
_FEW = 7
# Those are up to so many times shorter and longer than its own.
_ABOUT = 8.0


@frozen
class Drawing:
    """A picture that applies: its name, title, caption, and the function that draws it."""

    name: str
    title: str
    caption: str
    draw: Callable[[Axes], object]


def drawn(found: Findings) -> tuple[list[tuple[Drawing, str]], list[str]]:
    """The pictures with their SVG elements, and the reasons why others could not be drawn.

    Raises
    ------
    UsageError
        When matplotlib is missing.
    """
    figures, not_drawn = [], []
    result = found.simulated
    if result is not None and not result.options.record:
        not_drawn.append("Contact forces, their map and the balances: the shock is too long for its histories")
    for drawing in drawings(found):
        figure, (ax,) = pictures.figure(size=_SIZE)
        try:
            drawing.draw(ax)
        except ShockwaveError as error:
            not_drawn.append(f"{drawing.title}: {error}")
        else:
            figures.append((drawing, pictures.svg(figure, drawing.name, f"{drawing.title}. {drawing.caption}")))
    return figures, not_drawn


def drawings(found: Findings) -> list[Drawing]:
    """The pictures that apply to a scene, in their order."""
    return [*_of_shock(found), *_of_waves(found), *_of_simulation(found), *_of_rise_time(found)]


def _of_shock(found: Findings) -> Iterator[Drawing]:
    shock, predicted = found.scenario.shock, found.predicted
    yield Drawing(
        "pulse",
        "The shock",
        "Force against time, with the areas under rise and decay.",
        lambda ax: pictures.pulse(ax, shock),
    )
    yield Drawing(
        "conditions",
        "Conditions (3)",
        "By how much each holds or fails, as a share of both its sides.",
        lambda ax: pictures.conditions(ax, shock),
    )
    if isinstance(predicted, EjectionOutcome):
        yield Drawing(
            "correction",
            "Correction area",
            "The shock, the virtual shock of (5g), and the area that (5h) adds twice.",
            lambda ax: pictures.correction_area(ax, shock, predicted),
        )


def _of_waves(found: Findings) -> Iterator[Drawing]:
    compared, result = found.comparison, found.simulated
    if compared is not None:
        bar = "" if compared.predicted.expected_error is None else "; the bar is where the first is expected"
        caption = f"Peak forces, predicted beside simulated, strongest first{bar}."
        yield Drawing("train", "Waves", caption, lambda ax: pictures.train(ax, compared))
    if result is not None and result.options.record:
        lines = _LINES if set(_LINES) <= set(result.options.contacts) else None
        yield Drawing(
            "forces",
            "Contact forces",
            "Force against time at some contacts, counted from 0 at the loaded end.",
            lambda ax: pictures.contact_forces(ax, result, lines),
        )
        yield Drawing(
            "map",
            "Along the chain",
            "Contact force over contacts and time; dashed lines are the fronts of the waves as they end up.",
            lambda ax: pictures.space_time(ax, result),
        )


def _of_simulation(found: Findings) -> Iterator[Drawing]:
    result = found.simulated
    if result is None:
        return
    yield Drawing(
        "approach",
        "Approach to the limit",
        "How far the peak force of the primary is from its limit, contact by contact.",
        lambda ax: pictures.approach(ax, result, _contacts_passed(result)),
    )
    if result.options.record:
        yield Drawing(
            "energy",
            "Energy balance",
            "Energy of the granules and of their contacts, and the work of the shock.",
            lambda ax: pictures.balance(ax, result),
        )
        yield Drawing(
            "momentum",
            "Momentum balance",
            "Momentum of granules that move forward and backward, and the impulse of the shock.",
            lambda ax: pictures.balance(ax, result, of="momentum"),
        )


def _of_rise_time(found: Findings) -> Iterator[Drawing]:
    scenario, shock = found.scenario, found.scenario.shock

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

    if found.predicted is not None:
        caption = "Primary over shock for other rise times; a band shows where it is expected."
        yield Drawing("amplification", "Other rise times", caption, draw)


def _contacts_passed(result: SimulationResult) -> range | None:
    """The contacts at which the primary is examined; None for the choice of the picture itself."""
    if not result.was_measured:
        return None
    # without the search for the primary each of them costs as much as the simulation
    passed = result.primary.contact + 1
    return range(0, passed, -(-passed // _FEW))


def _rise_times(found: Findings) -> list[float] | None:
    """Rise times to simulate, over the characteristic time; None for the choice of the picture itself."""
    shock = found.scenario.shock
    if len(shock.profile.breakpoints) <= _LONG_RECORD:
        return None
    own = Scales.of(found.scenario.chain, shock.peak_force).rise_time(shock.rise_time)
    chosen: list[float] = np.geomspace(own / _ABOUT, own * _ABOUT, _FEW).tolist()
    return chosen
