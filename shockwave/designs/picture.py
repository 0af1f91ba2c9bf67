"""A design as a picture."""

from __future__ import annotations

import os
import pathlib

from shockwave.designs.design import Design
from shockwave.errors import InvalidValueError, UsageError

__all__ = ["write"]


def write(found: Design, file: str | os.PathLike[str]) -> None:
    """Draw ``found`` into ``file``, whose ending tells the format: svg, png or pdf.

    Raises
    ------
    UsageError
        When matplotlib is not installed, or materials were compared: they lie on no line.
    InvalidValueError, FileAccessError
        When the ending is another, or the file cannot be written.
    """
    path = pathlib.Path(file)
    if path.suffix.lower() not in (".svg", ".png", ".pdf"):
        raise InvalidValueError.of("file", f"must end in .svg, .png or .pdf (got {path.name!r})")
    if found.between is None:
        raise UsageError(f"{path}: {found.vary} has no picture, as materials lie on no line (leave -o out)")
    from shockwave.pictures.canvas import figure, save
    from shockwave.pictures.design import design as drawn

    sheet, (ax,) = figure()
    labels = tuple(name.replace("_", " ") for name in (found.vary.rpartition(".")[2], found.target.name))
    solutions = [float(option.value) for option in found.solutions]
    units = found.unit, found.target.unit
    drawn(ax, *found.line, found.target.value, solutions, labels=(labels[0], labels[1]), units=units)
    save(sheet, path)
