"""Base of the results for one scene: name, parts of the scene, and the verdict on its limit."""

from __future__ import annotations

from typing import Any

from shockwave.base.result import Result
from shockwave.scene.chain import Chain
from shockwave.scene.force_limit import LeavingForce, Limit, Verdict, verdict
from shockwave.scene.scene import Excitation, Scene
from shockwave.scene.shock import Shock
from shockwave.scene.yielding import law_notes


class SceneResult(Result):
    """Base of predictions and simulations of a scene.

    Attributes
    ----------
    scene : Scene
        Shock or impact, and chain.
    leaving : LeavingForce
        The transmitted force, on the wall, at the last contact, or of the leading wave in an endless chain.
    """

    __slots__ = ()
    scene: Scene

    _picture = "shockwave.pictures.histories:draw_scene"

    @property
    def leaving(self) -> LeavingForce:
        """The transmitted force, on the wall, at the last contact, or of the leading wave in an endless chain."""
        raise NotImplementedError

    @property
    def scenario(self) -> str | None:
        """Name of the scenario, if there is one."""
        return self.scene.name

    @property
    def excitation(self) -> Excitation:
        """The shock, the striker or the prescribed motion."""
        return self.scene.excitation

    @property
    def shock(self) -> Shock | Any:
        """The shock; None under an impact."""
        return self.scene.shock

    @property
    def chain(self) -> Chain:
        """The chain; equal granules are given by their number."""
        return self.scene.line

    @property
    def notes(self) -> tuple[str, ...]:
        """Changes that were made to a record, and the error of the law of elastic-plastic contacts."""
        return (*self.scene.notes, *law_notes(self.chain))

    @property
    def limit(self) -> Limit | None:
        """Limit on the transmitted force."""
        return self.scene.limit

    @property
    def verdict(self) -> Verdict | None:
        """Verdict on the limit; None without a limit."""
        return None if self.limit is None else verdict(self.limit, self.leaving)
