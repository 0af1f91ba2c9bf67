"""Pictures of a page: those that apply to a scene, and the functions that draw them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from shockwave import pictures
from shockwave.base.errors import ShockwaveError
from shockwave.base.progress import track
from shockwave.prediction.section4_outcome import EjectionOutcome
from shockwave.report.page_results import PageResults
from shockwave.scene.chain import HERTZ, Chain, Scales
from shockwave.scene.shock import Shock
from shockwave.studies.amplification_curve import UniversalCurve

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# A function that draws a picture.
_Draw = Callable[["Axes"], object]

# Longest shocks of the curve of amplifications, as a rule and at most [T0].
_LONGEST = 50.0
_LONGEST_OF_ALL = 1000.0
# Pictures that answer the question of the page, the first that applies beside its first lines.
_ANSWERS = ("wall", "peaks", "forces", "train", "pulse")
# Width and height [in]: a column in print, legible on a phone.
_SIZE = (3.4, 2.7)


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
        if result.structure is not None:
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
