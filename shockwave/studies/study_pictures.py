"""Universal curves and designs as files: pictures, and JSON of curves."""

from __future__ import annotations

import os
import pathlib

from shockwave.errors import FileAccessError, InvalidValueError, UsageError
from shockwave.pictures import design as draw_design
from shockwave.pictures import figure, save, universal_curves
from shockwave.studies.design import Design
from shockwave.studies.universal_curve import UniversalCurve

PICTURES = (".svg", ".png", ".pdf")
CURVE_FILES = (".json", *PICTURES)


def checked(output: str | os.PathLike[str], endings: tuple[str, ...], vary: str = "") -> pathlib.Path:
    """The file, if it can be written: a picture of a design along ``vary``, or a curve.

    Raises
    ------
    InvalidValueError
        When it has none of these endings.
    FileAccessError
        When there is no such folder.
    UsageError
        When materials were compared, as they lie on no line, or matplotlib is not installed.
    """
    path = pathlib.Path(output)
    if path.suffix.lower() not in endings:
        rule = f"must end in {', '.join(endings[:-1])} or {endings[-1]}"
        raise InvalidValueError.of("output", f"{rule} (got {path.name!r})")
    if vary == "chain.material":
        raise UsageError(f"{path}: {vary} has no picture, as materials lie on no line (leave -o out)")
    if not path.parent.is_dir():
        raise FileAccessError(f"{path}: cannot be written (there is no folder {path.parent})")
    if path.suffix.lower() in PICTURES:
        figure()  # raises if there is no matplotlib
    return path


def write_curve(curve: UniversalCurve, output: str | os.PathLike[str], mark: float | None = None) -> None:
    """Write ``curve`` to a file, whose ending selects JSON or a picture; ``mark`` is a t0/T0 to be marked in that.

    Raises
    ------
    InvalidValueError, FileAccessError, UsageError
        As `checked`, and when the file cannot be written.
    """
    path = checked(output, CURVE_FILES)
    if path.suffix.lower() == ".json":
        curve.save(path)
        return
    sheet, (ax,) = figure()
    universal_curves(ax, {"universal curve": curve}, mark)
    save(sheet, path)


def write_design(found: Design, output: str | os.PathLike[str]) -> None:
    """Draw ``found`` into a file, whose ending selects the format.

    Raises
    ------
    InvalidValueError, FileAccessError, UsageError
        As `checked`, and when the file cannot be written.
    """
    path = checked(output, PICTURES, found.vary)
    sheet, (ax,) = figure()
    value, target = (name.replace("_", " ") for name in (found.vary.rpartition(".")[2], found.target.name))
    solutions = [float(option.value) for option in found.solutions]
    units = found.unit, found.target.unit
    draw_design(ax, *found.line, found.target.value, solutions, labels=(value, target), units=units)
    save(sheet, path)
