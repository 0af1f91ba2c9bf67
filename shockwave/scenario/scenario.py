"""The scenario: one shock on one chain, with the settings of prediction and simulation; as an argument of functions."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from attrs import evolve, field, frozen

from shockwave.base.errors import Fault, InvalidValueError, text_of
from shockwave.base.result import cached_property
from shockwave.prediction.predictor import Predictor
from shockwave.scenario.block_keys import RECORD
from shockwave.scenario.loader import parts_of
from shockwave.scenario.published_results import Published
from shockwave.scenario.sweep_block import Sweep
from shockwave.scenario.uncertainty_block import Spread
from shockwave.scenario.yaml_document import Document, make_document, parse_document, read_document
from shockwave.scene.chain import Chain
from shockwave.scene.force_limit import Limit
from shockwave.scene.scene import Excitation, Scene
from shockwave.scene.shock import Shock
from shockwave.scene.simulate_options import SimulateOptions

if TYPE_CHECKING:  # a scenario with a shock does not need it
    from shockwave.scene.impact import Impact
    from shockwave.scene.motion import Motion


@frozen(kw_only=True, slots=False)
class Scenario:
    """One scene, with the settings of prediction and simulation.

    Attributes
    ----------
    name : str
        Name; by default the name of the file without its suffix.
    path : pathlib.Path or None
        File from which it was read.
    shock : Shock
        Profile, peak force, rise time; None if there is an impact.
    chain : Chain
        Material, radius, granules and further features.
    impact : Impact or None
        A striker in place of a shock.
    motion : Motion or None
        A prescribed motion of the first granule in place of a shock.
    predictor : Predictor
        Predictor with the settings of the ``predict`` block.
    simulate : SimulateOptions
        Options of the ``simulate`` block.
    limit : Limit or None
        Limit on the transmitted force.
    published : Published or None
        Results for the same scene printed in a source.
    sweep : Sweep or None
        The scenes of a sweep; shock, chain and settings are then those of its first valid scene.
    uncertainty : tuple of Spread
        Probability distributions of values; empty without an ``uncertainty`` block.
    document : Document or None
        Document from which it was read, without the blocks ``sweep`` and ``uncertainty``.

    Examples
    --------
    >>> import shockwave as sw
    >>> blocks = {
    ...     "chain": {"material": "delrin", "diameter": "9.5 mm"},
    ...     "shock": {"profile": "half-sine", "peak_force": "5 N", "duration": "200 us"},
    ... }
    >>> scenario = sw.Scenario.from_dict(blocks)
    >>> f"{sw.predict(scenario).peak_force:.3f} N"
    '7.961 N'
    """

    name: str
    path: Path | None
    shock: Shock = field(default=None)
    chain: Chain
    impact: Impact | None = None
    motion: Motion | None = None
    predictor: Predictor
    simulate: SimulateOptions
    limit: Limit | None = None
    published: Published | None = None
    sweep: Sweep | None = None
    uncertainty: tuple[Spread, ...] = ()
    document: Document | None = field(default=None, eq=False, repr=False)

    @classmethod
    def from_yaml(cls, text: str, folder: str | os.PathLike[str] = "") -> Scenario:
        """Load a scenario from text in YAML.

        Parameters
        ----------
        text : str
            The text that a file would have.
        folder : path-like, optional
            Folder of the files that it names; by default the current one.

        Raises
        ------
        ShockwaveError
            As `load_scenario`, with places in the text, or if ``text`` is not text.
        """
        if not isinstance(text, str):
            raise InvalidValueError.of("text", f"must be text in YAML (got {text_of(text)})")
        return parse_scenario(parse_document(text, "text", folder=folder), None)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], folder: str | os.PathLike[str] = "") -> Scenario:
        """Load a scenario from a mapping of its blocks, as YAML would give; see `from_yaml`.

        Errors state the path of the value, such as ``chain.material.density``.
        """
        return parse_scenario(make_document(data, folder), None)

    @property
    def excitation(self) -> Excitation:
        """The shock, or the impact or the motion in its place."""
        return self.impact or self.motion or self.shock

    @cached_property
    def scene(self) -> Scene:
        """The shock or the impact on the chain, with name and limit."""
        # a method of this object would be a reference to itself
        place = None if self.document is None else partial(_place, self.document)
        return Scene(excitation=self.excitation, chain=self.chain, name=self.name, limit=self.limit, place=place)

    @property
    def folder(self) -> Path:
        """Folder of the files that it names."""
        if self.path is not None:
            return self.path.parent
        return Path() if self.document is None else self.document.folder

    @property
    def files(self) -> tuple[Path, ...]:
        """Files from which the scenario was read, its own and that of its record."""
        if self.document is None:
            return ()
        shock = self.document.data.get("shock") or {}
        record = (shock.get("parameters") or {}).get("file") if str(shock.get("profile")).lower() == RECORD else None
        record = record or (self.document.data.get("motion") or {}).get("file")
        return tuple(file for file in (self.path, record and self.folder / record) if file)


def _place(document: Document, fault: Fault) -> Fault:
    """``fault`` with its place in the document, if its path, alone or below ``shock``, begins with a key there."""
    for each in (fault, fault.below("shock")):
        if each.steps[:2] in document.keys:
            return document.place(evolve(each, at_key=True))
    return fault


def load_scenario(path: str | os.PathLike[str]) -> Scenario:
    """Load the scenario in a file.

    Parameters
    ----------
    path : path-like
        A YAML file; messages use this name. Files that it names are relative to its folder.

    Raises
    ------
    FileAccessError
        When the file, or the record that it names, cannot be read.
    ScenarioError
        When it is not valid; all errors are listed, in the order of the file.
    PluginError
        When a plugin that it uses is faulty.

    Examples
    --------
    >>> import shockwave as sw
    >>> scenario = sw.load_scenario("profiles/paper/table2-row1.yaml")
    >>> scenario.name
    'table 2 row 1'
    """
    return parse_scenario(read_document(path), Path(path))


def parse_scenario(document: Document, path: Path | None) -> Scenario:
    """Scenario that ``document`` describes; see `load_scenario`."""
    return Scenario(**parts_of(document, path))


# ---------------------------------------------------------------- scenarios as arguments

#: A scenario, its file, or an excitation whose chain is given beside it.
SceneArgument: TypeAlias = "Scenario | str | os.PathLike[str] | Excitation"


def scenario_alone(scene: object, chain: object) -> Scenario:
    """The scenario of a single case, loaded if ``scene`` is a path.

    Raises
    ------
    InvalidValueError
        If it comes with a chain, is something else, or stands for a sweep.
    ShockwaveError
        As `load_scenario`.
    """
    named = isinstance(scene, str | os.PathLike)
    scenario = load_scenario(scene) if chain is None and named else scene  # type: ignore[arg-type]
    if chain is not None or not isinstance(scenario, Scenario):
        rule = "must be a scenario or its file alone, or a shock or an impact together with a chain"
        raise InvalidValueError.of("scene", f"{rule} (got {text_of(scene)} {'and' if chain else 'without'} a chain)")
    if scenario.sweep is not None:
        got = f"got a sweep of {len(scenario.sweep)}; shockwave.run_sweep runs it"
        raise InvalidValueError.of("scene", f"must describe a single case ({got})")
    return scenario
