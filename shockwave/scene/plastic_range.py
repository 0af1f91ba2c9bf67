"""Range of the law of elastic-plastic contacts."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from shockwave.base.errors import Fault, Steps
from shockwave.base.text import round_digits
from shockwave.scene.chain import Chain
from shockwave.scene.chain_end import Bar
from shockwave.scene.elastic_plastic import RANGE
from shockwave.scene.feature_rules import HERTZ_TEXT
from shockwave.scene.layout import STRIKER, Layout, material_name
from shockwave.scene.material import Material
from shockwave.scene.segments import Cell

# Strength over E*, around that of the finite elements to which the law was fitted, 0.011 to 0.036.
_FITTED = 0.005, 0.04
# Most digits of a ratio that is near an end of a range.
_MOST_DIGITS = 6
# What makes the contact behind a granule elastic.
_ELASTIC = f"a segment of its own with {HERTZ_TEXT}"
# Parts of names of materials that the law does not describe, and what they do.
_OTHERS = {
    "break": ("glass", "silica", "alumina", "zirconia"),
    "creep": ("ptfe", "nylon"),
}


def range_faults(chain: Chain, excitation: object) -> list[Fault]:
    """Errors of contacts outside the range of the law, one for each pair of materials at a place."""
    layout = Layout.of(chain, excitation)
    if layout.plastic is None:
        return []  # the law is that of a last granule at a free end
    faults = []
    for steps, where, ratio, granule, unknown in _contacts(chain, layout):
        if math.isfinite(ratio) and not RANGE[0] <= ratio <= RANGE[1]:
            rule = f"must not be elastic-plastic {where}: the yield strength of the softer body divided by E* is"
            hints = [f"give {granule} {_ELASTIC}"] if granule and ratio > RANGE[1] else []
            hints += [f"state the yield_strength of {' and '.join(unknown)}"] if unknown else []
            got = "; ".join([_digits(ratio, RANGE), *[", or ".join(hints)] * bool(hints)])
            faults.append(Fault(steps, f"{rule} outside {RANGE[0]:g} to {RANGE[1]:g} (got {got})"))
    if isinstance(chain.end, Bar) and layout.plastic.rate_constants[-1] and math.isfinite(layout.plastic.strengths[-1]):
        rule = "must be a wall where the strength of an elastic-plastic contact depends on the rate"
        hint = f"give the last granule {_ELASTIC}, or leave out the rate_constant"
        faults.append(Fault(("chain", "end"), f"{rule} (got a bar; {hint})"))
    return faults


def range_warnings(chain: Chain, excitation: object) -> list[Fault]:
    """Sentences on contacts near the ends of the range, and on materials that do not flow plastically."""
    layout = Layout.of(chain, excitation)
    if layout.plastic is None:
        return []
    faults = []
    for steps, where, ratio, *_ in _contacts(chain, layout):
        if math.isfinite(ratio) and not _FITTED[0] <= ratio <= _FITTED[1]:
            got = f"the yield strength of the softer body divided by E* is {_digits(ratio, _FITTED)}"
            faults.append(Fault(steps, f"is less accurate {where}: {got}, outside {_FITTED[0]:g} to {_FITTED[1]:g}."))
    path = ("chain", "contact") if chain.contact else ("chain", "granules")
    bodies = {body for pair in _plastic_pairs(layout).values() for body in pair}
    for body in sorted((each for each in bodies if isinstance(each, Material)), key=material_name):
        if body.yield_strength is None:
            faults.append(Fault(path, f"treats {material_name(body)} as elastic: its yield strength is not known."))
        for verb, parts in _OTHERS.items():
            if any(part in body.name for part in parts):
                faults.append(Fault(path, f"does not describe {material_name(body)}: such materials {verb}."))
    return faults


def _digits(ratio: float, ends: tuple[float, float]) -> str:
    """A ratio beyond a range, with enough digits to show it."""
    digits = 2
    while digits < _MOST_DIGITS and ends[0] <= float(round_digits(ratio, digits)) <= ends[1]:
        digits += 1
    return round_digits(ratio, digits)


def _plastic_pairs(layout: Layout) -> dict[int, list[Material | str]]:
    """Materials of the two bodies at each elastic-plastic contact, by its number."""
    assert layout.plastic is not None
    bodies = layout.bodies
    return {contact: bodies[contact : contact + 2] for contact in np.flatnonzero(layout.plastic.contacts).tolist()}


def _contacts(chain: Chain, layout: Layout) -> Iterator[tuple[Steps, str, float, str, list[str]]]:
    """Place, description, strength over E*, granule before, and bodies without a strength of elastic-plastic contacts.

    Of contacts between the same materials at a place, only the first is included. The law behind a striker is that of
    the chain, so that the granule before is then an empty text.
    """
    assert layout.plastic is not None
    ratios, seen = layout.plastic.strengths / layout.pairs.moduli, set()
    for contact, pair in _plastic_pairs(layout).items():
        steps = _place(chain, layout.segments[contact])
        if (steps, *pair) in seen:
            continue
        seen.add((steps, *pair))
        unknown = [material_name(body) for body in pair if isinstance(body, Material) and body.yield_strength is None]
        before = "" if layout.segments[contact] == STRIKER else f"granule {contact}"
        yield steps, layout.describe_contact(contact), float(ratios[contact]), before, unknown


def _place(chain: Chain, index: int) -> Steps:
    """Path of the law of the contacts behind the granules of a part of the chain."""
    part = chain.granules[index] if isinstance(chain.granules, tuple) and index != STRIKER else None
    if isinstance(part, Cell):
        return ("chain", "granules", index) if any(segment.contact for segment in part.cell) else ("chain", "contact")
    return ("chain", "contact") if part is None or part.contact is None else ("chain", "granules", index, "contact")
