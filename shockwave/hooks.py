"""Names for authors of plugins, besides those of `shockwave`.

A module of hooks, which is imported when plugins are listed, takes `Entry` and `hookimpl`; this module imports nothing
slow. Every other name is imported when it is first used.
"""

from __future__ import annotations

import importlib
from typing import Any

from shockwave.registry.built_ins import Entry as Entry
from shockwave.registry.hook_specifications import hookimpl as hookimpl

# Names by module; ``hooks.pyi`` states them to type checkers.
_NAMES: dict[str, tuple[str, ...]] = {
    "base.numerics": ("FloatArray",),
    "engine.integrator": ("Acceleration", "Integrator", "Step"),
    "engine.one_step": ("Attempt", "OneStep"),
    "profiles.free_path": ("FreePath",),
    "profiles.quadrature.base": ("Integral", "Integrand", "Quadrature"),
    "registry.built_ins": ("Entry",),
    "registry.hook_specifications": ("hookimpl",),
    "scene.contact_law": ("Pairs",),
}
# Name -> its module.
_HOMES = {name: f"shockwave.{module}" for module, names in _NAMES.items() for name in names}

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return __all__
