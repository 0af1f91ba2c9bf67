"""Files of universal curves and designs: pictures, and JSON of curves."""

from __future__ import annotations

import os
import pathlib

from shockwave.errors import InvalidValueError
from shockwave.pictures import design as draw_design
from shockwave.pictures import figure, save, universal_curves
from shockwave.studies.design_result import Design
from shockwave.studies.universal_curve import UniversalCurve

PICTURES = (".svg", ".png", ".pdf")
CURVE_FILES = (".json", *PICTURES)


def check_output(output: str, endings: tuple[str, ...]) -> None:
    """Check the ending of the name of an output file, before anything is computed.

    Raises
    ------
    InvalidValueError
        If it has none of these endings.
    """
    if pathlib.Path(output).suffix.lower() not in endings:
        rule = f"must end in {', '.join(endings[:-1])} or {endings[-1]}"
        raise InvalidValueError.of("output", f"{rule} (got {output})")


def write_curve(curve: UniversalCurve, output: str | os.PathLike[str], mark: float | None = None) -> None:
    """Write ``curve`` as JSON or as a picture, by the ending of ``output``; a picture marks the t0/T0 ``mark``."""
    path = pathlib.Path(output)
    if path.suffix.lower() == ".json":
        curve.save(path)
        return
    sheet, (ax,) = figure()
    universal_curves(ax, {"universal curve": curve}, mark)
    save(sheet, path)


def write_design(found: Design, output: str) -> None:
    """Draw the target property at the rows of the table and at the solutions of ``found``."""
    sheet, (ax,) = figure()
    labels = found.varied, found.target.label
    options = sorted((*found.table, *found.solutions), key=lambda option: float(option.value))
    values = [float(option.value) for option in options]
    solutions = [float(option.value) for option in found.solutions]
    units = found.unit, found.target.unit
    reached = [option.reached for option in options]
    draw_design(ax, values, reached, found.target.value, solutions, labels=labels, units=units)
    save(sheet, output)
