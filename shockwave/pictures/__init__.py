"""Pictures of shocks, predictions, simulations and sweeps.

Each function takes an ``Axes`` of matplotlib and data, draws, and returns the ``Axes``. `figure` makes figures; `svg`
and `save` write them. matplotlib is the extra ``plot``; it is imported when a figure is made, not with this package.
"""

from shockwave.pictures.accuracy import approach, balance, work_precision
from shockwave.pictures.amplification_curves import amplification, design, universal_curves
from shockwave.pictures.figures import figure, save, svg
from shockwave.pictures.maps import trust_map
from shockwave.pictures.shock import conditions, correction_area, pulse
from shockwave.pictures.waves import contact_forces, space_time, train

__all__ = [
    "amplification",
    "approach",
    "balance",
    "conditions",
    "contact_forces",
    "correction_area",
    "design",
    "figure",
    "pulse",
    "save",
    "space_time",
    "svg",
    "train",
    "trust_map",
    "universal_curves",
    "work_precision",
]
