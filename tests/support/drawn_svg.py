"""Content of an SVG file of matplotlib: data of each axes in units of its frame, apart from fonts and layout."""

import base64
import io
import re
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.image import imread

_SVG = "{http://www.w3.org/2000/svg}"
_LINK = "{http://www.w3.org/1999/xlink}href"
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")
_COLOUR = re.compile("(?:fill|stroke): (#[0-9a-f]{6})")
# Blocks of an image that are compared, along each side.
_BLOCKS = 12


class Shown(NamedTuple):
    """Number of texts, and colours, curves, marks and images of one axes; places in units of its frame."""

    texts: int
    colours: list[str]
    curves: list[np.ndarray]
    marks: list[np.ndarray]
    images: list[np.ndarray]


def shown_in(file: Path) -> list[Shown]:
    """Content of each axes of the picture."""
    root = ET.fromstring(file.read_text(encoding="utf-8"))
    groups = [each for each in root.iter(f"{_SVG}g") if re.search(r"-axes_\d+$", each.get("id", ""))]
    return [_axes(group, root) for group in groups]


def _points(path: ET.Element) -> np.ndarray:
    return np.array(_NUMBER.findall(path.get("d", "")), dtype=float).reshape(-1, 2)


def _places(group: ET.Element) -> np.ndarray:
    uses = [(float(use.get("x", 0)), float(use.get("y", 0))) for use in group.iter(f"{_SVG}use")]
    return np.array(uses).reshape(-1, 2)


def _axes(group: ET.Element, root: ET.Element) -> Shown:
    frame = group.find(f"{_SVG}g/{_SVG}path")
    box = np.array([float(each) for each in str(root.get("viewBox")).split()]).reshape(2, 2)
    if frame is not None and re.search(r"-patch_\d+$", group[0].get("id", "")):
        corners = _points(frame)
        box = np.array([corners.min(axis=0), np.ptp(corners, axis=0)])
    data = [each for each in group if "matplotlib.axis" not in each.get("id", "")]
    parts = [part for each in data for part in each.iter() if each.get("id", "").find("legend") < 0]
    clipped = [part for part in parts if part.get("clip-path")]
    colours = [colour for part in clipped for each in part.iter() for colour in _COLOUR.findall(each.get("style", ""))]
    curves = [_points(part) for part in clipped if part.tag == f"{_SVG}path"]
    marks = [_places(part) for part in clipped if part.tag == f"{_SVG}g"]
    images = [_blocks(part.get(_LINK, "")) for part in parts if part.tag == f"{_SVG}image"]
    curves, marks = ([(places - box[0]) / box[1] for places in kind] for kind in (curves, marks))
    return Shown(sum("-text_" in each.get("id", "") for each in group.iter()), colours, curves, marks, images)


def _blocks(link: str) -> np.ndarray:
    """Mean colours of the blocks of an image."""
    pixels: Any = imread(io.BytesIO(base64.b64decode(link.partition("base64,")[2])))
    rows = [part.mean(axis=0) for part in np.array_split(pixels[..., :3], _BLOCKS)]
    return np.array([[part.mean(axis=0) for part in np.array_split(row, _BLOCKS)] for row in rows])


def distance(one: np.ndarray, other: np.ndarray) -> float:
    """Largest distance of a vertex of ``one`` from the polygon ``other``, whose vertices may be elsewhere on it."""
    if len(other) < 2:
        return float(np.abs(one - other).max(initial=0))
    begins, along = other[:-1], np.diff(other, axis=0)
    lengths = np.maximum((along**2).sum(axis=1), 1e-30)
    share = (((one[:, None] - begins) * along).sum(axis=2) / lengths).clip(0, 1)
    gaps = one[:, None] - begins - share[..., None] * along
    return float(np.sqrt((gaps**2).sum(axis=2)).min(axis=1).max())
