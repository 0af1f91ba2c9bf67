"""How a simulation is asked for: one declaration for the call, the scenario and the command line."""

from __future__ import annotations

from attrs import field, frozen

from shockwave.fields import quantity
from shockwave.registry import find

__all__ = ["SimulateOptions"]


def _known_integrator(_: object, attribute: object, name: str) -> None:
    find("integrators", name)


@frozen(kw_only=True)
class SimulateOptions:
    """How a scene is to be simulated.

    Parameters
    ----------
    integrator : str
        Name of a registered integrator.
    rtol : float
        Relative error asked of the primary's peak force, 1e-9 to 1e-2.
    wave_threshold : float
        Weakest wave that counts, over the primary, from 1e-3 to below 1.

    Raises
    ------
    InvalidValueError, UnknownNameError
        When a value is out of range or the name unknown.
    """

    integrator: str = field(default="dop853", validator=_known_integrator)
    rtol: float = quantity(
        "", "relative error asked of the primary's peak force", at_least=1e-9, at_most=1e-2, default=1e-6
    )
    # Below a thousandth, peaks drown in what a chain at rest stirs by itself.
    wave_threshold: float = quantity(
        "", "weakest wave that counts, over the primary", at_least=1e-3, below=1, default=5e-3
    )
