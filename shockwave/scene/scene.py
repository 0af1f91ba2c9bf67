"""The scene: a shock or an impact on a chain, and the kind of answer that it has."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any, TypeAlias

from attrs import field, frozen

from shockwave.base.errors import Fault, InvalidValueError, detach, locate, refuse
from shockwave.base.quantity_fields import text_of
from shockwave.base.result import cached_property
from shockwave.scene.chain import Chain
from shockwave.scene.force_limit import Limit, limit_faults, limit_of
from shockwave.scene.shock import Shock

if TYPE_CHECKING:  # a shock on equal granules does not need them
    from shockwave.scene.impact import Impact
    from shockwave.scene.layout import Layout
    from shockwave.scene.motion import Motion
    from shockwave.scene.scene_summary import SceneSummary

#: What acts on the first granule.
Excitation: TypeAlias = "Shock | Impact | Motion"


@frozen(kw_only=True, slots=False)
class Scene:
    """A shock or an impact on a chain.

    Two scenes are equal if all parts but ``place`` are equal; segments of equal granules equal their number.

    Parameters
    ----------
    excitation : Shock, Impact or Motion
        The shock, the striker, or the motion of the first granule.
    chain : Chain
        The chain.
    name : str, optional
        Name, such as that of the scenario.
    limit : Limit, float or str, optional
        Limit on the transmitted force, or this force [N].
    place : callable, optional
        Function that adds the place in a file to a fault.

    Raises
    ------
    InvalidValueError
        If ``excitation`` is neither a Shock nor an Impact, or ``chain`` not a Chain.
    """

    excitation: Excitation
    chain: Chain = field(eq=lambda chain: uniform_of(chain) or chain)
    name: str | None = None
    limit: Limit | None = field(default=None, converter=limit_of)
    place: Callable[[Fault], Fault] | None = field(default=None, eq=False, repr=False)

    def __attrs_post_init__(self) -> None:
        excitation, chain = self.excitation, self.chain
        mistaken = not isinstance(chain, Chain)
        if not isinstance(excitation, Shock):
            mistaken = mistaken or (self.impact is None and self.motion is None)
        if mistaken:
            got = f"got {type(excitation).__name__} and {type(chain).__name__}"
            if isinstance(excitation, Chain):
                got += "; the chain comes second"
            raise InvalidValueError.of("shock", f"must be a Shock, Impact or Motion, and the chain a Chain ({got})")
        refuse(limit_faults(self.limit, chain.end))

    @property
    def impact(self) -> Impact | None:
        """The striker; None under a shock."""
        if isinstance(self.excitation, Shock):
            return None
        from shockwave.scene.impact import Impact  # a shock does not need it

        return self.excitation if isinstance(self.excitation, Impact) else None

    @property
    def motion(self) -> Motion | None:
        """The prescribed motion; None under a shock or an impact."""
        if isinstance(self.excitation, Shock):
            return None
        from shockwave.scene.motion import Motion  # a shock does not need it

        return self.excitation if isinstance(self.excitation, Motion) else None

    @property
    def shock(self) -> Shock | None:
        """The shock; None under an impact."""
        return self.excitation if isinstance(self.excitation, Shock) else None

    @cached_property
    def uniform(self) -> Chain | None:
        """The chain as equal granules with free ends, given by their number, or a packing; None for other scenes.

        A shock on such a chain generates waves whose peak forces have limits along the endless chain. An endless chain
        keeps its contact law. In other scenes the forces at the contacts are the result.
        """
        return None if self.shock is None else uniform_of(self.chain)

    @property
    def line(self) -> Chain:
        """The chain in its simplest form: as equal granules where it is uniform."""
        return self.uniform or self.chain

    def covered_chain(self, method: str, laws: bool = False, packings: bool = False) -> Chain:
        """The chain as equal granules, given by their number, for a ``method`` that covers no others.

        It covers other contact ``laws`` than Hertz's in endless chains, and ``packings``, if stated.

        Raises
        ------
        NotCoveredError
            If the scene has further features; it lists all of them.
        """
        if self.chain.is_uniform and self.shock is not None and not self.shock.profile.pulls:
            return self.chain
        from shockwave.scene.coverage_rules import check_coverage  # equal granules do not need it

        return check_coverage(self.chain, self.excitation, method, laws, packings)

    @property
    def contact_count(self) -> int | None:
        """Number of contacts, including that with a wall, which is the last one; None for an endless chain."""
        count = self.chain.count
        return None if count is None else count - 1 + (self.impact is not None) + (self.chain.end is not None)

    @cached_property
    def layout(self) -> Layout:
        """Granules and contacts of a finite chain, one by one.

        Raises
        ------
        InvalidValueError
            If the combination of chain and excitation is not possible.
        """
        from shockwave.scene.layout import Layout  # equal granules do not need it

        return Layout.of(self.chain, self.excitation)

    def summary(self) -> SceneSummary:
        """Numbers of the scene in SI units, and their text."""
        from shockwave.scene.scene_summary import summary_of  # a number alone does not need it

        return summary_of(self.excitation, self.line, self.uniform is not None)

    @property
    def notes(self) -> tuple[str, ...]:
        """Changes that were made to a record."""
        return () if self.shock is None else tuple(self.shock.profile.notes)

    def place_fault(self, fault: Fault) -> Fault:
        """``fault`` with its place in the file, if there is one."""
        return fault if self.place is None else self.place(fault)

    def locate_error(self, error: Exception) -> Exception:
        """``error``, with the places of its faults in the file where they concern a key there."""
        return error.with_places(self.place_fault) if isinstance(error, InvalidValueError) else error

    def locate_errors(self) -> AbstractContextManager[None]:
        """Report an invalid value with its place in the file."""
        return nullcontext() if self.place is None else locate(self.place)


def uniform_of(chain: Chain) -> Chain | None:
    """The chain as equal granules with free ends, given by their number, or a packing; None for others."""
    if chain.is_uniform:
        return chain
    from shockwave.scene.coverage_rules import reduce_chain  # equal granules do not need it

    return reduce_chain(chain)


def faults_of(chain: Chain, excitation: Impact | Motion | None) -> list[Fault]:
    """Errors of the combination of a chain with an impact or a motion, or with a shock in their place."""
    if chain.is_uniform and excitation is None:
        return []
    from shockwave.scene.coverage_rules import scene_faults  # equal granules do not need it

    faults = scene_faults(chain, excitation)
    if faults or not chain.is_plastic:
        return faults
    from shockwave.scene.plastic_range import range_faults  # elastic contacts do not need it

    return range_faults(chain, excitation)


def scenes_of(shocks: Iterable[Any], chain: Any, single: str, threads: object) -> list[Scene | InvalidValueError]:
    """Scenes of the shocks on ``chain``, one for all or one for each shock; the error of an invalid scene.

    Raises
    ------
    InvalidValueError
        If ``shocks`` is a single shock, for which there is the function ``single``, the numbers differ, or the number
        of ``threads`` is not one.
    """
    if threads is not None and not (isinstance(threads, int) and threads >= 1):
        raise InvalidValueError.of("threads", f"must be a whole number >= 1 (got {text_of(threads)})")
    if not isinstance(shocks, Iterable):
        rule = f"must be a list of shocks (got {type(shocks).__name__}; or use {single})"
        raise InvalidValueError.of("shocks", rule)
    shocks = list(shocks)
    if not isinstance(chain, Chain | Iterable) or isinstance(chain, str):
        raise InvalidValueError.of("chain", f"must be a Chain, or one for each shock (got {text_of(chain)})")
    chains = [chain] * len(shocks) if isinstance(chain, Chain) else list(chain)
    if len(chains) != len(shocks):
        raise InvalidValueError.of(
            "chain", f"must be a Chain, or a list of {len(shocks)} (got a list of {len(chains)})"
        )
    return [_scene(*pair) for pair in zip(shocks, chains, strict=True)]


def _scene(excitation: Any, chain: Any) -> Scene | InvalidValueError:
    try:
        return Scene(excitation=excitation, chain=chain)
    except InvalidValueError as error:
        return detach(error)
