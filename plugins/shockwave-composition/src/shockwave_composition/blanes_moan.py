"""Splitting methods of Blanes & Moan for x'' = a(t, x), from Table 3 of their paper.

They need fewer stages for their order than general splitting methods, because the kinetic energy is quadratic
in the velocities, so that many commutators in the error vanish. The time advances with the drifts, so a force
that depends on time does not reduce the order.

References
----------
Blanes, S. & Moan, P. C. (2002). Practical symplectic partitioned Runge-Kutta and Runge-Kutta-Nystroem
methods. Journal of Computational and Applied Mathematics 142, 313-330.
"""

from __future__ import annotations

from typing import ClassVar

from attrs import define

from shockwave_composition.splitting import Shares, Splitting

__all__ = ["BlanesMoan4", "BlanesMoan6", "BlanesMoan6Long"]


@define
class BlanesMoan4(Splitting):
    """SRKN_6^b, order 4: six evaluations per step."""

    name: ClassVar[str] = "blanes-moan-4"
    order: ClassVar[int] = 4
    shares: ClassVar[Shares] = Shares.mirrored(
        stages=6,
        kicks="0.0829844064174052 0.396309801498368 -0.0390563049223486",
        drifts="0.245298957184271 0.604872665711080",
    )


@define
class BlanesMoan6(Splitting):
    """SRKN_11^b, order 6: eleven evaluations per step."""

    name: ClassVar[str] = "blanes-moan-6"
    order: ClassVar[int] = 6
    shares: ClassVar[Shares] = Shares.mirrored(
        stages=11,
        kicks=(
            "0.0414649985182624 0.198128671918067 -0.0400061921041533 0.0752539843015807 -0.0115113874206879"
        ),
        drifts=(
            "0.123229775946271 0.290553797799558 -0.127049212625417 -0.246331761062075 0.357208872795928"
        ),
    )


@define
class BlanesMoan6Long(Splitting):
    """SRKN_14^a, order 6: fourteen evaluations per step, and one for the acceleration at its end.

    A step begins and ends with a drift.
    """

    name: ClassVar[str] = "blanes-moan-6-long"
    order: ClassVar[int] = 6
    shares: ClassVar[Shares] = Shares.mirrored(
        stages=14,
        drift_first=True,
        drifts=(
            "0.0378593198406116 0.102635633102435 -0.0258678882665587 0.314241403071447 "
            "-0.130144459517415 0.106417700369543 -0.00879424312851058"
        ),
        kicks=(
            "0.09171915262446165 0.183983170005006 -0.05653436583288827 0.004914688774712854 "
            "0.143761127168358 0.328567693746804"
        ),
    )
