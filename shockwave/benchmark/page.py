"""One page for a round: figures, tables, how to read them. Nothing is loaded from elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from shockwave.benchmark import smooth
from shockwave.benchmark.figure import drawing, panels_of
from shockwave.benchmark.rows import FAMILIES, Problem, Row, WorkPrecision, cells, columns

__all__ = ["page"]

_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #111; background: #fff; margin: 0 auto; max-width: 60rem;
       padding: 0 1rem 3rem; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.3rem; margin-top: 2.5rem; } h3 { font-size: 1.05rem; }
figure { margin: 1rem 0; max-width: 40rem; } figure svg { width: 100%; height: auto; display: block; }
.wide { overflow-x: auto; } table { border-collapse: collapse; font-size: 0.85rem; white-space: nowrap; }
th, td { text-align: left; padding: 0.15rem 0.7rem 0.15rem 0; border-bottom: 1px solid #ddd; }
td.note { white-space: normal; min-width: 14rem; } summary { cursor: pointer; padding: 0.4rem 0; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 0.1rem 1rem; font-size: 0.9rem; } dd { margin: 0; }
@media print { details > * { display: block; } figure { break-inside: avoid; } }
"""
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
    parts = [_family(result, family) for family in FAMILIES]
    title = "Work and precision"
    return "\n".join(
        [
            "<!DOCTYPE html>",
            '<html lang="en"><head><meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{title}</title><style>{_STYLE}</style></head><body>",
            f"<h1>{title}</h1>",
            f"<p>{escape(_READING)}</p>",
            *filter(None, parts),
            _orders(result),
            _provenance(result),
            "</body></html>",
            "",
        ]
    )


def _family(result: WorkPrecision, family: str) -> str:
    problems = [(number, problem) for number, problem in enumerate(result.problems) if problem.family == family]
    if not problems:
        return ""
    sections = [_section(result, problem, f"p{number}") for number, problem in problems]
    return "\n".join([f"<h2>{escape(family.capitalize())}</h2>", f"<p>{escape(_ABOUT[family])}</p>", *sections])


def _section(result: WorkPrecision, problem: Problem, key: str) -> str:
    rows = result.of(problem)
    lines = [f"<h3>{escape(problem.name)}</h3>", f"<p>{escape(_sentence(problem))}</p>"]
    for number, panel in enumerate(panels_of(result, problem)):
        lines.append(f"<figure>{drawing(result, [panel], f'{key}q{number}')}</figure>")
    lines.append(_failures(rows))
    lines.append(f"<details><summary>{len(rows)} rows</summary>{_table(problem, rows)}</details>")
    return "\n".join(filter(None, lines))


def _sentence(problem: Problem) -> str:
    text = f"{problem.description}. Reference: {problem.reference}, off by at most {problem.reference_error:.0e}."
    return text[0].upper() + text[1:]


def _failures(rows: Sequence[Row]) -> str:
    """Methods that found nothing at all, with the reason."""
    nothing = {row.method: row.problem for row in rows if row.problem}
    for row in rows:
        if not row.problem:
            nothing.pop(row.method, None)
    items = "".join(f"<li>{escape(method)}: {escape(why)}</li>" for method, why in nothing.items())
    return f"<p>Not drawn:</p><ul>{items}</ul>" if items else ""


def _table(problem: Problem, rows: Sequence[Row]) -> str:
    return _html_table(columns(problem), [cells(problem, row) for row in rows])


def _html_table(names: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in names)
    body = "".join("<tr>" + "".join(_cell(cell) for cell in row) + "</tr>" for row in rows)
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def _cell(text: str) -> str:
    kind = ' class="note"' if len(text) > 40 else ""
    return f"<td{kind}>{escape(text)}</td>"


def _orders(result: WorkPrecision) -> str:
    if not result.orders:
        return ""
    rows = [(o.method, str(o.declared), "-" if o.fitted is None else f"{o.fitted:.2f}") for o in result.orders]
    about = (
        "The slope of the error against the step, of methods of fixed step, over the convergent range of the problem"
    )
    table = _html_table(("method", "declared", "fitted"), rows)
    return f"<h2>Orders</h2><p>{escape(about)} <em>{escape(smooth.NAME)}</em>.</p>{table}"


def _provenance(result: WorkPrecision) -> str:
    items = "".join(f"<dt>{escape(key)}</dt><dd>{escape(value)}</dd>" for key, value in result.provenance.items())
    return f"<h2>Where this was run</h2><dl>{items}</dl>"
