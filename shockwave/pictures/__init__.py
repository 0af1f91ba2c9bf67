"""Pictures of shocks, predictions and simulations.

A picture takes data and an ``Axes`` of matplotlib, draws on it, and returns it; `figure` makes Axes, `svg` and `save`
write them. matplotlib is the extra ``plot``: it is loaded when a figure is made, not by this package.
"""

from shockwave.pictures.accuracy import approach, balance, trust_map, work_precision
from shockwave.pictures.canvas import figure, save, svg
from shockwave.pictures.curve import amplification
from shockwave.pictures.pulse import conditions, correction_area, pulse
from shockwave.pictures.waves import contact_forces, space_time, train

#: The former name of `balance`.
books = balance

__all__ = [
    "amplification",
    "approach",
    "balance",
    "books",
    "conditions",
    "contact_forces",
    "correction_area",
    "figure",
    "pulse",
    "save",
    "space_time",
    "svg",
    "train",
    "trust_map",
    "work_precision",
]
