"""A curve as a file: a picture, or JSON."""

from __future__ import annotations

import os
import pathlib

from shockwave.errors import InvalidValueError
from shockwave.studies.curve.universal import UniversalCurve

__all__ = ["checked", "write"]


def checked(file: str | os.PathLike[str]) -> pathlib.Path:
    """``file``, whose ending tells what it is to be.

    Raises
    ------
    InvalidValueError
        When that is another than those known.
    """
    path = pathlib.Path(file)
    if path.suffix.lower() not in (".json", ".svg", ".png", ".pdf"):
        raise InvalidValueError.of("file", f"must end in .json, .svg, .png or .pdf (got {path.name!r})")
    return path


def write(curve: UniversalCurve, file: str | os.PathLike[str], mark: float | None = None) -> None:
    """Write ``curve`` to ``file``: as JSON if its name ends so, else drawn, as SVG, PNG or PDF.

    Parameters
    ----------
    curve : UniversalCurve
        The curve.
    file : path-like
        Its ending tells what it is to be.
    mark : float, optional
        A t0/T0 that the picture is to mark.

    Raises
    ------
    InvalidValueError
        When the ending is another.
    FileAccessError
        When the file cannot be written.
    """
    path = checked(file)
    if path.suffix.lower() == ".json":
        curve.save(path)
        return
    # A file of numbers needs no pictures.
    from shockwave.pictures.canvas import figure, save
    from shockwave.pictures.curve import curve as drawn

    sheet, (ax,) = figure()
    drawn(ax, curve, mark=mark)
    save(sheet, path)
