"""Pictures of a page: those that apply to a scene, and the functions that draw them."""

from __future__ import annotations

import itertools
import json
import os
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from shockwave import pictures
from shockwave.chain.chain import Scales
from shockwave.errors import ShockwaveError
from shockwave.page.results import Findings
from shockwave.prediction.section4_outcome import EjectionOutcome
from shockwave.progress import counted, progress_shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from shockwave.profiles.shock import Shock

# A function that draws a picture.
_Draw = Callable[["Axes"], object]

# Width and height [in]: a column in print, legible on a phone.
_SIZE = (3.4, 2.7)
# Fraction of the pictures that this process draws if a second process helps: the last pictures take longer.
_OWN_SHARE = 0.6
# Name of a picture, and its SVG element or the reason why it could not be drawn.
_Drawn = tuple[str, str, str]


def drawn(found: Findings, aside: bool = False) -> Iterator[_Drawn]:
    """Draw the pictures of a scene.

    Parameters
    ----------
    found : Findings
        The results.
    aside : bool
        Fork this process, where that is safe: its child starts to draw the last pictures immediately.

    Returns
    -------
    iterator of (str, str, str)
        Name and SVG element of each picture, and the reason why it could not be drawn; one of the two is empty.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    chosen = list(drawings(found).items())
    # after a fork, locks that other threads hold are never released
    alone = sys.platform != "linux" or threading.active_count() > 1 or len(os.sched_getaffinity(0)) == 1
    if alone or not aside or len(chosen) < 2:
        return _drawn(counted("pictures", chosen))
    own = round(_OWN_SHARE * len(chosen))
    later = _drawn_aside(chosen[own:])
    return itertools.chain(_drawn(counted("pictures", chosen[:own])), later)


def _drawn(chosen: Iterable[tuple[str, _Draw]]) -> Iterator[_Drawn]:
    for name, draw in chosen:
        figure, (ax,) = pictures.figure(size=_SIZE)
        try:
            draw(ax)
        except ShockwaveError as error:
            yield name, "", str(error)
        else:
            yield name, pictures.svg(figure, name), ""


def _drawn_aside(chosen: list[tuple[str, _Draw]]) -> Iterator[_Drawn]:
    """Draw in a forked process, from now on; if that fails, draw here when the pictures are needed."""
    output, given = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(output)  # a reader of its own would let it wait for ever if the parent ends
            with progress_shown(None), open(given, "w", encoding="ascii") as file:
                file.write(json.dumps(list(_drawn(chosen))))
        finally:
            os._exit(0)
    os.close(given)

    def of_child() -> Iterator[_Drawn]:
        with open(output, encoding="ascii") as file:
            text = file.read()
        with suppress(ChildProcessError):  # the system has removed it if SIGCHLD is ignored
            os.waitpid(child, 0)
        try:
            received = json.loads(text)
        except ValueError:
            received = _drawn(chosen)
        yield from received

    return of_child()


def drawings(found: Findings) -> dict[str, _Draw]:
    """Return the functions that draw the pictures of a scene, in their order; their titles are in the template."""
    shock, predicted, result, compared = (
        found.scenario.shock,
        found.predicted and found.predicted.section4,
        found.simulated,
        found.comparison,
    )
    if found.is_beyond:
        return _of_chain(shock, result)
    chosen: dict[str, _Draw] = {
        "pulse": lambda ax: pictures.pulse(ax, shock),
        "conditions": lambda ax: pictures.conditions(ax, shock),
    }
    if isinstance(predicted, EjectionOutcome):
        chosen["correction"] = lambda ax: pictures.correction_area(ax, shock, predicted)
    if compared is not None:
        chosen["train"] = lambda ax: pictures.train(ax, compared)
    if result is not None:
        chosen["approach"] = lambda ax: pictures.approach(ax, result)
        if result.options.record:
            chosen["forces"] = lambda ax: pictures.contact_forces(ax, result)
            chosen["map"] = lambda ax: pictures.space_time(ax, result)
            chosen["energy"] = lambda ax: pictures.balance(ax, result)
            chosen["momentum"] = lambda ax: pictures.balance(ax, result, of="momentum")
    if predicted is not None:
        chain = found.scenario.chain
        own = Scales.of(chain, shock.peak_force).rise_time(shock.rise_time)
        predictor = found.scenario.predictor
        chosen["amplification"] = lambda ax: pictures.amplification(ax, shock.profile, predictor, chain, mark=own)
    return chosen


def _of_chain(shock: Shock | None, result: Any) -> dict[str, _Draw]:
    """Functions that draw the pictures of a chain beyond equal spheres."""
    chosen: dict[str, _Draw] = {}
    if shock is not None:
        chosen["pulse"] = lambda ax: pictures.pulse(ax, shock)
    if result is None:
        return chosen
    chosen["peaks"] = lambda ax: pictures.peak_forces(ax, result)
    chosen["chain-map"] = lambda ax: pictures.chain_map(ax, result)
    if result.transmitted is not None:
        chosen["wall"] = lambda ax: pictures.wall_force(ax, result)
    return chosen
