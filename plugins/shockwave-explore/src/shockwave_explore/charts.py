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
from shockwave.hooks import FloatArray
from shockwave.pictures.picture_elements import BLUE, FIELD, GREY, VERMILION, si_label

# Size of a chart and the margins around its axes [px of the drawing].
_WIDTH, _HEIGHT = 420, 270
_LEFT, _RIGHT, _TOP, _BOTTOM = 54, 12, 26, 42
# Additional margin for a colour bar.
_BAR = 56
# Width of a key of a legend and of a letter.
_KEY, _LETTER = 30, 6
# Most ticks of an axis, and its limit above the greatest value.
_MOST_TICKS = 6
_ROOM = 1.08
# Sections of a line, as many as a screen resolves.
_SECTIONS = 300
# Most cells of a map along the time.
_MOST_CELLS = 240
_PIXELS = 'preserveAspectRatio="none" image-rendering="pixelated"'
# Least distance of marks on the colour bar, relative to its height.
_APART = 0.12
# Animation: its length [s], frames, most beads, size [px], greatest displacement relative to the greatest diameter.
_SECONDS = 8
_FRAMES = 80
_MOST_BEADS = 40
_ROW, _ROW_HEIGHT = 860, 74
_TIMING = f'dur="{_SECONDS}s" repeatCount="indefinite"'
_SWING = 0.6


# Markers, and looks of lines.
_MARKS = {
    "dots": '<circle cx="{:.1f}" cy="{:.1f}" r="3.6" fill="{}"/>',
    "squares": '<path d="M{:.1f} {:.1f}m-3.5-3.5h7v7h-7z" fill="{}"/>',
}
_LOOKS = {
    "line": 'fill-opacity="0"',
    "dashed": 'fill-opacity="0" stroke-dasharray="5 4"',
    "area": 'fill-opacity="0.25"',
}
# Signs of a legend.
_KEYS = {"line": "\N{EM DASH}", "dashed": "\N{EN DASH} \N{EN DASH}", "dots": "\u25cf", "squares": "\u25a0"}
# Grid and axes.
_GRID = 'stroke="#dedede" stroke-width="0.7"'
_AXIS = 'fill="none" stroke="#555"'
_FONT = 'font-family="system-ui, \'Segoe UI\', \'DejaVu Sans\', sans-serif" font-size="12.5" fill="#1a1a1a"'


@frozen
class Series:
    """Points of a chart: a line, an area under a line, or markers."""

    x: Any
    y: Any
    label: str = ""
    kind: Literal["line", "dashed", "area", "dots", "squares"] = "line"
    colour: str = BLUE


def draw_chart(
    series: Iterable[Series], x: tuple[str, str], y: tuple[str, str], right: float, left: float = 0.0
) -> Markup:
    """Chart with an ordinate from 0, or from the least value if that is negative.

    Parameters
    ----------
    series : iterable of Series
        The data, in SI units.
    x, y : (str, str)
        Name and SI unit of each axis.
    right, left : float
        Ends of the abscissa.
    """
    drawn = list(series)
    greatest = max((float(np.max(line.y)) for line in drawn), default=0.0)
    least = min((float(np.min(line.y)) for line in drawn), default=0.0)
    bottom, top = _ROOM * min(least, 0.0), _ROOM * max(greatest, 0.0)
    area = _Area(left, right, top if top > bottom else 1.0, bottom)
    legend, at = "", 0
    for line in drawn:
        if line.label:
            key = Markup('<tspan fill="{}">{}</tspan> {}').format(line.colour, _KEYS[line.kind], line.label)
            legend += _text(area.left + at, 16, key)
            at += _KEY + _LETTER * len(line.label)
    return _write_picture(
        [area.axes(x, y), *map(area.draw, drawn), legend], f"{y[0]} against {x[0]}, {_state_most(greatest, y[1])}"
    )


