"""Summary of a scene: the numbers that a result was computed for, in SI units, and their text."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from attrs import asdict, field, frozen

from shockwave.base.errors import InvalidValueError
from shockwave.base.quantity_fields import text_of
from shockwave.base.text import si
from shockwave.scene.chain import Chain
from shockwave.scene.shock import Shock

if TYPE_CHECKING:  # a shock on equal granules does not need it
    from shockwave.scene.impact import Impact


def check_scene(shock: object, chain: object) -> None:
    """Refuse arguments in the wrong order, and anything else that is not a shock and a chain.

    Raises
    ------
    InvalidValueError
        If ``shock`` is not a Shock or ``chain`` not a Chain.
    """
    if not (isinstance(shock, Shock) and isinstance(chain, Chain)):
        got = f"got {type(shock).__name__} and {type(chain).__name__}"
        raise InvalidValueError.of("shock", f"must be a Shock, and the chain a Chain ({got})")


def equal_granules(excitation: object, chain: Chain) -> Chain | None:
    """The chain as equal granules with free ends; None if the scene has further features.

    An endless chain keeps its contact law.

    Raises
    ------
    InvalidValueError
        If ``excitation`` is neither a Shock nor an Impact, or ``chain`` not a Chain.
    """
    if isinstance(excitation, Shock) and isinstance(chain, Chain) and chain.is_uniform:
        return chain
    from shockwave.scene.coverage_rules import reduced  # a shock on equal granules does not need it
    from shockwave.scene.impact import Impact

    if isinstance(excitation, Impact) and isinstance(chain, Chain):
        return None
    check_scene(excitation, chain)
    return reduced(chain)


def scenes_of(shocks: Iterable[Any], chain: Any, single: str, threads: object) -> list[tuple[Any, Any]]:
    """Pairs of the shocks and their chains; ``chain`` is one for all shocks, or one for each shock.

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
        raise InvalidValueError.of("chain", f"must be one, or one for each shock (got {len(chains)})")
    return list(zip(shocks, chains, strict=True))


@frozen(kw_only=True)
class Scene:
    """Shock and chain, as numbers.

    Attributes
    ----------
    profile : str
        Class of the shock's profile.
    peak_force, rise_time, duration_ratio : float
        F0 [N], t0 [s], n; read off the record where there is one.
    radius, youngs_modulus, poisson_ratio, density : float
        R [m], E [Pa], nu, rho [kg/m^3].
    granules : int or None
        None for an endless chain.
    contact : dict or None
        Contact law in the form of a scenario block; None for Hertz's.
    notes : tuple of str
        Changes that were made to the given record.
    packing : str or None
        Packing in which a plane wave travels.
    """

    profile: str
    peak_force: float
    rise_time: float
    duration_ratio: float
    radius: float
    youngs_modulus: float
    poisson_ratio: float
    density: float
    granules: int | None
    contact: dict[str, Any] | None = None
    notes: tuple[str, ...] = ()
    packing: str | None = None

    @classmethod
    def of(cls, shock: Shock, chain: Chain) -> Scene:
        """The scene of ``shock`` on ``chain``."""
        contact = None
        if chain.contact is not None:
            from shockwave.scene.description import plain  # for such chains only

            contact = plain(chain.contact)
        return cls(
            profile=type(shock.profile).__name__,
            peak_force=shock.peak_force,
            rise_time=shock.rise_time,
            duration_ratio=float(shock.profile.duration_ratio),
            radius=chain.radius,
            youngs_modulus=chain.material.youngs_modulus,
            poisson_ratio=chain.material.poisson_ratio,
            density=chain.material.density,
            granules=chain.count,
            contact=contact,
            notes=tuple(shock.profile.notes),
            packing=chain.packing,
        )

    def to_dict(self) -> dict[str, Any]:
        """The numbers, and the packing if there is one; the notes stand among the warnings of the result."""
        left_out = ("notes",) if self.packing else ("notes", "packing")
        return asdict(self, filter=lambda attribute, _: attribute.name not in left_out)

    def facts(self) -> list[tuple[str, str]]:
        """Label and text of the shock and of the chain."""
        length = "endless" if self.granules is None else f"{self.granules} granules"
        stiffness = f"E {si(self.youngs_modulus, 'Pa')}, nu {self.poisson_ratio:.4g}"
        chain = f"R {si(self.radius, 'm')}, {stiffness}, rho {self.density:.5g} kg/m^3, {length}"
        if self.packing:
            chain += f", packing {self.packing}: forces per contact, shock per bead"
        contact = ", ".join(f"{name} {value:.5g}" for name, value in (self.contact or {}).items() if name != "model")
        return [("shock", self.shock), ("chain", chain), *[("contact", contact)] * bool(contact)]

    @property
    def shock(self) -> str:
        """The shock in one line."""
        duration = f"{si(self.rise_time * self.duration_ratio, 's')} (n = {self.duration_ratio:.5g})"
        return f"{self.profile}, peak {si(self.peak_force, 'N')}, rise {si(self.rise_time, 's')}, duration {duration}"


@frozen(kw_only=True)
class ChainScene:
    """Shock or impact, and a finite chain with further features, as plain data.

    Attributes
    ----------
    shock : dict or None
        Numbers of the shock, as in `Scene`; None for an impact.
    impact : dict or None
        The ``impact`` block of a scenario; None for a shock.
    chain : dict
        The ``chain`` block of a scenario, in SI units.
    granules : int or None
        Number of granules, without a striker; None for an endless chain.
    lines : tuple of (str, str)
        Label and text of every part.
    notes : tuple of str
        Changes that were made to the given record.
    """

    shock: dict[str, Any] | None = field(hash=False)
    impact: dict[str, Any] | None = field(hash=False)
    chain: dict[str, Any] = field(hash=False)
    granules: int | None
    lines: tuple[tuple[str, str], ...]
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, excitation: Shock | Impact, chain: Chain) -> ChainScene:
        """The scene of ``excitation`` on ``chain``."""
        from shockwave.scene.description import lines, plain, text  # for such chains only

        own: dict[str, Any] = {"shock": None, "impact": None}
        if isinstance(excitation, Shock):
            scene = Scene.of(excitation, chain)
            names = ("profile", "peak_force", "rise_time", "duration_ratio")
            own |= {"shock": {name: getattr(scene, name) for name in names}, "notes": scene.notes}
            first = ("shock", scene.shock)
        else:
            own["impact"] = plain(excitation)
            first = ("impact", text(excitation))
        return cls(chain=plain(chain), granules=chain.count, lines=(first, *lines(chain)), **own)

    def to_dict(self) -> dict[str, Any]:
        """Shock, impact and chain; the notes stand among the warnings of the result."""
        return {"shock": self.shock, "impact": self.impact, "chain": self.chain, "granules": self.granules}

    def facts(self) -> list[tuple[str, str]]:
        """Label and text of the shock or the impact, and of the parts of the chain."""
        return [*self.lines]
