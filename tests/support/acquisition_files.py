"""Files of data acquisition systems with a blow, written by the packages that read them."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

#: Times [s] and forces [N] of a blow.
TIMES = 1e-6 * np.arange(300)
FORCES = 100 * np.sin(np.pi * np.clip(TIMES / 200e-6 - 0.25, 0, 1)) ** 2


def write_file(package: str) -> None:
    """Write ``blow`` in the format of a package into the current folder."""
    module: Any = importlib.import_module(package)
    if package == "nptdms":
        channel = module.ChannelObject("Hammer", "Force", FORCES, {"wf_increment": 1e-6, "wf_start_offset": 0.0})
        with module.TdmsWriter("blow.tdms") as writer:
            writer.write_segment([channel])
    elif package == "pyuff":
        points = {f"{end}_{name}": 1 for end in ("rsp", "ref") for name in ("node", "dir")}
        units = {"abscissa_spec_data_type": 17, "ordinate_spec_data_type": 13, "orddenom_spec_data_type": 0}
        names = {"type": 58, "func_type": 1, "id1": "hammer", "rsp_ent_name": "", "ref_ent_name": ""}
        data = {"data": FORCES, "x": TIMES, "abscissa_spacing": 1}
        module.UFF("blow.uff").write_sets(names | points | units | data, "overwrite")
    else:
        with module.MDF() as file:
            file.append([module.Signal(FORCES, TIMES, name="Force", unit="N")])
            file.save("blow.mf4", overwrite=True)
