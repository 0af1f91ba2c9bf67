"""The scenario: one shock on one chain, and what is asked about it."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from attrs import field, frozen

from shockwave.chain.chain import Chain
from shockwave.fields import quantity
from shockwave.options import SimulateOptions
from shockwave.prediction.predictor import Predictor
from shockwave.profiles.shock import Shock
from shockwave.scenario.block_keys import RECORD
from shockwave.scenario.sweep_block import Sweep
from shockwave.scenario.uncertainty import Spread
from shockwave.scenario.yaml_document import Document


@frozen(kw_only=True)
class Published:
    """Figures printed in a source for the same scene, to be shown beside ours.

    Parameters
    ----------
    source : str
        Where they are printed.
    relation : "less", "equal" or "greater", optional
        Primary's peak force against the shock's.
    virtual_rise_time : float, optional
        [s].
    error : float, optional
        Relative error of the peak force.
    """

    source: str
    relation: Literal["less", "equal", "greater"] | None = None
    virtual_rise_time: float | None = quantity("s", "virtual rise time", above=0, optional=True, default=None)
    error: float | None = quantity("", "relative error of the peak force", optional=True, default=None)


@frozen(kw_only=True)
class Scenario:
    """One scene, and what is asked about it.

    Attributes
    ----------
    name : str
        Its name: the file's name without its suffix, unless it says otherwise.
    path : pathlib.Path or None
        The file.
    shock : Shock
        Profile, peak force, rise time.
    chain : Chain
        Material, radius, number of granules.
    predictor : Predictor
        As the block ``predict`` wants it.
    simulate : SimulateOptions
        As the block ``simulate`` wants it.
    published : Published or None
        Figures of a source for the same scene.
    sweep : Sweep or None
        The scenes that it stands for; shock, chain and settings are then those of the first that can be.
    uncertainty : tuple of Spread
        How well values are known; none where nothing is said of it.
    document : Document or None
        The document that it was read from, without the blocks ``sweep`` and ``uncertainty``.
    """

    name: str
    path: Path | None
    shock: Shock
    chain: Chain
    predictor: Predictor
    simulate: SimulateOptions
    published: Published | None = None
    sweep: Sweep | None = None
    uncertainty: tuple[Spread, ...] = ()
    document: Document | None = field(default=None, eq=False, repr=False)

    @property
    def files(self) -> tuple[Path, ...]:
        """Files that the scenario was read from: its own and that of its record."""
        if self.path is None or self.document is None:
            return ()
        shock = self.document.data["shock"]
        record = (shock.get("parameters") or {}).get("file") if shock["profile"] == RECORD else None
        return (self.path, self.path.parent / record) if record else (self.path,)
