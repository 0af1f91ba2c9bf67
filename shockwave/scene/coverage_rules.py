"""Rules on chain and excitation, and features that methods for equal granules do not cover; `Scene` asks them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from attrs import evolve

from shockwave.base.errors import Fault, NotCoveredError, Steps
from shockwave.scene.chain import Chain
from shockwave.scene.contact_law import ContactLaw, PowerContact
from shockwave.scene.impact import Impact
from shockwave.scene.motion import Motion
from shockwave.scene.segments import Segment, Taper, each_segment

# Key of a record that keeps negative forces.
_PULLING = "shock.parameters.negative"
_SCOPE = "shocks on chains of equal granules with free ends"


def scene_faults(chain: Chain, excitation: object) -> list[Fault]:
    """Errors of a chain beyond equal spheres, or under an impact."""
    struck, guided = isinstance(excitation, Impact), isinstance(excitation, Motion)
    if chain.packing is not None and (struck or guided):
        rule = f"must be left out under {'an impact' if struck else 'a motion'}"
        return [Fault("chain.packing", f"{rule} (got {chain.packing!r})")]
    excluded = [name for name in ("precompression", "gravity") if guided and getattr(chain, name)]
    parts: list[Any] = [chain, *(segment for _, segment in each_segment(chain.granules))] if guided else []
    excluded += ["contact"] if any(isinstance(part.contact, ContactLaw) for part in parts) else []
    if excluded:
        return [Fault(f"chain.{name}", "must be left out under a motion of the first granule") for name in excluded]
    if chain.count is None:
        needed = f"must be given, because a {'striker' if struck else 'motion'} needs a finite chain (got nothing)"
        return [Fault("chain.granules", needed)] if struck or guided else []
    if chain.count + struck + (chain.end is not None) < 2:
        return [Fault("chain.granules", "must give a contact (got 1 granule; add granules, a wall or a striker)")]
    return []


def reduce_chain(chain: Chain) -> Chain | None:
    """The chain as equal granules with free ends, given by their number, or a packing; None for further features.

    An endless chain keeps its contact law.
    """
    if chain.is_uniform or chain.packing is not None:
        return chain
    # a single granule is not a chain
    if chain.count == 1 or next(_features(chain), None) is not None:
        return None
    if chain.count is None:
        return chain
    first = next(segment for _, segment in each_segment(chain.granules))
    radius = _kind(chain, first)[0]
    return evolve(chain, material=first.material or chain.material, radius=radius, granules=chain.count)


def check_coverage(chain: Chain, excitation: object, method: str, laws: bool, packings: bool) -> Chain:
    """The chain as one of equal granules, given by their number, for a ``method`` that covers no others.

    It covers other contact ``laws`` than Hertz's in endless chains, and ``packings``, if stated.

    Raises
    ------
    NotCoveredError
        If the scene has further features; it lists all of them.
    """
    equal = reduce_chain(chain)
    pulls = getattr(getattr(excitation, "profile", None), "pulls", False)
    refused = (chain.packing and not packings) or (chain.contact and not laws)
    other: list[tuple[type, str, str]] = [(Impact, "impact", "a striker"), (Motion, "motion", "a prescribed motion")]
    others = [((name,), text) for kind, name, text in other if isinstance(excitation, kind)]
    if equal is not None and not refused and not others and not pulls:
        return equal
    line = evolve(chain, packing=None) if packings else chain
    features = [] if line.is_uniform else [(("chain", *steps), reason) for steps, reason in _features(line, laws)]
    features += others
    if not features and not pulls:
        features.append((("chain", "granules"), "1 granule"))
    rule = f"must be left out for {method}, which covers only {_SCOPE}"
    faults = [Fault(steps, f"{rule} (got {reason})") for steps, reason in features]
    if pulls:
        rule = f"must be zero for {method}, which covers no negative forces"
        faults.append(Fault(_PULLING, f"{rule} (got pulling forces)"))
    raise NotCoveredError(*faults)


def _features(chain: Chain, laws: bool = True) -> Iterator[tuple[Steps, str]]:
    """Path below ``chain`` and description of every feature beyond equal granules with free ends.

    ``laws`` states whether endless chains may have other contact laws than Hertz's.
    """
    segments = [*each_segment(chain.granules)]
    for place, segment in segments:
        if segment.gap:
            yield ("granules", *place, "gap"), "a gap"
        for name, text in (("contact", "another contact law"), ("damping", "damping")):
            if getattr(segment, name):
                yield ("granules", *place, name), text
    for place, segment in segments:
        kind = _kind(chain, segment)
        taper = kind[0] != kind[1]
        if taper or kind != _kind(chain, segments[0][1]):
            yield ("granules", *place), "a taper" if taper else "granules of another kind"
            break
    names = {
        "end": f"a {chain.end_word}",
        "precompression": "a static force",
        "gravity": "gravity",
        "damping": "damping",
    }
    names["packing"] = "a packing"
    if chain.count is not None or not laws:
        covered = laws and isinstance(chain.contact, PowerContact)
        names["contact"] = f"another contact law{'; without granules it is covered' if covered else ''}"
    for name, text in names.items():
        if getattr(chain, name):
            yield (name,), text


def _kind(chain: Chain, segment: Segment) -> tuple[float, ...]:
    """Radii [m] of the first and the last granule of a segment, and the constants of its material."""
    material, radius = segment.material or chain.material, segment.radius or chain.radius
    ends = (radius.first, radius.last) if isinstance(radius, Taper) else (radius, radius)
    return *ends, material.youngs_modulus, material.poisson_ratio, material.density
