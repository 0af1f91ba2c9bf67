"""Everything that shockwave itself registers, through the same hooks as a plugin."""

from __future__ import annotations

import json
from importlib import resources

from shockwave.hooks import Entry, hookimpl


@hookimpl
def shockwave_profiles() -> list[Entry]:
    place = "shockwave.profiles"
    return [
        Entry("power-law", f"{place}.power_law:PowerLaw", "rise s^eta1, decay ((n-s)/(n-1))^eta2"),
        Entry("triangular", f"{place}.triangular:Triangular", "linear rise, linear decay"),
        Entry("exponential", f"{place}.exponential:Exponential", "rise and decay by exponentials cut to [0, 1]"),
        Entry("tabulated", f"{place}.tabulated:Tabulated", "a force record, piecewise linear"),
    ]


@hookimpl
def shockwave_quadratures() -> list[Entry]:
    place = "shockwave.quadrature"
    return [
        Entry("gauss-legendre", f"{place}.gauss_legendre:GaussLegendre", "adaptive composite rule (default)"),
        Entry("tanh-sinh", f"{place}.tanh_sinh:TanhSinh", "double-exponential rule, for singular ends"),
        Entry("quadpack", f"{place}.quadpack:Quadpack", "QAGS of QUADPACK, through SciPy"),
    ]


@hookimpl
def shockwave_integrators() -> list[Entry]:
    place = "shockwave.simulation"
    nystroem = f"{place}.nystroem"
    rkn86 = "Runge-Kutta-Nystroem 8(6) of Dormand, El-Mikkawy & Prince, adaptive (default)"
    rkn1210 = "Runge-Kutta-Nystroem 12(10) of the same, adaptive (default below rtol 1e-7)"
    rkn64 = "Runge-Kutta-Nystroem 6(4) of Dormand & Prince, adaptive"
    return [
        Entry("rkn86", f"{nystroem}:Rkn86", rkn86, takes="rtol backend"),
        Entry("rkn1210", f"{nystroem}:Rkn1210", rkn1210, takes="rtol backend"),
        Entry("rkn64", f"{nystroem}:Rkn64", rkn64, takes="rtol backend"),
        Entry("verlet", f"{place}.fixed_step:Verlet", "velocity Verlet, order 2, fixed step, symplectic", takes="step"),
        Entry(
            "pefrl", f"{place}.fixed_step:Pefrl", "extended Forest-Ruth, order 4, fixed step, symplectic", takes="step"
        ),
        Entry("rk4", f"{place}.fixed_step:Rk4", "classical Runge-Kutta, order 4, fixed step", takes="step"),
        Entry("dop853", f"{place}.scipy_solver:Dop853", "Dormand-Prince 8(5,3), adaptive, from SciPy", takes="rtol"),
        Entry(
            "radau", f"{place}.scipy_solver:Radau", "Radau IIA, order 5, implicit, adaptive, from SciPy", takes="rtol"
        ),
    ]


@hookimpl
def shockwave_materials() -> list[Entry]:
    # the file is read without the module beside it, which would import the chain
    rows = json.loads(resources.files("shockwave").joinpath("chain/library.json").read_text(encoding="utf-8"))
    return [_material(row) for row in rows]


def _material(row: dict[str, str | float]) -> Entry:
    name = str(row["name"])
    constant = name.upper().replace("-", "_")
    modulus = float(row["youngs_modulus"]) / 1e9
    figures = f"E {modulus:g} GPa, nu {row['poisson_ratio']:.2f}, {row['density']:g} kg/m^3"
    return Entry(name, f"shockwave.chain.library:{constant}", figures)


@hookimpl
def shockwave_models() -> list[Entry]:
    relations = "relations of section 4 of Hasan & Nemat-Nasser"
    law = "law of the primary by the moments of the shock"
    cheapest = "the cheapest of laws, curve, simulation that meets rtol"
    return [
        Entry("section-4", "shockwave.prediction.section4:predict", relations, takes="alpha"),
        Entry("moments", "shockwave.prediction.moments:MODEL", law),
        Entry("auto", "shockwave.studies.automatic_model:MODEL", cheapest, takes="rtol"),
    ]
