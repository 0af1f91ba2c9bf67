"""Materials of granular chains and of protection engineering, ready to use.

The figures are typical values of isotropic material at room temperature, and quasi-static ones unless the
``source`` says otherwise. They are starting points, not properties of a certain bead: heat treatment,
porosity, moisture and crystallinity change them. Metals, glasses and dense ceramics differ from their
handbooks by a few per cent. Polymers stiffen with strain rate, so a shock meets a modulus that can be
well above the quasi-static one; their ``source`` gives the range. Where the result depends on the figures,
measure the beads and make a `Material` of your own.
"""

from __future__ import annotations

from shockwave.chain.material import Material

__all__ = [
    "ALUMINA",
    "ALUMINIUM_6061_T6",
    "BEARING_STEEL_52100",
    "BOROSILICATE_GLASS",
    "BRASS_260",
    "CARBON_STEEL_1020",
    "COPPER",
    "DELRIN",
    "FUSED_SILICA",
    "HOMALITE_100",
    "LEAD",
    "NYLON_66",
    "PAPER_STEEL",
    "PHOSPHOR_BRONZE_510",
    "PMMA",
    "POLYCARBONATE",
    "PTFE",
    "SILICON_NITRIDE",
    "SODA_LIME_GLASS",
    "STAINLESS_STEEL_302",
    "STAINLESS_STEEL_304",
    "STAINLESS_STEEL_316",
    "STAINLESS_STEEL_440C",
    "TITANIUM_TI_6AL_4V",
    "TUNGSTEN",
    "TUNGSTEN_CARBIDE",
    "ZIRCONIA",
]

# --- steels -------------------------------------------------------------------------------------------------

PAPER_STEEL = Material(
    youngs_modulus=193e9,
    poisson_ratio=0.3,
    density=7958.0,
    name="paper-steel",
    source="Hasan & Nemat-Nasser, caption of Table 1; the Poisson ratio is not printed there, 0.3 reproduces"
    " its Table 2",
)

STAINLESS_STEEL_302 = Material(
    youngs_modulus=193e9,
    poisson_ratio=0.3,
    density=7860.0,
    name="stainless-steel-302",
    source="ASM data sheet of AISI 302 (asm.matweb.com, MQ302AI) for E and density; nu 0.30 is the usual"
    " textbook figure, the sheet computes 0.25 from E and G",
)

STAINLESS_STEEL_304 = Material(
    youngs_modulus=193e9,
    poisson_ratio=0.29,
    density=8000.0,
    name="stainless-steel-304",
    source="ASM data sheet of AISI 304 (asm.matweb.com), which gives E 193 to 200 GPa",
)

STAINLESS_STEEL_316 = Material(
    youngs_modulus=193e9,
    poisson_ratio=0.3,
    density=8000.0,
    name="stainless-steel-316",
    source="Daraio, Nesterenko, Herbold & Jin, Phys. Rev. E 73, 026610 (2006); E and density also in the ASM"
    " data sheet of AISI 316 (asm.matweb.com, MQ316J)",
)

STAINLESS_STEEL_440C = Material(
    youngs_modulus=200e9,
    poisson_ratio=0.28,
    density=7650.0,
    name="stainless-steel-440c",
    source="MakeItFrom.com, annealed AISI 440C, for E and nu; density of suppliers' data sheets (others"
    " give 7700 kg/m^3)",
)

BEARING_STEEL_52100 = Material(
    youngs_modulus=203e9,
    poisson_ratio=0.3,
    density=7810.0,
    name="bearing-steel-52100",
    source="data sheets of AISI 52100 (chrome steel, 100Cr6, 100C6): E 29.5e6 psi of ball makers, density"
    " 7810 kg/m^3; they range over E 190 to 210 GPa, nu 0.27 to 0.30",
)

CARBON_STEEL_1020 = Material(
    youngs_modulus=207e9,
    poisson_ratio=0.29,
    density=7870.0,
    name="carbon-steel-1020",
    source="Callister, Materials Science and Engineering, Table B.2, for E; MatWeb data sheet of AISI 1020"
    " for nu and density",
)

# --- other metals -------------------------------------------------------------------------------------------

ALUMINIUM_6061_T6 = Material(
    youngs_modulus=68.9e9,
    poisson_ratio=0.33,
    density=2700.0,
    name="aluminium-6061-t6",
    source="MatWeb data sheet of aluminium 6061-T6, after the Aluminum Association; E is the mean of tension"
    " and compression",
)

BRASS_260 = Material(
    youngs_modulus=110e9,
    poisson_ratio=0.35,
    density=8530.0,
    name="brass-260",
    source="Olin Brass data sheet of C26000 (70Cu-30Zn) for E (16e6 psi) and density; nu of Dowling,"
    " Mechanical Behavior of Materials, Table 5.2 (others give 0.31 to 0.34)",
)

PHOSPHOR_BRONZE_510 = Material(
    youngs_modulus=110e9,
    poisson_ratio=0.34,
    density=8860.0,
    name="phosphor-bronze-510",
    source="Olin Brass data sheet of C51000 for E and density; MakeItFrom.com, UNS C51000, for nu",
)

COPPER = Material(
    youngs_modulus=117e9,
    poisson_ratio=0.34,
    density=8940.0,
    name="copper",
    source="wire makers' data sheets of C10200 (oxygen-free) for E (17e6 psi) and density; nu of Dowling,"
    " Mechanical Behavior of Materials, Table 5.2, which gives E 130 GPa",
)

