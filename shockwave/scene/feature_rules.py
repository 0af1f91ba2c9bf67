"""Rules on the features of chains beyond equal spheres, and on their combinations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from shockwave.base.errors import Fault, Steps, refuse
from shockwave.base.quantity_fields import text_of
from shockwave.registry.registry import load
from shockwave.scene.chain_end import Bar, Wall
from shockwave.scene.contact_law import AnyContact, ContactLaw, ElasticPlastic, PowerContact
from shockwave.scene.damping import HERTZ, Damping, Dashpot, Tsuji
from shockwave.scene.segments import MOST_GRANULES, Cell, Segment, each_segment

Granules = int | Sequence[Segment | Cell] | None
#: Feature -> its types, and their names in messages.
_TYPES: Mapping[str, tuple[Any, str]] = {
    "end": (Wall | Bar, "a Bar or a Wall, such as sw.Wall(material='same')"),
    "damping": (Damping, "a KuwabaraKono, a Dashpot or a Tsuji"),
    "contact": (AnyContact, "a PowerContact, an ElasticPlastic, a ContactLaw or a Hertz"),
}

#: Text in a file of the law of a segment whose contacts are elastic.
HERTZ_TEXT = "contact: {model: hertz}"
# Damping of a segment that has none in a chain with damping, and its text in a file.
_UNDAMPED = Dashpot(coefficient=0.0)
_UNDAMPED_TEXT = "damping: {model: dashpot, coefficient: 0}"

#: Exponents of the contact force for which the waves of an endless chain are computed: nearer to 1 they are too long,
#: and beyond, the granules behave nearly as hard spheres do.
WAVE_EXPONENTS = (1.05, 6.0)


def check_features(granules: Granules, elastic_only: bool, **features: Any) -> None:
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
    for place, segment in each_segment(granules):
        for name, value in (("contact", segment.contact), ("damping", segment.damping)):
            types, rule = _TYPES[name]
            if not isinstance(value, types | None):
                faults.append(Fault(("granules", *place, name), f"must be {rule} (got {text_of(value)})"))
    refuse(faults or [*_length_faults(granules, features), *_pair_faults(granules, features, elastic_only)])


def is_damped(chain: Any) -> bool:
    """Whether forces may depend on velocities outside plastic flow: by damping, or by the law of a plugin."""
    parts = [chain, *(segment for _, segment in each_segment(chain.granules))]
    end_damped = isinstance(chain.end, Bar) or (chain.end is not None and chain.end.damping > 0)
    if end_damped or any(part.damping for part in parts):
        return True
    return has_plugin_law(chain)


def has_plugin_law(chain: Any) -> bool:
    """Whether some contacts have the contact law of a plugin."""
    return any(
        isinstance(part.contact, ContactLaw) for part in (chain, *(each for _, each in each_segment(chain.granules)))
    )


def depends_on_rate(chain: Any) -> bool:
    """Whether the strength of elastic-plastic contacts depends on the strain rate."""
    materials = [chain.material, *(segment.material for _, segment in each_segment(chain.granules))]
    return chain.is_plastic and any(material.rate_constant for material in materials if material)


def integrator_refusal(name: str, chain: Any) -> str:
    """Reason why a registered integrator cannot integrate a chain; empty if it can."""
    refusal: str = load("integrators", name).refusal(chain.is_damped, chain.is_plastic, depends_on_rate(chain))
    return refusal


def is_plastic(granules: Granules, contact: object) -> bool:
    """Whether some contacts are elastic-plastic."""
    contacts = [contact, *(segment.contact for _, segment in each_segment(granules))]
    return any(isinstance(each, ElasticPlastic) for each in contacts)


def _length_faults(granules: Granules, features: Mapping[str, Any]) -> Iterator[Fault]:
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


def _pair_faults(granules: Granules, features: Mapping[str, Any], elastic_only: bool) -> Iterator[Fault]:
    """Errors of features that exclude each other."""
    static = [name for name in ("precompression", "gravity") if name in features]
    if "gravity" in features and "end" not in features:
        yield Fault(
            "gravity", f"must be 0 for a chain with a free end (got {features['gravity']:g}; give a wall as end)"
        )
    segments = [*each_segment(granules)]
    for place, segment in segments:
        if static and segment.gap:
            yield Fault(("granules", *place, "gap"), f"must be 0 under {' and '.join(static)} (got {segment.gap:g} m)")
    yield from _law_faults(features.get("contact"), features.get("damping"), segments, static, elastic_only)


def _law_faults(
    contact: Any, damping: Any, segments: list[tuple[Steps, Segment]], static: list[str], elastic_only: bool
) -> Iterator[Fault]:
    """Errors of the laws of the contacts: those of the chain, and those of segments with their own."""
    laws: list[tuple[Steps, Any, Any]] = [((), contact, damping)]
    for place, segment in segments:
        if segment.contact or segment.damping:
            laws.append((("granules", *place), segment.contact or contact, segment.damping or damping))
    plugins = [(steps, law) for steps, law, _ in laws if isinstance(law, ContactLaw)]
    if plugins and static:
        rule = f"must be left out for the contact law {type(plugins[0][1]).__name__}, which cannot be combined with it"
        yield from (Fault(name, rule) for name in static)
    for steps, law in plugins:
        if law != plugins[0][1]:
            rule = "must be the law of the other contacts with a law of a plugin"
            yield Fault((*steps, "contact"), f"{rule} (got {text_of(law)}; change one of the two)")
    if elastic_only and any(isinstance(law, ElasticPlastic) for _, law, _ in laws):
        yield Fault("elastic_only", "must be left out for elastic-plastic contacts (got true)")
    if elastic_only and all(isinstance(law, PowerContact | ContactLaw) for _, law, _ in laws):
        yield Fault("elastic_only", "must be left out where no contact has Hertz's law (got true)")
    damped = {("granules", *place) for place, segment in segments if segment.damping} | {()}
    for steps, law, force in laws:
        # where the segment has its own law alone, the damping is that of the chain
        name, other = ("damping", HERTZ_TEXT) if steps in damped else ("contact", _UNDAMPED_TEXT)
        hint = f" (or {other} for this segment)" if steps else ""
        if isinstance(law, ContactLaw | ElasticPlastic) and force not in (None, _UNDAMPED):
            label = "elastic-plastic" if isinstance(law, ElasticPlastic) else type(law).__name__
            of = f"the contact law {label}" if steps in damped else "the damping of the chain"
            yield Fault((*steps, name), f"must be left out for {of}, which cannot be combined with it{hint}")
        elif isinstance(force, Tsuji) and isinstance(law, PowerContact) and law.exponent != HERTZ:
            rule = "must be dashpot or kuwabara-kono for a contact exponent other than 1.5, for which the restitution"
            got = f"got tsuji, exponent {law.exponent:g}"
            path = (*steps, "damping", "model") if steps in damped else (*steps, "contact")
            yield Fault(path, f"{rule} depends on the velocity ({got})")
