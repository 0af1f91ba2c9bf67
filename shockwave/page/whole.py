"""The page: what was asked, both answers side by side, how they were come by, pictures, where it all comes from."""

from __future__ import annotations

from shockwave import pictures
from shockwave.markup import Html, document, joined, listed, section, tag
from shockwave.page.answers import answers
from shockwave.page.drawings import drawn
from shockwave.page.findings import Findings, findings
from shockwave.page.inputs import asked, judged
from shockwave.page.provenance import provenance
from shockwave.page.words import decision, lead
from shockwave.scenario.scenario import Scenario

__all__ = ["page", "written"]


def page(scenario: Scenario) -> str:
    """One page on ``scenario``, as HTML that needs nothing from elsewhere.

    A prediction or a simulation that fails is told in the page. To simulate in another way than the scenario says,
    give it other options: ``attrs.evolve(scenario, simulate=...)``. The same scenario makes the same page, to the byte.

    Parameters
    ----------
    scenario : Scenario
        What is asked. The text of its file is shown if it can be read.

    Raises
    ------
    UsageError
        When matplotlib is missing.
    """
    # What the pictures need is looked for before anything is computed.
    pictures.figure()
    return written(findings(scenario))


def written(found: Findings) -> str:
    """The page of what was found.

    Raises
    ------
    UsageError
        When matplotlib is missing.
    """
    name = found.scenario.name
    title = tag("header", tag("h1", name), tag("p", lead(found), kind="lead"), _failures(found))
    told = found.predicted
    return document(
        f"{name}: shock on a granular chain",
        [
            title,
            tag(
                "main",
                section("What was asked", asked(found.scenario)),
                section("Conditions (3)", judged(found.scenario)),
                section("What decided", decision(told)) if told is not None else Html(""),
                section("Prediction beside simulation", answers(found)),
                section("To know before using the figures", listed(found.warnings)),
                section("Pictures", drawn(found)),
                section("Where this comes from", provenance(found), _text(found)),
            ),
        ],
    )


def _failures(found: Findings) -> Html:
    return joined(tag("p", failure, kind="problem") for failure in found.failures)


def _text(found: Findings) -> Html:
    if not found.text or found.scenario.path is None:
        return Html("")
    return joined((tag("h3", f"The scenario, {found.scenario.path.name}"), tag("pre", found.text)))