def draw_map(times: FloatArray, contacts: Sequence[int], forces: FloatArray, label: str) -> Markup:
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
    area = _Area(0.0, float(times[-1]), contacts[-1] + 0.5, -0.5, margin=_BAR)
    place = f'x="{area.left}" y="{_TOP}" width="{area.width}" height="{area.height}"'
    bar = area.left + area.width + 8
    parts = [
        area.axes(("time", "s"), (label, "")),  # its grid lies behind the map
        f'<image {place} {_PIXELS} href="{_encode(levels)}"/>',
        f'<image x="{bar}" y="{_TOP}" width="10" height="{area.height}" {_PIXELS}'
        f' href="{_encode(np.linspace(0, 1, 64)[:, None])}"/>',
        f'<rect x="{bar}" y="{_TOP}" width="10" height="{area.height}" {_AXIS}/>',
    ]
    factor, unit = _scale(greatest, "N")
    marked = -_APART
    for tick in _place_ticks(0.0, greatest, factor):
        level = math.sqrt(tick / greatest)
        if level - marked >= _APART:
            marked = level
            parts.append(_text(bar + 14, _TOP + area.height * (1 - level) + 4, f"{tick / factor:.6g}"))
    parts.append(_text(bar + 10, _TOP - 10, f"force ({unit})", "middle"))
    parts.append(
        f'<path d="M{area.left} {_TOP}v{area.height}" stroke="{BLUE}">'
        f'<animateTransform attributeName="transform" type="translate" {_TIMING} values="0;{area.width}"/></path>'
    )
    return _write_picture(parts, f"force against time and {label}, {_state_most(greatest, 'N')}")


