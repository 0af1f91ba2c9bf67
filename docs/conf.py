"""Configuration of Sphinx; the lists of materials, integrators, quadratures and models come from the registry."""

from __future__ import annotations

from shockwave import OWN_DISTRIBUTION, __version__, registry

project = "shockwave"
author = "The shockwave developers"
copyright = "2026, the shockwave developers"
version = release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_build"]
html_theme = "furo"
html_title = f"shockwave {__version__}"
default_role = "py:obj"

myst_enable_extensions = ["dollarmath", "substitution"]
myst_heading_anchors = 3

napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_custom_sections = ["Contract for implementers", "Contract for implementers, beside that of `Integrator`"]

autodoc_member_order = "bysource"
autodoc_typehints = "none"


def _materials() -> str:
    rows = ["| name | E, GPa | nu | density, kg/m^3 | yield, MPa | source |", "|---|---|---|---|---|---|"]
    for entry in registry.entries("materials"):
        if entry.distribution == OWN_DISTRIBUTION:
            m = registry.load("materials", entry.name)
            strength = "-" if m.yield_strength is None else f"{m.yield_strength / 1e6:g}"
            figures = f"{m.youngs_modulus / 1e9:g} | {m.poisson_ratio:g} | {m.density:g} | {strength}"
            rows.append(f"| `{entry.name}` | {figures} | {m.source} |")
    return "\n".join(rows)


def _listed(kind: str) -> str:
    own = (entry for entry in registry.entries(kind) if entry.distribution == OWN_DISTRIBUTION)
    return "\n".join(f"- `{entry.name}`: {entry.summary}" for entry in own)


myst_substitutions = {
    "materials": _materials(),
    "integrators": _listed("integrators"),
    "quadratures": _listed("quadratures"),
    "models": _listed("models"),
    "contacts": _listed("contacts"),
}
