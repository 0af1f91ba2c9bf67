"""Formulas of the documentation: they are drawn as they are meant, with a font of the site."""

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from latex2mathml.converter import convert  # as docs/conf.py

from support.pages import DOCS, prose

PAGES = sorted(DOCS.glob("*.md"))
NAMESPACE = "{http://www.w3.org/1998/Math/MathML}"


def formulas(page: Path) -> list[str]:
    text = re.sub(r"`[^`\n]*`", "", prose(page))
    return re.findall(r"(?<![\w$])\$\$?([^$]+?)\$\$?(?![\w$])", text)


def misread(formula: str, markup: str) -> bool:
    """Whether a command is unknown, an operator or a space is an argument of a fraction, or an index a limit."""
    tree = ElementTree.fromstring(markup)
    arguments = {part.tag.removeprefix(NAMESPACE) for part in tree.iterfind(f".//{NAMESPACE}mfrac/*")}
    accents = len(re.findall(r"\\(?:hat|tilde|bar|dot|ddot)\b", formula))
    return (
        "\\" in markup
        or not arguments.isdisjoint({"mo", "mspace"})
        or len(list(tree.iter(f"{NAMESPACE}mover"))) != accents
    )


@pytest.mark.parametrize("page", [page for page in PAGES if formulas(page)], ids=lambda page: page.stem)
def test_formulas_are_drawn_as_they_are_meant(page: Path) -> None:
    assert [formula for formula in formulas(page) if misread(formula, convert(formula))] == []


@pytest.mark.parametrize(
    ("formula", "markup"),
    [
        (r"\frac12 - a", "<mfrac><mn>12</mn><mo>-</mo></mfrac><mi>a</mi>"),
        (r"\hat t_0", "<munderover><mi>t</mi><mn>0</mn><mo>^</mo></munderover>"),
        (r"\unknown", r"<mi>\unknown</mi>"),
    ],
    ids=["fraction", "index below", "unknown command"],
)
def test_misread_formulas_are_noticed(formula: str, markup: str) -> None:
    assert misread(formula, f'<math xmlns="{NAMESPACE.strip("{}")}">{markup}</math>')


def test_font_of_formulas_is_part_of_the_site() -> None:
    style = (DOCS / "_static" / "site.css").read_text(encoding="utf-8")
    (font,) = re.findall(r'url\("([^"]+)"\)', style)
    assert (DOCS / "_static" / font).read_bytes()[:4] == b"wOF2"
    assert (DOCS / "_static" / font).with_name("OFL.txt").is_file()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_pages_are_complete_as_they_stand(page: Path) -> None:
    assert "{{" not in page.read_text(encoding="utf-8")
