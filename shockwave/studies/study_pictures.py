"""Universal curves and designs as files: pictures, and JSON of curves."""

from __future__ import annotations

import os
import pathlib

from shockwave.errors import FileAccessError, InvalidValueError, UsageError
from shockwave.pictures.canvas import figure, save
from shockwave.pictures.curve import curve as draw_curve
from shockwave.pictures.design import design as draw_design
from shockwave.studies.design import Design
from shockwave.studies.universal_curve import UniversalCurve

__all__ = ["check_curve_file", "check_design_file", "write_curve", "write_design"]

_PICTURES = (".svg", ".png", ".pdf")


def check_curve_file(output: str | os.PathLike[str]) -> None:
    """Raise the errors of `write_curve` that can be found without a curve."""
    _check(pathlib.Path(output), ".json", *_PICTURES)


def check_design_file(output: str | os.PathLike[str], vary: str) -> None:
    """Raise the errors of `write_design` that can be found without the design along ``vary``."""
    path = pathlib.Path(output)
    _check(path, *_PICTURES)
    if vary == "chain.material":
        raise UsageError(f"{path}: {vary} has no picture, as materials lie on no line (leave -o out)")
    figure()  # which raises if there is no matplotlib


def _check(path: pathlib.Path, *endings: str) -> None:
    if path.suffix.lower() not in endings:
        rule = f"must end in {', '.join(endings[:-1])} or {endings[-1]}"
        raise InvalidValueError.of("output", f"{rule} (got {path.name!r})")
    if not path.parent.is_dir():
        raise FileAccessError(f"{path}: cannot be written (there is no folder {path.parent})")


def write_curve(curve: UniversalCurve, output: str | os.PathLike[str], mark: float | None = None) -> None:
    """Write ``curve`` to a file: as JSON if its name ends so, else drawn, as SVG, PNG or PDF.

    Parameters
    ----------
    curve : UniversalCurve
        The curve.
    output : path-like
        The file; its ending selects the format.
    mark : float, optional
        A t0/T0 that the picture is to mark.

    Raises
    ------
    InvalidValueError
        When the ending is another.
    FileAccessError
        When the file cannot be written.
    UsageError
        When matplotlib is not installed.
    """
    check_curve_file(output)
    path = pathlib.Path(output)
    if path.suffix.lower() == ".json":
        curve.save(path)
        return
    sheet, (ax,) = figure()
    draw_curve(ax, curve, mark=mark)
    save(sheet, path)


def write_design(found: Design, output: str | os.PathLike[str]) -> None:
    """Draw ``found`` into a file, whose ending selects the format: svg, png or pdf.

    Raises
    ------
    InvalidValueError, FileAccessError
        When the ending is another, or the file cannot be written.
    UsageError
        When matplotlib is not installed, or materials were compared: they lie on no line.
    """
    check_design_file(output, found.vary)
    sheet, (ax,) = figure()
    value, target = (name.replace("_", " ") for name in (found.vary.rpartition(".")[2], found.target.name))
    solutions = [float(option.value) for option in found.solutions]
    units = found.unit, found.target.unit
    draw_design(ax, *found.line, found.target.value, solutions, labels=(value, target), units=units)
    save(sheet, pathlib.Path(output))
