"""Charts of the explorer as SVG, each drawn in about a millisecond, so that they follow a slider."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Iterable, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from attrs import frozen
from markupsafe import Markup, escape

from shockwave.pictures.drawing import BLACK, BLUE, FIELD, GREY, MINUS, SKY, VERMILION, si_label
from shockwave.quadrature import FloatArray

# Size of a chart and the margins around its axes [px of the drawing].
_WIDTH, _HEIGHT = 420, 270
_LEFT, _RIGHT, _TOP, _BOTTOM = 54, 12, 26, 42
# Additional margin for a colour bar.
_BAR = 56
# Most ticks of an axis, and its limit above the greatest value.
_MOST_TICKS = 6
_ROOM = 1.08
# Sections of a line, as many as a screen resolves.
_SECTIONS = 300
# Most cells of a map along the time.
_MOST_CELLS = 240
# Marks on the colour bar, relative to the greatest value.
_SHARES = (0.0, 0.1, 0.3, 0.6, 1.0)
# Animation: its length [s], frames, most beads, size [px], greatest displacement relative to the greatest diameter.
_SECONDS = 8
_FRAMES = 80
_MOST_BEADS = 40
_ROW, _ROW_HEIGHT = 860, 74
_SWING = 0.6


@frozen
class Series:
    """Points of a chart: a line, an area under a line, markers, or a band between the limits ``y``, over ``x``."""

    x: Any
    y: Any
    label: str = ""
    kind: Literal["line", "dashed", "area", "dots", "squares", "band"] = "line"
    colour: str = BLUE


def chart(
    series: Iterable[Series], x: tuple[str, str], y: tuple[str, str], right: float, whole: bool = False
) -> Markup:
    """Chart with axes from 0.

    Parameters
    ----------
    series : iterable of Series
        The data, in SI units.
    x, y : (str, str)
        Name and SI unit of each axis.
    right : float
        End of the abscissa.
    whole : bool
        Whether the abscissa counts something.
    """
    drawn = list(series)
    top = _ROOM * max((float(np.max(one.y)) for one in drawn), default=0.0) or 1.0
    area = _Area(0.5 if whole else 0.0, right, top)
    parts = [area.axes(x, y)]
    parts += [_PAINTERS[one.kind](area, one) for one in drawn]
    return area.whole(parts, drawn)


def field_map(times: FloatArray, contacts: Sequence[int], forces: FloatArray, label: str) -> Markup:
    """Map of the contact force over time and contacts, with a colour bar; colours scale as the square root.

    A line that moves over it marks the time of the animation.

    Parameters
    ----------
    times : array, shape (k,)
        Times [s].
    contacts : sequence of int
        Contacts, ascending.
    forces : array, shape (k, contacts)
        Contact forces [N].
    label : str
        Name of the ordinate.
    """
    begins = np.arange(0, len(times), math.ceil(len(times) / _MOST_CELLS))
    greatest = float(forces.max()) or 1.0
    levels = np.sqrt(np.maximum.reduceat(forces, begins, axis=0).T / greatest)
    area = _Area(0.0, float(times[-1]), contacts[-1] + 1.0, _BAR)
    place = f'x="{area.left}" y="{_TOP}" width="{area.width}" height="{area.height}"'
    bar = area.left + area.width + 8
    parts = [
        f'<image {place} preserveAspectRatio="none" href="{_image(levels)}"/>',
        area.axes(("time", "s"), (label, "")),
        f'<image x="{bar}" y="{_TOP}" width="10" height="{area.height}" preserveAspectRatio="none"'
        f' href="{_image(np.linspace(0, 1, 64)[:, None])}"/>',
    ]
    factor, unit = _scale(greatest, "N")
    for share in _SHARES:
        height = _TOP + area.height * (1 - math.sqrt(share))
        parts.append(_text(bar + 14, height + 4, f"{share * greatest / factor:.3g}"))
    parts.append(_text(bar + 10, _TOP - 10, f"force ({unit})", "middle"))
    parts.append(
        f'<line y1="{_TOP}" y2="{_TOP + area.height}" class="now"><animate attributeName="x1" {_timing()}'
        f' values="{area.left};{area.left + area.width}"/><animate attributeName="x2" {_timing()}'
        f' values="{area.left};{area.left + area.width}"/></line>'
    )
    return area.whole(parts, ())


def beads(
    radii: FloatArray, times: FloatArray, moved: FloatArray, speeds: FloatArray, wall: bool
) -> tuple[Markup, str]:
    """Animation of the first granules, and a caption.

    Parameters
    ----------
    radii : array, shape (n,)
        Radii [m].
    times : array, shape (k,)
        Times [s].
    moved, speeds : array, shape (k, n)
        Displacements [m] and velocities [m/s].
    wall : bool
        Whether a wall follows the last granule.
    """
    shown = min(len(radii), moved.shape[1], _MOST_BEADS)
    frames = np.round(np.linspace(0, len(times) - 1, min(_FRAMES, len(times)))).astype(int)
    radii, moved, speeds = radii[:shown], moved[frames, :shown], speeds[frames, :shown]
    centres = 2 * np.cumsum(radii) - radii
    factor = _SWING * 2 * float(radii.max()) / (float(np.abs(moved).max()) or 1.0)
    factor = float(f"{factor:.1g}")
    # room for the swing on both sides
    swing = factor * np.array([max(-moved.min(), 0.0), max(moved.max(), 0.0)])
    scale = min((_ROW - 8) / (centres[-1] + radii[-1] + swing.sum()), (_ROW_HEIGHT - 8) / 2 / float(radii.max()))
    places = scale * (swing[0] + centres + factor * moved) + 4
    share = speeds / (float(np.abs(speeds).max()) or 1.0)
    shades = np.round(_SHADES * (1 + np.sign(share) * np.sqrt(np.abs(share)))).astype(int).tolist()
    parts = []
    for index in range(shown):
        path = ";".join(f"{place:.1f}" for place in places[:, index])
        fills = ";".join(_FILLS[row[index]] for row in shades)
        parts.append(
            f'<circle cx="{places[0, index]:.1f}" cy="{_ROW_HEIGHT / 2}" r="{scale * radii[index]:.2f}"'
            f' fill="#FFFFFF" stroke="{GREY}"><animate attributeName="cx" {_timing()} values="{path}"/>'
            f'<animate attributeName="fill" {_timing()} values="{fills}"/></circle>'
        )
    if wall and shown == len(radii) == moved.shape[1]:
        edge = scale * (swing[0] + centres[-1] + radii[-1]) + 4
        parts.append(f'<rect x="{edge:.1f}" y="2" width="6" height="{_ROW_HEIGHT - 4}" fill="{GREY}"/>')
    caption = (
        f"The first {shown} granules during {si_label(times[-1], 's')}, displacements enlarged {factor:g} times; "
        f"orange moves forward and blue backward, at up to {si_label(float(np.abs(speeds).max()), 'm/s')}."
    )
    return Markup(f'<svg viewBox="0 0 {_ROW} {_ROW_HEIGHT}" role="img">{"".join(parts)}</svg>'), caption


def _timing() -> str:
    return f'dur="{_SECONDS}s" repeatCount="indefinite"'


def _mixed(colour: str, share: float) -> str:
    """White with a share of ``colour``."""
    parts = (255 + (int(colour[at : at + 2], 16) - 255) * share for at in (1, 3, 5))
    return "#" + "".join(f"{round(part):02X}" for part in parts)


_SHADES = 20
#: Colours from the fastest backward motion over white, at rest, to the fastest forward motion.
_FILLS = [_mixed(VERMILION if step > 0 else BLUE, abs(step) / _SHADES) for step in range(-_SHADES, _SHADES + 1)]


def _image(levels: FloatArray) -> str:
    """Levels from 0 to 1 as the address of an image; the first row is at the bottom."""
    from matplotlib.image import imsave

    written = io.BytesIO()
    imsave(written, levels, vmin=0.0, vmax=1.0, cmap=FIELD, origin="lower", format="png")
    return "data:image/png;base64," + base64.b64encode(written.getvalue()).decode()


# ---------------------------------------------------------------- axes


@frozen
class _Area:
    """Axes from ``begin`` to ``end`` and from 0 to ``top``, with a further margin at the right."""

    begin: float
    end: float
    top: float
    margin: float = 0.0
    left: float = _LEFT
    height: float = _HEIGHT - _TOP - _BOTTOM

    @property
    def width(self) -> float:
        return _WIDTH - _LEFT - _RIGHT - self.margin

    def x(self, values: Any) -> FloatArray:
        return np.asarray(self.left + self.width * (np.asarray(values) - self.begin) / (self.end - self.begin))

    def y(self, values: Any) -> FloatArray:
        return np.asarray(_TOP + self.height * (1 - np.clip(np.asarray(values) / self.top, 0.0, 1.0)))

    def path(self, x: Any, y: Any) -> str:
        return " ".join(f"{left:.1f},{down:.1f}" for left, down in zip(self.x(x), self.y(y), strict=True))

    def axes(self, x: tuple[str, str], y: tuple[str, str]) -> str:
        """Ticks, grid and labels."""
        bottom, right = _TOP + self.height, self.left + self.width
        factor, unit = _scale(self.end, x[1])
        parts = []
        for tick in _ticks(self.begin, self.end, factor, 0.0 if x[1] else 1.0):
            at = float(self.x(tick))
            parts.append(f'<line x1="{at:.1f}" x2="{at:.1f}" y1="{_TOP}" y2="{bottom}" class="grid"/>')
            parts.append(_text(at, bottom + 15, _label(tick / factor), "middle"))
        parts.append(_text(self.left + self.width / 2, _HEIGHT - 8, _titled(x[0], unit), "middle"))
        factor, unit = _scale(self.top, y[1])
        for tick in _ticks(0.0, self.top, factor):
            at = float(self.y(tick))
            parts.append(f'<line x1="{self.left}" x2="{right}" y1="{at:.1f}" y2="{at:.1f}" class="grid"/>')
            parts.append(_text(self.left - 6, at + 4, _label(tick / factor), "end"))
        middle = _TOP + self.height / 2
        turned = f'transform="rotate(-90 14 {middle})"'
        parts.append(_text(14, middle, _titled(y[0], unit), "middle", turned))
        parts.append(f'<path d="M{self.left} {_TOP}V{bottom}H{right}" class="axis"/>')
        return "".join(parts)

    def whole(self, parts: Iterable[str], drawn: Iterable[Series]) -> Markup:
        """The picture with a legend above the axes."""
        legend, at = [], float(self.left)
        for one in drawn:
            if one.label:
                legend.append(f'<g transform="translate({at:.0f} 12)">{_KEYS[one.kind].format(one.colour)}</g>')
                legend.append(_text(at + 18, 16, one.label))
                at += 30 + 6.1 * len(one.label)
        return Markup(f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img">{"".join([*parts, *legend])}</svg>')


def _scale(largest: float, unit: str) -> tuple[float, str]:
    """Value in SI units of the prefixed unit for an axis up to ``largest``, and that unit."""
    if not unit:
        return 1.0, ""
    number, _, prefixed = si_label(largest, unit, 9).partition(" ")
    return 10.0 ** round(math.log10(largest / float(number))), prefixed


def _ticks(low: float, high: float, factor: float, finest: float = 0.0) -> FloatArray:
    """Round values between the ends of an axis, at distances of ``finest`` or more."""
    least = max((high - low) / factor / _MOST_TICKS, finest)
    power = 10.0 ** math.floor(math.log10(least))
    step = next(part * power for part in (1.0, 2.0, 5.0, 10.0) if part * power >= least * (1 - 1e-9)) * factor
    return np.asarray(step * np.arange(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1), dtype=float)


def _label(value: float) -> str:
    return f"{value:.6g}".replace("-", MINUS)


def _titled(name: str, unit: str) -> str:
    return f"{name} ({unit})" if unit else name


def _text(x: float, y: float, text: str, anchor: str = "start", more: str = "") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {more}>{escape(text)}</text>'


# ---------------------------------------------------------------- kinds of series


def _thinned(y: FloatArray) -> npt.NDArray[np.intp]:
    """Indices at which a line is drawn: both ends, and the least and the greatest value of each section."""
    width = -(-len(y) // _SECTIONS)
    sections = np.pad(y, (0, -len(y) % width), mode="edge").reshape(-1, width)
    extremes = [pick(sections, axis=1) + width * np.arange(len(sections)) for pick in (np.argmin, np.argmax)]
    return np.unique(np.concatenate(([0], *extremes, [len(y) - 1])).clip(0, len(y) - 1))


def _line(area: _Area, one: Series) -> str:
    kept = _thinned(np.asarray(one.y))
    dashes = ' stroke-dasharray="5 4"' if one.kind == "dashed" else ""
    points = area.path(np.asarray(one.x)[kept], np.asarray(one.y)[kept])
    return f'<polyline points="{points}" fill="none" stroke="{one.colour}" stroke-width="1.6"{dashes}/>'


def _filled(area: _Area, one: Series) -> str:
    kept = _thinned(np.asarray(one.y))
    x, y = np.asarray(one.x)[kept], np.asarray(one.y)[kept]
    points = area.path(np.concatenate((x[:1], x, x[-1:])), np.concatenate(([0.0], y, [0.0])))
    return f'<polygon points="{points}" fill="{SKY}" fill-opacity="0.35" stroke="{one.colour}" stroke-width="1.6"/>'


def _dots(area: _Area, one: Series) -> str:
    places = zip(area.x(one.x), area.y(one.y), strict=True)
    return "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.6" fill="{one.colour}"/>' for x, y in places)


def _squares(area: _Area, one: Series) -> str:
    places = zip(area.x(one.x), area.y(one.y), strict=True)
    look = f'width="7" height="7" fill="{one.colour}"'
    return "".join(f'<rect x="{x - 3.5:.1f}" y="{y - 3.5:.1f}" {look}/>' for x, y in places)


def _band(area: _Area, one: Series) -> str:
    (left, right), (low, high) = area.x(one.x), area.y(one.y)
    place = f'x="{left:.1f}" y="{high:.1f}" width="{right - left:.1f}" height="{max(low - high, 1):.1f}"'
    return f'<rect {place} fill="{one.colour}" fill-opacity="0.25"/>'


_PAINTERS = {"line": _line, "dashed": _line, "area": _filled, "dots": _dots, "squares": _squares, "band": _band}
_STROKE = '<line x2="14" stroke="{0}" stroke-width="1.6"/>'
#: Keys of a legend.
_KEYS = {
    "line": _STROKE,
    "dashed": '<line x2="14" stroke="{0}" stroke-width="1.6" stroke-dasharray="5 4"/>',
    "area": _STROKE,
    "dots": '<circle cx="8" r="3.6" fill="{0}"/>',
    "squares": '<rect x="4" y="-3.5" width="7" height="7" fill="{0}"/>',
    "band": '<rect y="-5" width="14" height="10" fill="{0}" fill-opacity="0.25"/>',
}
#: Colour of a limit or of an applied force.
APPLIED = GREY
PREDICTED, SIMULATED, LIMIT = BLUE, VERMILION, BLACK
