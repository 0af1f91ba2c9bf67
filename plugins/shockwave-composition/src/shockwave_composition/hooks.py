"""Entries that this distribution registers with shockwave."""

from __future__ import annotations

from shockwave.hooks import Entry, hookimpl


@hookimpl
def shockwave_integrators() -> list[Entry]:
    place, richardson = "shockwave_composition.blanes_moan", "shockwave_composition.verlet_richardson"
    symplectic = "fixed step, symplectic"
    four = f"Blanes & Moan's SRKN6b, order 4, {symplectic}"
    six = f"Blanes & Moan's SRKN11b, order 6, {symplectic}"
    long = f"Blanes & Moan's SRKN14a, order 6, {symplectic}"
    extrapolated = "Verlet with Richardson extrapolation, order 8(6), adaptive"
    return [
        Entry("blanes-moan-4", f"{place}:BlanesMoan4", four, takes="step"),
        Entry("blanes-moan-6", f"{place}:BlanesMoan6", six, takes="step"),
        Entry("blanes-moan-6-long", f"{place}:BlanesMoan6Long", long, takes="step"),
        Entry("verlet-richardson", f"{richardson}:VerletRichardson", extrapolated, takes="rtol"),
    ]
