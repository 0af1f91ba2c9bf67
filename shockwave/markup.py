"""Pieces of HTML: what is not markup already is escaped."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape

__all__ = [
    "Html",
    "document",
    "facts",
    "joined",
    "listed",
    "plain",
    "section",
    "table",
    "tag",
]

# What HTML does not admit, and what turns the direction of the text behind it.
_UNFIT = re.compile(
    "[^\t\n\x20-\x7e\xa0-\u2029\u202f-\u2065\u206a-\ud7ff\ue000-\ufdcf\ufdf0-\ufffd\U00010000-\U0010fffd]"
)
# matplotlib writes its curves with style attributes, and maps as pictures in data: addresses.
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'"
_STYLE = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { font: 16px/1.5 system-ui, -apple-system, "Segoe UI", sans-serif; color: #111; background: #fff;
  margin: 0 auto; max-width: 66rem; padding: 0 1rem 3rem; overflow-wrap: anywhere; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 1.5rem 0 0.5rem; }
h2 { font-size: 1.25rem; margin: 2.2rem 0 0.6rem; border-bottom: 1px solid #bbb; }
h3 { font-size: 1rem; margin: 1.4rem 0 0.3rem; }
p, ul, ol { max-width: 46rem; margin: 0.5rem 0; } ul, ol { padding-left: 1.4rem; } li { margin: 0.3rem 0; }
.lead { font-size: 1.1rem; } .note, figcaption { font-size: 0.875rem; color: #333; }
.problem { border-left: 4px solid #a33; padding-left: 0.7rem; }
.wide { overflow-x: auto; margin: 0.6rem 0; }
table { border-collapse: collapse; font-size: 0.9rem; font-variant-numeric: tabular-nums; }
th, td { text-align: right; vertical-align: top; padding: 0.25rem 0 0.25rem 1rem; border-bottom: 1px solid #ddd;
  overflow-wrap: normal; }
th { border-bottom: 1px solid #666; font-weight: 600; }
tr > :first-child, .words th, .words td { text-align: left; } tr > :first-child { padding-left: 0; }
.fails { font-weight: 700; color: #922; }
dl { display: grid; grid-template-columns: minmax(8rem, max-content) minmax(0, 1fr); gap: 0.15rem 1.2rem;
  font-size: 0.95rem; margin: 0.6rem 0; } dt { color: #333; } dd { margin: 0; }
.columns { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 24rem), 1fr)); gap: 0 2rem; }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 24rem), 1fr)); gap: 1rem 2rem; }
figure { margin: 0; max-width: 34rem; } figure svg { width: 100%; height: auto; display: block; }
figure h3 { margin: 0.6rem 0 0.2rem; }
sup, sub { line-height: 0; }
pre { font: 0.8rem/1.4 ui-monospace, Consolas, monospace; white-space: pre-wrap; background: #f5f5f5;
  padding: 0.7rem; margin: 0.5rem 0; }
code { font: 0.85em ui-monospace, Consolas, monospace; }
@page { margin: 15mm; }
@media print {
  body { font-size: 10pt; max-width: none; padding: 0; } h2, h3, p.note { break-after: avoid; }
  .wide { overflow: visible; } table { font-size: 8pt; } th, td { padding-left: 0.5rem; }
  figure, tr, li, dl > * { break-inside: avoid; }
  .columns, .pictures { grid-template-columns: 1fr 1fr; gap: 0.5rem 1.2rem; }
  pre { border: 1px solid #ccc; background: none; }
}
"""


class Html(str):
    """Text that is markup, and is not escaped again."""

    __slots__ = ()


def plain(text: str) -> Html:
    """``text`` escaped; what HTML does not admit, and what turns the direction of writing, is a replacement sign."""
    return text if isinstance(text, Html) else Html(escape(_UNFIT.sub("\N{REPLACEMENT CHARACTER}", text)))


def joined(parts: Iterable[str], between: str = "") -> Html:
    """Parts, escaped unless they are markup, with ``between`` between them."""
    return Html(plain(between).join(plain(part) for part in parts))


def tag(name: str, *parts: str, kind: str = "") -> Html:
    """An element with ``parts`` inside; ``kind`` is its class."""
    shown = f' class="{plain(kind)}"' if kind else ""
    return Html(f"<{name}{shown}>{joined(parts)}</{name}>")


def section(title: str, *parts: str) -> Html:
    """A heading and what stands under it; nothing where nothing does."""
    kept = [part for part in parts if part]
    return Html(f"<section>\n{tag('h2', title)}\n{joined(kept, Html(chr(10)))}\n</section>") if kept else Html("")


def facts(pairs: Iterable[tuple[str, str]]) -> Html:
    """Names and values, a line each."""
    lines = [joined((tag("dt", name), tag("dd", value))) for name, value in pairs]
    return tag("dl", *lines) if lines else Html("")


def listed(items: Iterable[str], ordered: bool = False) -> Html:
    """A list; nothing for no items."""
    lines = [tag("li", item) for item in items]
    return tag("ol" if ordered else "ul", *lines) if lines else Html("")


def table(header: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "", words: bool = False) -> Html:
    """A table that scrolls by itself where it is wider than the page; ``words``: its columns are no figures."""
    head = tag("thead", tag("tr", *(Html(f'<th scope="col">{plain(name)}</th>') for name in header)))
    body = tag("tbody", *(tag("tr", *(tag("td", cell) for cell in row)) for row in rows))
    # A region that scrolls must be within reach of the keyboard.
    region = f'<div class="wide" role="region" tabindex="0" aria-label="{plain(caption or "table")}">'
    inside = tag("table", head, body, kind="words" if words else "")
    return Html(f"{tag('p', caption, kind='note') if caption else ''}{region}{inside}</div>")


def document(title: str, parts: Iterable[str]) -> str:
    """The whole page."""
    head = [
        "<!DOCTYPE html>",
        '<html lang="en">',
        "<head>",
        '<meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{plain(title)}</title>",
        f"<style>{_STYLE}</style>",
        "</head>",
        "<body>",
    ]
    return "\n".join([*head, *(plain(part) for part in parts if part), "</body>", "</html>", ""])
