"""JSON document of the result of a simulation."""

from __future__ import annotations

from typing import Any

from shockwave.base.result import VERSION, plain

# Attributes that the document contains under their names.
_KEYS = (
    *("scenario", "peak_force", "amplification", "error_estimate", "waves", "passages", "greatest_force", "sensors"),
    *("transmitted", "structure", "end", "arrival_time", "applied_momentum", "applied_energy", "dissipated"),
    *("velocities", "restitution", "segments", "end_energy", "momentum_defect", "energy_defect"),
    *("recording", "integrator", "backend", "rtol", "cost"),
)
# JSON keys for the granules that leave the ends of the chain.
_ENDS = ("recoil_momentum", "recoil_error", "recoil_velocities", "ejected_granules", "spall_velocities")


def document_of(result: Any) -> dict[str, Any]:
    """Document of a `Simulation`."""
    # the rebounding granules of a train that is not known
    unknown = result.wave is not None and (
        result.options.waves != "train" or (result.recoil_error or 0.0) >= result.applied_momentum
    )
    ends = dict.fromkeys(_ENDS) if unknown else result._document(*_ENDS)
    options = {"wave_threshold": result.options.wave_threshold, "step": result.options.step}
    document = VERSION | result._document(*_KEYS)
    document["contacts"] = [plain(peak) | {"first": plain(peak.first)} for peak in result.contacts]
    others = {
        "yield": plain(result.yielding),
        "scene": result.scene.summary().numbers,
        "verdict": plain(result.verdict),
    }
    others |= {"warnings": [*result.warnings, *result._forces.warnings], "notes": list(result.notes)}
    return {**document, **ends, **options, **others}
