"""Segments of a finite chain: equal granules, tapers, and repeated cells of several segments."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Literal

from attrs import field, frozen

from shockwave.base.errors import InvalidValueError, Steps
from shockwave.base.quantity_fields import SI, Converted, Declaration, Value, one_of, quantity, text_of, tuple_repr
from shockwave.scene.contact_law import AnyContact
from shockwave.scene.damping import Damping
from shockwave.scene.material import SIZES, Diameter, OptionalMaterial, check_material, halve, material_of, set_radius

#: Greatest number of granules in segments: a bound on memory, far beyond what can be integrated.
MOST_GRANULES = 1_000_000


@frozen(kw_only=True)
class Taper(Value):
    """Sizes that change uniformly from the first granule of a segment to the last.

    Parameters
    ----------
    first, last : float
        Size of the first and of the last granule [m], above 0: radii, or diameters where the taper is a diameter.
    spacing : "linear" or "geometric"
        Equal differences (default) or equal ratios of neighbouring sizes.

    Raises
    ------
    InvalidValueError
        If a value is out of range.

    Examples
    --------
    >>> import shockwave as sw
    >>> taper = sw.Taper(first="5 mm", last="2 mm", spacing="geometric")
    >>> beads = [sw.Segment(count=20, radius=taper)]
    >>> sw.Chain(material="alumina", radius="5 mm", granules=beads).count
    20
    """

    first: SI[float] = quantity("m", "size of the first granule", within=SIZES)
    last: SI[float] = quantity("m", "size of the last granule", within=SIZES)
    spacing: Literal["linear", "geometric"] = field(default="linear", validator=one_of("linear", "geometric"))

    @property
    def half(self) -> Taper:
        """The taper with half the sizes, that of the radii, if this one is of diameters."""
        return Taper(first=self.first / 2, last=self.last / 2, spacing=self.spacing)

    def sizes(self, count: int) -> list[float]:
        """Sizes of ``count`` granules [m]; the ends are exact."""
        inner = [index / (count - 1) for index in range(1, count - 1)]
        if self.spacing == "linear":
            between = [self.first + (self.last - self.first) * share for share in inner]
        else:
            between = [self.first * (self.last / self.first) ** share for share in inner]
        return [self.first, *between, self.last]


RADIUS = Declaration("m", "radius of the granules", **SIZES, optional=True)


def _radius(value: Any) -> Any:
    return value if isinstance(value, Taper) else RADIUS.check("radius", value)


@frozen(kw_only=True)
class Segment(Value):
    """Consecutive granules of one material, of equal or tapered size.

    Parameters
    ----------
    count : int
        Number of granules, at least 1 (default).
    material : Material or str, optional
        Material, or its name; by default that of the chain.
    radius, diameter : float or Taper, optional
        Size [m], at most one of them; by default that of the chain.
    gap : float
        Initial distance between each of these granules and the next one [m], default 0.
    contact : PowerContact, ElasticPlastic, ContactLaw or Hertz, optional
        Law of the contacts between each of these granules and the next one or the wall; by default that of the chain.
    damping : KuwabaraKono, Dashpot or Tsuji, optional
        Damping at these contacts; by default that of the chain.

    Raises
    ------
    InvalidValueError
        If a value is out of range, both sizes are given, or a taper has fewer than two granules.

    Examples
    --------
    >>> import shockwave as sw
    >>> layers = [sw.Segment(count=10), sw.Segment(count=5, material="delrin")]
    >>> sw.Chain(material="alumina", diameter="10 mm", granules=layers).count
    15
    """

    count: SI[int] = quantity("", "number of granules", at_least=1, at_most=MOST_GRANULES, whole=True, default=1)
    material: OptionalMaterial = field(default=None, converter=material_of, validator=check_material)
    radius: SI[float | Taper | None] = field(default=None, converter=_radius, metadata=RADIUS.metadata)
    _diameter: Diameter = field(default=None, alias="diameter", converter=halve, eq=False, repr=False)
    gap: SI[float] = quantity(
        "m", "initial distance between each granule and the next one", at_least=0, at_most=1e6, default=0.0
    )
    contact: AnyContact | None = None
    damping: Damping | None = None

    def __attrs_post_init__(self) -> None:
        set_radius(self)
        if isinstance(self.radius, Taper) and self.count < 2:
            raise InvalidValueError.of("count", f"must be >= 2 for a taper (got {self.count})")

    @property
    def granules(self) -> int:
        """Number of granules."""
        return self.count


def _segments(value: Any) -> tuple[Segment, ...]:
    if not (isinstance(value, Sequence) and value and all(isinstance(part, Segment) for part in value)):
        raise InvalidValueError.of("cell", f"must be a list of one or more Segment objects (got {text_of(value)})")
    return tuple(value)


@frozen(kw_only=True)
class Cell(Value):
    """A sequence of segments that is repeated.

    Parameters
    ----------
    repeat : int
        Number of repetitions, at least 1.
    cell : sequence of Segment
        The segments of one cell, starting at the struck end.

    Raises
    ------
    InvalidValueError
        If a value is out of range.

    Examples
    --------
    >>> import shockwave as sw
    >>> pair = [sw.Segment(material="tungsten-carbide"), sw.Segment(material="delrin")]
    >>> cells = [sw.Cell(repeat=10, cell=pair)]
    >>> sw.Chain(material="delrin", radius="5 mm", granules=cells).count
    20
    """

    repeat: SI[int] = quantity("", "number of repetitions of the cell", at_least=1, at_most=MOST_GRANULES, whole=True)
    cell: Converted[tuple[Segment, ...], Sequence[Segment]] = field(converter=_segments, repr=tuple_repr)

    @property
    def granules(self) -> int:
        """Number of granules."""
        return self.repeat * sum(segment.count for segment in self.cell)


def check_segments(value: Sequence[Any]) -> tuple[Segment | Cell, ...]:
    """``value`` as the segments of a chain.

    Raises
    ------
    InvalidValueError
        If it is empty, an element is of another type, or there are more than a million granules.
    """
    wrong = [index for index, part in enumerate(value) if not isinstance(part, Segment | Cell)]
    if wrong or not value:
        got = text_of(value[wrong[0]]) if wrong else "none"
        rule = "a Segment or a Cell" if wrong else "a whole number, or a list of one or more segments"
        raise InvalidValueError.of(("granules", *wrong[:1]), f"must be {rule} (got {got})")
    total = sum(part.granules for part in value)
    if total > MOST_GRANULES:
        raise InvalidValueError.of("granules", f"must be at most {MOST_GRANULES} granules in all (got {total})")
    return tuple(value)


def each_segment(granules: object) -> Iterator[tuple[Steps, Segment]]:
    """Path below ``granules`` and the segment itself, for every segment; those of a cell once, none of a number."""
    for index, part in enumerate(granules if isinstance(granules, tuple) else ()):
        if isinstance(part, Segment):
            yield (index,), part
        else:
            yield from (((index, "cell", inner), segment) for inner, segment in enumerate(part.cell))