def draw_beads(
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
    fastest = float(np.abs(speeds).max()) or 1.0
    shades = np.sqrt(np.abs(speeds) / fastest)
    parts = []
    for index in range(shown):
        path = ";".join(f"{place:.1f}" for place in places[:, index])
        fills = ";".join(f"{shade:.2f}" for shade in shades[:, index])
        parts.append(
            f'<circle cx="{places[0, index]:.1f}" cy="{_ROW_HEIGHT / 2}" r="{scale * radii[index]:.2f}"'
            f' fill="{VERMILION}" stroke="{GREY}"><animate attributeName="cx" {_TIMING} values="{path}"/>'
            f'<animate attributeName="fill-opacity" {_TIMING} values="{fills}"/></circle>'
        )
    if wall and shown == len(radii) == moved.shape[1]:
        edge = scale * (swing[0] + centres[-1] + radii[-1]) + 4
        parts.append(f'<rect x="{edge:.1f}" y="2" width="6" height="{_ROW_HEIGHT - 4}" fill="{GREY}"/>')
    first = "" if shown == len(radii) else "first "
    caption = (
        f"The {first}{shown} granules during {si_label(times[-1], 's')}, displacements enlarged {factor:g} times; "
        f"colours deepen up to a speed of {si_label(fastest, 'm/s')}."
    )
    return _write_picture(parts, caption, _ROW, _ROW_HEIGHT), caption


def _encode(levels: FloatArray) -> str:
    """Levels from 0 to 1 as the address of an image; the first row is at the bottom."""
    from matplotlib.image import imsave

    written = io.BytesIO()
    imsave(written, levels, vmin=0.0, vmax=1.0, cmap=FIELD, origin="lower", format="png")
    return "data:image/png;base64," + base64.b64encode(written.getvalue()).decode()


# ---------------------------------------------------------------- axes


@frozen
class _Area:
    """Axes from ``begin`` to ``end`` and from ``bottom`` to ``top``, with a further margin at the right."""

    begin: float
    end: float
    top: float
    bottom: float = 0.0
    margin: float = 0.0
    left: float = _LEFT
    height: float = _HEIGHT - _TOP - _BOTTOM

    @property
    def width(self) -> float:
        return _WIDTH - _LEFT - _RIGHT - self.margin

    def x(self, values: Any) -> FloatArray:
        return np.asarray(self.left + self.width * (np.asarray(values) - self.begin) / (self.end - self.begin))

    def y(self, values: Any) -> FloatArray:
        parts = (np.asarray(values) - self.bottom) / (self.top - self.bottom)
        return np.asarray(_TOP + self.height * (1 - np.clip(parts, 0.0, 1.0)))

    def axes(self, x: tuple[str, str], y: tuple[str, str]) -> str:
        """Ticks, grid and labels."""
        bottom, right, middle = _TOP + self.height, self.left + self.width, _TOP + self.height / 2
        factor, unit = _scale(self.end, x[1])
        parts = [_text(self.left + self.width / 2, _HEIGHT - 8, f"{x[0]} ({unit})" if unit else x[0], "middle")]
        for tick in _place_ticks(self.begin, self.end, factor, 0.0 if unit else 1.0):
            at = float(self.x(tick))
            parts.append(f'<path d="M{at:.1f} {_TOP}V{bottom}" {_GRID}/>')
            parts.append(_text(at, bottom + 15, f"{tick / factor:.6g}", "middle"))
        factor, unit = _scale(max(self.top, -self.bottom), y[1])
        turned = f'transform="rotate(-90 14 {middle})"'
        parts.append(_text(14, middle, f"{y[0]} ({unit})" if unit else y[0], "middle", turned))
        for tick in _place_ticks(self.bottom, self.top, factor):
            at = float(self.y(tick))
            parts.append(f'<path d="M{self.left} {at:.1f}H{right}" {_GRID}/>')
            parts.append(_text(self.left - 6, at + 4, f"{tick / factor:.6g}", "end"))
        return "".join([*parts, f'<path d="M{self.left} {_TOP}V{bottom}H{right}" {_AXIS}/>'])

    def draw(self, series: Series) -> str:
        """The points of a series."""
        if series.kind in _MARKS:
            places = zip(self.x(series.x), self.y(series.y), strict=True)
            return "".join(_MARKS[series.kind].format(x, y, series.colour) for x, y in places)
        kept = _thin(np.asarray(series.y))
        x, y = self.x(np.asarray(series.x)[kept]), self.y(np.asarray(series.y)[kept])
        path = "L".join(f"{right:.1f} {down:.1f}" for right, down in zip(x, y, strict=True))
        if series.kind == "area":
            path += f"V{self.y(0.0):.1f}H{x[0]:.1f}Z"
        paint = f'fill="{series.colour}" stroke="{series.colour}" stroke-width="2"'
        return f'<path d="M{path}" {paint} {_LOOKS[series.kind]}/>'


def _write_picture(parts: Iterable[str], label: str, width: float = _WIDTH, height: float = _HEIGHT) -> Markup:
    """A picture with a ``label`` for readers that do not see it."""
    size = f'viewBox="0 0 {width} {height}"'
    head = f'xmlns="http://www.w3.org/2000/svg" {size} role="img" aria-label="{escape(label)}" {_FONT}'
    return Markup(f"<svg {head}>{''.join(parts)}</svg>")


def _state_most(value: float, unit: str) -> str:
    return f"at most {si_label(value, unit)}"


def _scale(largest: float, unit: str) -> tuple[float, str]:
    """Value in SI units of the prefixed unit for an axis up to ``largest``, and that unit."""
    if not unit:
        return 1.0, ""
    number, _, prefixed = si_label(largest, unit, 9).partition(" ")
    return 10.0 ** round(math.log10(largest / float(number))), prefixed


def _place_ticks(low: float, high: float, factor: float, finest: float = 0.0) -> FloatArray:
    """Round values between the ends of an axis, at distances of ``finest`` or more."""
    least = max((high - low) / factor / _MOST_TICKS, finest)
    power = 10.0 ** math.floor(math.log10(least))
    step = next(part * power for part in (1.0, 2.0, 5.0, 10.0) if part * power >= least * (1 - 1e-9)) * factor
    return np.asarray(step * np.arange(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1), dtype=float)


def _text(x: float, y: float, text: str, anchor: str = "start", more: str = "") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {more}>{escape(text)}</text>'


def _thin(y: FloatArray) -> npt.NDArray[np.intp]:
    """Indices at which a line is drawn: both ends, and the least and the greatest value of each section."""
    width = -(-len(y) // _SECTIONS)
    sections = np.pad(y, (0, -len(y) % width), mode="edge").reshape(-1, width)
    extremes = [pick(sections, axis=1) + width * np.arange(len(sections)) for pick in (np.argmin, np.argmax)]
    return np.unique(np.concatenate(([0], *extremes, [len(y) - 1])).clip(0, len(y) - 1))
