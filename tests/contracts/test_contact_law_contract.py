"""The test kit for plugins identifies broken contact laws by the clause that they violate."""

from __future__ import annotations

from typing import Any, ClassVar

import attrs
import numpy as np
import pytest

import shockwave as sw
from shockwave.scene.contact_law import ContactLaw, Pairs
from shockwave.testing import ContactLawContract
from shockwave.testing import contact_law_contract as kit
from shockwave.testing.contact_samples import SCENES
from support.pages import DOCS, blocks_of, execute


@attrs.frozen(kw_only=True)
class Sound(ContactLaw):
    """Hertz's force up to the greatest overlap, and a steeper one back to a residual overlap; parts can be replaced."""

    residual: float = sw.quantity(
        "", "residual overlap over the greatest overlap", default=0.2, at_least=0, at_most=0.9
    )

    states = 1

    def force(self, overlap: Any, closing_velocity: Any, state: Any, pairs: Pairs) -> Any:
        greatest = np.maximum(overlap, state[0])
        kept = self.residual * state[0]
        back = np.maximum(overlap - kept, 0.0) / np.maximum(greatest - kept, 1e-300)
        share = np.where(overlap >= state[0], 1.0, back)
        return pairs.stiffnesses * (np.maximum(greatest, 0.0) * share) ** 1.5

    def update(self, overlap: Any, closing_velocity: Any, state: Any, pairs: Pairs) -> Any:
        return np.maximum(state, overlap)


def other(**parts: Any) -> ContactLaw:
    """A law with replaced parts."""
    law: ContactLaw = attrs.frozen(type("Broken", (Sound,), parts))()
    return law


def plain(decorate: Any) -> ContactLaw:
    """A law without parameters, whose class is decorated otherwise."""
    parts = {"force": Sound.force, "residual": 0.2, "states": 1}
    law: ContactLaw = decorate(type("Broken", (ContactLaw,), parts))()
    return law


def force(change: Any, **parts: Any) -> ContactLaw:
    """A law whose force is changed, from that of `Sound` and the arguments."""

    def changed(self: Any, d: Any, w: Any, state: Any, pairs: Pairs) -> Any:
        return change(Sound.force(self, d, w, state, pairs), d, w, state, pairs)

    return other(force=changed, **parts)


def update(change: Any) -> ContactLaw:
    """A law with another update."""
    return other(update=lambda _, d, w, state, pairs: change(d, w, state))


def wipe(f: Any, d: Any, w: Any, state: Any, pairs: Pairs) -> Any:
    state[:] = 0
    return f


def store(d: Any, w: Any, state: Any) -> Any:
    state[:] = np.maximum(state, d)
    return state


def never(f: Any, *_: Any) -> Any:
    raise RuntimeError("out of order")


def above(d: Any, greatest: Any) -> Any:
    """Force over Hertz's, above it in unloading from overlaps that are smaller than those of the simulations."""
    share = d.clip(0) / np.maximum(greatest, 1e-9)
    return np.where((greatest > 1e-9) & (greatest < 1e-6), 1 + share * np.maximum(1 - share, 0.0), 0.0)


def counting(calls: list[int]) -> Any:
    def change(f: Any, *_: Any) -> Any:
        calls.append(0)
        return f * (1 + 1e-6 * len(calls))

    return change


#: Law, the test that fails, and its message.
LAWS: dict[str, tuple[ContactLaw, str, str]] = {
    "raising": (force(never), "clause_1", "must not raise (got RuntimeError: out of order"),
    "sum": (force(lambda f, *_: f.sum()), "clause_1", "force must return finite numbers of shape"),
    "not-finite": (
        force(lambda f, d, *_: np.where(d == 0, np.nan, f)),
        "clause_1",
        "force must return finite numbers of shape",
    ),
    "mean": (force(lambda f, *_: f + 1e-3 * f.mean()), "clause_1", "force returns other values for the same contact"),
    "greatest": (
        update(lambda d, w, s: 0 * s + d.max()),
        "clause_1",
        "update returns other values for the same contact",
    ),
    "open": (force(lambda f, d, w, *_: f + 5 * w), "clause_2", "N at an overlap of -"),
    "dashpot": (
        force(lambda f, d, w, *_: np.where(d > 0, f + 5 * w, 0)),
        "clause_3",
        "along the overlap the force jumps by 5 N at an overlap of 0 m, a closing velocity of 1 m/s",
    ),
    "turning": (
        force(lambda f, d, w, *_: f * (1 + 0.1 * (w > 0))),
        "clause_3",
        "along the closing velocity the force jumps by",
    ),
    "threshold": (force(lambda f, d, *_: f * (1 + 0.01 * (d > 3e-6))), "clause_3", "N at an overlap of 3e-06 m"),
    "wiping": (force(wipe), "it_has_no_side", "force must not change its arguments"),
    "remembering": (force(counting([])), "it_has_no_side", "force depends on earlier calls"),
    "no-number": (other(states="1"), "clause_4", "states must be a whole number"),
    "negative": (other(states=-1), "clause_4", "states must be >= 0"),
    "history-only": (
        force(lambda f, d, w, s, _: np.where(d <= np.maximum(s[0], 3e-6), f, 0)),
        "clause_4",
        "the force is 0 N at an overlap of",
    ),
    "storing": (update(store), "it_has_no_side", "update must not change its arguments"),
    "narrow": (
        update(lambda d, w, s: s[0]),
        "clause_1",
        "update must return finite numbers of shape (1, 6) (got shape (6,))",
    ),
    "itself": (update(lambda d, w, s: d[None]), "clause_5", "update returns overlap or closing_velocity itself"),
    "hardening": (update(lambda d, w, s: np.maximum(s, 1.1 * d)), "clause_5", "update changes the force by"),
    "no-unit": (
        other(factor=attrs.field(default=2.0)),
        "fields",
        "the number factor has no",
    ),
    "no-text": (other(length=sw.quantity("m", "", default=1.0)), "fields", "a field has no description"),
    "own-unit": (other(length=sw.quantity("mm", "a length", default=1.0)), "fields", "must be an SI unit (got 'mm')"),
    "object": (plain(attrs.frozen(eq=False)), "it_is_a_value", "must be equal to another one with the same parameters"),
    "mutable": (plain(attrs.define(unsafe_hash=True)), "it_is_a_value", "DID NOT RAISE"),
    "unregistered": (Sound(), "it_is_registered", "no contact is registered for Sound: return an Entry"),
    "nothing": (other(__len__=lambda _: 0), "it_excludes", "DID NOT RAISE"),
    "propelling": (
        force(lambda f, d, w, *_: f * (1 - 0.2 * np.tanh(w))),
        "clause_6",
        "opens again returns 8.75 % more energy than it received, at an overlap of",
    ),
    "unloading-above": (
        force(lambda f, d, w, s, pairs: np.maximum(f, pairs.stiffnesses * d.clip(0) ** 1.5 * above(d, s[0]))),
        "clause_6",
        "% more energy than it received, at an overlap of",
    ),
}
FIRST, *_ = SCENES


