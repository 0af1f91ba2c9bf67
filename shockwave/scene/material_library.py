"""Library of materials used in granular chains and in protection engineering, from ``material_library.json``.

Each material is a constant of this module, such as ``PAPER_STEEL`` for ``paper-steel``.

The values are typical of the isotropic material at room temperature; unless the ``source`` states otherwise they are
quasi-static. They are starting points and not properties of individual beads: heat treatment, porosity, moisture and
crystallinity change them. Real metals, glasses and dense ceramics differ from handbook values by a few per cent. The
stiffness of polymers increases with the strain rate, so that the modulus in a shock can be well above the quasi-static
one; their ``source`` gives the range. If the result depends on these values, measure the beads and create a
`Material`.
"""

from __future__ import annotations

import json
from pathlib import Path

from shockwave.scene.material import Material

_ROWS = json.loads((Path(__file__).parent / "material_library.json").read_text(encoding="utf-8"))
_MATERIALS = {row["name"].upper().replace("-", "_"): Material(**row) for row in _ROWS}


def __getattr__(constant: str) -> Material:
    if constant not in _MATERIALS:
        raise AttributeError(f"module {__name__!r} has no attribute {constant!r}")
    return _MATERIALS[constant]
