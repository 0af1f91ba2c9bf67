"""A small picture of any table: its first quantity along its rows."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

from shockwave.pictures.figures import DRAWING, figure, svg
from shockwave.tables import Table, evenly

# Width and height [in].
_SIZE = (3.4, 2.0)
# Lines of a quantity with a second axis, evenly chosen.
_MOST_LINES = 6
# Points up to which each is marked.
_MARKED = 60


def table_picture(table: Table) -> str:
    """Draw the first quantity of a table as an SVG element; empty if there are no numbers.

    Raises
    ------
    UsageError
        If matplotlib is not installed.
    """
    (row, along), *rest = table.items()
    floats = [(name, one) for name, one in rest if one.axes[0] == row and one.values.dtype.kind == "f"]
    found = [(name, one) for name, one in floats if np.isfinite(one.values).any()]
    if not found or along.values.dtype.kind not in "if":
        return ""
    with DRAWING:
        name, quantity = found[0]
        sheet, (ax,) = figure(size=_SIZE)
        lines = quantity.values.reshape(len(along.values), -1)
        shown = evenly(lines.shape[1], _MOST_LINES)
        labels = table[quantity.axes[1]].values[shown] if lines.shape[1] > 1 else [None]
        style: dict[str, Any] = {"marker": "o", "markersize": 3} if len(lines) <= _MARKED else {}
        if along.values.dtype.kind == "i":  # there is nothing between two waves or contacts
            style |= {"linestyle": "none", "marker": "o", "markersize": 3}
            ax.locator_params(axis="x", integer=True)
            ax.set_ylim(min(0.0, 1.1 * float(np.nanmin(lines))), 1.1 * float(np.nanmax(lines)) or 1.0)
        for index, label in zip(shown, labels, strict=True):
            ax.plot(along.values, lines[:, index], linewidth=0.8, label=None if label is None else str(label), **style)
        if lines.shape[1] > 1:
            ax.legend(title=quantity.axes[1], fontsize=6, title_fontsize=6, frameon=False)
        for set_label, text, unit in ((ax.set_xlabel, row, along.unit), (ax.set_ylabel, name, quantity.unit)):
            set_label(text.replace("_", " ") + (f" [{unit}]" if unit else ""))
        # names in the picture must differ from those of other pictures on the page
        digest = hashlib.sha256(np.ascontiguousarray(lines).tobytes()).hexdigest()[:12]
        return svg(sheet, f"shockwave-{digest}", f"{name} by {row}")
