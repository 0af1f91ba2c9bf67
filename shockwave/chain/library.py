"""Materials of granular chains and of protection engineering, ready to use, from ``library.json``.

A material is a constant of this module, such as ``PAPER_STEEL`` for ``paper-steel``.

The figures are typical values of isotropic material at room temperature, and quasi-static ones unless the
``source`` says otherwise. They are starting points, not properties of a certain bead: heat treatment,
porosity, moisture and crystallinity change them. Metals, glasses and dense ceramics differ from their
handbooks by a few per cent. Polymers stiffen with strain rate, so a shock meets a modulus that can be
well above the quasi-static one; their ``source`` gives the range. Where the result depends on the figures,
measure the beads and make a `Material` of your own.
"""

from __future__ import annotations

import json
from importlib import resources

from shockwave.chain.material import Material

_ROWS = json.loads(resources.files(__package__).joinpath("library.json").read_text(encoding="utf-8"))
_MATERIALS = {row["name"].upper().replace("-", "_"): Material(**row) for row in _ROWS}


def __getattr__(constant: str) -> Material:
    if constant not in _MATERIALS:
        raise AttributeError(f"module {__name__!r} has no attribute {constant!r}")
    return _MATERIALS[constant]
