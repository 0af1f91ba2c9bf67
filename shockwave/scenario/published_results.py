"""Results that a source prints for the scene of a scenario."""

from __future__ import annotations

from typing import Literal

from attrs import frozen

from shockwave.base.quantity_fields import plain_text, quantity


@frozen(kw_only=True)
class Published:
    """Results printed in a source for the same scene, for comparison.

    Parameters
    ----------
    source : str
        Source in which they are printed.
    relation : "less", "equal" or "greater", optional
        Peak force of the leading wave relative to that of the shock.
    virtual_rise_time : float, optional
        Virtual rise time [s].
    error : float, optional
        Relative error of the predicted peak force.
    """

    source: str = plain_text()
    relation: Literal["less", "equal", "greater"] | None = None
    virtual_rise_time: float | None = quantity("s", "virtual rise time", above=0, optional=True, default=None)
    error: float | None = quantity("", "relative error of the peak force", optional=True, default=None)
