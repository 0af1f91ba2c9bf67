"""First yield of contacts: the limit of elastic results."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

from attrs import frozen

from shockwave.base.errors import InvalidValueError
from shockwave.base.numerics import FloatArray
from shockwave.base.text import round_digits, si
from shockwave.scene.chain import Chain

_Number = TypeVar("_Number", float, FloatArray)
# Pressure at the centre of the contact at first yield, over the yield strength: 1.6 for a Poisson ratio of 0.3
# (Johnson, Contact Mechanics, section 6.1).
PRESSURE = 1.6
# Force over that of first yield up to which contacts of metals load by Hertz's law, and what differs up to there and
# beyond.
_CAP = 9.0
_UNLOADS = "Up to about 9 times, contacts load elastically and lose energy in unloading only."
_FLOWS = "Beyond about 9 times, contacts flow as they load, and forces are smaller."
# Errors of forces of elastic-plastic contacts in chains of ten steel beads, relative to finite elements
# (docs/validation.md), without and with rate dependence.
_LAW_ERRORS = (-0.02, 0.11), (-0.22, 0.015)
# Note on the contact law of a plugin.
_PLUGIN_LAW = "Energy that contacts with the law of a plugin still store at the end counts as dissipated by damping."
# Key of a scenario that includes plastic flow.
_KEY = "chain.contact: {model: elastic-plastic}"
#: Beginning of the warning of forces beyond first yield.
BEYOND = "Beyond elastic validity"
#: Beginning of the warning of contacts without a known yield strength.
UNJUDGED = "First yield is not judged"
#: Warning of contacts with a power law or the law of a plugin.
OTHER_LAWS = "First yield is checked only at contacts with Hertz's law or the elastic-plastic law."


@frozen(kw_only=True)
class Yielding:
    """First yield of the contacts.

    Attributes
    ----------
    first_yield_force : float
        Smallest force in the chain at which a contact begins to yield [N].
    peak_ratio : float
        Largest ratio of a peak force to the force at which its contact begins to yield.
    elastic_ratio : float
        The same for contacts without plastic flow; 0 if there are none.
    place : str
        Contact of this ratio and its bodies, in chains of different bodies; else empty.
    yielded_contacts : int or None
        Number of contacts with a greater peak force than that of first yield; None for an endless chain.
    """

    first_yield_force: float
    peak_ratio: float
    elastic_ratio: float
    place: str = ""
    yielded_contacts: int | None = None

    def facts(self) -> list[tuple[str, str]]:
        """Label and text."""
        ratio = f"largest ratio of a peak force to the force of first yield {round_digits(self.peak_ratio, 3)}"
        return [("first yield", f"at {si(self.first_yield_force, 'N', 4)}; {ratio}")]


def first_yield_force(radius: _Number, modulus: _Number, strength: _Number) -> _Number:
    """F_y = pi^3 R*^2 (1.6 sigma_y)^3 / (6 E*^2) [N], for the yield strength of the softer body.

    ``radius`` R* [m], ``modulus`` E* [Pa] and ``strength`` sigma_y [Pa] are numbers, or arrays of the same shape.
    """
    pressure = PRESSURE * strength
    size = radius / modulus
    return math.pi**3 / 6 * size * size * pressure * pressure * pressure


def strength_of(material: Any) -> float:
    """Yield strength of a material [Pa]; NaN if it is not known, infinite for ``rigid``."""
    strength = getattr(material, "yield_strength", math.inf)
    return math.nan if strength is None else float(strength)


def find_yielding(chain: Chain, peak_force: float) -> Yielding | None:
    """First yield in a chain of equal granules with a peak force [N].

    None if the yield strength is not known, or for another law than Hertz's.
    """
    material = chain.material
    if material.yield_strength is None or chain.contact is not None:
        return None
    force = first_yield_force(chain.radius / 2, 1 / (2 * material.compliance), material.yield_strength)
    return Yielding(first_yield_force=force, peak_ratio=peak_force / force, elastic_ratio=peak_force / force)


def warn_other_law(chain: Chain) -> tuple[str, ...]:
    """Warning of equal granules with another law than Hertz's, whose yield strength is known."""
    return (OTHER_LAWS,) if chain.contact is not None and chain.material.yield_strength is not None else ()


def warn_beyond(yielding: Yielding | None, chain: Chain) -> tuple[str, ...]:
    """Sentence on forces beyond first yield at elastic contacts: what differs there, and the key that includes it."""
    if yielding is None or yielding.elastic_ratio <= 1:
        return ()
    where = yielding.place and f", {yielding.place}"
    ratio = f"{BEYOND}: a peak force is {_times(yielding.elastic_ratio)} times that of first yield{where}."
    differs = _UNLOADS if yielding.elastic_ratio <= _CAP else _FLOWS
    remedy = f" {_KEY} includes yield{', without damping' if chain.damping else ''}."
    if chain.count is None:
        remedy = f" The peak force is an upper limit; a finite chain with {_KEY} includes yield."
    return (f"{ratio} {differs}{'' if chain.packing or chain.contact is not None else remedy}",)


def law_error(chain: Chain) -> tuple[float, float] | None:
    """Least and greatest relative error of the law of elastic-plastic contacts, if there are any."""
    if not chain.is_plastic:
        return None
    from shockwave.scene.feature_rules import depends_on_rate  # elastic contacts do not need it

    return _LAW_ERRORS[depends_on_rate(chain)]


def law_facts(chain: Chain) -> list[tuple[str, str]]:
    """Label and text of the error of the elastic-plastic law."""
    if (errors := law_error(chain)) is None:
        return []
    rate = ", with rate dependence" if errors == _LAW_ERRORS[True] else ""
    span = f"{100 * errors[0]:+.3g} to {100 * errors[1]:+.3g} %"
    return [("law error", f"{span} relative to finite-element results for steel beads{rate}")]


def law_notes(chain: Chain) -> tuple[str, ...]:
    """Sentences on the error of the elastic-plastic law, and on dissipated energy with the contact law of a plugin."""
    sentence = "Error estimates do not include the model error of the elastic-plastic law"
    notes = tuple(f"{sentence}: {text}." for _, text in law_facts(chain))
    if chain.is_uniform:
        return notes
    from shockwave.scene.feature_rules import has_plugin_law  # equal granules do not need it

    return (*notes, _PLUGIN_LAW) if has_plugin_law(chain) else notes


def beyond_elastic(chain: Chain, yielding: Callable[[], Yielding | None]) -> InvalidValueError | None:
    """Error of a result with forces beyond first yield, or of unknown yield strengths, if the chain must be elastic.

    ``yielding`` is called only if ``chain.elastic_only`` is set.
    """
    result = yielding() if chain.elastic_only else None
    if not chain.elastic_only or (result is not None and result.peak_ratio <= 1):
        return None
    rule, got = (
        "must be left out where a yield strength is not known",
        "got true; state yield_strength of each material",
    )
    if result is not None:
        rule = "must be left out for forces beyond first yield"
        got = f"got a peak force of {_times(result.peak_ratio, 3)} times the force of first yield"
    return InvalidValueError.of("chain.elastic_only", f"{rule} ({got})")


def _times(ratio: float, digits: int = 2) -> str:
    """A ratio above 1, with as many digits as show that it is."""
    return next((text for count in range(digits, 16) if (text := round_digits(ratio, count)) != "1"), "1")
