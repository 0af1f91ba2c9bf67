"""Configuration of Sphinx.

The pages are built and read without a network: formulas become MathML, which browsers
draw with the font in `_static`, and the inventories of other projects are files here.
"""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.ext import autosummary
from sphinx_gallery.scrapers import matplotlib_scraper

import shockwave
from shockwave import __version__
from shockwave.base.result import Result

project = "shockwave"
author = "The shockwave developers"
copyright = "2026, the shockwave developers"
version = release = __version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.intersphinx",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "gallery", "examples/*.ipynb"]
templates_path = ["_templates"]
html_theme = "furo"
pygments_dark_style = "github-dark"  # imported names do not look like links
html_title = f"shockwave {__version__}"
html_logo = "_static/logo.svg"
html_favicon = "_static/favicon.svg"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_math_renderer = "mathml"
default_role = "py:obj"

# The button copies what is typed: no prompts, no output.
copybutton_prompt_text = r"\$ |>>> ?|\.\.\. ?"
copybutton_prompt_is_regexp = True
copybutton_line_continuation_character = "\\"
copybutton_selector = "div:not(.output) > div.highlight pre"

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "examples",
    "abort_on_example_error": True,
    "within_subsection_order": "FileNameSortKey",
    # columns of print, enlarged
    "image_scrapers": (partial(matplotlib_scraper, dpi=150),),
    "image_srcset": ["2x"],
    # run times are those of one machine
    "min_reported_time": 1e9,
    "write_computation_times": False,
    "download_all_examples": False,
    "show_signature": False,
    "backreferences_dir": None,
}
# Notebooks are stored without output and run when the pages are built.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_merge_streams = True

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3

napoleon_google_docstring = False
napoleon_use_ivar = False
napoleon_custom_sections = [
    "Contract for implementers",
    "Contract for implementers, in addition to that of `Integrator`",
]

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_type_aliases = {
    "ArrayLike": "numpy.typing.ArrayLike",
    "FloatArray": "numpy.ndarray",
}
# Sentences do not end after these.
autosummary.WELL_KNOWN_ABBREVIATIONS += ("eq.", "eqs.", "sec.")
python_maximum_signature_line_length = 88
# Some names differ by case only, which many file systems ignore.
autosummary_filename_map = {
    f"shockwave.{name}": f"shockwave.{name}-function"
    for name in shockwave.__all__
    if name.islower() and name.capitalize() in shockwave.__all__
}
# Lists of the few objects that signatures name, in the plain format of version 1: the
# published ones need a network.
intersphinx_mapping = {
    "python": ("https://docs.python.org/3", "inventories/python.txt"),
    "numpy": ("https://numpy.org/doc/stable", "inventories/numpy.txt"),
    "pandas": ("https://pandas.pydata.org/docs", "inventories/pandas.txt"),
    "xarray": ("https://docs.xarray.dev/en/stable", "inventories/xarray.txt"),
}
# The pages that list what has a page of its own.
_PAGES = "\n".join(page.read_text() for page in Path(__file__).parent.glob("python/*"))


def _formula(translator: Any, node: nodes.math | nodes.math_block) -> None:
    """Write a formula as MathML; an unknown command ends the build."""
    block = isinstance(node, nodes.math_block)
    formula = convert(node.astext(), display="block" if block else "inline")
    if "\\" in formula:
        raise ValueError(f"unknown command in {node.astext()}")
    # MathML puts space around a slash, TeX does not
    formula = formula.replace("<mo>&#x0002F;</mo>", '<mo lspace="0" rspace="0">/</mo>')
    translator.body.append(f'<div class="math">{formula}</div>' if block else formula)
    raise nodes.SkipNode


def _mark_long_lines(_app: Sphinx, document: nodes.document) -> None:
    """Give console blocks with a line wider than a page a class for site.css."""
    for block in document.findall(nodes.literal_block):
        widest = max(map(len, block.astext().splitlines()), default=0)
        if block.get("language") == "console" and widest > 88:
            block["classes"].append("long-lines")


def _join_punctuation(_app: Sphinx, document: nodes.document) -> None:
    """Keep the punctuation behind a formula in its line."""
    for formula in list(document.findall(nodes.math)):
        at = formula.parent.index(formula)
        behind = formula.parent[at + 1 : at + 2]
        text = behind[0] if behind and isinstance(behind[0], nodes.Text) else ""
        if text.startswith((".", ",", ";", ":", ")")):
            joined = nodes.inline("", "", formula.deepcopy(), nodes.Text(text[0]))
            joined["classes"].append("joined")
            formula.parent[at : at + 2] = [joined, nodes.Text(text[1:])]


def _public(
    _app: Sphinx, _name: str, _what: object, _options: object, bases: list[Any]
) -> None:
    """Replace internal bases of a class by those of their own that have a page."""
    nearest = (
        next(
            base
            for base in getattr(base, "__mro__", (object,))
            if base.__module__ == "builtins"
            or re.search(rf"\.{base.__name__}$", _PAGES, re.MULTILINE)
        )
        for base in bases
    )
    bases[:] = [base for base in dict.fromkeys(nearest) if base is not object] or [
        object
    ]


def _hide_constructor(
    _app: Sphinx,
    what: str,
    _name: str,
    documented: Any,
    _options: object,
    signature: str,
    returns: str,
) -> tuple[str, str]:
    """Hide the signature of the constructor of results: functions create them."""
    is_result = what == "class" and issubclass(documented, Result)
    return ("" if is_result else signature), returns


def setup(app: Sphinx) -> None:
    """Register the writer of formulas and the handlers of events."""
    app.connect("autodoc-process-bases", _public)
    app.connect("autodoc-process-signature", _hide_constructor)
    app.connect("doctree-read", _mark_long_lines)
    app.connect("doctree-read", _join_punctuation)
    app.add_html_math_renderer("mathml", (_formula, None), (_formula, None))
