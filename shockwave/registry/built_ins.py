"""Entries of all built-in profiles, integrators, quadratures, materials, contact laws and commands."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

_PROFILES = "shockwave.profiles"
_QUADRATURES = "shockwave.profiles.quadrature"
_NYSTROEM = "shockwave.engine.nystroem_integrators"
_CONTACT = "shockwave.scene.contact_law"
_DAMPING = "shockwave.scene.damping"
# A damping is named in the ``damping`` block, other contact laws in the ``contact`` block.
_DAMPS = "damping"
_SCIPY = "shockwave.engine.scipy_integrators"


class Entry(NamedTuple):
    """A registered object: its ``name``, its ``address`` (``package.module:attribute``) and a ``summary`` in one line.

    ``takes`` lists the settings that it uses, if they differ within its kind: for an integrator ``rtol`` if it is
    adaptive and ``step`` otherwise; for a contact law ``damping`` if it is a damping. The registry sets
    ``distribution``.
    """

    name: str
    address: str
    summary: str
    distribution: str = ""
    takes: str = ""


def _material(row: dict[str, str | float]) -> Entry:
    name = str(row["name"])
    constant = name.upper().replace("-", "_")
    modulus = float(row["youngs_modulus"]) / 1e9
    strength = f"yield {float(row['yield_strength']) / 1e6:g} MPa" if "yield_strength" in row else "no yield strength"
    figures = f"E {modulus:g} GPa, nu {row['poisson_ratio']:.2f}, {row['density']:g} kg/m^3, {strength}"
    return Entry(name, f"shockwave.scene.material_library:{constant}", figures)


def _rkn(name: str, title: str) -> Entry:
    """A Runge-Kutta-Nystroem pair."""
    return Entry(name, f"{_NYSTROEM}:{name.capitalize()}", f"Runge-Kutta-Nystroem {title}", takes="rtol backend")


def _fixed_step(name: str, title: str) -> Entry:
    """A method with a fixed step."""
    return Entry(name, f"{_NYSTROEM}:{name.capitalize()}", title, takes="step backend")


# read here, because the module beside the file would import the chain
_LIBRARY = Path(__file__).parent.parent / "scene" / "material_library.json"

#: Other words for those in names of materials.
SYNONYMS = {
    "100cr6": "52100",
    "acetal": "delrin",
    "acrylic": "pmma",
    "aluminum": "aluminium",
    "chrome": "bearing",
    "plexiglas": "pmma",
    "pom": "delrin",
    "pyrex": "borosilicate",
    "teflon": "ptfe",
}
#: Kind -> entries.
ENTRIES = {
    "profiles": [
        Entry("power-law", f"{_PROFILES}.power_law:PowerLaw", "rise s^eta1, decay ((n-s)/(n-1))^eta2"),
        Entry("triangular", f"{_PROFILES}.triangular:Triangular", "linear rise, linear decay"),
        Entry("exponential", f"{_PROFILES}.exponential:Exponential", "exponential rise and decay, scaled to [0, 1]"),
        Entry("half-sine", f"{_PROFILES}.half_sine:HalfSine", "half a period of a sine"),
        Entry("haversine", f"{_PROFILES}.haversine:Haversine", "square of half a period of a sine"),
        Entry("trapezoid", f"{_PROFILES}.trapezoid:Trapezoid", "linear rise, plateau, linear fall"),
        Entry("rectangular", f"{_PROFILES}.rectangular:Rectangular", "constant force, short linear ends"),
        Entry("initial-peak-sawtooth", f"{_PROFILES}.sawtooth:InitialPeakSawtooth", "short rise, long linear decay"),
        Entry("final-peak-sawtooth", f"{_PROFILES}.sawtooth:FinalPeakSawtooth", "long linear rise, short fall"),
        Entry("friedlander", f"{_PROFILES}.friedlander:Friedlander", "blast wave, (1 - u) e^(-b u) after a short rise"),
        Entry("tabulated", f"{_PROFILES}.tabulated:Tabulated", "a force record, piecewise linear"),
    ],
    "integrators": [
        _rkn("rkn86", "8(6) of Dormand, El-Mikkawy & Prince, adaptive (default)"),
        _rkn("rkn1210", "12(10) of Dormand, El-Mikkawy & Prince, adaptive (default below rtol 1e-7)"),
        _rkn("rkn64", "6(4) of Dormand & Prince, adaptive"),
        _fixed_step("verlet", "velocity Verlet, order 2, fixed step, symplectic"),
        _fixed_step("pefrl", "extended Forest-Ruth, order 4, fixed step, symplectic"),
        _fixed_step("rk4", "classical Runge-Kutta, order 4, fixed step"),
        Entry("dop853", f"{_SCIPY}:Dop853", "Dormand-Prince 8(5,3), adaptive, from SciPy", takes="rtol"),
        Entry("radau", f"{_SCIPY}:Radau", "Radau IIA, order 5, implicit, adaptive, from SciPy", takes="rtol"),
    ],
    "quadratures": [
        Entry("gauss-legendre", f"{_QUADRATURES}.gauss_legendre:GaussLegendre", "adaptive composite rule (default)"),
        Entry("tanh-sinh", f"{_QUADRATURES}.tanh_sinh:TanhSinh", "double-exponential rule, for singular end points"),
        Entry("quadpack", f"{_QUADRATURES}.quadpack:Quadpack", "QAGS of QUADPACK, through SciPy"),
    ],
    "materials": sorted(_material(row) for row in json.loads(_LIBRARY.read_text(encoding="utf-8"))),
    "contacts": [
        Entry("hertz", f"{_CONTACT}:Hertz", "k d^(3/2), k from materials and radii (default)"),
        Entry("power-law", f"{_CONTACT}:PowerContact", "k d^p, with k and p the same at all contacts"),
        Entry("elastic-plastic", f"{_CONTACT}:ElasticPlastic", "Hertz's law up to plastic flow, finite chains"),
        Entry("kuwabara-kono", f"{_DAMPING}:KuwabaraKono", "damping (3/2) k A d^(1/2) d', viscoelastic", takes=_DAMPS),
        Entry("dashpot", f"{_DAMPING}:Dashpot", "damping c d', linear", takes=_DAMPS),
        Entry("tsuji", f"{_DAMPING}:Tsuji", "damping c d^(1/4) d', with constant restitution", takes=_DAMPS),
    ],
    "commands": [],  # those of the core are in `shockwave.cli.command_table`, and come first
}