def failures(law: ContactLaw, name: str, contract: ContactLawContract | None = None) -> list[str]:
    """Messages of the failed tests of a clause; of the simulations, one is run."""
    messages = []
    for test in (test for test in dir(ContactLawContract) if test.startswith(f"test_{name}")):
        function = getattr(contract or ContactLawContract(), test)
        marks = [mark for mark in getattr(function, "pytestmark", ()) if mark.name == "parametrize"]
        cases = [(FIRST,)] if "simulated" in test else [(case,) for case in marks[0].args[1]] if marks else [()]
        for case in cases:
            try:
                function(law, *case)
            except (pytest.fail.Exception, Exception) as failure:
                messages.append(str(failure))
    return messages


def test_correct_law_passes_all_tests(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = sw.hooks.Entry("sound", f"{__name__}:Sound", "")
    monkeypatch.setattr("shockwave.testing.contact_law_contract.entry_of", lambda kind, cls: entry)
    monkeypatch.setattr("shockwave.scenario.chain_blocks.load", lambda kind, name: Sound)
    monkeypatch.setattr("shockwave.scenario.chain_blocks.entries", lambda kind: [entry])
    assert failures(Sound(residual=0.3), "") == []


@pytest.mark.parametrize("broken", LAWS)
def test_broken_law_fails_the_test_of_its_clause(broken: str) -> None:
    law, clause, message = LAWS[broken]
    assert message in " ".join(failures(law, clause))


def test_results_that_depend_on_the_steps_are_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def rough(excitation: Any, chain: Any, rtol: float, **options: Any) -> Any:
        return sw.simulate(attrs.evolve(excitation, velocity=1 + 3 * rtol), chain, rtol=rtol, **options)

    monkeypatch.setattr(kit, "simulate", rough)
    (failure,) = failures(Sound(), "it_is_simulated")
    assert (
        "clause 4: in the scene 1-free-striker (granules, end, load) the greatest force at contact 0 is 123.6587"
        in failure
    )


@pytest.mark.parametrize(("change", "part"), [(2, 1.0), (100, 0.1)], ids=["small", "still-rising"])
def test_small_changes_and_those_of_rising_forces_are_allowed(
    change: float, part: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    def rough(excitation: Any, chain: Any, rtol: float, until: float) -> Any:
        faster = attrs.evolve(excitation, velocity=1 + change * rtol)
        return sw.simulate(faster, chain, rtol=rtol, until=part * until)

    monkeypatch.setattr(kit, "simulate", rough)
    assert failures(Sound(), "it_is_simulated") == []


def of_the_docs(name: str) -> type[ContactLaw]:
    """An example of the page on plugins."""
    names: dict[str, Any] = {"__name__": __name__}
    (block,) = (each for each in blocks_of(DOCS / "plugins.md") if f"class {name}(sw.ContactLaw)" in each.text)
    execute(block, names)
    law: type[ContactLaw] = names[name]
    return law


Viscous, Indented = of_the_docs("Viscous"), of_the_docs("Indented")


@pytest.mark.slow
class TestDocs(ContactLawContract):
    laws: ClassVar = (Viscous(time=1e-6), Viscous(time=1e-4), Indented(part=0.2))
    leave_out: ClassVar = {"test_it_is_registered_and_loads_from_a_scenario": "the page shows no distribution"}
