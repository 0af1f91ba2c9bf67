"""Prediction and simulation of solitary waves in granular crystals under shocks of finite rise and decay.

The public names are listed in ``__init__.pyi``. Each is imported when it is first used, so that ``import shockwave`` is
fast.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.2.0.dev0"
#: Name of the distribution; on the package index, the name ``shockwave`` belongs to another project.
OWN_DISTRIBUTION = "granular-shockwave"

with open(f"{__file__}i", encoding="utf-8") as _stub:
    _imports = [line.split() for line in _stub if line.startswith("    from ")]
# Public name -> its module.
_HOMES = {words[-1]: words[1] for words in _imports}

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'shockwave' has no attribute {name!r}")
    value = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