TITANIUM_TI_6AL_4V = Material(
    youngs_modulus=113.8e9,
    poisson_ratio=0.342,
    density=4430.0,
    name="titanium-ti-6al-4v",
    source="ASM data sheet of Ti-6Al-4V, grade 5, annealed (asm.matweb.com, MTP641)",
)

TUNGSTEN = Material(
    youngs_modulus=411e9,
    poisson_ratio=0.28,
    density=19300.0,
    name="tungsten",
    source="Dowling, Mechanical Behavior of Materials, Table 5.2, for E and nu; MatWeb data sheet of"
    " tungsten for the density; pure metal, not the sintered heavy alloys (E near 270 to 380 GPa)",
)

LEAD = Material(
    youngs_modulus=16.1e9,
    poisson_ratio=0.44,
    density=11340.0,
    name="lead",
    source="Dowling, Mechanical Behavior of Materials, Table 5.2, for E and nu; usual density of the pure"
    " metal; lead yields and creeps at small load, so contacts are elastic only for weak pulses",
)

# --- ceramics and glasses -----------------------------------------------------------------------------------

TUNGSTEN_CARBIDE = Material(
    youngs_modulus=630e9,
    poisson_ratio=0.24,
    density=14900.0,
    name="tungsten-carbide",
    source="MakeItFrom.com, tungsten carbide, for E and nu; usual density of grades with about 6 % cobalt;"
    " grades range over E 530 to 700 GPa, nu 0.24 to 0.31, 14400 to 15600 kg/m^3",
)

ALUMINA = Material(
    youngs_modulus=375e9,
    poisson_ratio=0.22,
    density=3890.0,
    name="alumina",
    source="Lily Bearing, table of ceramic materials, 99.5 % Al2O3; E falls with porosity, from 416 GPa at"
    " 3984 kg/m^3 (Munro, J. Am. Ceram. Soc. 80, 1919 (1997)) to 270 GPa in 94 % grades",
)

ZIRCONIA = Material(
    youngs_modulus=205e9,
    poisson_ratio=0.3,
    density=6050.0,
    name="zirconia",
    source="makers' data sheets of yttria-stabilized zirconia (Y-TZP), which give E 200 to 210 GPa",
)

SILICON_NITRIDE = Material(
    youngs_modulus=310e9,
    poisson_ratio=0.27,
    density=3290.0,
    name="silicon-nitride",
    source="Lily Bearing, table of ceramic materials, hot-pressed Si3N4; bearing grades range over E 300 to"
    " 315 GPa, 3200 to 3290 kg/m^3",
)

SODA_LIME_GLASS = Material(
    youngs_modulus=72e9,
    poisson_ratio=0.22,
    density=2520.0,
    name="soda-lime-glass",
    source="Valley Design data sheet of soda-lime glass for E and nu; usual density of container glass;"
    " sheets range over E 69 to 74 GPa, nu 0.20 to 0.23, 2440 to 2530 kg/m^3",
)

BOROSILICATE_GLASS = Material(
    youngs_modulus=64e9,
    poisson_ratio=0.2,
    density=2230.0,
    name="borosilicate-glass",
    source="SCHOTT data sheet of Borofloat 33 (borosilicate glass 3.3); the same figures hold for Corning 7740",
)

FUSED_SILICA = Material(
    youngs_modulus=73e9,
    poisson_ratio=0.17,
    density=2200.0,
    name="fused-silica",
    source="MakeItFrom.com, fused silica (fused quartz)",
)

# --- polymers -----------------------------------------------------------------------------------------------

PTFE = Material(
    youngs_modulus=1.46e9,
    poisson_ratio=0.46,
    density=2178.0,
    name="ptfe",
    source="Daraio, Nesterenko, Herbold & Jin, Phys. Rev. E 73, 026610 (2006), for waves in chains; the"
    " modulus depends on strain rate, quasi-static handbooks give 0.40 to 0.55 GPa (Callister, Table B.2)",
)

NYLON_66 = Material(
    youngs_modulus=2.7e9,
    poisson_ratio=0.41,
    density=1140.0,
    name="nylon-66",
    source="Dowling, Mechanical Behavior of Materials, Table 5.2, dry nylon 66, and usual density; depends"
    " on strain rate and moisture, E from 1.5 GPa (moist) to 3.8 GPa",
)

DELRIN = Material(
    youngs_modulus=3.0e9,
    poisson_ratio=0.35,
    density=1410.0,
    name="delrin",
    source="Engineering Plastics Handbook, Table 5.5, acetal homopolymer, for E and density; nu is a usual"
    " design figure; depends on strain rate; copolymers have a quasi-static E near 2.5 GPa",
)

PMMA = Material(
    youngs_modulus=2.7e9,
    poisson_ratio=0.35,
    density=1190.0,
    name="pmma",
    source="Dowling, Mechanical Behavior of Materials, Table 5.2, for E and nu; Callister, Table B.1, for"
    " the density; strongly dependent on strain rate, quasi-static E 2.2 to 3.3 GPa and more in a shock",
)

POLYCARBONATE = Material(
    youngs_modulus=2.4e9,
    poisson_ratio=0.38,
    density=1200.0,
    name="polycarbonate",
    source="Dowling, Mechanical Behavior of Materials, Table 5.2, for E and nu; makers' data sheets for the"
    " density; depends on strain rate, quasi-static E 2.0 to 2.4 GPa",
)

HOMALITE_100 = Material(
    youngs_modulus=3.9e9,
    poisson_ratio=0.35,
    density=1230.0,
    name="homalite-100",
    source="Samudrala & Rosakis (2003), as tabulated in CaltechAUTHORS record 50847, Table 1; static"
    " figures, the dynamic ones there are E 5.2 GPa, nu 0.34",
)
