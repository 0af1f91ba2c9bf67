"""A design as a picture."""

from __future__ import annotations

import os
import pathlib

from shockwave.errors import FileAccessError, InvalidValueError, UsageError
from shockwave.pictures.canvas import figure, save
from shockwave.studies.designs.design import Design

__all__ = ["checked", "write"]


def checked(output: str | os.PathLike[str], vary: str) -> pathlib.Path:
    """The file, if a design along ``vary`` can be drawn into it; the same errors as of `write`."""
    path = pathlib.Path(output)
    if path.suffix.lower() not in (".svg", ".png", ".pdf"):
        raise InvalidValueError.of("output", f"must end in .svg, .png or .pdf (got {path.name!r})")
    if vary == "chain.material":
        raise UsageError(f"{path}: {vary} has no picture, as materials lie on no line (leave -o out)")
    if not path.parent.is_dir():
        raise FileAccessError(f"{path}: cannot be written (there is no folder {path.parent})")
    figure()  # which tells if there is no matplotlib
    return path


def write(found: Design, output: str | os.PathLike[str]) -> None:
    """Draw ``found`` into the file ``output``, whose ending tells the format: svg, png or pdf.

    Raises
    ------
    UsageError
        When matplotlib is not installed, or materials were compared: they lie on no line.
    InvalidValueError, FileAccessError
        When the ending is another, or the file cannot be written.
    """
    path = checked(output, found.vary)
    from shockwave.pictures.design import design as drawn

    sheet, (ax,) = figure()
    labels = tuple(name.replace("_", " ") for name in (found.vary.rpartition(".")[2], found.target.name))
    solutions = [float(option.value) for option in found.solutions]
    units = found.unit, found.target.unit
    drawn(ax, *found.line, found.target.value, solutions, labels=(labels[0], labels[1]), units=units)
    save(sheet, path)
