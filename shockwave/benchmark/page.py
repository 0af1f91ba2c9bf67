"""One page for a round: figures, tables, how to read them. Nothing is loaded from elsewhere."""

from __future__ import annotations

from collections.abc import Sequence

from shockwave.benchmark import smooth
from shockwave.benchmark.figure import drawing, panels_of
from shockwave.benchmark.rows import FAMILIES, Problem, Row, WorkPrecision, cells, columns
from shockwave.markup import Html, document, facts, joined, listed, section, table, tag

__all__ = ["page"]

_ABOUT = {
    "quadratures": "Areas under rise and decay of a pulse, and its impulse, by every registered quadrature.",
    "predictors": "The peak force of the primary far along the chain: by formulae, which have the error that they have"
    " whatever one does, by the simulation at tolerance after tolerance, and by SciPy on the whole chain.",
    "integrators": "The front as it passes one contact, how strong and when: by every registered integrator on a"
    " window that grows with the front, by the simulation as it is called, and by codes made elsewhere on the whole"
    " chain.",
}
_READING = (
    "Each point is a run at one setting, each line a method. Down is more accurate, left is faster: of two methods at"
    " the same height the one on the left costs less for that error. Which is best depends on the error that one can"
    " bear. Points near the dashed line tell nothing more, since the reference may itself be off by as much. A"
    " triangle at the bottom has no error at all. Times are medians of repeated runs after a warm-up."
)


def page(result: WorkPrecision) -> str:
    """The page as HTML; every text is escaped.

    Raises
    ------
    UsageError
        When matplotlib is missing.
    """
    title = "Work and precision"
    families = [_family(result, family) for family in FAMILIES]
    where = section("Where this was run", facts(result.provenance.items()))
    return document(title, [tag("h1", title), tag("p", _READING), *families, _orders(result), where])


def _family(result: WorkPrecision, family: str) -> Html:
    parts = [
        _problem(result, problem, f"p{number}")
        for number, problem in enumerate(result.problems)
        if problem.family == family
    ]
    return section(family.capitalize(), tag("p", _ABOUT[family]), *parts) if parts else Html("")


def _problem(result: WorkPrecision, problem: Problem, key: str) -> Html:
    rows = result.of(problem)
    panels = enumerate(panels_of(result, problem))
    figures = [tag("figure", Html(drawing(result, [panel], f"{key}q{number}"))) for number, panel in panels]
    shown = table(columns(problem), [cells(problem, row) for row in rows], words=True)
    parts = [
        tag("h3", problem.name),
        tag("p", _sentence(problem)),
        *figures,
        _failures(rows),
        tag("details", tag("summary", f"{len(rows)} rows"), shown),
    ]
    return joined(parts, Html("\n"))


def _sentence(problem: Problem) -> str:
    text = f"{problem.description}. Reference: {problem.reference}, off by at most {problem.reference_error:.0e}."
    return text[0].upper() + text[1:]


def _failures(rows: Sequence[Row]) -> Html:
    """Methods that found nothing at all, with the reason."""
    nothing = {row.method: row.problem for row in rows if row.problem}
    for row in rows:
        if not row.problem:
            nothing.pop(row.method, None)
    items = listed(f"{method}: {why}" for method, why in nothing.items())
    return joined((tag("p", "Not drawn:"), items)) if items else Html("")


def _orders(result: WorkPrecision) -> Html:
    if not result.orders:
        return Html("")
    rows = [(o.method, str(o.declared), "-" if o.fitted is None else f"{o.fitted:.2f}") for o in result.orders]
    about = (
        "The slope of the error against the step, of methods of fixed step, over the convergent range of the problem "
    )
    return section(
        "Orders", tag("p", about, tag("em", smooth.NAME), "."), table(("method", "declared", "fitted"), rows)
    )
