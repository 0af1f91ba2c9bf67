"""What shockwave itself registers, through the same hooks as a plugin."""

from __future__ import annotations

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
        Entry("verlet", f"{place}.verlet:Verlet", "velocity Verlet, order 2, fixed step, symplectic", takes="step"),
        Entry("pefrl", f"{place}.pefrl:Pefrl", "extended Forest-Ruth, order 4, fixed step, symplectic", takes="step"),
        Entry("rk4", f"{place}.rk4:Rk4", "classical Runge-Kutta, order 4, fixed step", takes="step"),
        Entry("dop853", f"{place}.scipy_solver:Dop853", "Dormand-Prince 8(5,3), adaptive, from SciPy", takes="rtol"),
        Entry(
            "radau", f"{place}.scipy_solver:Radau", "Radau IIA, order 5, implicit, adaptive, from SciPy", takes="rtol"
        ),
    ]


@hookimpl
def shockwave_materials() -> list[Entry]:
    place = "shockwave.chain.library"
    return [
        Entry("paper-steel", f"{place}:PAPER_STEEL", "E 193 GPa, nu 0.30, 7958 kg/m^3"),
        Entry("stainless-steel-302", f"{place}:STAINLESS_STEEL_302", "E 193 GPa, nu 0.30, 7860 kg/m^3"),
        Entry("stainless-steel-304", f"{place}:STAINLESS_STEEL_304", "E 193 GPa, nu 0.29, 8000 kg/m^3"),
        Entry("stainless-steel-316", f"{place}:STAINLESS_STEEL_316", "E 193 GPa, nu 0.30, 8000 kg/m^3"),
        Entry("stainless-steel-440c", f"{place}:STAINLESS_STEEL_440C", "E 200 GPa, nu 0.28, 7650 kg/m^3"),
        Entry("bearing-steel-52100", f"{place}:BEARING_STEEL_52100", "E 203 GPa, nu 0.30, 7810 kg/m^3"),
        Entry("carbon-steel-1020", f"{place}:CARBON_STEEL_1020", "E 207 GPa, nu 0.29, 7870 kg/m^3"),
        Entry("aluminium-6061-t6", f"{place}:ALUMINIUM_6061_T6", "E 68.9 GPa, nu 0.33, 2700 kg/m^3"),
        Entry("brass-260", f"{place}:BRASS_260", "E 110 GPa, nu 0.35, 8530 kg/m^3"),
        Entry("phosphor-bronze-510", f"{place}:PHOSPHOR_BRONZE_510", "E 110 GPa, nu 0.34, 8860 kg/m^3"),
        Entry("copper", f"{place}:COPPER", "E 117 GPa, nu 0.34, 8940 kg/m^3"),
        Entry("titanium-ti-6al-4v", f"{place}:TITANIUM_TI_6AL_4V", "E 113.8 GPa, nu 0.34, 4430 kg/m^3"),
        Entry("tungsten", f"{place}:TUNGSTEN", "E 411 GPa, nu 0.28, 19300 kg/m^3"),
        Entry("lead", f"{place}:LEAD", "E 16.1 GPa, nu 0.44, 11340 kg/m^3"),
        Entry("tungsten-carbide", f"{place}:TUNGSTEN_CARBIDE", "E 630 GPa, nu 0.24, 14900 kg/m^3"),
        Entry("alumina", f"{place}:ALUMINA", "E 375 GPa, nu 0.22, 3890 kg/m^3"),
        Entry("zirconia", f"{place}:ZIRCONIA", "E 205 GPa, nu 0.30, 6050 kg/m^3"),
        Entry("silicon-nitride", f"{place}:SILICON_NITRIDE", "E 310 GPa, nu 0.27, 3290 kg/m^3"),
        Entry("soda-lime-glass", f"{place}:SODA_LIME_GLASS", "E 72 GPa, nu 0.22, 2520 kg/m^3"),
        Entry("borosilicate-glass", f"{place}:BOROSILICATE_GLASS", "E 64 GPa, nu 0.20, 2230 kg/m^3"),
        Entry("fused-silica", f"{place}:FUSED_SILICA", "E 73 GPa, nu 0.17, 2200 kg/m^3"),
        Entry("ptfe", f"{place}:PTFE", "E 1.46 GPa, nu 0.46, 2178 kg/m^3"),
        Entry("nylon-66", f"{place}:NYLON_66", "E 2.7 GPa, nu 0.41, 1140 kg/m^3"),
        Entry("delrin", f"{place}:DELRIN", "E 3 GPa, nu 0.35, 1410 kg/m^3"),
        Entry("pmma", f"{place}:PMMA", "E 2.7 GPa, nu 0.35, 1190 kg/m^3"),
        Entry("polycarbonate", f"{place}:POLYCARBONATE", "E 2.4 GPa, nu 0.38, 1200 kg/m^3"),
        Entry("homalite-100", f"{place}:HOMALITE_100", "E 3.9 GPa, nu 0.35, 1230 kg/m^3"),
    ]


@hookimpl
def shockwave_models() -> list[Entry]:
    place = "shockwave.prediction"
    relations = "relations of section 4 of Hasan & Nemat-Nasser"
    return [
        Entry("section-4", f"{place}.section4:predict", relations, takes="alpha"),
        Entry("moments", f"{place}.moments:MODEL", "law of the primary by the moments of the shock"),
        Entry(
            "auto",
            "shockwave.studies.auto:MODEL",
            "the cheapest of laws, curve, simulation that meets rtol",
            takes="rtol",
        ),
    ]
