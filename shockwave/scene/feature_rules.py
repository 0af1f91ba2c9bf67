"""Rules on the features of chains beyond equal spheres, and on their combinations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from shockwave.base.errors import Fault, refuse
from shockwave.base.quantity_fields import text_of
from shockwave.scene.chain_end import Wall
from shockwave.scene.contact_law import ContactLaw, PowerContact
from shockwave.scene.damping import HERTZ, Damping, Tsuji
from shockwave.scene.segments import MOST_GRANULES, Cell, Segment, each_segment

Granules = int | Sequence[Segment | Cell] | None
#: Feature -> its types, and their names in messages.
_TYPES: Mapping[str, tuple[Any, str]] = {
    "end": (Wall, "a Wall"),
    "damping": (Damping, "a KuwabaraKono, a Dashpot or a Tsuji"),
    "contact": (PowerContact | ContactLaw, "a PowerContact or a ContactLaw"),
}

#: Exponents of the contact force for which the waves of an endless chain are computed: nearer to 1 they are too long,
#: and beyond, the granules behave nearly as hard spheres do.
WAVE_EXPONENTS = (1.05, 6.0)


def check_features(granules: Granules, **features: Any) -> None:
    """Check the features of a chain, named as the arguments of `Chain`.

    Raises
    ------
    InvalidValueError
        If there are errors; it contains all of them.
    """
    features = {name: value for name, value in features.items() if value}
    faults = [
        Fault(name, f"must be {rule} (got {text_of(features[name])})")
        for name, (types, rule) in _TYPES.items()
        if name in features and not isinstance(features[name], types)
    ]
    refuse(faults or [*_of_length(granules, features), *_of_pairs(granules, features)])


def _of_length(granules: Granules, features: Mapping[str, Any]) -> Iterator[Fault]:
    """Errors of features that need a finite chain, or one that is not too long."""
    contact = features.get("contact")
    if granules is None:
        for name in features:
            if name == "precompression" or (name == "contact" and isinstance(contact, PowerContact)):
                continue
            yield Fault(name, "must be left out for an endless chain (give the number of granules)")
        if isinstance(contact, PowerContact) and "precompression" not in features:
            least, most = WAVE_EXPONENTS
            if not least <= contact.exponent <= most:
                rule = f"must be >= {least:g} and <= {most:g} for the waves of an endless chain"
                yield Fault("contact.exponent", f"{rule} (got {contact.exponent:g}; give the number of granules)")
    elif isinstance(granules, int) and granules > MOST_GRANULES:
        names = ", ".join(features)
        yield Fault("granules", f"must be <= {MOST_GRANULES} for a chain with {names} (got {granules})")


def _of_pairs(granules: Granules, features: Mapping[str, Any]) -> Iterator[Fault]:
    """Errors of features that exclude each other."""
    static = [name for name in ("precompression", "gravity") if name in features]
    if "gravity" in features and "end" not in features:
        yield Fault(
            "gravity", f"must be 0 for a chain with a free end (got {features['gravity']:g}; give a wall as end)"
        )
    for place, segment in each_segment(granules) if static and isinstance(granules, Sequence) else ():
        if segment.gap:
            yield Fault(("granules", *place, "gap"), f"must be 0 under {' and '.join(static)} (got {segment.gap:g} m)")
    contact, damping = features.get("contact"), features.get("damping")
    if isinstance(contact, ContactLaw):
        rule = f"must be left out for the contact law {type(contact).__name__}, which cannot be combined with it"
        for name in (*static, *(["damping"] if damping else [])):
            yield Fault(name, rule)
    elif isinstance(damping, Tsuji) and contact is not None and contact.exponent != HERTZ:
        rule = "must be dashpot or kuwabara-kono for a contact exponent other than 1.5, for which the restitution"
        got = f"got tsuji, exponent {contact.exponent:g}"
        yield Fault("damping.model", f"{rule} depends on the velocity ({got})")
